//! The delay stage: its invariants and its limits. `geometry.rs` has echoes and the f64 reference.

mod bits;
mod echoes;
pub mod frames;
mod limits;

use crate::common;
use bonebeam::Complex;
use bonebeam::delay::{Compounding, Delay, DelayParameters, Record, ScanLine, Stage};
use bonebeam::geometry::{Active, Array, Element, Ray, Transmit, TransmitLaw};
use bonebeam::simd::Vector;
use bonebeam_drive::config::Beamform;
use bonebeam_drive::delay::DelayStage;
use bonebeam_files::{ChannelData, Transmits};
use bonebeam_oracle::reference;
use common::assert_same_bits;
use common::tolerances::DELAY_SHIFT;
use ndarray::{Array3, Axis};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

const C: f64 = 1540.0;
const F0: f64 = 5e6;
const PITCH: f64 = 0.308e-3;
const HILBERT_TAPS: usize = 8;
const ZERO: Complex<f32> = Complex::new(0.0, 0.0);

const LAWS: [TransmitLaw<'static>; 3] = [
    TransmitLaw::Focused,
    TransmitLaw::Plane { angle: -0.15 },
    TransmitLaw::Element { x: 2.1e-3, z: 0.0 },
];

fn parameters(fs: f64, fout: f64, elements: usize, record_samples: usize) -> DelayParameters {
    DelayParameters {
        sound_speed: C,
        sampling_rate: fs,
        centre_frequency: F0,
        output_rate: fout,
        output_start: 0.0,
        output_samples: (record_samples as f64 * fout / fs) as usize + 7,
        elements,
        record_samples,
        hilbert_taps: HILBERT_TAPS,
    }
}

fn line_up(elements: usize) -> Vec<f64> {
    (0..elements)
        .map(|m| (m as f64 - (elements as f64 - 1.0) / 2.0) * PITCH)
        .collect()
}

fn noise(length: usize, seed: u64) -> Vec<f32> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..length).map(|_| rng.random_range(-1.0..1.0)).collect()
}

/// The line at 0.3 mm with all elements, recorded from t = 0.
fn line_of<'a>(law: TransmitLaw<'a>, element_x: &'a [f64]) -> ScanLine<'a> {
    ScanLine {
        transmit: Transmit { law, t0: 0.0 },
        ray: Ray::down(0.3e-3),
        array: Array::LinearAt(element_x),
        active: Active::new(0, element_x.len()),
        compounding: Compounding::Replace,
    }
}

fn core_line(p: &DelayParameters, line: &ScanLine, rf: &[f32]) -> Vec<Complex<f32>> {
    // Any output that is not overwritten shows.
    let mut out = vec![Complex::new(f32::NAN, f32::NAN); p.output_samples * p.elements];
    line_into(0.0f32, p, line, rf, &mut out);
    out
}

fn line_into<V: Vector>(
    zero: V,
    p: &DelayParameters,
    line: &ScanLine,
    rf: &[f32],
    out: &mut [Complex<f32>],
) {
    line_by(&Delay::new(*p).unwrap(), zero, line, rf, out);
}

fn line_by<V: Vector>(
    delay: &Delay,
    zero: V,
    line: &ScanLine,
    rf: &[f32],
    out: &mut [Complex<f32>],
) {
    let p = delay.parameters();
    let record = Record::new(rf, p.elements).unwrap();
    let mut scratch = vec![f32::NAN; p.need(V::LANES).real];
    delay.line(zero, line, &record, &mut scratch, out).unwrap();
}

/// Asserts that `ours` has the bits of the reference.
///
/// The reference has no lanes, blocks or shared tables.
fn assert_reference(
    ours: &[Complex<f32>],
    p: &DelayParameters,
    line: &ScanLine,
    rf: &[f32],
    what: &str,
) {
    // Any output that is not overwritten shows.
    let mut reference = vec![Complex::new(7.0, 7.0); ours.len()];
    reference::f32::delay::line(p, line, rf, &mut reference);
    assert_same_bits(ours, &reference, what);
}
