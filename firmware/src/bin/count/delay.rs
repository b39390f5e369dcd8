//! The delay stage, for records of three rates: RF to aligned analytic samples at 20 MHz.

use bonebeam::delay::hilbert_taps;
use bonebeam::prelude::stages::*;
use firmware::arrays;
use static_cell::ConstStaticCell;

use crate::counter::Counter;
use crate::input;
use crate::report;

const ELEMENTS: usize = 64;
const PITCH: f64 = 0.308e-3;
const OUTPUTS: usize = 256;
const OUTPUT_RATE: f64 = 20e6;
const CENTRE_FREQUENCY: f64 = 5e6;
/// Sound speed, m/s, and two-way time of the first sample, 10 mm deep, s.
const SOUND_SPEED: f64 = 1540.0;
const START: f64 = 2.0 * 10e-3 / SOUND_SPEED;
/// Output samples of the record beyond the first and the last sample on the axis.
const BEYOND: usize = 32;
pub const FASTEST: usize = 5;
const SCRATCH: usize = parameters(FASTEST).need(1).real;

/// Ratio of sampling rate to output rate, and bound on the instructions.
///
/// The bound is per output sample of an element (see `beamform.rs`).
const CASES: [(usize, u32); 3] = [(1, 595), (2, 765), (FASTEST, 910)];

/// Parameters for a record at `ratio` times the output rate.
pub const fn parameters(ratio: usize) -> DelayParameters {
    DelayParameters {
        sound_speed: SOUND_SPEED,
        sampling_rate: ratio as f64 * OUTPUT_RATE,
        centre_frequency: CENTRE_FREQUENCY,
        output_rate: OUTPUT_RATE,
        output_start: START,
        output_samples: OUTPUTS,
        elements: ELEMENTS,
        record_samples: ratio * (OUTPUTS + 2 * BEYOND),
        hilbert_taps: hilbert_taps(OUTPUT_RATE, CENTRE_FREQUENCY),
    }
}

arrays! {
    /// The memory of the cases.
    struct Workspaces {
        rf: [f32; ELEMENTS * FASTEST * (OUTPUTS + 2 * BEYOND)] = [0.0; _],
        scratch: [f32; SCRATCH] = [0.0; _],
        out: [Complex<f32>; ELEMENTS * OUTPUTS] = [Complex::ZERO; _],
    }
}
static WORKSPACES: ConstStaticCell<Workspaces> = ConstStaticCell::new(Workspaces::new());

/// Counts every case; returns whether all stay within their bounds.
///
/// The check of the record is included.
pub fn run(counter: &mut Counter) -> Result<bool, Error> {
    let workspaces = WORKSPACES.take();
    let element_x: [f64; ELEMENTS] = core::array::from_fn(|m| m as f64 * PITCH);
    let mut within = true;
    for (ratio, bound) in CASES {
        let parameters = parameters(ratio);
        let delay = Delay::new(parameters)?;
        let line = ScanLine::new(
            Transmit::new(TransmitLaw::Focused, START - BEYOND as f64 / OUTPUT_RATE),
            Ray::down(0.5 * (ELEMENTS - 1) as f64 * PITCH),
            Array::LinearAt(&element_x),
        );
        let rf = &mut workspaces.rf[..ELEMENTS * parameters.record_samples];
        input::rf(rf);
        let scratch = &mut workspaces.scratch[..parameters.need(1).real];
        let scratch_bytes = size_of_val(scratch);
        let out = &mut workspaces.out;
        let cost = counter.cost(|| {
            let record = Record::new(rf, ELEMENTS)?;
            delay.line(0.0f32, &line, &record, scratch, out)
        })?;
        let bytes = Delay::BYTES + scratch_bytes;
        within &= report("delay", 20 * ratio, ELEMENTS * OUTPUTS, &cost, bytes, bound);
    }
    Ok(within)
}
