//! Poses of a stream's pictures.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use crate::calibration::Calibration;
use crate::igtl::{Image, transform};
use crate::message::Message;
use crate::sequence::{Frame, Tracked};
use crate::track::{chain_from_image, in_pixels, pose, sides};
use crate::transforms::{Chain, Matrix};

/// Transforms that are kept, and poses of each.
const MOST_NAMES: usize = 64;
const KEPT: usize = 32;
/// Times within which a pose is that of a picture, and beyond which it is not used, s.
const SAME: f64 = 0.005;
const FARTHEST: f64 = 0.1;

/// Finds the pose of each picture of a stream.
#[derive(Clone, Debug, Default)]
pub struct Live {
    calibration: Calibration,
    target: Option<String>,
    pixel: Option<[f64; 2]>,
    transforms: BTreeMap<String, VecDeque<(f64, Tracked)>>,
}

impl Live {
    /// By fixed transforms, the name of the frame of reference, and the sides of a pixel in mm.
    ///
    /// Without fixed transforms and a name, poses are in the pictures. The sides are for poses in mm instead of pixels.
    pub fn new(calibration: Calibration, target: Option<String>, pixel: Option<[f64; 2]>) -> Self {
        Self {
            calibration,
            target,
            pixel,
            transforms: BTreeMap::new(),
        }
    }

    /// Takes a TRANSFORM, whose device is its name.
    ///
    /// # Errors
    /// A message of another size, or too many names.
    pub fn add(&mut self, message: &Message) -> Result<(), String> {
        let tracked = transform(message)?;
        let full =
            self.transforms.len() == MOST_NAMES && !self.transforms.contains_key(&message.name);
        if full {
            return Err(format!("sent transforms of more than {MOST_NAMES} names"));
        }
        let own = self.transforms.entry(message.name.clone()).or_default();
        own.truncate(KEPT - 1);
        own.push_front((message.seconds().unwrap_or(0.0), tracked));
        Ok(())
    }

    /// Whether poses are in the pictures, not in a chain of transforms.
    fn is_embedded(&self) -> bool {
        self.target.is_none() && self.calibration.transforms.is_empty()
    }

    fn chain(&self, image: &Image) -> Result<Chain, String> {
        let fixed = self.calibration.transforms.iter().map(|(name, _)| name);
        let names = self
            .transforms
            .keys()
            .chain(image.transforms.keys())
            .chain(fixed);
        let names: BTreeSet<&str> = names.map(String::as_str).collect();
        chain_from_image(&names, self.target.as_deref()).map(|(_, chain)| chain)
    }

    /// Whether no later message can give a better pose.
    pub fn is_ready(&self, image: &Image) -> bool {
        let Ok(chain) = self.chain(image) else {
            return self.is_embedded();
        };
        let time = image.message.seconds().unwrap_or(0.0);
        let known = |name: &str| {
            let newest = self.transforms.get(name).and_then(|own| own.front());
            image.transforms.contains_key(name) || newest.is_none_or(|(own, _)| *own > time - SAME)
        };
        self.is_embedded() || chain.links.iter().all(|(name, _)| known(name))
    }

    /// The matrix from (column, row, 0, 1) to the frame of reference, and the sides of a pixel, mm.
    ///
    /// Of each transform, the pose nearest in time is used.
    ///
    /// # Errors
    /// No pose, or pixels of a size that no scanner has.
    pub fn pose(&self, image: &Image) -> Result<(Matrix, [f64; 2]), String> {
        if self.is_embedded() {
            return in_pixels(image.matrix, self.pixel, None);
        }
        let mut frame = Frame {
            has_picture: true,
            transforms: image.transforms.clone(),
            ..Frame::default()
        };
        let time = image.message.seconds();
        for (name, poses) in &self.transforms {
            let away = |(own, _): &&(f64, Tracked)| time.map_or(0.0, |time| (own - time).abs());
            let nearest = poses.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
            let Some(nearest) = nearest else { continue };
            let mut tracked = nearest.1.clone();
            if away(&nearest) > FARTHEST {
                tracked.status = format!("more than {FARTHEST} s away");
            }
            frame.transforms.entry(name.clone()).or_insert(tracked);
        }
        let pose = pose(&self.chain(image)?, &self.calibration, &frame)?;
        in_pixels(pose, self.pixel, Some(sides(&image.matrix)))
    }
}
