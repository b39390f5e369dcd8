//! Measures of a scene.

use crate::experiments::study::*;
use ndarray::ArrayView1;

use crate::experiments::common::bone::FOUND;
use crate::experiments::common::pictures;
use crate::experiments::surface::detectors::{DEPTHS, Detector, Frame, Kind, ONSET_PATH};

use super::by_direction;
use super::condition::{Condition, Medium};
use super::mechanism::{Zones, zones};
use super::pose::{Images, Pose, TISSUE};
use super::tuning::{BY_DIRECTION, Tuned};
use bonebeam::surface::Settings;

/// Detectors of the surface that are compared. PS is phase symmetry.
pub const DETECTORS: [&str; 6] = [
    "PS on DAS, the paper's filter",
    "PS on DAS, tuned",
    "PS on DAS, tuned, thresholds by direction",
    "PS on rank 1, tuned",
    "shadow onset in two windows, path",
    "the core's surface detector",
];

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneResult {
    /// The number of its bone.
    pub bone: u64,
    /// Medium and disturbance.
    pub condition: Condition,
    /// The bone over the tissue, DAS; `None` in water.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub brightness: Option<Brightness>,
    /// DAS first.
    pub beamformers: Vec<SceneMeasure>,
    /// Scores of an image of one grey level: B-mode and phase symmetry.
    pub uniform: [BoneMeasure; 2],
    /// Detectors of the surface, by their names.
    pub detectors: Vec<(String, Judged)>,
    /// DAS's image with parts of rank-1 ESMV's; only in tissue.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub zones: Option<Zones>,
}

/// The measures of a beamformer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneMeasure {
    /// Its key.
    pub beamformer: String,
    /// The B-mode image.
    pub b_mode: BoneMeasure,
    /// Phase symmetry with the paper's parameters.
    pub phase_symmetry: BoneMeasure,
    /// Phase symmetry with the parameters tuned for this beamformer on other bones.
    pub tuned: BoneMeasure,
}

impl SceneResult {
    /// Whether it is the same scene.
    pub fn is_same(&self, other: &Self) -> bool {
        self.order() == other.order()
    }

    /// Sort key of scenes.
    pub fn order(&self) -> (Condition, u64) {
        (self.condition, self.bone)
    }
}

/// Reads the scenes from another run's data.
///
/// # Errors
/// Data of another program or version.
pub fn read(data: &serde_json::Value) -> Result<Vec<SceneResult>> {
    let scenes = data.get("scenes").cloned().unwrap_or_default();
    serde_json::from_value(scenes).map_err(|e| {
        Error::Data(format!(
            "`claims.scenes` is not a list of scenes of this version: {e}"
        ))
    })
}

/// Measures of the scenes of a bone.
///
/// Kept results are read instead if they exist.
pub fn scenes(pose: &Pose<'_>, tuned: &[Tuned]) -> Result<Vec<SceneResult>> {
    let claims = pose.claims;
    let detector = Settings::DEFAULT;
    let key = format!("{claims:?} {tuned:?} {detector:?} {}", pose.bone.number);
    kept(pose.context, "claims", &key, || {
        let mut found = Vec::new();
        pose.images(&pose.conditions(), |made| {
            found.push(measured(pose, &made, tuned)?);
            Ok(())
        })?;
        Ok(found)
    })
}

fn measured(pose: &Pose<'_>, made: &Images, tuned: &[Tuned]) -> Result<SceneResult> {
    let Images {
        condition,
        outline,
        view,
        images,
    } = made;
    let medium = condition.medium();
    let (display, paper) = pose.claims.display(medium);
    let papers = pose.claims.papers(medium);
    let best_by_direction = tuned.iter().find(|t| t.is_for(medium, BY_DIRECTION));
    let mut beamformers = Vec::new();
    let mut maps = Vec::new();
    for made in images {
        let (variant, image) = (&made.variant, &made.pixels);
        let map = ridges(image, paper)?;
        let tuned = match tuned.iter().find(|t| t.is_for(medium, &variant.key)) {
            Some(best) => {
                let image = made.over(best.dynamic_range, view, display.median)?;
                ridges(&image, &best.filter(paper))?
            }
            None => map.clone(),
        };
        beamformers.push(SceneMeasure {
            beamformer: variant.key.clone(),
            b_mode: view.measure(image, Region::B_MODE),
            phase_symmetry: view.measure(&map, Region::PHASE_SYMMETRY),
            tuned: view.measure(&tuned, Region::PHASE_SYMMETRY),
        });
        if maps.is_empty() {
            maps.push((DETECTORS[0], map));
            maps.push((DETECTORS[1], tuned));
            if let Some(best) = best_by_direction {
                let image = made.over(best.dynamic_range, view, display.median)?;
                let bank = by_direction::filter(&image, &best.scales);
                let sides = [image.nrows(), image.ncols()];
                let map =
                    by_direction::map(&bank.iter().collect::<Vec<_>>(), sides, best.threshold);
                maps.push((DETECTORS[2], pictures::shown(map)?));
            }
        } else if variant.key == papers {
            maps.push((DETECTORS[3], tuned));
        }
    }
    let none = || Error::Data("no beamformer was selected".into());
    let das = &images.first().ok_or_else(none)?.lines;
    let brightness = match medium {
        Medium::Water => None,
        Medium::Tissue => Brightness::of(das, view, TISSUE[0], TISSUE[1])?,
    };
    Ok(SceneResult {
        bone: pose.bone.number,
        condition: *condition,
        brightness,
        beamformers,
        uniform: REGIONS.map(|region| view.uniform(region)),
        detectors: detectors(outline, view, &maps, das)?,
        zones: match medium {
            Medium::Water => None,
            Medium::Tissue => zones(view, images, paper, pose.claims.tissue.dynamic_range)?,
        },
    })
}

/// Compares detectors.
///
/// Phase symmetry: the largest ridge of each column from grey level 64 on. On the lines of DAS: the path of shadow
/// onset, and the core's detector.
fn detectors(
    outline: &Outline,
    view: &View,
    maps: &[(&str, Array2<f32>)],
    das: &BeamformedLines,
) -> Result<Vec<(String, Judged)>> {
    let depth = |row: f64| view.grid.z0 + row * view.grid.pixel;
    let depths: Vec<_> = view.hits.iter().map(|hit| hit.map(depth)).collect();
    let x = |column: usize| view.grid.x0 + column as f64 * view.grid.pixel;
    let x: Vec<f64> = (0..depths.len()).map(x).collect();
    let columns = Known {
        x: &x,
        depths: &depths,
    };
    let mut found = Vec::new();
    for (name, map) in maps {
        let ridge = |column: ArrayView1<f32>| {
            let rows = column.into_iter().enumerate();
            let (row, value) = rows.max_by(|a, b| a.1.total_cmp(b.1))?;
            (*value >= FOUND).then(|| depth(row as f64))
        };
        let answers: Vec<_> = map.columns().into_iter().map(ridge).collect();
        found.push(((*name).to_owned(), judge(&answers, columns, TOLERANCE)));
    }
    let outer = outline.without_holes()?;
    let [first, last] = DEPTHS;
    let surface = das.beam_x.iter().map(|x| {
        let hit = outer.first_hit(*x);
        hit.filter(|depth| (first..=last).contains(depth))
    });
    let depths: Vec<_> = surface.collect();
    let lines = Known {
        x: &das.beam_x,
        depths: &depths,
    };
    let image = Image::default();
    let frame = Frame::new(das, None, &image, 0.0);
    for (name, detector) in [
        (DETECTORS[4], ONSET_PATH),
        (DETECTORS[5], Detector::of(DETECTORS[5], 0, Kind::Core)),
    ] {
        let answers = frame.answers(detector)?;
        let answers: Vec<_> = answers.into_iter().map(|a| a.map(|a| a.1)).collect();
        found.push((name.to_owned(), judge(&answers, lines, TOLERANCE)));
    }
    Ok(found)
}
