//! Lines of a pipeline from I/Q counts, in blocks shorter than the aperture's growth, and sub-lines of one.

use bonebeam::beamform::Sizes;
use bonebeam::memory;
use bonebeam::prelude::stages::*;

use crate::iq::COUNTS;
use crate::snapshots::{ELEMENTS, SAMPLES};
use crate::{arrays, hash};

const SCAN: ScanParameters = ScanParameters {
    array: Array::linear(ELEMENTS, 0.2e-3),
    lines: Lines::Even(Axis::centred(3, 1.1e-3)),
    sampling_rate: 10e6,
    record_samples: SAMPLES,
    output_rate: 12e6,
    start: Depth::Seconds(0.4e-6),
    end: Depth::Seconds(4.0e-6),
    f_number: 0.7,
    ..ScanParameters::EXAMPLE
};
const BEAMFORMER: beamform::Parameters = beamform::Parameters {
    temporal_half_window: 1,
    ..beamform::Parameters::of(Method::Mv)
};
const LENGTH: usize = 44;
/// Samples of a block, and the further samples of its time windows.
const STRETCH: usize = 7;
const HELD: usize = STRETCH + 2;

/// Sub-lines of a line.
const SUB_LINES: usize = 4;
const OF_SUB_LINES: beamform::Parameters = beamform::Parameters {
    sub_lines: SUB_LINES,
    ..BEAMFORMER
};

const SIZES: Sizes = OF_SUB_LINES.sizes(ELEMENTS);
/// The elements' lags and the aligned samples.
const LINE: Need = Need::new(7 * ELEMENTS, HELD * ELEMENTS);
const NEED: Need = LINE.and(SIZES.need());

arrays! {
    /// The memory of the case.
    pub struct Memory {
        scratch: memory::Memory<{ NEED.real }, { NEED.complex }> = memory::Memory::new(),
        z: [Complex<f32>; LENGTH * SUB_LINES] = [Complex::ZERO; _],
        directions: [Complex<f32>; Steering::need(LENGTH, SUB_LINES).complex] = [Complex::ZERO; _],
    }
}

pub(crate) fn run(memory: &mut Memory, report: &mut impl FnMut(&str, u64)) -> Result<(), Error> {
    let input = IqInput {
        demodulation_frequency: 5.1e6,
        interpolation: None,
    };
    let lines = |scan, beamformer| LinePipeline::of_iq(Scan::of_iq(scan)?, input, beamformer);
    // Directions of the demodulation frequency, as in C.
    let of_sub_lines = ScanParameters {
        centre_frequency: input.demodulation_frequency,
        ..SCAN
    };
    let (one, several) = (lines(SCAN, BEAMFORMER)?, lines(of_sub_lines, OF_SUB_LINES)?);
    let samples = IqSamples::Counts(&COUNTS, 1e-3);
    let record = Record::iq(samples, IqLayout::Interleaved, ELEMENTS)?;
    // Two waves, compounded.
    let wave = |angle| (Transmit::new(TransmitLaw::Plane { angle }, 0.1e-6), &record);
    let waves = [wave(-0.1), wave(0.15)];
    let steering = Steering::new(several.scan(), 1, SUB_LINES, &mut memory.directions)?;
    let z = &mut memory.z;
    for (line, lines, name) in [
        (0, &one, "pipeline-iq-left"),
        (1, &one, "pipeline-iq-middle"),
        (1, &several, "sub-lines-pipeline-iq"),
    ] {
        let mut scratch = memory.scratch.scratch();
        let own = scratch.take(lines.need(1, STRETCH))?;
        let mut workspace = Workspace::new(0.0, SIZES, scratch)?;
        let sub_lines = lines.beamformer().parameters().sub_lines;
        let z = &mut z[..LENGTH * sub_lines];
        match sub_lines {
            1 => lines.line(line, waves, own, &mut workspace, z)?,
            _ => lines.sub_lines(line, waves, own, &mut workspace, (steering, z))?,
        }
        report(name, hash::complex(z));
    }
    Ok(())
}
