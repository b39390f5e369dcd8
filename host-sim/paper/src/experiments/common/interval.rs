//! Means with their intervals.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::Serialize;

use crate::experiments::outcome::number;

/// Draws of the bootstrap.
const DRAWS: usize = 2000;

/// A mean and the interval that holds it with 95 %.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// The mean over scenes.
    pub mean: f64,
    /// The interval's ends: percentiles of a bootstrap over scenes.
    pub ends: [f64; 2],
    /// How many scenes.
    pub scenes: usize,
}

impl Interval {
    /// The mean of values with a bootstrap over them; none without values.
    pub fn of(values: &[f64]) -> Option<Self> {
        if values.is_empty() {
            return None;
        }
        let n = values.len();
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let mut means: Vec<f64> = (0..DRAWS)
            .map(|_| {
                let sum: f64 = (0..n)
                    .map(|_| values[((random.random::<f64>() * n as f64) as usize).min(n - 1)])
                    .sum();
                sum / n as f64
            })
            .collect();
        means.sort_by(f64::total_cmp);
        let at = |share: f64| means[((share * DRAWS as f64) as usize).min(DRAWS - 1)];
        Some(Interval {
            mean: values.iter().sum::<f64>() / n as f64,
            ends: [at(0.025), at(0.975)],
            scenes: n,
        })
    }

    /// For people.
    pub fn text(&self) -> String {
        let [low, high] = self.ends.map(|v| number(Some(v)));
        format!("{} ({low} to {high})", number(Some(self.mean)))
    }
}
