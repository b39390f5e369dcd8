//! The core's beamformer in the sections: one beam per lane, one thread.

use bonebeam::beamform::{AlignedLine, Beamformer, Parameters, Segment, SteeredSegments};
use bonebeam::geometry::Steering;
use bonebeam::simd::InstructionSet;
use ndarray::{Array2, Array3, Axis};
use num_complex::Complex;

use crate::Result;
use bonebeam_drive::beamform::memory;

/// Beamforms all lines into `z`, `[beam, sample]` or `[beam, sample and sub-line]`.
pub type Core<'a> = dyn FnMut(&mut Array2<Complex<f32>>) -> Result<()> + 'a;

/// Callback with a beamformer whose memory is allocated.
pub type Then<'a> = dyn FnMut(&mut Core<'_>) -> Result<()> + 'a;

/// Makes a beamformer of `lines [beam, sample, element]` and passes it to `then`.
///
/// All elements are active. Beams are in the lanes of `set`. Sub-lines have the directions of [`steered`].
///
/// # Errors
/// The errors of the core and of `then`.
pub fn with_core(
    set: InstructionSet,
    parameters: Parameters,
    lines: &Array3<Complex<f32>>,
    then: &mut Then<'_>,
) -> Result<()> {
    let beamformer = Beamformer::new(parameters)?;
    let elements = lines.dim().2;
    let mut memory = memory(set, beamformer.sizes(elements))?;
    let mut segments = Vec::new();
    for line in lines.axis_iter(Axis(0)) {
        let line = line.to_slice().expect("a standard layout");
        segments.push(Segment::new(AlignedLine::new(line, elements)?, 0, 0));
    }
    let sub_lines = parameters.sub_lines;
    let directions = steered(lines.dim().1, sub_lines);
    let steering = vec![Steering::of(&directions, sub_lines); memory.lanes()];
    then(&mut |z| {
        let mut rows: Vec<&mut [Complex<f32>]> = z
            .outer_iter_mut()
            .map(|row| row.into_slice().expect("a standard layout"))
            .collect();
        let lanes = memory.lanes();
        for (segments, z) in segments.chunks(lanes).zip(rows.chunks_mut(lanes)) {
            if sub_lines > 1 {
                let steering = &steering[..segments.len()];
                let lines = SteeredSegments::new(segments, steering);
                memory.sub_lines(&beamformer, lines, elements, z)?;
            } else {
                memory.segments(&beamformer, segments, elements, z)?;
            }
        }
        Ok(())
    })
}

/// Half of the phase from element to element of the outermost sub-lines, rad.
const OUTERMOST: f32 = 0.05;

/// Even directions of sub-lines, the same for all `samples`: `e^{js/2}` and `e^{−jφ_c}`, which is 1.
fn steered(samples: usize, sub_lines: usize) -> Vec<Complex<f32>> {
    let direction = |k: usize| {
        let part = (2 * k + 1) as f32 / sub_lines as f32 - 1.0;
        [
            Complex::from_polar(1.0, OUTERMOST * part),
            Complex::new(1.0, 0.0),
        ]
    };
    let of_sample = (0..sub_lines).flat_map(direction);
    let all = of_sample.cycle().take(2 * samples * sub_lines);
    all.collect()
}
