//! Means with intervals, and tests.

use serde::Serialize;

use crate::experiments::outcome::{number, ranged};
use crate::measure::mean;

use super::student;

/// Coverage of an interval.
const COVERAGE: f64 = 0.95;

/// A mean and its interval of 95 %, by Student's t.
///
/// The mean of the values must be nearly Gaussian.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Mean over scenes.
    pub mean: f64,
    /// Ends of the interval; `None` for a single scene.
    pub ends: Option<[f64; 2]>,
    /// Standard error of the mean; `None` for a single scene.
    pub error: Option<f64>,
    /// Number of scenes.
    pub scenes: usize,
}

impl Interval {
    /// The mean of independent values; `None` without values.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let values: Vec<f64> = values.into_iter().collect();
        let mean = mean(values.iter().copied())?;
        let n = values.len() as f64;
        let square: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
        let error = (values.len() > 1).then(|| (square / (n - 1.0) / n).sqrt());
        let ends = error.map(|error| {
            let half = student::quantile(0.5 + 0.5 * COVERAGE, n - 1.0) * error;
            [mean - half, mean + half]
        });
        Some(Interval {
            mean,
            ends,
            error,
            scenes: values.len(),
        })
    }

    /// The mean of independent shares, with an interval cut to 0 to 1.
    ///
    /// A mean of shares lies there, so the cut leaves out no mean that is possible.
    pub fn of_shares(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let found = Self::of(values)?;
        let ends = found.ends.map(|ends| ends.map(|end| end.clamp(0.0, 1.0)));
        Some(Interval { ends, ..found })
    }

    /// p-value of "below the bound"; 1 for a single scene.
    ///
    /// It is the probability of a mean as low as this, or lower, if the true mean is `bound`.
    pub fn chance_below(&self, bound: f64) -> f64 {
        let Some(error) = self.error else { return 1.0 };
        let distance = self.mean - bound;
        let t = match error == 0.0 {
            true if distance == 0.0 => 0.0,
            true => distance.signum() * f64::INFINITY,
            false => distance / error,
        };
        student::cumulative(t, self.scenes as f64 - 1.0)
    }

    /// p-value of "above the bound".
    pub fn chance_above(&self, bound: f64) -> f64 {
        let mirrored = Interval {
            mean: -self.mean,
            ..*self
        };
        mirrored.chance_below(-bound)
    }

    /// p-value of "within ± `margin` of 0": two one-sided tests.
    pub fn chance_within(&self, margin: f64) -> f64 {
        self.chance_below(margin).max(self.chance_above(-margin))
    }

    /// The text of an interval in tables, or a dash.
    pub fn cell(interval: Option<Self>) -> String {
        interval.map_or("–".into(), |interval| interval.text())
    }

    /// The text in tables.
    pub fn text(&self) -> String {
        match self.ends {
            None => format!("{} (one scene)", number(self.mean)),
            Some(ends) => ranged(self.mean, ends),
        }
    }
}

/// Holm's correction of the p-values of one family.
///
/// Each p-value is multiplied by the number of p-values that are not smaller. The result is at most 1, and never below
/// that of a smaller p-value.
pub fn holm(chances: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..chances.len()).collect();
    order.sort_by(|&a, &b| chances[a].total_cmp(&chances[b]));
    let mut corrected = vec![1.0; chances.len()];
    let mut most = 0.0f64;
    for (k, index) in order.into_iter().enumerate() {
        most = most
            .max((chances.len() - k) as f64 * chances[index])
            .min(1.0);
        corrected[index] = most;
    }
    corrected
}

#[cfg(test)]
mod tests {
    use super::*;
    use bonebeam_simulate::complex_gaussian;
    use rand::SeedableRng;
    use rand::rngs::ChaCha8Rng;

    #[test]
    fn an_interval_is_that_of_a_published_example() {
        // Student's sleep data (1908): differences of ten patients, mean 1.58, t = 4.0621, 95 % from 0.70 to 2.46.
        let sleep = [1.2, 2.4, 1.3, 1.3, 0.0, 1.0, 1.8, 0.8, 4.6, 1.4];
        let found = Interval::of(sleep).unwrap();
        let [low, high] = found.ends.unwrap();
        assert!((found.mean - 1.58).abs() < 1e-12);
        assert!((low - 0.700_114).abs() < 1e-5 && (high - 2.459_886).abs() < 1e-5);
        assert!((2.0 * found.chance_above(0.0) - 0.002_833).abs() < 1e-6);
        assert_eq!(Interval::of([]), None);
        assert_eq!(Interval::of([2.0]).unwrap().ends, None);
        assert_eq!(Interval::of([2.0]).unwrap().chance_within(1e9), 1.0);
        let shares = Interval::of_shares([1.0, 0.8, 1.0]).unwrap();
        let [low, high] = Interval::of([1.0, 0.8, 1.0]).unwrap().ends.unwrap();
        assert!(high > 1.0 && low > 0.0);
        assert_eq!(shares.ends, Some([low, 1.0]));
    }

    #[test]
    fn intervals_cover_what_they_say() {
        // 4000 samples: a share of 0.95 has a standard deviation of 0.0034.
        let mut random = ChaCha8Rng::seed_from_u64(5);
        for n in [3, 8, 12] {
            let covered = (0..4000).filter(|_| {
                let values: Vec<f64> = (0..n).map(|_| complex_gaussian(&mut random).re).collect();
                let [low, high] = Interval::of(values).unwrap().ends.unwrap();
                low <= 0.0 && 0.0 <= high
            });
            let fraction = covered.count() as f64 / 4000.0;
            assert!((fraction - 0.95).abs() < 0.014, "{n}: {fraction}");
        }
    }

    #[test]
    fn equivalence_needs_both_ends_within_the_margin() {
        let near = Interval::of([0.05, 0.0, -0.05, 0.02]).unwrap();
        assert!(near.chance_within(0.2) < 0.01);
        // As near, but not known well enough.
        let wide = Interval::of([0.5, -0.45, 0.3, -0.33]).unwrap();
        assert!(wide.chance_within(0.2) > 0.05);
        // At the margin the chance is a half. With t = √3 and two degrees of freedom it is (1 + √(3/5))/2.
        let at = Interval::of([0.1, 0.2, 0.3]).unwrap();
        assert!((at.chance_within(0.2) - 0.5).abs() < 1e-9);
        assert!((at.chance_within(0.1) - 0.5 * (1.0 + 0.6f64.sqrt())).abs() < 1e-9);
    }

    #[test]
    fn holm_corrects_by_rank() {
        // The four p-values of Holm's procedure as textbooks have it.
        let found = holm(&[0.01, 0.04, 0.03, 0.005]);
        let expected = [0.03, 0.06, 0.06, 0.02];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        assert_eq!(holm(&[0.6, 0.9]), [1.0, 1.0]);
        assert!(holm(&[]).is_empty());
    }
}
