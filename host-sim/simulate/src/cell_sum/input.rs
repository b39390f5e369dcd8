//! The input of a sum: scatterers, elements, beams, and the time axes.

use crate::cells::Cell;
use crate::pulse::Pulse;
use crate::response::Response;
use crate::scatterer::PointSource;
use crate::shadow::Shadow;
use crate::time_axis::Window;

pub struct CellSumInput<'a> {
    /// The scatterers.
    pub sources: &'a [PointSource],
    /// The scatterers, grouped into cells.
    pub cells: &'a [Cell],
    /// Visibility of the scatterers for the elements.
    pub shadow: &'a Shadow,
    /// The elements' lateral positions, m.
    pub element_x: &'a [f64],
    /// An element's response.
    pub response: Response,
    /// The two-way pulse.
    pub pulse: Pulse,
    /// The time axes.
    pub window: Window,
    /// Whether each element transmits.
    ///
    /// A pair without a transmitting element is left out.
    pub transmits: &'a [bool],
    /// The beams, if they are so few that their transmits are summed first.
    ///
    /// Rows are then for a beam and an element instead of two elements.
    pub beams: Option<&'a [Beam]>,
}

/// A transmit beam: its axis, its elements, and how early each fires.
pub struct Beam {
    /// Lateral position of the axis, m.
    pub x: f64,
    /// The elements that fire.
    pub elements: std::ops::Range<usize>,
    /// Firing advance of each element relative to one on the axis, s.
    pub advance: Vec<f64>,
}

impl CellSumInput<'_> {
    /// Number of required pairs of elements.
    pub fn pairs(&self) -> usize {
        let elements = self.element_x.len();
        let of = |i: usize| (i..elements).filter(move |&j| self.transmits[i] || self.transmits[j]);
        (0..elements).map(|i| of(i).count()).sum()
    }

    /// Whether the pair, or the beam and the element, is required.
    pub fn wants(&self, i: usize, j: usize) -> bool {
        self.beams.is_some() || i <= j && (self.transmits[i] || self.transmits[j])
    }
}
