//! The delay stage: one column of a small record, by each transmit law, and the three added up.
//!
//! The record is the real parts of the golden snapshots read as 8 elements of 192 samples: numbers
//! for the arithmetic, not a scene.

use bonebeam::focus::analytic::HilbertTransformer;
use bonebeam::focus::delay::{Column, Delay, DelayParameters, Store};
use bonebeam::focus::delay_law::TransmitLaw;
use bonebeam::focus::record::Record;
use bonebeam::geometry::Active;
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
/// Samples of the column.
pub const SAMPLES: usize = 64;
const MARGIN: usize = 2 * HILBERT_TAPS - 1;
/// `Delay::scratch_len::<f32>()`, which is no constant.
const SCRATCH: usize = 4 * (SAMPLES + 2 * MARGIN).next_multiple_of(16) + (2 * MARGIN + 32) + 15;

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
};

/// The columns and what their hashes are called, in this order into one output: the first
/// replaces what stands there, the others add to it.
pub const COLUMNS: [(&str, Column<'static>); 3] = [
    (
        "delay-focused",
        column(TransmitLaw::Focused, Store::Replace),
    ),
    (
        "delay-focused-plane",
        column(TransmitLaw::Plane { angle: 0.1 }, Store::Add),
    ),
    (
        "delay-focused-plane-element",
        column(TransmitLaw::Element { x: 0.45e-3 }, Store::Add),
    ),
];

const fn column(law: TransmitLaw, store: Store) -> Column<'static> {
    Column {
        law,
        t0: 0.1e-6,
        x: 0.2e-3,
        element_x: &ELEMENT_X,
        active: Active { first: 1, count: 6 },
        store,
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

pub(crate) fn run(memory: &mut Memory, report: &mut impl FnMut(&str, u64)) -> Result<(), Error> {
    let delay = Delay::new(PARAMETERS, HilbertTransformer::new(HILBERT_TAPS)?)?;
    let record = Record::new(&REAL_PARTS, ELEMENTS)?;
    for (name, column) in COLUMNS {
        delay.column(0.0f32, &column, &record, &mut memory.scratch, &mut memory.x)?;
        report(name, hash::complex(&memory.x));
    }
    Ok(())
}
