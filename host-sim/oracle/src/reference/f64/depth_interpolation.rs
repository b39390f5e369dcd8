//! Interpolation of lines with a depth step in f64, directly from its definition.

use std::f64::consts::PI;

use num_complex::Complex;

/// All `samples` of a line from every `depth_step`-th, `z`.
///
/// The carrier has `cycles` per sample. The result is `y(n) = e^{jωn}·Σ_k h(n/step − k)·e^{−jω·step·k}·z[k]` over the eight
/// nearest samples of the line. `h` is a sinc with a Kaiser window of shape 4, and sums to 1. Beyond the line's ends its
/// baseband is constant.
pub fn line(
    z: &[Complex<f32>],
    (samples, depth_step, cycles): (usize, usize, f64),
) -> Vec<Complex<f64>> {
    let phasor = |n: f64| Complex::from_polar(1.0, 2.0 * PI * (cycles * n).rem_euclid(1.0));
    let at = |k: i64| {
        let k = k.clamp(0, z.len() as i64 - 1) as usize;
        let z = Complex::new(f64::from(z[k].re), f64::from(z[k].im));
        z * phasor((k * depth_step) as f64).conj()
    };
    let of_sample = |n: usize| {
        let below = (n / depth_step) as i64;
        let part = (n % depth_step) as f64 / depth_step as f64;
        let (mut sum, mut gain) = (Complex::ZERO, 0.0);
        for k in below - 3..=below + 4 {
            let weight = weight(part + (below - k) as f64);
            sum += at(k) * weight;
            gain += weight;
        }
        sum / gain * phasor(n as f64)
    };
    (0..samples).map(of_sample).collect()
}

/// `sinc(u)·kaiser(u/4)`.
fn weight(u: f64) -> f64 {
    let sinc = if u == 0.0 {
        1.0
    } else {
        (PI * u).sin() / (PI * u)
    };
    let inside = 1.0 - (u / 4.0).powi(2);
    sinc * bessel(4.0 * inside.max(0.0).sqrt()) / bessel(4.0)
}

/// The modified Bessel function I₀.
fn bessel(x: f64) -> f64 {
    let terms = (1..60).scan(1.0, |term: &mut f64, k| {
        *term *= (x / 2.0 / f64::from(k)).powi(2);
        Some(*term)
    });
    1.0 + terms.sum::<f64>()
}
