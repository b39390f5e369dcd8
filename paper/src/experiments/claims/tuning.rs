//! Finds the best filter of phase symmetry for each beamformer and medium.

use super::by_direction;
use super::condition::{Condition, Medium};
use super::pose::{Beamformed, Images, Pose};
use crate::experiments::study::*;

/// Exponents of the finest and of the coarsest scale of [`SCALES`].
const EVERY_SCALE: [i32; 2] = [1, 9];
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

/// Parameters of phase symmetry for a beamformer in a medium, and their score.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// Average precision on a scene, or its mean on the bones used for tuning.
    pub average_precision: f64,
    /// Whether a better value may lie beyond the grid.
    ///
    /// The value is then at the largest threshold, the coarsest scale, or an end of the dynamic ranges. A scale of 2⁻¹
    /// is the finest that pixels have.
    pub at_edge: bool,
    #[serde(skip)]
    scenes: usize,
}

impl Tuned {
    /// Whether it is for this beamformer in this medium.
    pub fn is_for(&self, medium: Medium, beamformer: &str) -> bool {
        self.medium == medium && self.beamformer == beamformer
    }

    /// Whether it is the score of the same parameters.
    fn is_of(&self, other: &Tuned) -> bool {
        self.is_for(other.medium, &other.beamformer)
            && self.scales == other.scales
            && self.threshold == other.threshold
            && self.dynamic_range == other.dynamic_range
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
pub fn scores(pose: &Pose<'_>) -> Result<Vec<Tuned>> {
    let key = format!("{:?} {}", pose.claims, pose.bone.number);
    kept(pose.context, "claims-tune", &key, || {
        let mut scores = Vec::new();
        let mut wanted = pose.conditions();
        if wanted.iter().any(|c| CONDITIONS.contains(c)) {
            wanted.retain(|c| CONDITIONS.contains(c));
        }
        pose.images(&wanted, |made| {
            for (k, beamformed) in made.images.iter().enumerate() {
                for range in 0..RANGES.len() {
                    scores.extend(tried(pose, &made, beamformed, range, false)?);
                    if k == 0 {
                        scores.extend(tried(pose, &made, beamformed, range, true)?);
                    }
                }
            }
            Ok(())
        })?;
        Ok(scores)
    })
}

/// Scores on a scene's image over one of [`RANGES`], with a threshold for all directions or for each.
fn tried(
    pose: &Pose<'_>,
    made: &Images,
    beamformed: &Beamformed,
    range: usize,
    by_direction: bool,
) -> Result<Vec<Tuned>> {
    let medium = made.condition.medium();
    let (display, paper) = pose.claims.display(medium);
    let dynamic_range = display.dynamic_range + RANGES[range];
    let image = beamformed.over(dynamic_range, &made.view, display.median)?;
    let bank = by_direction.then(|| by_direction::filter(&image, &octaves(EVERY_SCALE)));
    let (beamformer, thresholds) = match by_direction {
        true => (BY_DIRECTION, &DEVIATIONS[..]),
        false => (&beamformed.variant.key[..], &THRESHOLDS[..]),
    };
    let mut scores = Vec::new();
    for exponents @ [from, to] in SCALES {
        for &threshold in thresholds {
            let mut tuned = Tuned {
                medium,
                beamformer: beamformer.to_owned(),
                scales: octaves(exponents),
                threshold,
                dynamic_range,
                average_precision: 0.0,
                at_edge: range == 0
                    || range + 1 == RANGES.len()
                    || to == EVERY_SCALE[1]
                    || thresholds.last() == Some(&threshold),
                scenes: 1,
            };
            let map = match &bank {
                Some(bank) => {
                    let [from, to] = [from, to].map(|k| (k - EVERY_SCALE[0]) as usize);
                    let bank: Vec<_> = bank[from..=to].iter().collect();
                    by_direction::map(&bank, [image.nrows(), image.ncols()], threshold)
                }
                None => ridges(&image, &tuned.filter(paper))?,
            };
            let found = precision(&map, &made.view.hits, &made.view.grid);
            tuned.average_precision = found.unwrap_or(0.0);
            scores.push(tuned);
        }
    }
    Ok(scores)
}

/// Mean score of every filter.
pub fn means(scores: Vec<Tuned>) -> Vec<Tuned> {
    let mut means: Vec<Tuned> = Vec::new();
    for score in scores {
        match means.iter_mut().find(|mean| mean.is_of(&score)) {
            Some(found) => {
                found.scenes += 1;
                let weight = 1.0 / found.scenes as f64;
                found.average_precision +=
                    weight * (score.average_precision - found.average_precision);
            }
            None => means.push(Tuned { scenes: 1, ..score }),
        }
    }
    means
}

/// The best filter of every beamformer and medium.
pub fn best(means: Vec<Tuned>) -> Vec<Tuned> {
    let mut best: Vec<Tuned> = Vec::new();
    for score in means {
        let same = |t: &&mut Tuned| t.is_for(score.medium, &score.beamformer);
        match best.iter_mut().find(same) {
            Some(found) if found.average_precision < score.average_precision => *found = score,
            Some(_) => {}
            None => best.push(score),
        }
    }
    best
}
