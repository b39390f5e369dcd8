//! The delay stage on lines of a small record.
//!
//! One line by each transmit law, and their sum; a line of halved records; a line of upsampled records.
//!
//! The record is the real parts of the golden snapshots read as 8 elements of 192 samples: numbers
//! for the arithmetic, not a scene.

use bonebeam::delay::UPSAMPLING;
use bonebeam::prelude::stages::*;

use crate::snapshots::REAL_PARTS;
use crate::{arrays, hash};

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
    output_start: 0.5e-6,
    ..DelayParameters::EXAMPLE
};
/// From 100 MHz to 20 MHz: each record is halved twice first.
pub const HALVED: DelayParameters = DelayParameters {
    sampling_rate: 100e6,
    ..PARAMETERS
};
/// Scratch of the case that needs most.
const SCRATCH: usize = HALVED.need(1).real;

/// The lines and the names of their hashes, in this order into one output.
///
/// The first replaces the output, the others add to it.
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
        active: Active::new(1, 6),
        compounding,
        ..ScanLine::new(
            Transmit::new(law, 0.1e-6),
            Ray::down(0.2e-3),
            Array::LinearAt(&ELEMENT_X),
        )
    }
}

/// From 20 MHz to 20 MHz: the record's first 64 samples of each element, upsampled.
pub const UPSAMPLED: DelayParameters = DelayParameters {
    sampling_rate: 20e6,
    record_samples: 64,
    ..PARAMETERS
};
/// Values of a line: its samples and 15 at either end, up to full sixteens.
const VALUES: usize = 96;
/// Length of the upsampled record, with 16 filter taps and two more, and scratch.
const RECORD: usize = (64 + 16 + 2) * UPSAMPLING;
const PADDED: usize = 64 + 2 * 16 + 2 + 4;

arrays! {
    /// The memory of the cases.
    pub struct Memory {
        scratch: [f32; SCRATCH] = [0.0; _],
        x: [Complex<f32>; SAMPLES * ELEMENTS] = [Complex::ZERO; _],
        upsampled: UpsampledMemory = UpsampledMemory::new(),
    }
}
arrays! {
    /// The memory of the case of upsampled records.
    struct UpsampledMemory {
        record: [f32; RECORD] = [0.0; _],
        padded: [f32; PADDED] = [0.0; _],
        centre: [i32; VALUES] = [0; _],
        receive_delays: [i32; VALUES] = [0; _],
        values: [f32; 6 * VALUES] = [0.0; _],
    }
}

impl Memory {
    /// Scratch and output of [`PARAMETERS`].
    pub(crate) fn slices(&mut self) -> (&mut [f32], &mut [Complex<f32>]) {
        (&mut self.scratch[..PARAMETERS.need(1).real], &mut self.x)
    }
}

pub(crate) fn run(memory: &mut Memory, report: &mut impl FnMut(&str, u64)) -> Result<(), Error> {
    let Memory {
        scratch,
        x,
        upsampled,
    } = memory;
    lines(scratch, x, report)?;
    let scratch = &mut scratch[..UPSAMPLED.need(1).real];
    upsampled_lines(upsampled, scratch, x, report)?;
    filter_in_f32(memory, report)
}

/// The focused wave through a filter computed in f32.
fn filter_in_f32(memory: &mut Memory, report: &mut impl FnMut(&str, u64)) -> Result<(), Error> {
    let mut delay = Delay::new(PARAMETERS)?;
    delay.set_in_f32(PARAMETERS)?;
    let record = Record::new(&REAL_PARTS, ELEMENTS)?;
    let (scratch, x) = memory.slices();
    delay.line(0.0f32, &LINES[0].1, &record, scratch, x)?;
    report("delay-filter-f32", hash::complex(x));
    Ok(())
}

/// The focused and the plane wave, compounded from upsampled records.
fn upsampled_lines(
    memory: &mut UpsampledMemory,
    scratch: &mut [f32],
    x: &mut [Complex<f32>],
    report: &mut impl FnMut(&str, u64),
) -> Result<(), Error> {
    let delay = Delay::new(UPSAMPLED)?;
    let upsampled = Upsampled::new(&delay)?;
    memory.values.fill(0.0);
    for (_, line) in &LINES[..2] {
        upsampled.centre(line, &mut memory.centre)?;
        for (k, values) in memory
            .values
            .as_chunks_mut::<VALUES>()
            .0
            .iter_mut()
            .enumerate()
        {
            let element = line.active.first + k;
            let samples = &REAL_PARTS[element * 64..][..64];
            upsampled.receive_delays(0.0f32, line, element, &mut memory.receive_delays)?;
            upsampled.record(0.0f32, samples, &mut memory.padded, &mut memory.record)?;
            let contribution = Contribution {
                record: &memory.record,
                centre: &memory.centre,
                receive_delays: &memory.receive_delays,
            };
            upsampled.add(0.0f32, &contribution, values)?;
        }
    }
    upsampled.analytic(0.0f32, &LINES[0].1, &memory.values, scratch, x)?;
    report("delay-upsampled", hash::complex(x));
    Ok(())
}

/// All lines, and the first one of halved records, with scratch for [`HALVED`].
fn lines(
    scratch: &mut [f32],
    x: &mut [Complex<f32>],
    report: &mut impl FnMut(&str, u64),
) -> Result<(), Error> {
    let delay = Delay::new(PARAMETERS)?;
    let record = Record::new(&REAL_PARTS, ELEMENTS)?;
    for (name, line) in LINES {
        let scratch = &mut scratch[..PARAMETERS.need(1).real];
        delay.line(0.0f32, &line, &record, scratch, x)?;
        report(name, hash::complex(x));
    }
    let delay = Delay::new(HALVED)?;
    delay.line(0.0f32, &LINES[0].1, &record, scratch, x)?;
    report("delay-halved", hash::complex(x));
    Ok(())
}
