//! The columns of a filtered image: spectrum × gain, inversely transformed.

use super::external::{Source, Store};
use super::fft::{Fft, inverse, opposite};
use super::gains::{Gains, LaneColumns};
use super::lines::{groups, load, store};
use super::log_gabor::ORIENTATIONS;
use super::strip::{Kernels, PhaseSymmetry};
use super::workspace::StripBuffers;
use crate::Error;
use crate::simd::Vector;
use crate::simd::{MOST_LANES, transpose};
use core::ops::Range;
use num_complex::Complex;

impl PhaseSymmetry {
    /// The second step of [`PhaseSymmetry::run`], for one filter and one of
    /// [`PhaseSymmetry::column_strips`]: writes the filtered columns.
    ///
    /// The other half of the spectrum is the mirror image of the stored one, so a strip gives the
    /// columns of the opposite frequencies as well.
    ///
    /// # Errors
    /// As [`PhaseSymmetry::run`]; [`Error::Capacity`] or [`Error::Parameter`] for a filter or strip
    /// that the bank does not have.
    pub fn filter_columns<V: Vector, F: Fft<V>, G: Gains<V>>(
        &self,
        kernels: &Kernels<'_, V, F, G>,
        filter: usize,
        columns: Range<usize>,
        spectrum: &mut dyn Source,
        filtered: &mut dyn Store,
        buffers: &mut StripBuffers<'_, V>,
    ) -> Result<(), Error> {
        self.check(kernels, buffers)?;
        self.check_step(filter, &columns, self.column_strips())?;
        let strip = &mut buffers.strip[..2 * self.rows * columns.len()];
        spectrum.read(2 * self.rows * columns.start, strip)?;
        for mirrored in [false, true] {
            let wanted = self.wanted(&columns, mirrored);
            if wanted.is_empty() {
                continue;
            }
            kernels.zero.vectorize(
                #[inline(always)]
                || self.filter_half(kernels, filter, &columns, mirrored, buffers),
            );
            for rows in self.row_strips() {
                let [from, to] = [rows.start, rows.end].map(|row| 2 * row * wanted.len());
                let place =
                    self.columns * rows.start + self.place(wanted.start, mirrored) * rows.len();
                filtered.write(2 * place, &buffers.sums[from..to])?;
            }
        }
        Ok(())
    }

    /// The columns of a strip of the half spectrum that the image has, as they are or mirrored:
    /// the zero and the Nyquist frequency are their own mirror images.
    fn wanted(&self, columns: &Range<usize>, mirrored: bool) -> Range<usize> {
        let nyquist = self.columns / 2;
        let start = if mirrored && columns.start == 0 {
            1
        } else {
            columns.start
        };
        let end = if mirrored && columns.end > nyquist {
            nyquist
        } else {
            columns.end
        };
        start..end
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

    /// From the strip buffer into the sums buffer, in pieces for the strips of rows.
    #[inline(always)]
    fn filter_half<V: Vector, F: Fft<V>, G: Gains<V>>(
        &self,
        kernels: &Kernels<'_, V, F, G>,
        filter: usize,
        columns: &Range<usize>,
        mirrored: bool,
        buffers: &mut StripBuffers<'_, V>,
    ) {
        let Kernels { zero, fft, gains } = *kernels;
        let (rows, width) = (self.rows, columns.len());
        let wanted = self.wanted(columns, mirrored);
        let strip = &buffers.strip[..2 * rows * width];
        let out = &mut *buffers.sums;
        let line = &mut buffers.line[..rows];
        let gain = &mut buffers.gains[..rows];
        let scale = zero.splat(1.0 / rows as f32);
        let sign = zero.splat(if mirrored { -1.0 } else { 1.0 });
        for (first, lanes) in groups::<V>(width) {
            // Lanes become rows, each column that is wanted.
            let lane = |k: usize| {
                let column = columns.start + first + k;
                let wanted = k < lanes && wanted.contains(&column);
                wanted.then_some(column)
            };
            if (0..lanes).all(|k| lane(k).is_none()) {
                continue;
            }
            if lanes < V::LANES {
                gain.fill(zero);
            }
            let group = LaneColumns {
                first: columns.start + first,
                lanes,
                mirrored,
            };
            let (radius, orientation) = (filter / ORIENTATIONS.len(), filter % ORIENTATIONS.len());
            gains.fill(self, radius, orientation, group, gain);
            let (re, im) = (&strip[first..], &strip[width + first..]);
            inverse(
                fft,
                #[inline(always)]
                |row| {
                    // F(−fy, −fx)* of a real image; row 0 is its own mirror image.
                    let source = if mirrored { opposite(row, rows) } else { row };
                    let at = 2 * source * width;
                    Complex {
                        re: load(zero, re, at, lanes) * gain[row],
                        im: load(zero, im, at, lanes) * (sign * gain[row]),
                    }
                },
                line,
            );
            if V::LANES > 1 && self.strip.is_multiple_of(V::LANES) {
                for row in (0..rows).step_by(V::LANES) {
                    let (mut re, mut im): ([V; MOST_LANES], [V; MOST_LANES]) =
                        ([zero; _], [zero; _]);
                    for (k, bin) in line[row..row + V::LANES].iter().enumerate() {
                        (re[k], im[k]) = (bin.re * scale, bin.im * scale);
                    }
                    transpose(&mut re);
                    transpose(&mut im);
                    for k in 0..V::LANES {
                        if let Some(column) = lane(k) {
                            let [re_at, im_at] = self.piece(row, column, &wanted);
                            store(re[k], out, re_at, V::LANES);
                            store(im[k], out, im_at, V::LANES);
                        }
                    }
                }
                continue;
            }
            for strip in self.row_strips() {
                let height = strip.len();
                let bins = &line[strip.clone()];
                for k in 0..lanes {
                    let Some(column) = lane(k) else {
                        continue;
                    };
                    let [at, _] = self.piece(strip.start, column, &wanted);
                    let (re, im) = out[at..at + 2 * height].split_at_mut(height);
                    for ((re, im), bin) in re.iter_mut().zip(im).zip(bins) {
                        *re = (bin.re * scale).lanes()[k];
                        *im = (bin.im * scale).lanes()[k];
                    }
                }
            }
        }
    }

    /// Where the real and imaginary part at a row of a column go in the sums buffer, which holds
    /// the wanted columns in pieces for the strips of rows.
    #[inline(always)]
    fn piece(&self, row: usize, column: usize, wanted: &Range<usize>) -> [usize; 2] {
        let start = row / self.strip * self.strip;
        let left = self.rows - start;
        let height = if self.strip < left { self.strip } else { left };
        let line = 2 * (column - wanted.start) * height;
        let at = 2 * wanted.len() * start + line + row - start;
        [at, at + height]
    }
}
