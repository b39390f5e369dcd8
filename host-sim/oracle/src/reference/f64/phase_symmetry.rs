//! Phase symmetry directly from Eq. 9 and 10: dense filters, whole transforms.

use std::f64::consts::PI;

use ndarray::{Array2, ArrayView2, Axis, Zip};
use num_complex::Complex;
use rustfft::FftPlannerScalar;

/// `PS` of Eq. 10 for scales `r0` (cycles per pixel) and a noise threshold.
pub fn phase_symmetry(image: ArrayView2<f64>, scales: &[f64], threshold: f64) -> Array2<f64> {
    let mut spectrum = image.mapv(|pixel| Complex::new(pixel, 0.0));
    transform(&mut spectrum, false);

    let mut numerator = Array2::<f64>::zeros(image.dim());
    let mut denominator = Array2::<f64>::zeros(image.dim());
    for &r0 in scales {
        for k in [-2.0, -1.0, 0.0, 1.0, 2.0, 3.0] {
            let mut filtered = &spectrum * &log_gabor(image.dim(), r0, -PI / 2.0 + k * PI / 6.0);
            transform(&mut filtered, true);
            filtered /= Complex::new(image.len() as f64, 0.0);
            Zip::from(&mut numerator)
                .and(&mut denominator)
                .and(&filtered)
                .for_each(|numerator, denominator, c| {
                    let (e, o) = (c.re, c.im);
                    *numerator += (e - o.abs() - threshold).max(0.0);
                    *denominator += (e * e + o * o).sqrt();
                });
        }
    }
    numerator / (denominator + 1e-10)
}

/// Eq. 9 on the grid of the discrete transform.
pub fn log_gabor((rows, columns): (usize, usize), r0: f64, theta0: f64) -> Array2<Complex<f64>> {
    Array2::from_shape_fn((rows, columns), |(row, column)| {
        let fy = frequency(row, rows);
        let fx = frequency(column, columns);
        let r = (fx * fx + fy * fy).sqrt();
        if r == 0.0 {
            return Complex::new(0.0, 0.0);
        }
        let theta = (-fy).atan2(fx);
        let alpha = (theta - theta0).sin().atan2((theta - theta0).cos());
        let radial = (-0.5 * ((r / r0).ln() / 0.15_f64.ln()).powi(2)).exp();
        let angular = (-0.5 * (alpha / (PI / 6.0)).powi(2)).exp();
        Complex::new(radial * angular, 0.0)
    })
}

/// Cycles per pixel in [−0.5, 0.5).
fn frequency(k: usize, n: usize) -> f64 {
    let f = k as f64 / n as f64;
    if f < 0.5 { f } else { f - 1.0 }
}

fn transform(data: &mut Array2<Complex<f64>>, inverse: bool) {
    let mut planner = FftPlannerScalar::new();
    for axis in [Axis(1), Axis(0)] {
        let length = data.len_of(axis);
        let fft = if inverse {
            planner.plan_fft_inverse(length)
        } else {
            planner.plan_fft_forward(length)
        };
        for mut lane in data.lanes_mut(axis) {
            let mut line = lane.to_vec();
            fft.process(&mut line);
            lane.assign(&ndarray::ArrayView1::from(&line));
        }
    }
}
