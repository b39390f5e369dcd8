//! Phase symmetry with all matrices in one memory, one line at a time.
//!
//! For a microcontroller with enough memory. The operations are those of the strips in their order, and so are the
//! bits. Nothing is copied: a column of the spectrum, or a row of a filtered image, is one range.

use super::bank::PhaseSymmetry;
use super::fft::{Fft, Microfft, inverse_to, opposite};
use super::fft64::POINTS;
use super::gains::{Gains, LaneColumns};
use super::memory::Sizes;
use super::rows::quotient;
use super::spectrum::check_pixels;
use crate::error::check_length;
use crate::instructions::sqrt;
use crate::memory::{Need, STEP, Scratch};
use crate::simd::split_front;
use crate::{Complex, Error};

impl Sizes {
    /// Memory of [`PhaseSymmetry::map`], without image and map.
    ///
    /// For R × C pixels and N the longer side: 4·R·C + 2·R + N real numbers and N complex ones, 66.8 kB for 64 ×
    /// 64.
    pub const fn map_need(&self) -> Need {
        let images = self.filtered_len().saturating_add(self.amplitude_len());
        let whole = Need::real(self.spectrum_len()).and(Need::real(images));
        whole.and(Need::new(self.gains_len(), self.line_len()))
    }
}

/// Real and imaginary part.
type Pair = [f32; 2];

/// Matrices of a map.
struct Matrices<'a> {
    /// `[column][row]`, columns 0..=C/2.
    spectrum: &'a mut [Pair],
    /// `[row][column]`, the columns by their opposite frequencies, as the inverse transform takes them.
    filtered: &'a mut [Pair],
    /// Eq. 10's denominator.
    amplitude: &'a mut [f32],
    gains: &'a mut [f32],
    line: &'a mut [Complex<f32>],
}

impl PhaseSymmetry {
    /// The bank of strip height 1, whose gains [`PhaseSymmetry::map`] reads.
    ///
    /// Make the [`super::GainTables`] of a map for this bank.
    pub const fn by_columns(&self) -> Self {
        PhaseSymmetry { strip: 1, ..*self }
    }

    /// Number of steps that [`PhaseSymmetry::map`] reports.
    pub fn map_steps(&self) -> usize {
        let [rows, columns] = [self.rows, self.columns];
        let of = |lines: usize, length: usize| lines.div_ceil(lines_of_step(length));
        let half = self.sizes().half();
        of(rows, columns)
            + of(half, rows)
            + self.filters() * (of(columns, rows) + of(rows, columns))
    }

    /// Computes the map `PS` of an image in one memory.
    ///
    /// The bits are those of [`PhaseSymmetry::run`]. `progress` receives the number of steps done, of
    /// [`PhaseSymmetry::map_steps`], after each step: 64 lines of 64 points, or as many points of longer lines. A step
    /// takes less than a million instructions on a Cortex-M7, so `progress` can reset a watchdog. `scratch`:
    /// [`Sizes::map_need`], contents irrelevant.
    ///
    /// ```
    /// use bonebeam::memory::Memory;
    /// use bonebeam::phase_symmetry::{LogGabor, Parameters, PhaseSymmetry, Sizes};
    ///
    /// const SIZES: Sizes = Sizes { rows: 64, columns: 64, strip: 1 };
    /// let bank = PhaseSymmetry::new(&Parameters { sizes: SIZES, scales: &[0.125], threshold: 3.0 })?;
    /// let mut image = [10.0; SIZES.image_len()];
    /// image[20 * 64..21 * 64].fill(200.0);
    /// let mut memory = Memory::<{ SIZES.map_need().real }, { SIZES.map_need().complex }>::new();
    /// let mut map = [0.0; SIZES.symmetry_len()];
    /// let mut steps = 0;
    /// bank.map(&LogGabor::fixed(), &image, memory.scratch(), &mut map, &mut |done| steps = done)?;
    /// assert!(map[20 * 64] > 0.3 && map[50 * 64] < 0.1);
    /// assert_eq!(steps, bank.map_steps());
    /// # Ok::<(), bonebeam::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Length`] for an image, a map or memory of another size; as [`PhaseSymmetry::run`] for pixels and gains.
    /// The gains must be those of [`PhaseSymmetry::by_columns`].
    pub fn map<G: Gains<f32>>(
        &self,
        gains: &G,
        image: &[f32],
        scratch: Scratch<'_>,
        map: &mut [f32],
        progress: &mut dyn FnMut(usize),
    ) -> Result<(), Error> {
        let (bank, sizes) = (self.by_columns(), self.sizes());
        gains.check(&bank)?;
        check_length("image", image.len(), sizes.image_len())?;
        check_length("map", map.len(), sizes.symmetry_len())?;
        let mut scratch = scratch;
        let Scratch {
            mut real,
            complex: line,
        } = scratch.take(sizes.map_need())?;
        let spectrum = split_front(&mut real, sizes.spectrum_len());
        let filtered = split_front(&mut real, sizes.filtered_len());
        let mut matrices = Matrices {
            spectrum: spectrum.as_chunks_mut().0,
            filtered: filtered.as_chunks_mut().0,
            amplitude: split_front(&mut real, sizes.amplitude_len()),
            gains: real,
            line,
        };
        let mut done = 0;
        let mut steps = |line: usize, lines: usize, length: usize| {
            if line == lines || line.is_multiple_of(lines_of_step(length)) {
                done += 1;
                progress(done);
            }
        };
        bank.image_spectrum(image, &mut matrices, &mut steps)?;
        for filter in 0..bank.filters() {
            bank.filter_image(gains, filter, &mut matrices, &mut steps);
            bank.add_image(filter, map, &mut matrices, &mut steps);
        }
        Ok(())
    }

    /// The half spectrum of the image, whose pixels are checked.
    fn image_spectrum(
        &self,
        image: &[f32],
        matrices: &mut Matrices<'_>,
        steps: &mut impl FnMut(usize, usize, usize),
    ) -> Result<(), Error> {
        let (rows, columns, half) = (self.rows, self.columns, self.sizes().half());
        let Matrices { spectrum, line, .. } = matrices;
        for (row, pixels) in image.chunks_exact(columns.max(1)).enumerate() {
            check_pixels(pixels, row * columns)?;
            let line = line.get_mut(..columns).unwrap_or_default();
            let input = |n| Complex::new(pixels.get(n).copied().unwrap_or_default(), 0.0);
            Microfft.transform(input, line);
            let places = spectrum.chunks_exact_mut(rows.max(1));
            for (bin, to) in line
                .iter()
                .zip(places.filter_map(|column| column.get_mut(row)))
            {
                *to = [bin.re, bin.im];
            }
            steps(row + 1, rows, columns);
        }
        for (column, bins) in spectrum.chunks_exact_mut(rows.max(1)).enumerate() {
            let line = line.get_mut(..rows).unwrap_or_default();
            Microfft.transform(|n| number(bins, n), line);
            for (bin, to) in line.iter().zip(bins) {
                *to = [bin.re, bin.im];
            }
            steps(column + 1, half, rows);
        }
        Ok(())
    }

    /// The columns of spectrum × gain, inversely transformed.
    fn filter_image<G: Gains<f32>>(
        &self,
        gains: &G,
        filter: usize,
        matrices: &mut Matrices<'_>,
        steps: &mut impl FnMut(usize, usize, usize),
    ) {
        let (rows, columns) = (self.rows, self.columns);
        let Matrices {
            spectrum,
            filtered,
            gains: gain,
            line,
            ..
        } = matrices;
        let (Some(gain), Some(line)) = (gain.get_mut(..rows), line.get_mut(..rows)) else {
            return;
        };
        for column in 0..columns {
            let mirrored = column > columns / 2;
            let of_column = LaneColumns {
                first: if mirrored { columns - column } else { column },
                lanes: 1,
                mirrored,
            };
            gains.fill(self, filter, of_column, gain);
            let bins = spectrum.chunks_exact(rows.max(1)).nth(of_column.first);
            let bins = bins.unwrap_or_default();
            let of_column = Column {
                bins,
                gains: gain,
                mirrored,
            };
            match (line.as_mut_array(), filtered.as_mut_array()) {
                (Some(line), Some(filtered)) => of_column.filter_64(line, column, filtered),
                _ => of_column.filter(line, (column, columns), filtered),
            }
            steps(column + 1, columns, rows);
        }
    }

    /// Adds the filtered rows to Eq. 10's two sums; the last filter divides them.
    fn add_image(
        &self,
        filter: usize,
        map: &mut [f32],
        matrices: &mut Matrices<'_>,
        steps: &mut impl FnMut(usize, usize, usize),
    ) {
        let (rows, columns) = (self.rows, self.columns);
        let Matrices {
            filtered,
            amplitude,
            line,
            ..
        } = matrices;
        let Some(line) = line.get_mut(..columns) else {
            return;
        };
        let sums = map.chunks_exact_mut(columns.max(1));
        let sums = sums.zip(amplitude.chunks_exact_mut(columns.max(1)));
        let lines = filtered.chunks_exact(columns.max(1)).zip(sums);
        for (row, (filtered, (above, below))) in lines.enumerate() {
            if filter == 0 {
                above.fill(0.0);
                below.fill(0.0);
            }
            match (
                filtered.as_array(),
                line.as_mut_array(),
                above.as_mut_array(),
                below.as_mut_array(),
            ) {
                (Some(filtered), Some(line), Some(above), Some(below)) => {
                    add_64(filtered, line, self.threshold, above, below);
                }
                _ => add(filtered, line, self.threshold, above, below),
            }
            if filter + 1 == self.filters() {
                for (above, below) in above.iter_mut().zip(below) {
                    *above = quotient(*above, *below);
                }
            }
            steps(row + 1, rows, columns);
        }
    }
}

/// A column of the image's spectrum, or the mirror image of one, to be filtered.
struct Column<'a> {
    bins: &'a [Pair],
    gains: &'a [f32],
    mirrored: bool,
}

impl Column<'_> {
    /// The column times its gains, inversely transformed, to its place in the filtered image.
    #[inline(always)]
    fn filter(
        &self,
        line: &mut [Complex<f32>],
        (column, columns): (usize, usize),
        filtered: &mut [Pair],
    ) {
        let rows = line.len();
        let scale = 1.0 / rows as f32;
        let at = opposite(column, columns);
        let output = |row: usize, bin: Complex<f32>| {
            if let Some(to) = filtered.get_mut(row * columns + at) {
                *to = [bin.re * scale, bin.im * scale];
            }
        };
        let gain = |row| self.gains.get(row).copied().unwrap_or_default();
        if self.mirrored {
            // F(−fy, −fx)* of a real image.
            let input = |row| {
                let (bin, gain) = (number(self.bins, opposite(row, rows)), gain(row));
                Complex::new(bin.re * gain, -(bin.im * gain))
            };
            inverse_to(input, line, output);
        } else {
            inverse_to(|row| number(self.bins, row) * gain(row), line, output);
        }
    }

    /// [`Column::filter`] of 64 × 64 pixels.
    ///
    /// A separate function, so that the compiler keeps all in registers. It has no checks, since all lengths are
    /// known.
    #[inline(never)]
    fn filter_64(
        &self,
        line: &mut [Complex<f32>; POINTS],
        column: usize,
        filtered: &mut [Pair; POINTS * POINTS],
    ) {
        let (Some(bins), Some(gains)) = (
            self.bins.first_chunk::<POINTS>(),
            self.gains.first_chunk::<POINTS>(),
        ) else {
            return;
        };
        let column_of = Column {
            bins,
            gains,
            mirrored: self.mirrored,
        };
        column_of.filter(line, (column, POINTS), filtered);
    }
}

/// A row of a filtered image, inversely transformed and added to Eq. 10's two sums.
#[inline(always)]
fn add(
    filtered: &[Pair],
    line: &mut [Complex<f32>],
    threshold: f32,
    above: &mut [f32],
    below: &mut [f32],
) {
    let columns = line.len();
    let scale = 1.0 / columns as f32;
    let output = |column, c: Complex<f32>| {
        let (e, o) = (c.re * scale, c.im * scale);
        let excess = e - o.abs() - threshold;
        if let (Some(above), Some(below)) = (above.get_mut(column), below.get_mut(column)) {
            // The larger of it and 0.
            *above += 0.5 * (excess + excess.abs());
            *below += sqrt(e * e + o * o);
        }
    };
    // The columns are stored at their opposite frequencies.
    let input = |column| number(filtered, opposite(column, columns));
    inverse_to(input, line, output);
}

/// [`add()`] of 64 columns.
#[inline(never)]
fn add_64(
    filtered: &[Pair; POINTS],
    line: &mut [Complex<f32>; POINTS],
    threshold: f32,
    above: &mut [f32; POINTS],
    below: &mut [f32; POINTS],
) {
    add(filtered, line, threshold, above, below);
}

/// Lines of a step of [`PhaseSymmetry::map`], at least one.
fn lines_of_step(length: usize) -> usize {
    (STEP / length.max(1)).max(1)
}

/// The complex number `pairs[n]`; `n` must be in bounds.
#[inline(always)]
fn number(pairs: &[Pair], n: usize) -> Complex<f32> {
    let [re, im] = pairs.get(n).copied().unwrap_or_default();
    Complex { re, im }
}
