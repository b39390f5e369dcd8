//! A picture with the bone surface drawn over it.

use std::path::Path;

use ndarray::Array2;

use crate::Result;
use bonebeam_drive::image::BModeImage;
use bonebeam_drive::surface::{PictureFan, SurfacePoint};
use bonebeam_files::atomic::Outputs;
use bonebeam_files::image;

/// An RGB picture with a surface drawn over it.
pub struct Overlay {
    /// The pixels.
    pub pixels: Array2<[u8; 3]>,
}

impl Overlay {
    /// Colours of a sure point and of a doubtful one.
    const SURE: [f32; 3] = [255.0, 140.0, 0.0];
    const DOUBTFUL: [f32; 3] = [90.0, 120.0, 255.0];
    /// Colour of a fan's outline.
    const OUTLINE: [u8; 3] = [0, 110, 60];

    /// Draws each piece as a polyline, and the outline of the searched fan.
    pub fn of(
        picture: &BModeImage,
        fan: Option<&PictureFan>,
        points: &[SurfacePoint],
        colour: fn(f32) -> [u8; 3],
    ) -> Self {
        // The cast saturates.
        let pixels = picture.pixels.mapv(|level| [(level + 0.5) as u8; 3]);
        let mut overlay = Self { pixels };
        let [across, down] = picture.pixel;
        let position = |[x, z]: [f64; 2]| [(x - picture.x0) / across, (z - picture.z0) / down];
        if let Some(fan) = fan {
            let outline = outline(fan);
            let next = outline.iter().skip(1).chain(outline.first());
            for (from, to) in outline.iter().zip(next) {
                overlay.line(position(*from), position(*to), Self::OUTLINE);
            }
        }
        for piece in points.chunk_by(|a, b| a.piece == b.piece) {
            for (k, point) in piece.iter().enumerate() {
                let next = piece.get(k + 1).unwrap_or(point);
                let [from, to] = [point, next].map(|point| position([point.x, point.z]));
                overlay.line(from, to, colour(point.confidence));
            }
        }
        overlay
    }

    /// From doubtful blue to sure orange.
    pub fn colour(confidence: f32) -> [u8; 3] {
        std::array::from_fn(|k| {
            let (low, high) = (Self::DOUBTFUL[k], Self::SURE[k]);
            (low + (high - low) * confidence + 0.5) as u8
        })
    }

    fn line(&mut self, from: [f64; 2], to: [f64; 2], colour: [u8; 3]) {
        let steps = (to[0] - from[0]).abs().max((to[1] - from[1]).abs());
        let steps = 2.0 * steps.ceil().min(1e5) + 1.0;
        for k in 0..=steps as usize {
            let t = k as f64 / steps;
            let at = [0, 1].map(|axis| (from[axis] + t * (to[axis] - from[axis])).round());
            let inside = at[0] >= 0.0 && at[1] >= 0.0;
            if let Some(pixel) = self.pixels.get_mut([at[1] as usize, at[0] as usize])
                && inside
            {
                *pixel = colour;
            }
        }
    }

    /// Stages the PNG.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add_to(&self, path: &Path, outputs: &mut Outputs) -> Result<()> {
        image::add_colours_to(&self.pixels, path, outputs)
    }
}

/// Both arcs of a fan's outline, m.
fn outline(fan: &PictureFan) -> Vec<[f64; 2]> {
    const STEPS: usize = 64;
    let [first, last] = fan.angles;
    let angles = (0..=STEPS).map(|k| first + (last - first) * k as f64 / STEPS as f64);
    let near = angles.clone().map(|angle| fan.at(fan.radii[0], angle));
    near.chain(angles.rev().map(|angle| fan.at(fan.radii[1], angle)))
        .collect()
}
