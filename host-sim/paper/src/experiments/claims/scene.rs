//! What is measured of a scene.

use serde::{Deserialize, Serialize};

use crate::experiments::common::bone::BoneMeasure;
use crate::experiments::common::pictures::ridges;
use crate::measure::signed_distance::Region;
use crate::{Error, Result};

use super::kept::kept;
use super::mechanism::{Zones, zones};
use super::medium::Medium;
use super::pose::{Images, Pose};
use super::tuning::Tuned;

/// What came out of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneResult {
    /// Which bone.
    pub geometry: String,
    /// What surrounds it.
    pub medium: Medium,
    /// With noise, clutter and reverberation.
    pub disturbed: bool,
    /// Seed of pose, tissue, clutter and noise.
    pub seed: u64,
    /// DAS first.
    pub beamformers: Vec<SceneMeasure>,
    /// What an image of one grey level scores, B-mode and phase symmetry.
    pub uniform: [BoneMeasure; 2],
    /// DAS's image with parts of rank-1 ESMV's; in tissue alone.
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
    /// Phase symmetry with those that are best for this beamformer on other seeds.
    pub tuned: BoneMeasure,
}

impl SceneResult {
    /// Whether it is of the same scene.
    pub fn is_same(&self, other: &Self) -> bool {
        self.order() == other.order()
    }

    /// The order in which scenes stand.
    pub fn order(&self) -> (Medium, bool, String, u64) {
        (
            self.medium,
            self.disturbed,
            self.geometry.clone(),
            self.seed,
        )
    }
}

/// The scenes of another run's data.
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

/// The measures of the scenes of a pose; from the folder of kept results where they are there.
///
/// # Errors
/// A scene that cannot be simulated.
pub fn scenes(pose: &Pose<'_>, tuned: &[Tuned]) -> Result<Vec<SceneResult>> {
    let (claims, geometry, seed) = (pose.claims, pose.geometry, pose.seed);
    let key = format!("{claims:?} {tuned:?} {geometry} {seed}");
    kept(pose.context, "claims", &key, || {
        let mut found = Vec::new();
        pose.images(|made| {
            found.push(measured(pose, &made, tuned)?);
            Ok(())
        })?;
        Ok(found)
    })
}

fn measured(pose: &Pose<'_>, made: &Images, tuned: &[Tuned]) -> Result<SceneResult> {
    let Images {
        medium,
        disturbed,
        view,
        images,
    } = made;
    let (_, paper) = pose.claims.display(*medium);
    let mut beamformers = Vec::new();
    for (variant, image) in images {
        let found = tuned
            .iter()
            .find(|t| t.medium == *medium && t.beamformer == variant.key);
        let best = found.map_or(paper.clone(), |found| found.filter(paper));
        beamformers.push(SceneMeasure {
            beamformer: variant.key.clone(),
            b_mode: view.measure(image, Region::B_MODE),
            phase_symmetry: view.measure(&ridges(image, paper)?, Region::PHASE_SYMMETRY),
            tuned: view.measure(&ridges(image, &best)?, Region::PHASE_SYMMETRY),
        });
    }
    Ok(SceneResult {
        geometry: pose.geometry.to_owned(),
        medium: *medium,
        disturbed: *disturbed,
        seed: pose.seed,
        beamformers,
        uniform: [Region::B_MODE, Region::PHASE_SYMMETRY].map(|region| view.uniform(region)),
        zones: match medium {
            Medium::Water => None,
            Medium::Tissue => zones(view, images, paper, pose.claims.tissue.dynamic_range)?,
        },
    })
}
