//! The columns of a filtered image: spectrum × gain, inversely transformed.

use super::bank::PhaseSymmetry;
use super::external::{ReadAt, WriteAt};
use super::fft::{Fft, inverse, opposite};
use super::gains::{Gains, LaneColumns};
use super::lines::{in_groups, load_partial, store_partial};
use super::log_gabor::ORIENTATIONS;
use super::memory::StripSlices;
use super::strip::Kernels;
use crate::Error;
use crate::simd::Vector;
use crate::simd::{MOST_LANES, transpose};
use core::ops::Range;
use num_complex::Complex;

impl PhaseSymmetry {
    /// The second step of [`PhaseSymmetry::run`], for one filter and one of
    /// [`PhaseSymmetry::column_strips`]: writes the filtered columns.
    /// An example stands at [`StripSlices`].
    ///
    /// The other half of the spectrum is the mirror image of the stored one, so a strip gives the
    /// columns of the opposite frequencies as well.
    ///
    /// # Errors
    /// As [`PhaseSymmetry::run`]; [`Error::Capacity`] or [`Error::Parameter`] for a filter or strip
    /// that the bank does not have.
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
        let strip = &mut memory.strip[..2 * self.rows * columns.len()];
        spectrum.read_at(2 * self.rows * columns.start, strip)?;
        for mirrored in [false, true] {
            let half = Half::new(self, &columns, mirrored);
            if half.wanted.is_empty() {
                continue;
            }
            zero.vectorize(
                #[inline(always)]
                || half.filter(zero, kernels, filter, memory),
            );
            for rows in self.row_strips() {
                let [from, to] = [rows.start, rows.end].map(|row| 2 * row * half.wanted.len());
                let first = self.place(half.wanted.start, mirrored);
                let place = self.columns * rows.start + first * rows.len();
                filtered.write_at(2 * place, &memory.sums[from..to])?;
            }
        }
        Ok(())
    }

    /// Where a column of the half spectrum, or its mirror image, stands among the filtered ones:
    /// the mirror images come after the half spectrum, in its order.
    fn place(&self, column: usize, mirrored: bool) -> usize {
        if mirrored {
            self.columns / 2 + column
        } else {
            column
        }
    }

    /// Where a column of the image's spectrum stands among the filtered ones.
    #[inline(always)]
    pub(super) fn filtered_place(&self, column: usize) -> usize {
        if column <= self.columns / 2 {
            column
        } else {
            self.place(self.columns - column, true)
        }
    }
}

/// The columns of a strip of the half spectrum as they are, or their mirror images.
struct Half<'a> {
    bank: &'a PhaseSymmetry,
    /// The strip.
    columns: &'a Range<usize>,
    /// Those of them that the image has: the zero and the Nyquist frequency are their own mirror images.
    wanted: Range<usize>,
    mirrored: bool,
}

impl<'a> Half<'a> {
    fn new(bank: &'a PhaseSymmetry, columns: &'a Range<usize>, mirrored: bool) -> Self {
        let wanted = if mirrored {
            columns.start.max(1)..columns.end.min(bank.columns / 2)
        } else {
            columns.clone()
        };
        Half {
            bank,
            columns,
            wanted,
            mirrored,
        }
    }

    /// From the strip buffer into the sums buffer, in pieces for the strips of rows.
    #[inline(always)]
    fn filter<V: Vector, F: Fft<V>, G: Gains<V>>(
        &self,
        zero: V,
        kernels: &Kernels<'_, F, G>,
        filter: usize,
        memory: &mut StripSlices<'_, V>,
    ) {
        let rows = self.bank.rows;
        let strip = &memory.strip[..2 * rows * self.columns.len()];
        let line = &mut memory.line[..rows];
        let gains = &mut memory.gains[..rows];
        let out = &mut *memory.sums;
        let (scale, orientation) = (filter / ORIENTATIONS.len(), filter % ORIENTATIONS.len());
        in_groups::<V>(
            self.columns.len(),
            #[inline(always)]
            |first, lanes| {
                let group = LaneColumns {
                    first: self.columns.start + first,
                    lanes,
                    mirrored: self.mirrored,
                };
                if (0..lanes).all(|k| self.column(group, k).is_none()) {
                    return;
                }
                if lanes < V::LANES {
                    gains.fill(zero);
                }
                let bank = self.bank;
                kernels.gains.fill(bank, scale, orientation, group, gains);
                self.invert(zero, kernels.fft, strip, group, gains, line);
                if V::LANES > 1 && bank.strip.is_multiple_of(V::LANES) {
                    self.store_squares(zero, group, line, out);
                } else {
                    self.store_lanes(zero, group, line, out);
                }
            },
        );
    }

    /// The column in a lane, if it is wanted.
    #[inline(always)]
    fn column(&self, group: LaneColumns, lane: usize) -> Option<usize> {
        let column = group.first + lane;
        (lane < group.lanes && self.wanted.contains(&column)).then_some(column)
    }

    /// The inverse transform of a group's columns times their gains, without the factor 1/rows.
    #[inline(always)]
    fn invert<V: Vector, F: Fft<V>>(
        &self,
        zero: V,
        fft: &F,
        strip: &[f32],
        group: LaneColumns,
        gains: &[V],
        line: &mut [Complex<V>],
    ) {
        let (rows, width) = (self.bank.rows, self.columns.len());
        let first = group.first - self.columns.start;
        let (re, im) = (&strip[first..], &strip[width + first..]);
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
                let at = 2 * source * width;
                Complex {
                    re: load_partial(zero, re, at, lanes) * gains[row],
                    im: load_partial(zero, im, at, lanes) * (sign * gains[row]),
                }
            },
            line,
        );
    }

    /// A group's columns into their pieces, by squares of as many rows as a vector has lanes: lanes become
    /// rows. The strips are made of whole squares.
    #[inline(always)]
    fn store_squares<V: Vector>(
        &self,
        zero: V,
        group: LaneColumns,
        line: &[Complex<V>],
        out: &mut [f32],
    ) {
        let scale = zero.splat(1.0 / self.bank.rows as f32);
        for row in (0..self.bank.rows).step_by(V::LANES) {
            let (mut re, mut im): ([V; MOST_LANES], [V; MOST_LANES]) = ([zero; _], [zero; _]);
            for (k, bin) in line[row..row + V::LANES].iter().enumerate() {
                (re[k], im[k]) = (bin.re * scale, bin.im * scale);
            }
            transpose(&mut re);
            transpose(&mut im);
            for k in 0..V::LANES {
                if let Some(column) = self.column(group, k) {
                    let [re_at, im_at] = self.piece(row, column);
                    store_partial(re[k], out, re_at, V::LANES);
                    store_partial(im[k], out, im_at, V::LANES);
                }
            }
        }
    }

    /// A group's columns into their pieces, lane by lane.
    #[inline(always)]
    fn store_lanes<V: Vector>(
        &self,
        zero: V,
        group: LaneColumns,
        line: &[Complex<V>],
        out: &mut [f32],
    ) {
        let scale = zero.splat(1.0 / self.bank.rows as f32);
        for strip in self.bank.row_strips() {
            let height = strip.len();
            let bins = &line[strip.clone()];
            for k in 0..group.lanes {
                let Some(column) = self.column(group, k) else {
                    continue;
                };
                let [at, _] = self.piece(strip.start, column);
                let (re, im) = out[at..at + 2 * height].split_at_mut(height);
                for ((re, im), bin) in re.iter_mut().zip(im).zip(bins) {
                    *re = (bin.re * scale).lanes()[k];
                    *im = (bin.im * scale).lanes()[k];
                }
            }
        }
    }

    /// Where the real and imaginary part at a row of a column go in the sums buffer, which holds
    /// the wanted columns in pieces for the strips of rows.
    #[inline(always)]
    fn piece(&self, row: usize, column: usize) -> [usize; 2] {
        let PhaseSymmetry { rows, strip, .. } = *self.bank;
        let start = row / strip * strip;
        let height = strip.min(rows - start);
        let line = 2 * (column - self.wanted.start) * height;
        let at = 2 * self.wanted.len() * start + line + row - start;
        [at, at + height]
    }
}
