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
//! The lines of a strip sit in lanes, as many as a vector has. Each is transformed by itself and
//! each pixel's sums grow by one filter at a time, in the same order whatever the strip height and
//! the vector; so strips of one step may also be worked on side by side.

use super::external::Store;
use super::fft::Fft;
use super::gains::Gains;
use super::log_gabor::{ORIENTATIONS, Scale};
use super::workspace::{External, StripBuffers, spectrum_columns};
use crate::Error;
use crate::simd::Vector;
use core::ops::Range;

/// The most scales of a bank.
pub const MAX_SCALES: usize = 8;

/// Validated parameters: the image's size, the bank and the strip height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseSymmetry {
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) scales: [Scale; MAX_SCALES],
    pub(super) scale_count: usize,
    pub(super) threshold: f32,
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
        let mut kept = [Scale::new(rows, columns, 0.5)?; MAX_SCALES];
        for (kept, &scale) in kept.iter_mut().zip(scales) {
            *kept = Scale::new(rows, columns, scale)?;
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
    /// index of a NaN or infinite pixel; [`Error::Parameter`] for a pixel beyond
    /// [`super::MAX_PIXEL`] or another bank's gain tables; what the external memory reports.
    /// Only the last kind of error leaves `symmetry` changed.
    pub fn run<V: Vector, F: Fft<V>, G: Gains<V>>(
        &self,
        kernels: &Kernels<'_, V, F, G>,
        external: &mut External<'_>,
        buffers: &mut StripBuffers<'_, V>,
        progress: &mut dyn FnMut(usize),
    ) -> Result<(), Error> {
        self.spectrum(kernels, external.image, external.spectrum, buffers)?;
        for filter in 0..self.filters() {
            for columns in self.column_strips() {
                let (spectrum, filtered) = (&mut *external.spectrum, &mut *external.filtered);
                self.filter_columns(kernels, filter, columns, spectrum, filtered, buffers)?;
            }
            for rows in self.row_strips() {
                let sums: [&mut dyn Store; 2] = [external.symmetry, external.amplitude];
                self.add_rows(kernels, filter, rows, external.filtered, sums, buffers)?;
            }
            progress(filter + 1);
        }
        Ok(())
    }

    /// Refuses buffers that are too small and gains of another bank.
    pub(super) fn check<V: Vector, F: Fft<V>, G: Gains<V>>(
        &self,
        kernels: &Kernels<'_, V, F, G>,
        buffers: &StripBuffers<'_, V>,
    ) -> Result<(), Error> {
        kernels.gains.check(self)?;
        let longest = if self.rows > self.columns {
            self.rows
        } else {
            self.columns
        };
        let area = 2 * self.strip * longest;
        for (name, actual, capacity) in [
            ("strip buffer", area, buffers.strip.len()),
            ("sums buffer", area, buffers.sums.len()),
            ("line buffer", longest, buffers.line.len()),
            ("gain buffer", longest, buffers.gains.len()),
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

    /// The strips of rows, from the top.
    pub fn row_strips(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        strips(self.rows, self.strip)
    }

    /// The strips of columns of the half spectrum, from the left.
    pub fn column_strips(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        strips(spectrum_columns(self.columns), self.strip)
    }

    /// Refuses a filter that the bank does not have and lines that are not one of its strips.
    pub(super) fn check_step(
        &self,
        filter: usize,
        strip: &Range<usize>,
        mut strips: impl Iterator<Item = Range<usize>>,
    ) -> Result<(), Error> {
        if filter >= self.filters() {
            return Err(Error::Capacity {
                name: "number of the filter",
                actual: filter,
                capacity: self.filters() - 1,
            });
        }
        if strips.any(|known| known == *strip) {
            return Ok(());
        }
        Err(Error::Parameter {
            name: "first line of a strip",
            value: strip.start as f64,
            expected: "a strip that the bank itself names",
        })
    }
}

/// What phase symmetry computes with, whatever the image.
#[derive(Debug)]
pub struct Kernels<'a, V, F, G> {
    /// Zero in every lane of the vector to use.
    pub zero: V,
    /// The transform.
    pub fft: &'a F,
    /// The filters' gains.
    pub gains: &'a G,
}

fn strips(lines: usize, strip: usize) -> impl Iterator<Item = Range<usize>> {
    (0..lines).step_by(strip).map(move |start| {
        let left = lines - start;
        start..start + if strip < left { strip } else { left }
    })
}
