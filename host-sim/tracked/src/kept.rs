//! The surfaces of an interrupted sweep.

use std::path::Path;

use bonebeam_drive::surface::SurfacePoint;
use bonebeam_files::{PartialFrames, hash_of_array};
use ndarray::ArrayView1;

use crate::Result;
use crate::finder::Finder;
use crate::sequence::Sequence;
use crate::transforms::Matrix;

/// Numbers of a point.
const NUMBERS: usize = 5;

/// Opens the file beside the output of a run of this program with these settings, and keeps the frames of the same pictures.
///
/// # Errors
/// A file that cannot be read, or a damaged sequence.
pub(crate) fn open(
    (output, program): (&Path, &str),
    sequence: &Sequence,
    finder: &Finder,
    frames: &[(usize, Matrix)],
) -> Result<PartialFrames> {
    let frames: Vec<usize> = frames.iter().map(|(frame, _)| *frame).collect();
    let key = format!("{program} {finder:?} {frames:?}");
    let key = hash_of_array(&ArrayView1::from(key.as_bytes()));
    let mut partial = PartialFrames::beside(output, key)?;
    let mut reader = sequence.reader()?;
    partial.keep(|k| {
        let picture = sequence.picture(reader.frame(frames[k])?)?;
        Ok(hash_of_array(&finder.part_of(picture).view()))
    })?;
    Ok(partial)
}

/// The bytes of a frame's points.
pub(crate) fn encoded(points: &[SurfacePoint]) -> Vec<u8> {
    let of = |p: &SurfacePoint| -> [u64; NUMBERS] {
        let [x, z] = [p.x, p.z].map(f64::to_bits);
        [
            p.line as u64,
            x,
            z,
            p.confidence.to_bits().into(),
            p.piece as u64,
        ]
    };
    points
        .iter()
        .flat_map(of)
        .flat_map(u64::to_le_bytes)
        .collect()
}

/// The points of [`encoded`].
pub(crate) fn decoded(bytes: &[u8]) -> Option<Vec<SurfacePoint>> {
    let (numbers, rest) = bytes.as_chunks();
    let numbers: Vec<u64> = numbers.iter().copied().map(u64::from_le_bytes).collect();
    let (points, odd) = numbers.as_chunks();
    let of = |&[line, x, z, confidence, piece]: &[u64; NUMBERS]| SurfacePoint {
        line: line as usize,
        x: f64::from_bits(x),
        z: f64::from_bits(z),
        confidence: f32::from_bits(confidence as u32),
        piece: piece as usize,
    };
    (rest.is_empty() && odd.is_empty()).then(|| points.iter().map(of).collect())
}
