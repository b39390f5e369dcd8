//! Phase symmetry with a threshold per direction, from the image's own noise.
//!
//! Kovesi's `phasesym` does the same. The paper has one threshold for all filters.

use crate::experiments::study::*;
use std::f64::consts::PI;

use bonebeam_oracle::reference::f32::phase_symmetry::filtered;
use num_complex::Complex;
use rayon::prelude::*;

/// Directions of the filters.
const DIRECTIONS: usize = 6;
/// Keeps the quotient finite.
const EPSILON: f64 = 1e-10;

/// An image filtered with one scale, one entry per direction: even and odd parts.
pub type Filtered = Vec<Vec<Complex<f32>>>;

/// The image filtered with each scale, cycles per pixel.
pub fn filter(image: &Array2<f32>, scales: &[f64]) -> Vec<Filtered> {
    let (rows, columns) = image.dim();
    let pixels: Vec<f32> = image.iter().copied().collect();
    let all = scales
        .iter()
        .flat_map(|scale| (0..DIRECTIONS).map(move |direction| (*scale, direction)));
    let all: Vec<_> = all.collect();
    let mut parts: Vec<_> = all
        .par_iter()
        .map(|(scale, direction)| filtered(&pixels, rows, columns, *scale, *direction).1)
        .collect();
    let mut scales = Vec::new();
    while !parts.is_empty() {
        let rest = parts.split_off(DIRECTIONS.min(parts.len()));
        scales.push(std::mem::replace(&mut parts, rest));
    }
    scales
}

/// Phase symmetry of the scales, the finest first.
///
/// For each direction, it is the sum of the symmetric energy of its scales, less the mean and `k` standard deviations
/// of the noise's energy in that direction. The amplitudes of noise at the finest scale have the Rayleigh distribution
/// with the measured median; each coarser scale has half of them.
pub fn map(scales: &[&Filtered], [rows, columns]: [usize; 2], k: f64) -> Array2<f32> {
    let mut sums = vec![(0.0, EPSILON); rows * columns];
    for direction in 0..DIRECTIONS {
        let noise = scales.first().map_or(0.0, |finest| {
            let mut amplitudes: Vec<f32> = finest[direction].iter().map(|c| c.norm()).collect();
            let middle = amplitudes.len() / 2;
            let (_, median, _) = amplitudes.select_nth_unstable_by(middle, f32::total_cmp);
            let finest = f64::from(*median) / 4f64.ln().sqrt();
            finest * 2.0 * (1.0 - 0.5f64.powi(scales.len() as i32))
        });
        let threshold = noise * ((0.5 * PI).sqrt() + k * (2.0 - 0.5 * PI).sqrt());
        for (pixel, (above, amplitude)) in sums.iter_mut().enumerate() {
            let mut energy = -threshold;
            for scale in scales {
                let c = scale[direction][pixel];
                energy += f64::from(c.re - c.im.abs());
                *amplitude += f64::from(c.norm());
            }
            *above += energy.max(0.0);
        }
    }
    let level = |at: (usize, usize)| {
        let (above, amplitude) = sums[at.0 * columns + at.1];
        (above / amplitude) as f32
    };
    Array2::from_shape_fn((rows, columns), level)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_below_its_threshold_and_a_ridge_is_not() {
        let mut seed = 1u64;
        let mut noise = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 40) as f32 / (1u64 << 24) as f32
        };
        let ridge = |row: usize| 200.0 * (-((row as f32 - 40.0) / 3.0).powi(2)).exp();
        let image = Array2::from_shape_fn((128, 128), |(row, _)| 20.0 * noise() + ridge(row));
        let found = filter(&image, &[0.0625, 0.03125]);
        assert_eq!((found.len(), found[0].len()), (2, DIRECTIONS));
        let scales: Vec<&Filtered> = found.iter().collect();
        let level = |k: f64, row: usize| map(&scales, [128, 128], k)[[row, 64]];
        // No threshold leaves noise; that of three standard deviations leaves none, and the ridge.
        let mean = |k: f64| {
            map(&scales, [128, 128], k)
                .rows()
                .into_iter()
                .skip(60)
                .take(40)
                .map(|row| row.sum())
                .sum::<f32>()
                / (40.0 * 128.0)
        };
        assert!(level(3.0, 40) > 0.3, "{}", level(3.0, 40));
        assert!(mean(3.0) < 0.1 * mean(-1.0), "{} {}", mean(3.0), mean(-1.0));
    }
}
