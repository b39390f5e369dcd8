//! The noise threshold of phase symmetry, from the image.
//!
//! The amplitude of white noise behind a filter has the Rayleigh distribution. Ridges are rare in the finest scale, so
//! the median of its amplitude gives the parameter `τ = median/√(ln 4)`, and the threshold is `k` standard deviations
//! above the mean: `T_n = τ·(√(π/2) + k·√(2 − π/2))`. This is the estimate of Kovesi's `phasesym`, there for the sum over
//! the scales of a direction; here for one filter, as in Eq. 10. Noise is weaker in coarser scales.

use std::f64::consts::FRAC_PI_2;

use bonebeam_kernels::phase_symmetry::DIRECTIONS;

/// Amplitudes of the finest scale, for each direction of its filters.
pub struct Noise {
    /// One list for each direction.
    pub directions: Vec<Vec<f32>>,
}

impl Noise {
    /// Thresholds of the directions, `deviations` above the mean of the noise.
    ///
    /// The unit is the standard deviation of the noise. Thresholds are equal, or each is from its own direction.
    pub fn thresholds(self, deviations: f64, by_direction: bool) -> [f32; DIRECTIONS] {
        let factor = FRAC_PI_2.sqrt() + deviations * (2.0 - FRAC_PI_2).sqrt();
        let of = |mut amplitudes: Vec<f32>| {
            let middle = amplitudes.len() / 2;
            if amplitudes.is_empty() {
                return 0.0;
            }
            let (_, median, _) = amplitudes.select_nth_unstable_by(middle, f32::total_cmp);
            (f64::from(*median) / 4f64.ln().sqrt() * factor) as f32
        };
        let mut thresholds = [0.0; DIRECTIONS];
        if by_direction {
            for (threshold, amplitudes) in thresholds.iter_mut().zip(self.directions) {
                *threshold = of(amplitudes);
            }
        } else {
            thresholds.fill(of(self.directions.concat()));
        }
        thresholds
    }
}
