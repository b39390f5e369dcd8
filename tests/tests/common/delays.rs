//! Lines of the delay stages, and their scenes.

use bonebeam::prelude::stages::*;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::f64::consts::{PI, TAU};

pub const C: f64 = 1540.0;
pub const F0: f64 = 5e6;

pub fn noise(length: usize, seed: u64) -> Vec<f32> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..length).map(|_| rng.random_range(-1.0..1.0)).collect()
}

/// Lateral positions around 0.
pub fn line_up(elements: usize, pitch: f64) -> Vec<f64> {
    (0..elements)
        .map(|m| (m as f64 - (elements as f64 - 1.0) / 2.0) * pitch)
        .collect()
}

/// A convex array of 40 mm radius.
pub fn convex(elements: usize) -> Vec<Element> {
    (0..elements)
        .map(|m| Element::convex(elements, 0.3e-3, 40e-3, m))
        .collect()
}

/// Envelope of a Gaussian pulse with this bandwidth at −6 dB, Hz.
pub fn envelope(t: f64, bandwidth: f64) -> f64 {
    let a = (PI * bandwidth).powi(2) / (4.0 * 10f64.powf(6.0 / 20.0).ln());
    (-a * t * t).exp()
}

/// A Gaussian pulse of 5 MHz and 60 % bandwidth at −6 dB.
pub fn pulse(t: f64) -> f64 {
    envelope(t, 0.6 * F0) * (TAU * F0 * t).cos()
}

/// Arrival time of the wave at a point, from the definitions of the laws; `r` is the distance from the line's origin.
pub fn arrival(law: TransmitLaw, elements: &[[f64; 2]], [x, z]: [f64; 2], r: f64) -> f64 {
    match law {
        TransmitLaw::Focused => r / C,
        TransmitLaw::Plane { angle } => (x * angle.sin() + z * angle.cos()) / C,
        TransmitLaw::Element { x: ex, z: ez } => (x - ex).hypot(z - ez) / C,
        TransmitLaw::VirtualSource { x: sx, z: sz } => {
            let (distance, range) = ((x - sx).hypot(z - sz), sx.hypot(sz));
            if sz <= 0.0 {
                (distance - range) / C
            } else {
                (range + distance * (z - sz).signum()) / C
            }
        }
        TransmitLaw::Delays(delays) => {
            let waves = delays.iter().zip(elements);
            let fired = waves.filter(|(delay, _)| delay.is_finite());
            let times = fired.map(|(delay, [ex, ez])| delay + (x - ex).hypot(z - ez) / C);
            times.fold(f64::INFINITY, f64::min)
        }
    }
}

/// A line over one lane.
pub fn line_into<D: Stage>(delay: &D, line: &ScanLine, record: &Record, out: &mut [Complex<f32>]) {
    let samples = out.len() / line.array.elements();
    let mut scratch = vec![f32::NAN; delay.need(1, samples).real];
    delay.line(0.0f32, line, record, &mut scratch, out).unwrap();
}

/// [`line_into`] memory of its own: any output that is not overwritten shows.
pub fn aligned<D: Stage>(
    delay: &D,
    samples: usize,
    line: &ScanLine,
    record: &Record,
) -> Vec<Complex<f32>> {
    let mut out = vec![Complex::new(f32::NAN, f32::NAN); samples * line.array.elements()];
    line_into(delay, line, record, &mut out);
    out
}

pub fn rf_line(p: &DelayParameters, line: &ScanLine, rf: &[f32]) -> Vec<Complex<f32>> {
    let record = Record::new(rf, p.elements).unwrap();
    aligned(&Delay::new(*p).unwrap(), p.output_samples, line, &record)
}
