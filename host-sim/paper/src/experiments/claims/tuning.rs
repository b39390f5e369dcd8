//! The filter of phase symmetry that is best for each beamformer and medium.

use serde::{Deserialize, Serialize};

use crate::Result;
use crate::experiments::common::pictures::ridges;
use crate::experiments::common::truth::precision;
use bonebeam_drive::config::PhaseSymmetry;

use super::condition::{Condition, Medium};
use super::kept::kept;
use super::pose::Pose;

/// The filters that are tried: scales as exponents of 2, from and to, and thresholds.
const SCALES: [[i32; 2]; 12] = [
    [1, 1],
    [1, 2],
    [1, 3],
    [2, 2],
    [2, 3],
    [3, 4],
    [4, 5],
    [5, 6],
    [5, 7],
    [6, 8],
    [7, 9],
    [5, 9],
];
const THRESHOLDS: [f64; 8] = [0.0, 2.5, 5.0, 10.0, 15.0, 30.0, 60.0, 120.0];
/// The conditions that are tuned on.
const CONDITIONS: [Condition; 2] = [Condition::WaterDisturbed, Condition::TissueDisturbed];

/// Parameters of phase symmetry for a beamformer in a medium.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tuned {
    /// What surrounds the bone.
    pub medium: Medium,
    /// The beamformer's key.
    pub beamformer: String,
    /// Scales, cycles per pixel.
    pub scales: Vec<f64>,
    /// Threshold.
    pub threshold: f64,
    /// Mean average precision on the bones that they were tuned on.
    pub average_precision: f64,
    /// Whether it lies at an end of the grid that could be farther out: the largest threshold, or the coarsest scale. A scale of 2⁻¹ is the finest that pixels have.
    pub at_edge: bool,
    #[serde(skip)]
    scenes: usize,
}

/// The score of a filter on a scene.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Score {
    medium: Medium,
    beamformer: String,
    scales: Vec<f64>,
    threshold: f64,
    average_precision: f64,
}

impl Tuned {
    /// The paper's filter with these scales and this threshold.
    pub fn filter(&self, paper: &PhaseSymmetry) -> PhaseSymmetry {
        PhaseSymmetry {
            scales: self.scales.clone(),
            threshold: self.threshold,
            ..paper.clone()
        }
    }
}

/// The scores of every filter on the scenes of a pose; from the folder of kept results where they are there.
///
/// # Errors
/// A scene that cannot be simulated.
pub fn scores(pose: &Pose<'_>) -> Result<Vec<Score>> {
    let key = format!("{:?} {}", pose.claims, pose.bone.number);
    kept(pose.context, "claims-tune", &key, || {
        let mut scores = Vec::new();
        let wanted = pose.claims.conditions();
        let wanted: Vec<_> = CONDITIONS
            .into_iter()
            .filter(|c| wanted.contains(c))
            .collect();
        let wanted = if wanted.is_empty() {
            pose.claims.conditions()
        } else {
            wanted
        };
        pose.images(&wanted, |made| {
            let medium = made.condition.medium();
            let (_, paper) = pose.claims.display(medium);
            for (variant, image) in &made.images {
                for [from, to] in SCALES {
                    for threshold in THRESHOLDS {
                        let scales: Vec<f64> = (from..=to).map(|k| f64::from(-k).exp2()).collect();
                        let filter = PhaseSymmetry {
                            scales: scales.clone(),
                            threshold,
                            ..paper.clone()
                        };
                        let map = ridges(image, &filter)?;
                        let score = precision(&map, &made.view.hits, &made.view.grid);
                        scores.push(Score {
                            medium,
                            beamformer: variant.key.clone(),
                            scales,
                            threshold,
                            average_precision: score.unwrap_or(0.0),
                        });
                    }
                }
            }
            Ok(())
        })?;
        Ok(scores)
    })
}

/// The mean score of every filter.
pub fn means(scores: Vec<Score>) -> Vec<Tuned> {
    let mut means: Vec<Tuned> = Vec::new();
    for score in scores {
        let same = |t: &&mut Tuned| {
            t.medium == score.medium
                && t.beamformer == score.beamformer
                && t.scales == score.scales
                && t.threshold == score.threshold
        };
        match means.iter_mut().find(same) {
            Some(found) => {
                found.scenes += 1;
                let weight = 1.0 / found.scenes as f64;
                found.average_precision +=
                    weight * (score.average_precision - found.average_precision);
            }
            None => means.push(Tuned {
                at_edge: at_edge(&score),
                medium: score.medium,
                beamformer: score.beamformer,
                scales: score.scales,
                threshold: score.threshold,
                average_precision: score.average_precision,
                scenes: 1,
            }),
        }
    }
    means
}

fn at_edge(score: &Score) -> bool {
    let coarsest = SCALES.iter().map(|[_, to]| *to).max();
    let coarse = score.scales.last().map(|s| -s.log2().round() as i32) == coarsest;
    coarse || THRESHOLDS.last() == Some(&score.threshold)
}

/// The best filter of every beamformer and medium.
pub fn best(means: Vec<Tuned>) -> Vec<Tuned> {
    let mut best: Vec<Tuned> = Vec::new();
    for score in means {
        let same = |t: &&mut Tuned| t.medium == score.medium && t.beamformer == score.beamformer;
        match best.iter_mut().find(same) {
            Some(found) if found.average_precision < score.average_precision => *found = score,
            Some(_) => {}
            None => best.push(score),
        }
    }
    best
}
