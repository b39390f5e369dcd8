//! Grey levels of lines → the bone surface: a depth or none for each line.
//!
//! Bone is bright above and dark below. A line's samples are joined to cells, of 0.12 mm by default
//! ([`Settings::cell`]). Each cell gets a score, in nats, of five terms (see [`Settings`]): the shadow onset, the
//! echo's contrast with the tissue above, the change of level over centimetres, the brightest level below, and the
//! shadow down to the end of the line. A Viterbi search over the lines finds the path with the largest sum. The
//! path has a cell or absence in each line, with prices of moves, jumps, starts and ends.
//!
//! [`Parameters`] give the plan, a [`Detector`]. A [`Tracker`] is a plan with its memory, a
//! [`Scratch`](crate::memory::Scratch). [`Detector::frame`] computes a whole frame; a tracker takes line after line
//! with bounded latency. A map of the samples'
//! [coherence](crate::beamform::ShortLagCoherence) is an optional sixth term, where clutter may fill the shadow.
//!
//! Scores and paths are integers, from grey levels of eight bits ([`grey`]): means in 1/16 of a level, scores in 1/1024
//! nat. The bits are therefore the same on every target, in any order of the sums.
//!
//! ```
//! use bonebeam::geometry::Axis;
//! use bonebeam::memory::Scratch;
//! use bonebeam::surface::{Detector, Parameters, Settings};
//!
//! // 24 lines of 30 mm: tissue of grey level 100, bone at 12 mm, nothing below.
//! let samples = Axis { first: 0.0, step: 0.04e-3, count: 750 };
//! let detector = Detector::new(Parameters { samples, spacing: 0.3e-3, settings: Settings::DEFAULT, latency: 23 })?;
//! let mut line = vec![100u8; 300];
//! line.extend([220; 8]);
//! line.resize(750, 10);
//! let frame = line.repeat(24);
//!
//! let mut real = vec![0.0; detector.need().real];
//! let mut surface = vec![None; 24];
//! let scratch = Scratch { real: &mut real, complex: &mut [] };
//! detector.frame(&frame, scratch, &mut surface)?;
//! let depth = surface[12].map(|point| point.depth).unwrap_or_default();
//! assert!((depth - 12.1e-3).abs() < 0.2e-3);
//! # Ok::<(), bonebeam::Error>(())
//! ```

mod detector;
mod frame;
mod learnt;
mod levels;
mod logarithm;
mod onset;
mod parameters;
mod track;
pub mod weights;

pub use detector::Detector;
pub use levels::Survey;
pub use onset::Levels;
pub use parameters::{Parameters, Ramp, Settings};
pub use track::{Point, Tracker};

use crate::Error;
use crate::error::check_length;

/// Rounds grey levels to integers from 0 to 255.
///
/// ```
/// let mut grey = [0; 4];
/// bonebeam::surface::grey(&[0.4, 127.5, 254.6, 300.0], &mut grey)?;
/// assert_eq!(grey, [0, 128, 255, 255]);
/// # Ok::<(), bonebeam::Error>(())
/// ```
///
/// # Errors
/// [`Error::Length`] if `out` and `levels` differ in length; [`Error::NonFinite`] with the index of the first bad
/// level. `out` is then unchanged.
pub fn grey(levels: &[f32], out: &mut [u8]) -> Result<(), Error> {
    check_length("grey levels", out.len(), levels.len())?;
    if let Some(index) = levels.iter().position(|level| !level.is_finite()) {
        return Err(Error::NonFinite {
            name: "levels",
            index,
        });
    }
    for (out, &number) in out.iter_mut().zip(levels) {
        *out = level(number);
    }
    Ok(())
}

/// The nearest integer from 0 to 255.
pub(crate) fn level(level: f32) -> u8 {
    // The cast saturates.
    (level + 0.5) as u8
}
