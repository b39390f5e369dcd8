//! The core's beamformer in the sections: one beam per lane, one thread.

use bonebeam::beamform::{AlignedLine, Beamformer, Parameters, Segment};
use bonebeam::covariance::Covariance;
use bonebeam::simd::InstructionSet;
use ndarray::{Array2, Array3, Axis};
use num_complex::Complex;

use crate::Result;
use bonebeam_drive::beamform::Needs;

/// Beamforms all lines into `z [beam, sample]`.
pub type Core<'a> = dyn FnMut(&mut Array2<Complex<f32>>) -> Result<()> + 'a;

/// Callback with a beamformer whose memory is allocated.
pub type Then<'a> = dyn FnMut(&mut Core<'_>) -> Result<()> + 'a;

/// Makes a beamformer of `lines [beam, sample, element]` and passes it to `then`.
///
/// All elements are active. Beams are in the lanes of `set`.
///
/// # Errors
/// The errors of the core and of `then`.
pub fn with_core(
    set: InstructionSet,
    parameters: Parameters,
    covariance: Covariance,
    lines: &Array3<Complex<f32>>,
    then: &mut Then<'_>,
) -> Result<()> {
    let beamformer = Beamformer::new(parameters)?;
    let elements = lines.dim().2;
    let needs = Needs {
        covariance,
        sizes: beamformer.sizes(elements),
    };
    let mut memory = needs.memory(set)?;
    let mut segments = Vec::new();
    for line in lines.axis_iter(Axis(0)) {
        let line = line.to_slice().expect("a standard layout");
        segments.push(Segment {
            line: AlignedLine::new(line, elements)?,
            first_element: 0,
            first_sample: 0,
        });
    }
    then(&mut |z| {
        let mut rows: Vec<&mut [Complex<f32>]> = z
            .outer_iter_mut()
            .map(|row| row.into_slice().expect("a standard layout"))
            .collect();
        let lanes = memory.lanes();
        for (segments, z) in segments.chunks(lanes).zip(rows.chunks_mut(lanes)) {
            memory.segments(&beamformer, segments, elements, z)?;
        }
        Ok(())
    })
}
