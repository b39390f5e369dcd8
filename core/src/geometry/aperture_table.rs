//! The apertures of a scan from a table.
//!
//! The number of active elements depends on the depth alone. Their indices depend on the line and that number. One
//! table of numbers therefore serves all lines, with integer arithmetic. With f64 in software, [`Scan::active`]
//! takes about 2,700 instructions, the table about 15.

use super::aperture::{GRID, GRID_BITS};
use super::{Active, Scan};
use crate::Error;
use crate::error::check_length;

/// Aperture width at each sample of a scan's lines.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ApertureTable<'m> {
    elements: i32,
    /// Numbers of elements before the cut at the array's ends, as whole numbers.
    widths: &'m [f32],
}

/// Aperture centre of a line, in half pitches from element 0, rounded up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ApertureCentre(i32);

impl<'m> ApertureTable<'m> {
    /// Computes the table in `memory`, once for all lines and frames of a scan.
    ///
    /// `memory` has [`Scan::samples`] numbers, contents irrelevant. Cost: a division and a rounding in f64 per sample,
    /// down to the first sample whose aperture is the whole array.
    ///
    /// ```
    /// # use bonebeam::geometry::{ApertureTable, Scan, ScanParameters};
    /// # let scan = Scan::new(ScanParameters::EXAMPLE)?;
    /// let mut memory = vec![0.0; scan.samples()];
    /// let table = ApertureTable::new(&scan, &mut memory)?;
    /// let centre = ApertureTable::centre(&scan, 20);
    /// assert_eq!(table.active(centre, 100), scan.active(20, 100));
    /// # Ok::<(), bonebeam::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Length`]; [`Error::Capacity`] for more than 2²⁴ elements, the limit of whole numbers in f32.
    pub fn new(scan: &Scan<'_>, memory: &'m mut [f32]) -> Result<Self, Error> {
        check_length("aperture table", memory.len(), scan.samples())?;
        const LARGEST: usize = 1 << f32::MANTISSA_DIGITS;
        if scan.elements() > LARGEST {
            return Err(Error::capacity("elements", scan.elements(), LARGEST));
        }
        let elements = scan.elements() as f32;
        let mut widths = memory.iter_mut().enumerate();
        for (sample, width) in widths.by_ref() {
            *width = scan.aperture().width(scan.depth(sample)) as f32;
            if *width == elements {
                break;
            }
        }
        // Deeper apertures are not narrower.
        for (_, width) in widths {
            *width = elements;
        }
        Ok(ApertureTable {
            elements: scan.elements() as i32,
            widths: memory,
        })
    }

    /// Aperture centre of a line; compute it once per line.
    pub fn centre(scan: &Scan<'_>, line: usize) -> ApertureCentre {
        let steps = libm::round(scan.aperture_centre(line) * GRID);
        // A line without a position is far away.
        let steps = if steps.is_nan() { FAR } else { steps as i64 };
        let halves = -((-2 * steps.clamp(-FAR, FAR)) >> GRID_BITS);
        ApertureCentre(halves as i32)
    }

    /// The active elements at a sample, equal to [`Scan::active`].
    ///
    /// No element is active beyond the last sample.
    pub fn active(&self, centre: ApertureCentre, sample: usize) -> Active {
        let none = Active::new(0, 0);
        let Some(&width) = self.widths.get(sample) else {
            return none;
        };
        let width = width as i32;
        // ⌈centre − width/2⌉ = ⌈(⌈2·centre⌉ − width)/2⌉; the shift rounds down, so the sign changes before and after.
        let first = -((width - centre.0) >> 1);
        let end = (first + width).min(self.elements);
        let first = first.max(0);
        if first < end {
            Active::new(first as usize, (end - first) as usize)
        } else {
            none
        }
    }
}

/// Beyond every array, and within the range of whole half pitches.
const FAR: i64 = 1 << (GRID_BITS + 28);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Array, Lines, ScanParameters};
    use std::vec;

    fn scan(elements: usize) -> Scan<'static> {
        let array = Array::linear(elements, 0.3e-3);
        let lines = Lines::At(&[0.0]);
        let parameters = ScanParameters {
            array,
            lines,
            ..ScanParameters::EXAMPLE
        };
        Scan::new(parameters).unwrap()
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let scan = scan(16);
        let mut memory = vec![0.0; scan.samples() + 1];
        assert_eq!(
            ApertureTable::new(&scan, &mut memory).err(),
            Some(Error::length(
                "aperture table",
                scan.samples() + 1,
                scan.samples()
            ))
        );
        let short = &mut memory[..scan.samples()];
        let table = ApertureTable::new(&scan, short).unwrap();
        assert_eq!(table.active(ApertureCentre(0), scan.samples()).count, 0);
        let many = self::scan((1 << 24) + 1);
        let refused = ApertureTable::new(&many, &mut memory[..many.samples()]);
        assert!(matches!(refused, Err(Error::Capacity { .. })));
    }
}
