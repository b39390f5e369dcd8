//! What a delay stage focuses: one scan line of one transmit.

use crate::geometry::{Active, Array, Ray, Scan, Transmit};

/// Coherent compounding: what becomes of the line that `out` holds already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Compounding {
    /// Overwrite it; elements that are not active become 0.
    Replace,
    /// Add to it, as the next of several transmits; other elements stay as they are.
    Add,
}

/// One scan line of one transmit.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ScanLine<'a> {
    /// The transmit.
    pub transmit: Transmit<'a>,
    /// The line.
    pub ray: Ray,
    /// Where the elements are.
    pub array: Array<'a>,
    /// Elements to compute: the active ones of the deepest sample include all shallower ones'.
    pub active: Active,
    /// Overwrite or add.
    pub compounding: Compounding,
}

impl<'a> ScanLine<'a> {
    /// Line `line` of a scan.
    pub fn of(
        scan: &Scan<'a>,
        line: usize,
        transmit: Transmit<'a>,
        compounding: Compounding,
    ) -> Self {
        let p = scan.parameters();
        ScanLine {
            transmit,
            ray: scan.ray(line),
            array: p.array,
            active: scan.widest(line),
            compounding,
        }
    }
}
