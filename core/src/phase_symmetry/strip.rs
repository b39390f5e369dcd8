//! Phase symmetry in strips: exact for every strip height.
//!
//! The filters reach over the whole image, so no tile with a halo gives the global result. A
//! two-dimensional transform done one row and one column at a time does, and needs only the
//! strip at hand in fast memory:
//!
//! 1. The image's rows are transformed, then the columns of the half spectrum that a real image
//!    needs (0..=N/2).
//! 2. For each filter: columns of spectrum × gain are inversely transformed, then rows, and each
//!    row's `e` and `o` are added to Eq. 10's two sums.
//!
//! Each line is transformed by itself and each pixel's sums grow by one filter at a time, in the
//! same order whatever the strip height; so could the lines of a strip sit in lanes.

use super::external::Area;
use super::log_gabor::{Filter, LogGabor, ORIENTATIONS};
use super::transform::inverse;
use super::workspace::{External, StripBuffers, spectrum_columns};
use crate::Error;
use num_complex::Complex;

/// The most scales of a bank.
pub const MAX_SCALES: usize = 8;
/// `ε` of Eq. 10.
const EPSILON: f32 = 1e-10;
/// The largest float below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// Validated parameters: the image's size, the bank and the strip height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseSymmetry {
    pub(super) rows: usize,
    pub(super) columns: usize,
    scales: [f64; MAX_SCALES],
    scale_count: usize,
    threshold: f32,
    pub(super) strip: usize,
}

impl PhaseSymmetry {
    /// Phase symmetry of `rows` × `columns` pixels with the six orientations of
    /// [`ORIENTATIONS`] at each of `scales` (`r₀`, cycles per pixel), the noise threshold `T_n`
    /// (in units of the image) and strips of `strip` rows or columns. A strip height beyond the
    /// image means the whole image.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a side that is not 64, 128, 256, 512 or 1024, for no scales or
    /// one outside 2⁻¹⁰..=2⁻¹, for a threshold that is negative or not finite, for a strip
    /// height of 0; [`Error::Capacity`] for more than [`MAX_SCALES`] scales.
    pub fn new(
        rows: usize,
        columns: usize,
        scales: &[f64],
        threshold: f32,
        strip: usize,
    ) -> Result<Self, Error> {
        if scales.len() > MAX_SCALES {
            return Err(Error::Capacity {
                name: "number of scales",
                actual: scales.len(),
                capacity: MAX_SCALES,
            });
        }
        for (name, value) in [("number of scales", scales.len()), ("strip height", strip)] {
            if value == 0 {
                return Err(Error::Parameter {
                    name,
                    value: 0.0,
                    expected: "at least 1",
                });
            }
        }
        if !(threshold >= 0.0 && threshold.is_finite()) {
            return Err(Error::Parameter {
                name: "noise threshold",
                value: threshold.into(),
                expected: "a finite number of at least 0",
            });
        }
        let mut kept = [0.0; MAX_SCALES];
        for (kept, &scale) in kept.iter_mut().zip(scales) {
            Filter::new(rows, columns, scale, ORIENTATIONS[0])?;
            *kept = scale;
        }
        let longest = if rows > columns { rows } else { columns };
        Ok(PhaseSymmetry {
            rows,
            columns,
            scales: kept,
            scale_count: scales.len(),
            threshold,
            strip: if strip < longest { strip } else { longest },
        })
    }

    /// How many filters the bank has: 6 a scale.
    pub fn filters(&self) -> usize {
        self.scale_count * ORIENTATIONS.len()
    }

    /// Computes the map `PS`, in `[0, 1)`, into [`External::symmetry`]. `progress` hears the
    /// number of filters done, of [`PhaseSymmetry::filters`], after each.
    ///
    /// In exact arithmetic the quotient of Eq. 10 stays below 1; where it rounds to 1 the largest
    /// float below 1 stands instead. The filters are added scale by scale in the order given, and
    /// within a scale in the order of [`ORIENTATIONS`]. A constant image gives exactly 0.
    ///
    /// Cost: one complex transform per row and per half-spectrum column, then per filter one
    /// inverse transform per row and per column, and 8 bytes of traffic each way per pixel and
    /// filter for `filtered`, 8 more each way for the sums.
    ///
    /// # Errors
    /// [`Error::Capacity`] for buffers that are too small; [`Error::NonFinite`] with the flat
    /// index of a NaN or infinite pixel; [`Error::Parameter`] for a pixel beyond [`super::MAX_PIXEL`];
    /// what the external memory reports. An error of the first two kinds or a pixel too large
    /// leaves `symmetry` untouched.
    pub fn run(
        &self,
        filters: &LogGabor<'_>,
        external: &mut External<'_>,
        buffers: &mut StripBuffers<'_>,
        progress: &mut dyn FnMut(usize),
    ) -> Result<(), Error> {
        self.check_buffers(buffers)?;
        self.transform_rows(external, buffers)?;
        self.transform_columns(external, buffers)?;
        let mut done = 0;
        for &scale in &self.scales[..self.scale_count] {
            for orientation in ORIENTATIONS {
                let filter = Filter::new(self.rows, self.columns, scale, orientation)?;
                self.filter_columns(filters, &filter, external, buffers)?;
                let (first, last) = (done == 0, done + 1 == self.filters());
                self.add_rows(first, last, external, buffers)?;
                done += 1;
                progress(done);
            }
        }
        Ok(())
    }

    fn check_buffers(&self, buffers: &StripBuffers<'_>) -> Result<(), Error> {
        let longest = if self.rows > self.columns {
            self.rows
        } else {
            self.columns
        };
        let area = self.strip * longest;
        for (name, actual, capacity) in [
            ("strip buffer", area, buffers.strip.len()),
            ("line buffer", longest, buffers.line.len()),
            ("gain buffer", longest, buffers.gains.len()),
            ("symmetry buffer", area, buffers.symmetry.len()),
            ("amplitude buffer", area, buffers.amplitude.len()),
        ] {
            if actual > capacity {
                return Err(Error::Capacity {
                    name,
                    actual,
                    capacity,
                });
            }
        }
        Ok(())
    }

    /// All columns from `row` down, at most a strip of rows.
    pub(super) fn row_strip(&self, row: usize) -> Area {
        let left = self.rows - row;
        Area {
            row,
            column: 0,
            rows: if self.strip < left { self.strip } else { left },
            columns: self.columns,
        }
    }

    /// All rows of the columns from `column` up to, but without, `end`, at most a strip of them.
    pub(super) fn column_strip(&self, column: usize, end: usize) -> Area {
        let left = end - column;
        Area {
            row: 0,
            column,
            rows: self.rows,
            columns: if self.strip < left { self.strip } else { left },
        }
    }

    /// Spectrum × gain, inversely transformed along the columns, into `filtered`.
    fn filter_columns(
        &self,
        filters: &LogGabor<'_>,
        filter: &Filter,
        external: &mut External<'_>,
        buffers: &mut StripBuffers<'_>,
    ) -> Result<(), Error> {
        let half = spectrum_columns(self.columns);
        // The strips of the stored half, then those of the other, which is its mirror image.
        for (start, end) in [(0, half), (half, self.columns)] {
            let mirrored = start == half;
            for column in (start..end).step_by(self.strip) {
                let area = self.column_strip(column, end);
                let width = area.columns;
                let strip = &mut buffers.strip[..self.rows * width];
                if mirrored {
                    let column = self.columns + 1 - column - width;
                    external.spectrum.read(Area { column, ..area }, strip)?;
                    strip.chunks_exact_mut(width).for_each(<[_]>::reverse);
                } else {
                    external.spectrum.read(area, strip)?;
                }
                let line = &mut buffers.line[..self.rows];
                let gains = &mut buffers.gains[..self.rows];
                for k in 0..width {
                    filters.column(filter, column + k, gains);
                    for (row, bin) in line.iter_mut().enumerate() {
                        let value = if mirrored {
                            // F(−fy, −fx)* of a real image; row 0 is its own mirror image.
                            let opposite = (self.rows - row) % self.rows;
                            strip[opposite * width + k].conj()
                        } else {
                            strip[row * width + k]
                        };
                        *bin = Complex::new(value.re * gains[row], value.im * gains[row]);
                    }
                    inverse(line);
                    for (row, bin) in line.iter().enumerate() {
                        strip[row * width + k] = *bin;
                    }
                }
                external.filtered.write(area, strip)?;
            }
        }
        Ok(())
    }

    /// The rows of the filtered image, added to the sums; after the last filter their quotient.
    fn add_rows(
        &self,
        first: bool,
        last: bool,
        external: &mut External<'_>,
        buffers: &mut StripBuffers<'_>,
    ) -> Result<(), Error> {
        for row in (0..self.rows).step_by(self.strip) {
            let area = self.row_strip(row);
            let length = area.rows * self.columns;
            let strip = &mut buffers.strip[..length];
            let symmetry = &mut buffers.symmetry[..length];
            let amplitude = &mut buffers.amplitude[..length];
            external.filtered.read(area, strip)?;
            if first {
                symmetry.fill(0.0);
                amplitude.fill(0.0);
            } else {
                external.symmetry.read(area, symmetry)?;
                external.amplitude.read(area, amplitude)?;
            }
            strip.chunks_exact_mut(self.columns).for_each(inverse);
            for ((c, symmetry), amplitude) in
                strip.iter().zip(symmetry.iter_mut()).zip(&mut *amplitude)
            {
                let excess = c.re - c.im.abs() - self.threshold;
                *symmetry += if excess > 0.0 { excess } else { 0.0 };
                *amplitude += libm::sqrtf(c.re * c.re + c.im * c.im);
            }
            if last {
                for (symmetry, amplitude) in symmetry.iter_mut().zip(&*amplitude) {
                    let ratio = *symmetry / (*amplitude + EPSILON);
                    *symmetry = if ratio < 1.0 { ratio } else { BELOW_ONE };
                }
            } else {
                external.amplitude.write(area, amplitude)?;
            }
            external.symmetry.write(area, symmetry)?;
        }
        Ok(())
    }
}
