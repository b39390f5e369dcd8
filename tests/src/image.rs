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

/// Envelopes of lines that begin with the snapshots, with a depth step.
///
/// The name, the samples, the depth step and the sub-lines, cycles of the carrier from one of the samples to the next,
/// and the pooling of the sub-lines.
const INTERPOLATED: [(&str, [usize; 3], f64, Pooling); 3] = [
    ("depth-interpolation-2", [200, 2, 1], 0.25, Pooling::Largest),
    ("depth-interpolation-3-rms", [101, 3, 4], 0.31, Pooling::Rms),
    (
        "depth-interpolation-8-largest",
        [95, 8, 2],
        1.7,
        Pooling::Largest,
    ),
];

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
    for (name, [samples, depth_step, sub_lines], cycles, pooling) in INTERPOLATED {
        let interpolation = DepthInterpolation::new(samples, depth_step, cycles)?;
        let z = SNAPSHOTS.get(..interpolation.line_samples() * sub_lines);
        let (scratch, _) = scratch.split_at_mut(interpolation.need(sub_lines).complex);
        let (envelopes, _) = envelopes.split_at_mut(samples);
        let of_line = (sub_lines, pooling);
        interpolation.envelope(z.unwrap_or_default(), of_line, scratch, envelopes)?;
        report(name, hash::real(envelopes));
    }
    let interpolation = DepthInterpolation::new(150, 4, 0.2)?;
    let need = interpolation.need(1).complex;
    let (scratch, rest) = scratch.split_at_mut(need);
    let (out, _) = rest.split_at_mut(150);
    let z = SNAPSHOTS.get(..interpolation.line_samples());
    interpolation.line(z.unwrap_or_default(), scratch, out)?;
    report("depth-interpolation-line-4", hash::complex(out));
    Ok(())
}
