//! The rows of a filtered image: inversely transformed, and added to Eq. 10's two sums.

use super::external::{Source, Store};
use super::fft::{Fft, inverse};
use super::gains::Gains;
use super::lines::{groups, load, store};
use super::strip::{Kernels, PhaseSymmetry};
use super::workspace::StripBuffers;
use crate::Error;
use crate::simd::Vector;
use core::ops::Range;
use num_complex::Complex;

/// `ε` of Eq. 10.
const EPSILON: f32 = 1e-10;
/// The largest float below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

impl PhaseSymmetry {
    /// The third step of [`PhaseSymmetry::run`], for one filter and one of
    /// [`PhaseSymmetry::row_strips`], once every column is there: adds the filtered rows to the sums
    /// (`symmetry` and `amplitude` of [`super::External`]), and after the last filter divides.
    ///
    /// # Errors
    /// As [`PhaseSymmetry::run`]; [`Error::Capacity`] or [`Error::Parameter`] for a filter or strip
    /// that the bank does not have.
    pub fn add_rows<V: Vector, F: Fft<V>, G: Gains<V>>(
        &self,
        kernels: &Kernels<'_, V, F, G>,
        filter: usize,
        rows: Range<usize>,
        filtered: &mut dyn Source,
        mut sums: [&mut dyn Store; 2],
        buffers: &mut StripBuffers<'_, V>,
    ) -> Result<(), Error> {
        self.check(kernels, buffers)?;
        self.check_step(filter, &rows, self.row_strips())?;
        let (columns, height) = (self.columns, rows.len());
        let place = rows.start * columns;
        let area = height * columns;
        filtered.read(2 * place, &mut buffers.strip[..2 * area])?;
        let first = filter == 0;
        self.read_sums(first, rows.start, &mut sums, &mut buffers.sums[..2 * area])?;
        kernels.zero.vectorize(
            #[inline(always)]
            || self.add(kernels, height, buffers),
        );
        let last = filter + 1 == self.filters();
        self.write_sums(last, rows.start, sums, &mut buffers.sums[..2 * area])
    }

    /// What Eq. 10's two sums are so far, in the strip of rows that begins at a row; 0 before the
    /// `first` addition.
    pub(super) fn read_sums(
        &self,
        first: bool,
        row: usize,
        [symmetry, amplitude]: &mut [&mut dyn Store; 2],
        sums: &mut [f32],
    ) -> Result<(), Error> {
        if first {
            sums.fill(0.0);
            return Ok(());
        }
        let (above, below) = sums.split_at_mut(sums.len() / 2);
        symmetry.read(row * self.columns, above)?;
        amplitude.read(row * self.columns, below)
    }

    /// Keeps the sums, or after the `last` addition divides them.
    pub(super) fn write_sums(
        &self,
        last: bool,
        row: usize,
        [symmetry, amplitude]: [&mut dyn Store; 2],
        sums: &mut [f32],
    ) -> Result<(), Error> {
        let (columns, place) = (self.columns, row * self.columns);
        let (above, below) = sums.split_at_mut(sums.len() / 2);
        if !last {
            amplitude.write(place, below)?;
            return symmetry.write(place, above);
        }
        for (above, below) in above.iter_mut().zip(&*below) {
            let ratio = *above / (*below + EPSILON);
            *above = if ratio < 1.0 { ratio } else { BELOW_ONE };
        }
        let height = above.len() / columns;
        for (k, row) in below.chunks_exact_mut(columns).enumerate() {
            for (n, ratio) in row.iter_mut().enumerate() {
                *ratio = above[n * height + k];
            }
        }
        symmetry.write(place, below)
    }

    /// From the strip buffer to the sums buffer.
    #[inline(always)]
    fn add<V: Vector, F: Fft<V>, G: Gains<V>>(
        &self,
        kernels: &Kernels<'_, V, F, G>,
        height: usize,
        buffers: &mut StripBuffers<'_, V>,
    ) {
        let (zero, columns) = (kernels.zero, self.columns);
        let strip = &buffers.strip[..2 * columns * height];
        let (above, below) = buffers.sums[..2 * columns * height].split_at_mut(columns * height);
        let line = &mut buffers.line[..columns];
        let scale = zero.splat(1.0 / columns as f32);
        let threshold = zero.splat(self.threshold);
        for (first, lanes) in groups::<V>(height) {
            self.invert_rows(kernels, strip, height, (first, lanes), line);
            let sums = above
                .chunks_exact_mut(height)
                .zip(below.chunks_exact_mut(height));
            for (c, (above, below)) in line.iter().zip(sums) {
                let response = [c.re * scale, c.im * scale];
                Self::add_response(threshold, response, [above, below], (first, lanes));
            }
        }
    }

    /// Inversely transforms a vector's rows of a filtered strip, without the factor 1/columns.
    #[inline(always)]
    pub(super) fn invert_rows<V: Vector, F: Fft<V>, G: Gains<V>>(
        &self,
        kernels: &Kernels<'_, V, F, G>,
        strip: &[f32],
        height: usize,
        (first, lanes): (usize, usize),
        line: &mut [Complex<V>],
    ) {
        let (re, im) = (&strip[first..], &strip[height + first..]);
        inverse(
            kernels.fft,
            #[inline(always)]
            |column| {
                let at = 2 * self.filtered_place(column) * height;
                Complex {
                    re: load(kernels.zero, re, at, lanes),
                    im: load(kernels.zero, im, at, lanes),
                }
            },
            line,
        );
    }

    /// Adds what one filter gives to Eq. 10's numerator and denominator, in `lanes` lanes whose sums
    /// begin at `first`.
    #[inline(always)]
    pub(super) fn add_response<V: Vector>(
        threshold: V,
        [e, o]: [V; 2],
        [above, below]: [&mut [f32]; 2],
        (first, lanes): (usize, usize),
    ) {
        let zero = threshold.zero();
        let excess = e - o.abs() - threshold;
        let excess = V::select(zero.less(excess), excess, zero);
        store(
            load(zero, above, first, lanes) + excess,
            above,
            first,
            lanes,
        );
        let modulus = (e * e + o * o).sqrt();
        store(
            load(zero, below, first, lanes) + modulus,
            below,
            first,
            lanes,
        );
    }
}
