//! The delay stage in f64, directly from its definition.
//!
//! The sinc is four times as long as the core's and is not tabulated. The analytic signal is by the DFT.

use bonebeam::prelude::stages::*;
use num_complex::Complex;
use rustfft::FftPlannerScalar;
use std::f64::consts::PI;

/// Sinc lobes on either side of a sample, and output samples beyond either end of the line.
const LOBES: f64 = 32.0;
const MARGIN: usize = 256;

/// The aligned analytic samples of one scan line.
///
/// They are row-major `[output sample][element]`. Elements that are not active are 0. Compounding has no effect. `rf` is row-major `[element][sample]`. The sizes must
/// fit.
pub fn line(parameters: &DelayParameters, scan_line: &ScanLine, rf: &[f32]) -> Vec<Complex<f64>> {
    let p = parameters;
    let mut out = vec![Complex::new(0.0, 0.0); p.output_samples * p.elements];
    let samples = p.output_samples + 2 * MARGIN;
    let mut planner = FftPlannerScalar::new();
    let forward = planner.plan_fft_forward(samples);
    let inverse = planner.plan_fft_inverse(samples);
    for m in scan_line.active.first..scan_line.active.first + scan_line.active.count {
        let record = &rf[m * p.record_samples..][..p.record_samples];
        let mut line: Vec<Complex<f64>> = (0..samples)
            .map(|n| {
                let t = p.output_start + (n as f64 - MARGIN as f64) / p.output_rate;
                let value = read(p, record, arrival(p, scan_line, m, t), t);
                Complex::new(value, 0.0)
            })
            .collect();
        forward.process(&mut line);
        keep_positive(&mut line);
        inverse.process(&mut line);
        for n in 0..p.output_samples {
            out[n * p.elements + m] = line[n + MARGIN] / samples as f64;
        }
    }
    out
}

/// The arrival time of the echo of the line's pixel at element `m`, in record samples.
///
/// The pixel is at two-way time `t`.
fn arrival(p: &DelayParameters, scan_line: &ScanLine, m: usize, t: f64) -> f64 {
    let (_, flight) = flight(scan_line, m, p.sound_speed, t);
    (flight - scan_line.transmit.t0) * p.sampling_rate
}

/// The line's pixel (x, z) at two-way time `t`, m, and the time of flight, s.
///
/// The time of flight is to the pixel and back to element `m`.
pub fn flight(scan_line: &ScanLine, m: usize, c: f64, t: f64) -> ([f64; 2], f64) {
    let r = c * t / 2.0;
    let ray = &scan_line.ray;
    let (x, z) = (
        ray.x() + r * ray.angle().sin(),
        ray.z() + r * ray.angle().cos(),
    );
    let transmit = match scan_line.transmit.law {
        TransmitLaw::Focused => r,
        TransmitLaw::Plane { angle } => x * angle.sin() + z * angle.cos(),
        TransmitLaw::Element { x: ex, z: ez } => (x - ex).hypot(z - ez),
        TransmitLaw::VirtualSource { x: sx, z: sz } => {
            let (distance, range) = ((x - sx).hypot(z - sz), sx.hypot(sz));
            match (sz > 0.0, z < sz) {
                (false, _) => distance - range,
                (true, true) => range - distance,
                (true, false) => range + distance,
            }
        }
        TransmitLaw::Delays(delays) => {
            let mut first = f64::INFINITY;
            for (m, &delay) in delays.iter().enumerate() {
                let (ex, ez) = position(&scan_line.array, m);
                if delay.is_finite() {
                    first = first.min(c * delay + (x - ex).hypot(z - ez));
                }
            }
            first
        }
    };
    let (ex, ez) = position(&scan_line.array, m);
    ([x, z], (transmit + (x - ex).hypot(z - ez)) / c)
}

/// The position of an element, m.
fn position(array: &Array, m: usize) -> (f64, f64) {
    match array {
        Array::Linear { elements, pitch } => {
            ((m as f64 - (elements - 1) as f64 / 2.0) * pitch, 0.0)
        }
        Array::LinearAt(x) => (x[m], 0.0),
        Array::At { elements, .. } => (elements[m].x, elements[m].z),
        _ => unimplemented!("an array of another kind"),
    }
}

/// The band-limited record at `position`; 0 at depths of 0 and less.
///
/// The band ends at the lower of the Nyquist frequencies of the record and the output.
fn read(p: &DelayParameters, record: &[f32], position: f64, t: f64) -> f64 {
    if t <= 0.0 {
        return 0.0;
    }
    let cutoff = (p.output_rate / p.sampling_rate).min(1.0);
    let half = LOBES / cutoff;
    let first = (position - half).ceil().max(0.0) as usize;
    let end = (position + half).floor().min(record.len() as f64 - 1.0);
    let mut sum = 0.0;
    let mut k = first;
    while k as f64 <= end {
        let u = position - k as f64;
        sum += f64::from(record[k]) * cutoff * sinc(cutoff * u) * hann(u / half);
        k += 1;
    }
    sum
}

pub(super) fn sinc(x: f64) -> f64 {
    if x == 0.0 {
        1.0
    } else {
        (PI * x).sin() / (PI * x)
    }
}

/// A cosine-squared window over −1..1.
pub(super) fn hann(position: f64) -> f64 {
    (PI / 2.0 * position).cos().powi(2)
}

/// Doubles the positive frequencies of a DFT and removes the negative ones.
fn keep_positive(spectrum: &mut [Complex<f64>]) {
    let samples = spectrum.len();
    for (k, value) in spectrum.iter_mut().enumerate() {
        if k > 0 && 2 * k < samples {
            *value *= 2.0;
        } else if 2 * k > samples {
            *value = Complex::new(0.0, 0.0);
        }
    }
}
