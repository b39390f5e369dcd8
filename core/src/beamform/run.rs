//! Samples of one beam with one active set.

use super::aligned_line::AlignedLine;
use crate::geometry::Active;

/// Consecutive samples of one beam that have one active set: what a lane works on.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Run<'a> {
    /// The beam.
    pub line: AlignedLine<'a>,
    /// The first active element.
    pub first_element: usize,
    /// The first sample that is put out.
    pub first_sample: usize,
}

/// Splits `0..samples` where the active set changes: `(first sample, number of samples, active)`.
pub fn constant_runs(
    samples: usize,
    active: impl Fn(usize) -> Active,
) -> impl Iterator<Item = (usize, usize, Active)> {
    let mut start = 0;
    core::iter::from_fn(move || {
        if start >= samples {
            return None;
        }
        let set = active(start);
        let mut end = start + 1;
        while end < samples && active(end) == set {
            end += 1;
        }
        let run = (start, end - start, set);
        start = end;
        Some(run)
    })
}
