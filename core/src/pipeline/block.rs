//! Blocks of a line's aligned samples.

use crate::geometry::{Active, Scan};

/// A block of a line's aligned samples: its beginning and its elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Block {
    /// The line.
    pub line: usize,
    /// The first sample.
    pub first: usize,
    /// Elements that are computed; other elements are 0.
    ///
    /// A beamformer reads the elements that are active at a sample whose time window reaches the block. Deeper sets
    /// contain shallower ones.
    pub active: Active,
}

impl Block {
    /// A line from its first sample on, with every element that is active at any depth.
    pub fn of_line(scan: &Scan, line: usize) -> Self {
        Block {
            line,
            first: 0,
            active: scan.widest(line),
        }
    }
}
