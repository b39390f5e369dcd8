//! Rows of a filtered image: inverse transform and the two sums of Eq. 10.

use super::bank::PhaseSymmetry;
use super::external::{ReadAt, WriteAt, view_or_read};
use super::fft::{Fft, inverse};
use super::gains::Gains;
use super::lines::{add_partial, in_groups, load_complex, parts};
use super::memory::StripSlices;
use super::strip::Kernels;
use crate::Error;
use crate::simd::{Vector, vectorize};
use core::ops::Range;
use num_complex::Complex;

/// `ε` of Eq. 10.
const EPSILON: f32 = 1e-10;
/// The largest float below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

impl PhaseSymmetry {
    /// Adds the filtered rows of one filter and one strip to the sums.
    ///
    /// This is the third step of [`PhaseSymmetry::run`], for a filter and one of [`PhaseSymmetry::row_strips`], after
    /// every column is written. The sums are `symmetry` and `amplitude` of [`super::External`]. With the last filter,
    /// the sums are divided. [`StripSlices`] has an example.
    ///
    /// # Errors
    /// As [`PhaseSymmetry::run`]; [`Error::Capacity`] or [`Error::Parameter`] for a filter or strip outside the
    /// bank.
    pub fn add_rows<V: Vector, F: Fft<V>, G: Gains<V>>(
        &self,
        kernels: &Kernels<'_, F, G>,
        filter: usize,
        rows: Range<usize>,
        filtered: &mut dyn ReadAt,
        [symmetry, amplitude]: [&mut dyn WriteAt; 2],
        memory: &mut StripSlices<'_, V>,
    ) -> Result<(), Error> {
        self.check(kernels, memory)?;
        self.check_step(filter, &rows, self.row_strips())?;
        let (height, offset) = (rows.len(), rows.start * self.columns);
        let area = height * self.columns;
        let StripSlices {
            strip, sums, line, ..
        } = memory;
        let strip = strip.get_mut(..2 * area).ok_or(Error::Memory)?;
        let strip = view_or_read(filtered, 2 * offset, strip)?;
        let line = line.get_mut(..self.columns).ok_or(Error::Memory)?;
        let last = filter + 1 == self.filters();
        if !last
            && let Some(above) = symmetry.view_mut(offset, area)
            && let Some(below) = amplitude.view_mut(offset, area)
        {
            if filter == 0 {
                above.fill(0.0);
                below.fill(0.0);
            }
            self.add(kernels.fft, strip, line, [above, below]);
            return Ok(());
        }
        let sums = sums.get_mut(..2 * area).unwrap_or_default();
        let (above, below) = sums.split_at_mut_checked(area).ok_or(Error::Memory)?;
        if filter > 0 {
            symmetry.read_at(offset, above)?;
            amplitude.read_at(offset, below)?;
        } else {
            above.fill(0.0);
            below.fill(0.0);
        }
        self.add(kernels.fft, strip, line, [above, below]);
        if !last {
            amplitude.write_at(offset, below)?;
            return symmetry.write_at(offset, above);
        }
        divide(above, below, height);
        symmetry.write_at(offset, below)
    }

    /// Adds a strip to the sums.
    fn add<V: Vector, F: Fft<V>>(
        &self,
        fft: &F,
        strip: &[f32],
        line: &mut [Complex<V>],
        sums: [&mut [f32]; 2],
    ) {
        let Some(bin) = line.first() else {
            return;
        };
        let vector = bin.re;
        vectorize!(vector, self.add_strip(fft, strip, line, sums));
    }

    #[inline(always)]
    fn add_strip<V: Vector, F: Fft<V>>(
        &self,
        fft: &F,
        strip: &[f32],
        line: &mut [Complex<V>],
        [above, below]: [&mut [f32]; 2],
    ) {
        let Some(bin) = line.first() else {
            return;
        };
        let zero = bin.re.zero();
        let columns = self.columns;
        let Some(height) = above
            .len()
            .checked_div(columns)
            .filter(|&height| height > 0)
        else {
            return;
        };
        let scale = zero.splat(1.0 / columns as f32);
        let threshold = zero.splat(self.threshold);
        in_groups::<V>(
            height,
            #[inline(always)]
            |first, lanes| {
                let Some(strip) = parts(strip, first, height) else {
                    return;
                };
                inverse(
                    fft,
                    #[inline(always)]
                    |column| {
                        let at = 2 * height * self.filtered_offset(column);
                        load_complex(zero, strip, at, lanes)
                    },
                    line,
                );
                let above = above.chunks_exact_mut(height);
                let below = below.chunks_exact_mut(height);
                for ((c, above), below) in line.iter().zip(above).zip(below) {
                    let (e, o) = (c.re * scale, c.im * scale);
                    let excess = e - o.abs() - threshold;
                    let excess = V::select(zero.less(excess), excess, zero);
                    add_partial(excess, above, first, lanes);
                    let modulus = (e * e + o * o).sqrt();
                    add_partial(modulus, below, first, lanes);
                }
            },
        );
    }
}

/// Eq. 10's quotient, which stays below 1.
#[inline(always)]
pub(super) fn quotient(above: f32, below: f32) -> f32 {
    let ratio = above / (below + EPSILON);
    if ratio < 1.0 { ratio } else { BELOW_ONE }
}

/// Quotients of Eq. 10 from the sums `above` and `below`, into `below`.
///
/// The sums are column by column, the quotients row by row.
fn divide(above: &mut [f32], below: &mut [f32], height: usize) {
    for (above, below) in above.iter_mut().zip(&*below) {
        *above = quotient(*above, *below);
    }
    let height = height.max(1);
    let columns = (above.len() / height).max(1);
    for (k, row) in below.chunks_exact_mut(columns).enumerate() {
        let above = above.get(k..).unwrap_or_default();
        for (ratio, above) in row.iter_mut().zip(above.iter().step_by(height)) {
            *ratio = *above;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotients_are_rotated_and_stay_below_one() {
        // Two rows of three columns. The sums of a bright line without noise may round to the same.
        let mut above = [1.0, 3.0, 0.0, 1e-3, 2.0, 0.0];
        let mut below = [2.0, 4.0, 0.0, 1e-3, 2.0, 1.0];
        divide(&mut above, &mut below, 2);
        assert_eq!(&below[..2], [0.5, 0.0]);
        assert!(below[2] < 1.0 && below[2] > 0.999_999_9);
        assert_eq!(&below[3..5], [0.75, 1e-3 / (1e-3 + EPSILON)]);
        assert_eq!(below[5], 0.0);
        assert_eq!(BELOW_ONE.to_bits() + 1, 1f32.to_bits());
    }
}
