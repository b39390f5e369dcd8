//! One scan line of one transmit: the input of a delay stage.

use crate::Complex;
use crate::geometry::{Active, Array, Ray, Scan, Transmit};
use crate::instructions::parts;

/// Coherent compounding: whether a line replaces `out` or is added to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Compounding {
    /// Overwrites `out`; elements that are not active become 0.
    Replace,
    /// Adds to `out`, for further transmits; other elements stay unchanged.
    Add,
}

/// One scan line of one transmit.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ScanLine<'a> {
    /// The transmit.
    pub transmit: Transmit<'a>,
    /// The ray of the line.
    pub ray: Ray,
    /// Element positions.
    pub array: Array<'a>,
    /// Elements to compute: the active aperture of the deepest sample.
    ///
    /// It includes all shallower apertures.
    pub active: Active,
    /// Overwrite or add.
    pub compounding: Compounding,
}

impl<'a> ScanLine<'a> {
    /// A line along `ray` that replaces `out`, of all elements of `array`.
    pub const fn new(transmit: Transmit<'a>, ray: Ray, array: Array<'a>) -> Self {
        ScanLine {
            transmit,
            ray,
            array,
            active: Active::new(0, array.elements()),
            compounding: Compounding::Replace,
        }
    }

    /// Scan line `line` of a scan.
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

/// Puts real and imaginary parts alternately into `out`, which may be shorter.
#[inline(always)]
pub(super) fn put_parts(compounding: Compounding, values: &[f32], out: &mut [Complex<f32>]) {
    let out = parts(out);
    // Whole registers by themselves: their number is known when this is compiled.
    match out.get_mut(..values.len()) {
        Some(out) => put_values(compounding, values, out),
        None => put_values(compounding, values, out),
    }
}

#[inline(always)]
fn put_values(compounding: Compounding, values: &[f32], out: &mut [f32]) {
    let out = out.iter_mut().zip(values);
    match compounding {
        Compounding::Replace => out.for_each(
            #[inline(always)]
            |(y, &value)| *y = value,
        ),
        Compounding::Add => out.for_each(
            #[inline(always)]
            |(y, &value)| *y += value,
        ),
    }
}
