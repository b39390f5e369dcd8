//! The delay stage: one line of a small record, by each transmit law, and the three added up.
//!
//! The record is the real parts of the golden snapshots read as 8 elements of 192 samples: numbers
//! for the arithmetic, not a scene.

use bonebeam::focus::{Compounding, Delay, DelayParameters, Record, ScanLine};
use bonebeam::geometry::{Active, Array, Ray, Transmit, TransmitLaw};
use bonebeam::simd::Vector;
use bonebeam::{Complex, Error};

use crate::hash;
use crate::snapshots::{LENGTH, REAL_PARTS};

/// Elements of the array.
pub const ELEMENTS: usize = 8;
/// The elements' positions, m.
pub const ELEMENT_X: [f64; ELEMENTS] = [
    -1.05e-3, -0.75e-3, -0.45e-3, -0.15e-3, 0.15e-3, 0.45e-3, 0.75e-3, 1.05e-3,
];
/// Hilbert taps a side.
pub const HILBERT_TAPS: usize = 8;
/// Samples of the line.
pub const SAMPLES: usize = 64;

/// From 40 MHz to 20 MHz.
pub const PARAMETERS: DelayParameters = DelayParameters {
    sound_speed: 1540.0,
    sampling_rate: 40e6,
    centre_frequency: 5e6,
    output_rate: 20e6,
    output_start: 0.5e-6,
    output_samples: SAMPLES,
    elements: ELEMENTS,
    record_samples: LENGTH / ELEMENTS,
    hilbert_taps: HILBERT_TAPS,
};
const SCRATCH: usize = PARAMETERS.scratch_len(1);

/// The lines and what their hashes are called, in this order into one output: the first
/// replaces what stands there, the others add to it.
pub const LINES: [(&str, ScanLine<'static>); 3] = [
    (
        "delay-focused",
        line(TransmitLaw::Focused, Compounding::Replace),
    ),
    (
        "delay-focused-plane",
        line(TransmitLaw::Plane { angle: 0.1 }, Compounding::Add),
    ),
    (
        "delay-focused-plane-element",
        line(
            TransmitLaw::Element { x: 0.45e-3, z: 0.0 },
            Compounding::Add,
        ),
    ),
];

const fn line(law: TransmitLaw<'static>, compounding: Compounding) -> ScanLine<'static> {
    ScanLine {
        transmit: Transmit { law, t0: 0.1e-6 },
        ray: Ray::down(0.2e-3),
        array: Array::LinearAt(&ELEMENT_X),
        active: Active { first: 1, count: 6 },
        compounding,
    }
}

/// The memory of the cases.
pub struct Memory {
    scratch: [f32; SCRATCH],
    x: [Complex<f32>; SAMPLES * ELEMENTS],
}

impl Memory {
    pub(crate) const fn new() -> Self {
        Memory {
            scratch: [0.0; SCRATCH],
            x: [Complex::new(0.0, 0.0); SAMPLES * ELEMENTS],
        }
    }
}

impl Memory {
    /// Scratch and output.
    pub(crate) fn slices(&mut self) -> (&mut [f32], &mut [Complex<f32>]) {
        (&mut self.scratch, &mut self.x)
    }
}

pub(crate) fn run(memory: &mut Memory, report: &mut impl FnMut(&str, u64)) -> Result<(), Error> {
    let (scratch, x) = memory.slices();
    lines(0.0f32, scratch, x, report)
}

/// All lines. `scratch` is as long as the vector's lanes ask for.
pub(crate) fn lines<V: Vector>(
    zero: V,
    scratch: &mut [f32],
    x: &mut [Complex<f32>],
    report: &mut dyn FnMut(&str, u64),
) -> Result<(), Error> {
    let delay = Delay::new(PARAMETERS)?;
    let record = Record::new(&REAL_PARTS, ELEMENTS)?;
    for (name, line) in LINES {
        delay.line(zero, &line, &record, scratch, x)?;
        report(name, hash::complex(x));
    }
    Ok(())
}
