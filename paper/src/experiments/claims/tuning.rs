//! Finds the best filter of phase symmetry for each beamformer and medium.

use ndarray::Array2;
use serde::{Deserialize, Serialize};

use crate::Result;
use crate::experiments::common::kept::kept;
use crate::experiments::common::pictures::ridges;
use crate::experiments::common::truth::precision;
use bonebeam_drive::config::PhaseSymmetry;

use super::by_direction;
use super::condition::{Condition, Medium};
use super::pose::{Beamformed, Images, Pose};

/// Filters to try: scales as exponents of 2, from and to, and thresholds.
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
/// Dynamic ranges to try, dB relative to the paper's.
const RANGES: [f64; 6] = [-30.0, -15.0, 0.0, 20.0, 40.0, 80.0];
/// Key of DAS with a threshold for each direction.
///
/// Its thresholds are standard deviations of the noise.
pub const BY_DIRECTION: &str = "DAS, a threshold for each direction";
const DEVIATIONS: [f64; 6] = [0.0, 1.0, 2.0, 4.0, 8.0, 16.0];
/// Conditions to tune on.
const CONDITIONS: [Condition; 2] = [Condition::WaterDisturbed, Condition::TissueDisturbed];

/// Parameters of phase symmetry for a beamformer in a medium.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tuned {
    /// The medium around the bone.
    pub medium: Medium,
    /// The beamformer's key.
    pub beamformer: String,
    /// Scales, cycles per pixel.
    pub scales: Vec<f64>,
    /// Threshold, grey levels; for [`BY_DIRECTION`] standard deviations of the noise.
    pub threshold: f64,
    /// Dynamic range of the image, dB.
    pub dynamic_range: f64,
    /// Mean average precision on the bones used for tuning.
    pub average_precision: f64,
    /// Whether a better value may lie beyond the grid.
    ///
    /// The value is then at the largest threshold, the coarsest scale, or an end of the dynamic ranges. A scale of 2⁻¹
    /// is the finest that pixels have.
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
    dynamic_range: f64,
    at_edge: bool,
    average_precision: f64,
}

impl Tuned {
    /// Whether it is for this beamformer in this medium.
    pub fn is_for(&self, medium: Medium, beamformer: &str) -> bool {
        self.medium == medium && self.beamformer == beamformer
    }

    /// The paper's filter with these scales and this threshold.
    pub fn filter(&self, paper: &PhaseSymmetry) -> PhaseSymmetry {
        PhaseSymmetry {
            scales: self.scales.clone(),
            threshold: self.threshold,
            ..paper.clone()
        }
    }
}

/// Scores of every filter on the scenes of a pose.
///
/// Kept results are read instead if they exist.
///
/// # Errors
/// A scene that cannot be simulated.
pub fn scores(pose: &Pose<'_>) -> Result<Vec<Score>> {
    let key = format!("{:?} {}", pose.claims, pose.bone.number);
    kept(pose.context, "claims-tune", &key, || {
        let mut scores = Vec::new();
        let wanted = pose.conditions();
        let wanted: Vec<_> = CONDITIONS
            .into_iter()
            .filter(|c| wanted.contains(c))
            .collect();
        let wanted = if wanted.is_empty() {
            pose.conditions()
        } else {
            wanted
        };
        pose.images(&wanted, |made| {
            for (k, beamformed) in made.images.iter().enumerate() {
                for (range, offset) in RANGES.into_iter().enumerate() {
                    let at_end = range == 0 || range + 1 == RANGES.len();
                    let tried = Tried {
                        pose,
                        made: &made,
                        offset,
                        at_end,
                    };
                    scores.extend(tried.filters(beamformed)?);
                    if k == 0 {
                        scores.extend(tried.by_direction(beamformed)?);
                    }
                }
            }
            Ok(())
        })?;
        Ok(scores)
    })
}

/// Filters to try on a scene, with one dynamic range.
struct Tried<'a> {
    pose: &'a Pose<'a>,
    made: &'a Images,
    /// Dynamic range relative to the paper's, dB.
    offset: f64,
    /// Whether it is the smallest or the largest.
    at_end: bool,
}

impl Tried<'_> {
    fn image(&self, beamformed: &Beamformed) -> Result<(Array2<f32>, f64)> {
        let (display, _) = self.pose.claims.display(self.made.condition.medium());
        let dynamic_range = display.dynamic_range + self.offset;
        let image = beamformed.over(dynamic_range, &self.made.view, display.median)?;
        Ok((image, dynamic_range))
    }

    fn score(&self, map: &Array2<f32>) -> Score {
        let view = &self.made.view;
        Score {
            medium: self.made.condition.medium(),
            beamformer: String::new(),
            scales: Vec::new(),
            threshold: 0.0,
            dynamic_range: 0.0,
            at_edge: self.at_end,
            average_precision: precision(map, &view.hits, &view.grid).unwrap_or(0.0),
        }
    }

    /// Scores of the paper's filter.
    fn filters(&self, beamformed: &Beamformed) -> Result<Vec<Score>> {
        let (_, paper) = self.pose.claims.display(self.made.condition.medium());
        let (image, dynamic_range) = self.image(beamformed)?;
        let mut scores = Vec::new();
        for range in SCALES {
            for threshold in THRESHOLDS {
                let scales = scales(range);
                let filter = PhaseSymmetry {
                    scales: scales.clone(),
                    threshold,
                    ..paper.clone()
                };
                scores.push(Score {
                    beamformer: beamformed.variant.key.clone(),
                    at_edge: self.at_end
                        || is_coarsest(range)
                        || THRESHOLDS.last() == Some(&threshold),
                    scales,
                    threshold,
                    dynamic_range,
                    ..self.score(&ridges(&image, &filter)?)
                });
            }
        }
        Ok(scores)
    }

    /// Scores of the filter with a threshold for each direction.
    fn by_direction(&self, beamformed: &Beamformed) -> Result<Vec<Score>> {
        let (image, dynamic_range) = self.image(beamformed)?;
        let sides = [image.nrows(), image.ncols()];
        let finest = SCALES.iter().map(|[from, _]| *from).min().unwrap_or(1);
        let coarsest = SCALES.iter().map(|[_, to]| *to).max().unwrap_or(1);
        let bank = by_direction::filter(&image, &scales([finest, coarsest]));
        let mut scores = Vec::new();
        for range in SCALES {
            let [from, to] = range.map(|k| (k - finest) as usize);
            let bank: Vec<_> = bank[from..=to].iter().collect();
            for k in DEVIATIONS {
                scores.push(Score {
                    beamformer: BY_DIRECTION.into(),
                    scales: scales(range),
                    threshold: k,
                    dynamic_range,
                    at_edge: self.at_end || is_coarsest(range) || DEVIATIONS.last() == Some(&k),
                    ..self.score(&by_direction::map(&bank, sides, k))
                });
            }
        }
        Ok(scores)
    }
}

/// Scales from exponents of 2, the finest first, cycles per pixel.
fn scales([from, to]: [i32; 2]) -> Vec<f64> {
    (from..=to).map(|k| f64::from(-k).exp2()).collect()
}

/// Whether a range of scales has the coarsest one.
fn is_coarsest([_, to]: [i32; 2]) -> bool {
    SCALES.iter().all(|[_, other]| *other <= to)
}

/// Mean score of every filter.
pub fn means(scores: Vec<Score>) -> Vec<Tuned> {
    let mut means: Vec<Tuned> = Vec::new();
    for score in scores {
        let same = |t: &&mut Tuned| {
            t.medium == score.medium
                && t.beamformer == score.beamformer
                && t.scales == score.scales
                && t.threshold == score.threshold
                && t.dynamic_range == score.dynamic_range
        };
        match means.iter_mut().find(same) {
            Some(found) => {
                found.scenes += 1;
                let weight = 1.0 / found.scenes as f64;
                found.average_precision +=
                    weight * (score.average_precision - found.average_precision);
            }
            None => means.push(Tuned {
                at_edge: score.at_edge,
                medium: score.medium,
                beamformer: score.beamformer,
                scales: score.scales,
                threshold: score.threshold,
                dynamic_range: score.dynamic_range,
                average_precision: score.average_precision,
                scenes: 1,
            }),
        }
    }
    means
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
