//! Output of a line.

use super::coherence_map::CoherenceRow;
use crate::Complex;
use crate::geometry::Steering;

/// Output of a line.
pub(super) struct Output<'a> {
    /// The directions of its sub-lines; `None` for the line alone.
    pub(super) steering: Option<Steering<'a>>,
    /// `[sample][sub-line]`.
    pub(super) z: &'a mut [Complex<f32>],
    /// The coherence of its samples, if it is wanted.
    pub(super) coherence: Option<CoherenceRow<'a>>,
}

impl<'a> Output<'a> {
    /// Without coherence.
    pub(super) fn new(steering: Option<Steering<'a>>, z: &'a mut [Complex<f32>]) -> Self {
        Output {
            steering,
            z,
            coherence: None,
        }
    }
}
