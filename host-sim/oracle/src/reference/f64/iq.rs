//! The delay stage of I/Q in f64, directly from its definition.
//!
//! The sinc has 32 lobes per side and is not tabulated. Phases are by the exponential function.

use bonebeam::prelude::stages::*;
use num_complex::Complex;
use std::f64::consts::TAU;

use super::delay::{flight, hann, sinc};

/// Sinc lobes on either side of a sample.
const LOBES: f64 = 32.0;

/// The aligned analytic samples of one scan line.
///
/// They are row-major `[output sample][element]`. Elements that are not active are 0. Compounding has no effect. `iq` is row-major `[element][sample]`. The sizes must
/// fit.
pub fn line(
    parameters: &IqParameters,
    scan_line: &ScanLine,
    iq: &[Complex<f32>],
) -> Vec<Complex<f64>> {
    let p = parameters;
    let mut out = vec![Complex::new(0.0, 0.0); p.output_samples * p.elements];
    for m in scan_line.active.first..scan_line.active.first + scan_line.active.count {
        let record = &iq[m * p.record_samples..][..p.record_samples];
        for n in 0..p.output_samples {
            let t = p.output_start + n as f64 / p.output_rate;
            if t <= 0.0 {
                continue;
            }
            let (_, flight) = flight(scan_line, m, p.sound_speed, t);
            let position = (flight - scan_line.transmit.t0) * p.sampling_rate;
            let mut sum = Complex::new(0.0, 0.0);
            let first = (position - LOBES).ceil().max(0.0) as usize;
            let end = (position + LOBES).floor().min(record.len() as f64 - 1.0);
            let mut k = first;
            while k as f64 <= end {
                let u = position - k as f64;
                let weight = sinc(u) * hann(u / LOBES);
                sum += Complex::new(f64::from(record[k].re), f64::from(record[k].im)) * weight;
                k += 1;
            }
            let angle = TAU * (p.demodulation_frequency * flight).rem_euclid(1.0);
            out[n * p.elements + m] = sum * Complex::from_polar(1.0, angle);
        }
    }
    out
}
