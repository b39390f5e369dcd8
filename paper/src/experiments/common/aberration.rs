//! Aberration on receive: each element's record delayed by a smooth random curve.

use std::f64::consts::PI;

use ndarray::ArrayView1;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;

use crate::Result;
use bonebeam_files::ChannelData;
use bonebeam_simulate::complex_gaussian;

use super::recording::rf;

/// Half the length of the interpolator that delays a channel, samples.
const TAPS: i64 = 8;

/// Delays the elements of an RF recording by a random curve of `rms` s.
///
/// Its correlation along the array has a full width of `length` m at half maximum.
///
/// # Errors
/// The recording is I/Q.
pub fn aberrate(data: &mut ChannelData, rms: f64, length: f64, seed: u64) -> Result<()> {
    let delays = delays(&data.element_x, rms, length, seed);
    let fs = data.fs;
    let kernels: Vec<_> = delays.iter().map(|delay| Kernel::of(delay * fs)).collect();
    let mut rows: Vec<_> = rf(data)?.rows_mut().into_iter().collect();
    rows.par_iter_mut().enumerate().for_each(|(row, values)| {
        let delayed = kernels[row % kernels.len()].apply(values.view());
        values.iter_mut().zip(delayed).for_each(|(v, d)| *v = d);
    });
    Ok(())
}

/// Delays of the elements, s: a smooth random curve without mean and slope.
fn delays(element_x: &[f64], rms: f64, length: f64, seed: u64) -> Vec<f64> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let white: Vec<f64> = element_x
        .iter()
        .map(|_| complex_gaussian(&mut random).re)
        .collect();
    // White noise through a Gaussian of the standard deviation σ has a correlation of the full width 4·√(ln 2)·σ.
    let width = length / (4.0 * std::f64::consts::LN_2.sqrt());
    let smooth = |x: &f64| {
        let weight = |at: &f64| (-0.5 * ((x - at) / width).powi(2)).exp();
        let terms = element_x.iter().zip(&white);
        terms.map(|(at, value)| weight(at) * value).sum::<f64>()
    };
    let mut delays: Vec<f64> = element_x.iter().map(smooth).collect();
    let n = delays.len() as f64;
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / n;
    let centre = mean(&mut element_x.iter().copied());
    let level = mean(&mut delays.iter().copied());
    let spread = mean(&mut element_x.iter().map(|x| (x - centre).powi(2)));
    let tilt = mean(&mut delays.iter().zip(element_x).map(|(d, x)| d * (x - centre)));
    let slope = tilt / spread.max(f64::MIN_POSITIVE);
    for (delay, x) in delays.iter_mut().zip(element_x) {
        *delay -= level + slope * (x - centre);
    }
    let found = mean(&mut delays.iter().map(|d| d * d)).sqrt();
    let scale = rms / found.max(f64::MIN_POSITIVE);
    delays.iter().map(|d| d * scale).collect()
}

/// A delay by a fraction of samples: a sinc with a Hann window.
struct Kernel {
    /// Whole samples.
    whole: i64,
    /// Weights of the samples from `whole + 1 − TAPS` before on.
    weights: Vec<f32>,
}

impl Kernel {
    fn of(delay: f64) -> Self {
        let whole = delay.floor() as i64;
        let fraction = delay - whole as f64;
        let weight = |k: i64| {
            let x = k as f64 - fraction;
            let sinc = if x == 0.0 {
                1.0
            } else {
                (PI * x).sin() / (PI * x)
            };
            (sinc * (0.5 + 0.5 * (PI * x / (TAPS as f64 + 1.0)).cos())) as f32
        };
        Kernel {
            whole,
            weights: (1 - TAPS..=TAPS).map(weight).collect(),
        }
    }

    /// Applies the delay. Samples before the first and after the last are 0.
    fn apply(&self, row: ArrayView1<f32>) -> Vec<f32> {
        let at = |n: i64| usize::try_from(n).ok().and_then(|n| row.get(n)).copied();
        let delayed = |n: i64| {
            let taps = self.weights.iter().zip(1 - TAPS..);
            taps.map(|(w, k)| w * at(n - self.whole - k).unwrap_or(0.0))
                .sum()
        };
        (0..row.len() as i64).map(delayed).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array1;

    #[test]
    fn a_sine_is_delayed() {
        let sine = |n: f64| (2.0 * PI * 5.0 / 40.0 * n).sin();
        let row = Array1::from_shape_fn(200, |n| sine(n as f64) as f32);
        for delay in [-3.4, -0.5, 0.0, 1.25, 2.0] {
            let found = Kernel::of(delay).apply(row.view());
            for (n, found) in found.iter().enumerate().take(180).skip(20) {
                let error = f64::from(*found) - sine(n as f64 - delay);
                assert!(error.abs() < 3e-3, "{delay}: {error} at {n}");
            }
        }
    }

    #[test]
    fn delays_have_the_rms_that_is_asked_for_and_no_slope() {
        let x: Vec<f64> = (0..128).map(|k| 0.3e-3 * k as f64).collect();
        let delays = delays(&x, 35e-9, 3e-3, 3);
        let rms = (delays.iter().map(|d| d * d).sum::<f64>() / 128.0).sqrt();
        assert!((rms - 35e-9).abs() < 1e-12, "{rms}");
        assert!(delays.iter().sum::<f64>().abs() < 1e-15);
        let tilt: f64 = delays.iter().zip(&x).map(|(d, x)| d * x).sum();
        assert!(tilt.abs() < 1e-16, "{tilt}");
        // Neighbours are alike, those 10 mm away are not.
        let correlation = |lag: usize| {
            let pairs = delays.iter().zip(&delays[lag..]);
            pairs.map(|(a, b)| a * b).sum::<f64>() / (128 - lag) as f64 / (rms * rms)
        };
        assert!(correlation(1) > 0.9 && correlation(5) < 0.75 && correlation(33) < 0.5);
    }
}
