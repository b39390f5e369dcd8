//! Interpolation of lines with a depth step, in plain loops.
//!
//! The order of operations is that of `bonebeam::image::DepthInterpolation`.

use std::f32::consts::TAU;
use std::f64::consts::PI;

use num_complex::Complex;

use super::filter::kaiser;

/// The taps for the sample `between` two samples of the line, `depth_step` apart.
fn taps(between: usize, depth_step: usize) -> Vec<f32> {
    let mut values = Vec::new();
    for tap in 0..8 {
        let from = between as f64 / depth_step as f64 + 3.0 - f64::from(tap);
        values.push(libm::sin(PI * from) / (PI * from) * kaiser(from / 4.0, 4.0));
    }
    let mut sum = 0.0;
    for value in &values {
        sum += value;
    }
    values.iter().map(|value| (value / sum) as f32).collect()
}

/// `e^{j2πx}` of the fractional part of `cycles`, rounded to f32.
fn phasor(cycles: f64) -> Complex<f32> {
    let angle = 2.0 * PI * cycles.rem_euclid(1.0);
    Complex::new(libm::sin(angle + PI / 2.0) as f32, libm::sin(angle) as f32)
}

/// `e^{−jφ}` of the carrier at each sample of a line.
///
/// Every 16th is computed from its phase in 2⁻³² cycles.
fn phases(samples: usize, cycles: f64) -> Vec<Complex<f32>> {
    let phase_step = (cycles.rem_euclid(1.0) * 4_294_967_296.0 + 0.5) as u64 as u32;
    let mut phases: Vec<Complex<f32>> = Vec::new();
    for k in 0..samples {
        phases.push(if k % 16 == 0 {
            let angle = phase_step.wrapping_mul(k as u32) as i32 as f32 * (TAU / 4_294_967_296.0);
            Complex::new(libm::cosf(angle), -libm::sinf(angle))
        } else {
            phases[k - 1] * phasor(cycles).conj()
        });
    }
    phases
}

/// All `samples` of a line in baseband, from every `depth_step`-th, `z`.
///
/// Each comes with the preceding sample of `z`, and its distance from it in samples. A filter makes the samples between
/// those of `z`.
fn baseband(
    z: &[Complex<f32>],
    (samples, depth_step, cycles): (usize, usize, f64),
) -> Vec<Complex<f32>> {
    let phases = phases(z.len(), cycles * depth_step as f64);
    let at = |k: i64| {
        let k = k.clamp(0, z.len() as i64 - 1) as usize;
        z[k] * phases[k]
    };
    let mut out = Vec::new();
    for n in 0..samples {
        let (k, between) = (n / depth_step, n % depth_step);
        let mut sum = Complex::<f32>::ZERO;
        if between > 0 {
            for (tap, weight) in taps(between, depth_step).iter().enumerate() {
                sum += at((k + tap) as i64 - 3) * weight;
            }
        }
        out.push(sum);
    }
    out
}

/// The line with its carrier at all samples; `cycles` of the carrier per sample.
pub fn line(
    z: &[Complex<f32>],
    (samples, depth_step, cycles): (usize, usize, f64),
) -> Vec<Complex<f32>> {
    let phases = phases(z.len(), cycles * depth_step as f64);
    let mut out = baseband(z, (samples, depth_step, cycles));
    for (n, y) in out.iter_mut().enumerate() {
        let (k, between) = (n / depth_step, n % depth_step);
        *y = match between {
            0 => z[k],
            _ => *y * phases[k].conj() * phasor(cycles * between as f64),
        };
    }
    out
}

/// The input of the envelope: the line's own samples, and the baseband in between.
pub fn for_envelope(
    z: &[Complex<f32>],
    (samples, depth_step, cycles): (usize, usize, f64),
) -> Vec<Complex<f32>> {
    let mut out = baseband(z, (samples, depth_step, cycles));
    for (own, &z) in out.iter_mut().step_by(depth_step).zip(z) {
        *own = z;
    }
    out
}
