//! The image stage in f64, directly from its definitions.

use ndarray::{Array2, ArrayView2};
use num_complex::Complex;

/// `|z|`.
pub fn envelope(z: ArrayView2<Complex<f32>>) -> Array2<f64> {
    z.mapv(|z| f64::from(z.re).hypot(f64::from(z.im)))
}

/// Log compression relative to the largest value.
///
/// Decibels `[−dynamic_range, 0]` are mapped to `0..255`.
pub fn log_compression(envelope: ArrayView2<f64>, dynamic_range: f64) -> Array2<f64> {
    let largest = envelope.iter().copied().fold(0.0, f64::max);
    envelope.mapv(|e| {
        let decibels = 20.0 * (e / largest).log10();
        (255.0 * (decibels + dynamic_range) / dynamic_range).max(0.0)
    })
}

/// Bilinear interpolation at a fractional `(beam, sample)`; 0 outside.
pub fn bilinear(data: ArrayView2<f64>, beam: f64, sample: f64) -> f64 {
    let (beams, samples) = data.dim();
    let outside = |at: f64, count: usize| at < 0.0 || at > (count - 1) as f64;
    if outside(beam, beams) || outside(sample, samples) {
        return 0.0;
    }
    let mut sum = 0.0;
    for (b, weight_b) in weights(beam) {
        for (s, weight_s) in weights(sample) {
            // Beyond the last index the weight is 0.
            sum += weight_b * weight_s * data.get((b, s)).copied().unwrap_or(0.0);
        }
    }
    sum
}

fn weights(at: f64) -> [(usize, f64); 2] {
    let below = at.floor();
    let above = below as usize + 1;
    [(below as usize, 1.0 - (at - below)), (above, at - below)]
}

/// The 3×3 median with the edge repeated.
pub fn median(image: ArrayView2<f64>) -> Array2<f64> {
    let (rows, columns) = image.dim();
    Array2::from_shape_fn((rows, columns), |(row, column)| {
        let near = |k: usize, d: usize, count: usize| (k + d).saturating_sub(1).min(count - 1);
        let mut around: Vec<f64> = (0..9)
            .map(|k| image[(near(row, k / 3, rows), near(column, k % 3, columns))])
            .collect();
        around.sort_by(f64::total_cmp);
        around[4]
    })
}
