//! Columns of a filtered image: inverse transform of spectrum × gain.

use super::bank::PhaseSymmetry;
use super::external::{ReadAt, WriteAt, view_or_read};
use super::fft::{Fft, inverse, opposite};
use super::gains::{Gains, LaneColumns};
use super::lines::{in_groups, load_complex, parts, store_partial};
use super::memory::StripSlices;
use super::strip::Kernels;
use crate::Error;
use crate::simd::{MOST_LANES, Vector, get, transpose, vectorize};
use core::hint::cold_path;
use core::ops::Range;
use num_complex::Complex;

impl PhaseSymmetry {
    /// Writes the filtered columns of one filter and one strip.
    ///
    /// This is the second step of [`PhaseSymmetry::run`], for a filter and one of [`PhaseSymmetry::column_strips`].
    /// [`StripSlices`] has an example. The other half of the spectrum mirrors the stored one, so a strip also gives
    /// the columns of the opposite frequencies.
    ///
    /// # Errors
    /// As [`PhaseSymmetry::run`]; [`Error::Capacity`] or [`Error::Parameter`] for a filter or strip outside the
    /// bank.
    pub fn filter_columns<V: Vector, F: Fft<V>, G: Gains<V>>(
        &self,
        kernels: &Kernels<'_, F, G>,
        filter: usize,
        columns: Range<usize>,
        spectrum: &mut dyn ReadAt,
        filtered: &mut dyn WriteAt,
        memory: &mut StripSlices<'_, V>,
    ) -> Result<(), Error> {
        let zero = self.check(kernels, memory)?;
        self.check_step(filter, &columns, self.column_strips())?;
        let StripSlices {
            strip,
            sums,
            line,
            gains,
        } = memory;
        let offset = 2 * self.rows * columns.start;
        let strip = strip.get_mut(..2 * self.rows * columns.len());
        let strip = view_or_read(spectrum, offset, strip.ok_or(Error::Memory)?)?;
        for mirrored in [false, true] {
            let half = HalfSpectrum::new(self, filter, &columns, mirrored, strip);
            if half.wanted.is_empty() {
                continue;
            }
            vectorize!(zero, half.filter(kernels, line, gains, sums));
            for rows in self.row_strips() {
                let [from, to] = [rows.start, rows.end].map(|row| 2 * row * half.wanted.len());
                let first = self.offset(half.wanted.start, mirrored);
                let offset = self.columns * rows.start + first * rows.len();
                filtered.write_at(2 * offset, sums.get(from..to).ok_or(Error::Memory)?)?;
            }
        }
        Ok(())
    }

    /// Position of a column of the half spectrum among the filtered ones.
    ///
    /// Mirror images come after the half spectrum, in its order.
    fn offset(&self, column: usize, mirrored: bool) -> usize {
        if mirrored {
            self.columns / 2 + column
        } else {
            column
        }
    }

    /// Position of a column of the image's spectrum among the filtered ones.
    #[inline(always)]
    pub(super) fn filtered_offset(&self, column: usize) -> usize {
        if column <= self.columns / 2 {
            column
        } else {
            self.offset(self.columns - column, true)
        }
    }
}

/// The columns of a strip of the half spectrum, or their mirror images.
struct HalfSpectrum<'a> {
    bank: &'a PhaseSymmetry,
    filter: usize,
    /// The strip.
    columns: &'a Range<usize>,
    /// The wanted columns: zero and Nyquist frequency are their own mirror images.
    wanted: Range<usize>,
    mirrored: bool,
    /// The strip's part of the half spectrum.
    spectrum: &'a [f32],
}

impl<'a> HalfSpectrum<'a> {
    fn new(
        bank: &'a PhaseSymmetry,
        filter: usize,
        columns: &'a Range<usize>,
        mirrored: bool,
        spectrum: &'a [f32],
    ) -> Self {
        let wanted = if mirrored {
            columns.start.max(1)..columns.end.min(bank.columns / 2)
        } else {
            columns.clone()
        };
        HalfSpectrum {
            bank,
            filter,
            columns,
            wanted,
            mirrored,
            spectrum,
        }
    }

    /// From the spectrum into the sums buffer, in tiles for the strips of rows.
    #[inline(always)]
    fn filter<V: Vector, F: Fft<V>, G: Gains<V>>(
        &self,
        kernels: &Kernels<'_, F, G>,
        line: &mut [Complex<V>],
        gains: &mut [V],
        out: &mut [f32],
    ) {
        let rows = self.bank.rows;
        let (Some(line), Some(gains)) = (line.get_mut(..rows), gains.get_mut(..rows)) else {
            return;
        };
        let Some(gain) = gains.first() else {
            return;
        };
        let zero = gain.zero();
        in_groups::<V>(
            self.columns.len(),
            #[inline(always)]
            |first, lanes| {
                let group = LaneColumns {
                    first: self.columns.start + first,
                    lanes,
                    mirrored: self.mirrored,
                };
                if self.lanes(group).is_empty() {
                    return;
                }
                if lanes < V::LANES {
                    gains.fill(zero);
                }
                let bank = self.bank;
                kernels.gains.fill(bank, self.filter, group, gains);
                self.invert(kernels.fft, group, gains, line);
                if V::LANES > 1 && bank.strip.is_multiple_of(V::LANES) {
                    self.store_squares(zero, group, line, out);
                } else {
                    self.store_lanes(zero, group, line, out);
                }
            },
        );
    }

    /// The inverse transform of a group's columns times their gains, without the factor 1/rows.
    #[inline(always)]
    fn invert<V: Vector, F: Fft<V>>(
        &self,
        fft: &F,
        group: LaneColumns,
        gains: &[V],
        line: &mut [Complex<V>],
    ) {
        let Some(gain) = gains.first() else {
            return;
        };
        let zero = gain.zero();
        let (rows, width) = (self.bank.rows, self.columns.len());
        let first = group.first - self.columns.start;
        let Some(spectrum) = parts(self.spectrum, first, width) else {
            return;
        };
        let LaneColumns {
            lanes, mirrored, ..
        } = group;
        let sign = zero.splat(if mirrored { -1.0 } else { 1.0 });
        inverse(
            fft,
            #[inline(always)]
            |row| {
                // F(−fy, −fx)* of a real image; row 0 is its own mirror image.
                let source = if mirrored { opposite(row, rows) } else { row };
                let bin = load_complex(zero, spectrum, 2 * source * width, lanes);
                let Some(&gain) = get::<V, _, _>(gains, row) else {
                    cold_path();
                    return bin;
                };
                Complex::new(bin.re * gain, bin.im * (sign * gain))
            },
            line,
        );
    }

    /// The lanes of a group whose columns are wanted.
    #[inline(always)]
    fn lanes(&self, group: LaneColumns) -> Range<usize> {
        let Range { start, end } = self.wanted;
        let first = start.saturating_sub(group.first);
        first..end.saturating_sub(group.first).min(group.lanes)
    }

    /// Writes a group's columns into their tiles, by squares: lanes become rows.
    ///
    /// A square has as many rows as a vector has lanes. The strips consist of whole squares.
    #[inline(always)]
    fn store_squares<V: Vector>(
        &self,
        zero: V,
        group: LaneColumns,
        line: &[Complex<V>],
        out: &mut [f32],
    ) {
        let scale = zero.splat(1.0 / self.bank.rows as f32);
        let lanes = self.lanes(group);
        for strip in self.bank.row_strips() {
            let height = strip.len();
            let tile = self.tile(&strip, group.first + lanes.start, out);
            let bins = line.get(strip).unwrap_or_default();
            for (chunk, bins) in bins.chunks_exact(V::LANES).enumerate() {
                let (mut re, mut im): ([V; MOST_LANES], [V; MOST_LANES]) = ([zero; _], [zero; _]);
                for (k, bin) in bins.iter().enumerate() {
                    (re[k], im[k]) = (bin.re * scale, bin.im * scale);
                }
                transpose(&mut re);
                transpose(&mut im);
                let columns = tile.chunks_exact_mut(2 * height);
                for (k, column) in lanes.clone().zip(columns) {
                    let (above, below) = column.split_at_mut(height);
                    store_partial(re[k], above, chunk * V::LANES, V::LANES);
                    store_partial(im[k], below, chunk * V::LANES, V::LANES);
                }
            }
        }
    }

    /// A group's columns into their tiles, lane by lane.
    #[inline(always)]
    fn store_lanes<V: Vector>(
        &self,
        zero: V,
        group: LaneColumns,
        line: &[Complex<V>],
        out: &mut [f32],
    ) {
        let scale = zero.splat(1.0 / self.bank.rows as f32);
        let lanes = self.lanes(group);
        for strip in self.bank.row_strips() {
            let height = strip.len();
            let tile = self.tile(&strip, group.first + lanes.start, out);
            let bins = line.get(strip).unwrap_or_default();
            for (k, column) in lanes
                .clone()
                .zip(tile.chunks_exact_mut((2 * height).max(1)))
            {
                let Some((re, im)) = column.split_at_mut_checked(height) else {
                    return;
                };
                for ((re, im), bin) in re.iter_mut().zip(im).zip(bins) {
                    *re = (bin.re * scale).lanes()[k];
                    *im = (bin.im * scale).lanes()[k];
                }
            }
        }
    }

    /// The columns from one on at a strip of rows, in the sums buffer, which holds the wanted columns in
    /// tiles for the strips of rows.
    #[inline(always)]
    fn tile<'b>(&self, rows: &Range<usize>, column: usize, out: &'b mut [f32]) -> &'b mut [f32] {
        let columns = self.wanted.len();
        let before = 2 * (column - self.wanted.start) * rows.len();
        let tile = out.get_mut(2 * columns * rows.start..2 * columns * rows.end);
        tile.unwrap_or_default()
            .get_mut(before..)
            .unwrap_or_default()
    }
}
