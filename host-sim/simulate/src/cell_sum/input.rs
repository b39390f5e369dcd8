//! The input of a sum: scatterers, elements, beams, and the time axes.

use crate::cells::Cell;
use crate::pulse::Pulse;
use crate::response::Response;
use crate::scatterer::PointSource;
use crate::shadow::Shadow;
use crate::time_axis::Window;

/// What the sum is made of.
pub struct CellSumInput<'a> {
    /// The scatterers.
    pub sources: &'a [PointSource],
    /// The same by cells.
    pub cells: &'a [Cell],
    /// Which elements hear which.
    pub shadow: &'a Shadow,
    /// The elements' lateral positions, m.
    pub element_x: &'a [f64],
    /// An element's response.
    pub response: Response,
    /// The two-way pulse.
    pub pulse: Pulse,
    /// The time axes.
    pub window: Window,
    /// The elements that transmit at all: a pair without one is left out.
    pub transmits: &'a [bool],
    /// The beams, where there are so few that their transmits are summed first: rows are then of a beam and
    /// an element in place of two elements.
    pub beams: Option<&'a [Beam]>,
}

/// A transmit beam: its axis, its elements and by how much each fires ahead.
pub struct Beam {
    /// Lateral position of the axis, m.
    pub x: f64,
    /// The elements that fire.
    pub elements: std::ops::Range<usize>,
    /// By how much each fires ahead of one on the axis, s.
    pub advance: Vec<f64>,
}

impl CellSumInput<'_> {
    /// How many pairs of elements are asked for.
    pub fn pairs(&self) -> usize {
        let elements = self.element_x.len();
        let of = |i: usize| (i..elements).filter(move |&j| self.transmits[i] || self.transmits[j]);
        (0..elements).map(|i| of(i).count()).sum()
    }

    /// Whether the pair, or the beam and the element, is asked for.
    pub fn wants(&self, i: usize, j: usize) -> bool {
        self.beams.is_some() || i <= j && (self.transmits[i] || self.transmits[j])
    }
}
