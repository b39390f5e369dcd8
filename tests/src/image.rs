//! The image stage on the golden snapshots read as 32 beams of 48 samples.

use bonebeam::image::{envelope, largest, log_compression, log_compression_with, median, resample};
use bonebeam::prelude::stages::*;

use crate::snapshots::{ELEMENTS, LENGTH, SAMPLES, SNAPSHOTS};
use crate::{arrays, hash};

/// Rows and columns of the image.
pub const SIDE: usize = 64;
/// In dB.
pub const DYNAMIC_RANGE: f32 = 50.0;

/// The beams, as a share of the image's side.
pub const BEAMS: Axis = Axis::new(0.0, 1.0 / (ELEMENTS as f64 - 1.0), ELEMENTS);
/// The samples along a beam.
pub const DEPTHS: Axis = Axis::new(0.0, 1.0 / (SAMPLES as f64 - 1.0), SAMPLES);
/// The rows; the last ones are beyond the data.
pub const ROWS: Axis = Axis::new(0.0, 1.0 / 60.0, SIDE);
/// The columns; the first one is beyond the data.
pub const COLUMNS: Axis = Axis::new(-0.01, 1.0 / 63.0, SIDE);

/// A case of envelopes of a line with a depth step.
#[derive(Clone, Copy, Debug)]
pub struct Interpolated {
    /// Envelopes of the line.
    pub samples: usize,
    /// The depth step.
    pub depth_step: usize,
    /// Cycles of the carrier from one of the samples to the next.
    pub cycles: f64,
    /// Sub-lines of the line.
    pub sub_lines: usize,
    /// Pooling of the sub-lines.
    pub pooling: Pooling,
}

/// The cases of envelopes, with their names. Lines begin with the snapshots.
pub const INTERPOLATED: [(&str, Interpolated); 3] = [
    (
        "depth-interpolation-2",
        Interpolated {
            samples: 200,
            depth_step: 2,
            cycles: 0.25,
            sub_lines: 1,
            pooling: Pooling::Largest,
        },
    ),
    (
        "depth-interpolation-3-rms",
        Interpolated {
            samples: 101,
            depth_step: 3,
            cycles: 0.31,
            sub_lines: 4,
            pooling: Pooling::Rms,
        },
    ),
    (
        "depth-interpolation-8-largest",
        Interpolated {
            samples: 95,
            depth_step: 8,
            cycles: 1.7,
            sub_lines: 2,
            pooling: Pooling::Largest,
        },
    ),
];

/// The case of a line at all samples, computed from every fourth of them.
pub const LINE: &str = "depth-interpolation-line-4";
/// Number of its samples.
pub const LINE_SAMPLES: usize = 150;
/// Cycles of its carrier from one sample to the next.
pub const LINE_CYCLES: f64 = 0.2;
/// Complex numbers of the cases' scratch and output.
const SCRATCH: usize = 256;

arrays! {
    /// The memory of the cases.
    pub struct Memory {
        envelope: [f32; LENGTH] = [0.0; _],
        levels: [f32; LENGTH] = [0.0; _],
        image: [f32; SIDE * SIDE] = [0.0; _],
        smooth: [f32; SIDE * SIDE] = [0.0; _],
        scratch: [Complex<f32>; SCRATCH] = [Complex::ZERO; _],
    }
}

pub(crate) fn run(memory: &mut Memory, report: &mut impl FnMut(&str, u64)) -> Result<(), Error> {
    let Memory {
        envelope: magnitudes,
        levels,
        image,
        smooth,
        scratch,
    } = memory;
    envelope(&SNAPSHOTS, magnitudes)?;
    report("envelope", hash::real(magnitudes));
    log_compression(magnitudes, largest(magnitudes), DYNAMIC_RANGE, levels)?;
    report("log-compression", hash::real(levels));
    let reference = largest(magnitudes);
    let by = Logarithm::Polynomial;
    // Written into the image's memory, so that the next step still has the first levels.
    let polynomial = &mut image[..LENGTH];
    log_compression_with(by, magnitudes, reference, DYNAMIC_RANGE, polynomial)?;
    report("log-compression-polynomial", hash::real(polynomial));
    resample(levels, [BEAMS, DEPTHS], [ROWS, COLUMNS], image)?;
    report("resample", hash::real(image));
    median(0.0f32, image, SIDE, smooth)?;
    report("median", hash::real(smooth));
    interpolations(magnitudes, scratch, report)
}

/// Envelopes of a line with sub-lines, and a line at all samples.
///
/// The sub-lines are the snapshots' elements. The line has one sub-line and a depth step.
fn interpolations(
    envelopes: &mut [f32],
    scratch: &mut [Complex<f32>],
    report: &mut impl FnMut(&str, u64),
) -> Result<(), Error> {
    for (name, case) in INTERPOLATED {
        let interpolation = DepthInterpolation::new(case.samples, case.depth_step, case.cycles)?;
        let z = SNAPSHOTS.get(..interpolation.line_samples() * case.sub_lines);
        let (scratch, _) = scratch.split_at_mut(interpolation.need(case.sub_lines).complex);
        let (envelopes, _) = envelopes.split_at_mut(case.samples);
        let of_line = (case.sub_lines, case.pooling);
        interpolation.envelope(z.unwrap_or_default(), of_line, scratch, envelopes)?;
        report(name, hash::real(envelopes));
    }
    let interpolation = DepthInterpolation::new(LINE_SAMPLES, 4, LINE_CYCLES)?;
    let need = interpolation.need(1).complex;
    let (scratch, rest) = scratch.split_at_mut(need);
    let (out, _) = rest.split_at_mut(LINE_SAMPLES);
    let z = SNAPSHOTS.get(..interpolation.line_samples());
    interpolation.line(z.unwrap_or_default(), scratch, out)?;
    report(LINE, hash::complex(out));
    Ok(())
}
