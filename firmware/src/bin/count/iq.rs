//! The delay stage from I/Q, 16-bit counts as a front end sends them, by each reading.

use bonebeam::prelude::stages::*;
use firmware::arrays;
use static_cell::ConstStaticCell;

use crate::counter::Counter;
use crate::report;

const ELEMENTS: usize = 64;
const PITCH: f64 = 0.308e-3;
const OUTPUTS: usize = 128;
const RATE: f64 = 10e6;
const RECORD: usize = OUTPUTS + 32;
/// Sound speed, m/s, and two-way time of the first sample, 10 mm deep, s.
const SOUND_SPEED: f64 = 1540.0;
const START: f64 = 2.0 * 10e-3 / SOUND_SPEED;

/// A reading, its name, its taps, and the bound on the instructions.
///
/// The bound is per output sample of an element (see `beamform.rs`).
const CASES: [(IqInterpolation, &str, usize, u32); 4] = [
    (IqInterpolation::LinearFixed, "iq-fixed", 2, 63),
    (IqInterpolation::Linear, "iq", 2, 255),
    (IqInterpolation::Cubic, "iq", 4, 340),
    (IqInterpolation::Sinc, "iq", 12, 700),
];

pub const PARAMETERS: IqParameters = IqParameters {
    sound_speed: SOUND_SPEED,
    sampling_rate: RATE,
    demodulation_frequency: 5e6,
    output_rate: RATE,
    output_start: START,
    output_samples: OUTPUTS,
    elements: ELEMENTS,
    record_samples: RECORD,
    interpolation: IqInterpolation::Linear,
};
const SCRATCH: usize = PARAMETERS.need(1).real;

arrays! {
    /// The memory of the cases.
    struct Workspaces {
        counts: [[i16; 2]; ELEMENTS * RECORD] = [[0; 2]; _],
        scratch: [f32; SCRATCH] = [0.0; _],
        out: [Complex<f32>; ELEMENTS * OUTPUTS] = [Complex::ZERO; _],
    }
}
static WORKSPACES: ConstStaticCell<Workspaces> = ConstStaticCell::new(Workspaces::new());

/// Counts every case; returns whether all stay within their bounds.
///
/// The check of the record is included.
pub fn run(counter: &mut Counter) -> Result<bool, Error> {
    let Workspaces {
        counts,
        scratch,
        out,
    } = WORKSPACES.take();
    for (n, count) in counts.iter_mut().enumerate() {
        let n = n as i32;
        *count = [
            (n * 7919 % 2001 - 1000) as i16,
            (n * 104_729 % 2001 - 1000) as i16,
        ];
    }
    let line = ScanLine::new(
        Transmit::new(TransmitLaw::Focused, START - 4.0 / RATE),
        Ray::down(0.0),
        Array::linear(ELEMENTS, PITCH),
    );
    let mut within = true;
    for (interpolation, name, taps, bound) in CASES {
        let delay = IqDelay::new(IqParameters {
            interpolation,
            ..PARAMETERS
        })?;
        let cost = counter.cost(|| {
            let samples = IqSamples::Counts(counts, 1e-3);
            let record = Record::iq(samples, IqLayout::Interleaved, ELEMENTS)?;
            delay.line(0.0f32, &line, &record, scratch, out)
        })?;
        let bytes = IqDelay::BYTES + size_of_val(scratch);
        within &= report(name, taps, ELEMENTS * OUTPUTS, &cost, bytes, bound);
    }
    Ok(within)
}
