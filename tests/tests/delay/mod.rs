//! The delay stage: its invariants and its limits. `geometry.rs` has echoes and the f64 reference.

mod bits;
mod echoes;
pub mod frames;
mod limits;

use crate::common;
use crate::common::kit::*;
use common::delays::{C, F0, aligned, line_up, noise, rf_line};
use common::tolerances::DELAY_SHIFT;
use ndarray::Axis;

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
        sampling_rate: fs,
        output_rate: fout,
        output_samples: (record_samples as f64 * fout / fs) as usize + 7,
        elements,
        record_samples,
        hilbert_taps: HILBERT_TAPS,
        ..DelayParameters::EXAMPLE
    }
}

/// The line at 0.3 mm with all elements, recorded from t = 0.
fn line_of<'a>(law: TransmitLaw<'a>, element_x: &'a [f64]) -> ScanLine<'a> {
    ScanLine::new(
        Transmit::new(law, 0.0),
        Ray::down(0.3e-3),
        Array::LinearAt(element_x),
    )
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
