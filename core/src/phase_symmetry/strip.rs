//! Phase symmetry in strips: exact for every strip height.
//!
//! The filters extend over the whole image, so no tile with a halo gives the global result. A two-dimensional
//! transform computed one row and one column at a time does, with only the current strip in fast memory:
//!
//! 1. The image's rows are transformed, then the columns of the half spectrum of a real image (0..=N/2).
//! 2. For each filter: columns of spectrum × gain are inversely transformed, then rows. Each row's `e` and `o` are
//!    added to the two sums of Eq. 10.
//!
//! The lines of a strip are in lanes, one a lane. Each line is transformed alone, and each pixel's sums grow by one
//! filter at a time, in the same order for every strip height and vector. Strips of one step may therefore run in
//! parallel.

use super::bank::PhaseSymmetry;
use super::external::WriteAt;
use super::fft::Fft;
use super::gains::Gains;
use super::memory::{External, StripSlices};
use crate::Error;
use crate::simd::Vector;

/// The transform and the gains, for all images.
#[derive(Debug)]
pub struct Kernels<'a, F, G> {
    /// The transform: [`super::Microfft`] for one line, [`super::LaneFft`] for lanes.
    pub fft: &'a F,
    /// The filters' gains: [`super::LogGabor`] or [`super::GainTables`].
    pub gains: &'a G,
}

impl<'a, F, G> Kernels<'a, F, G> {
    /// A transform with gains.
    pub const fn new(fft: &'a F, gains: &'a G) -> Self {
        Kernels { fft, gains }
    }
}

impl PhaseSymmetry {
    /// Computes the map `PS`, in `[0, 1)`, into [`External::symmetry`].
    ///
    /// `progress` receives the number of filters done, of [`PhaseSymmetry::filters`], after each filter.
    /// [`PhaseSymmetry`] has an example.
    ///
    /// In exact arithmetic the quotient of Eq. 10 is below 1. A quotient that rounds to 1 becomes the largest float
    /// below 1. Filters are added in the order of [`PhaseSymmetry::filters`]. A constant image gives exactly 0.
    ///
    /// Cost: one complex transform per row and per half-spectrum column, then per filter one
    /// inverse transform per row and per column, and 8 bytes of traffic each way per pixel and
    /// filter for `filtered`, 8 more each way for the sums.
    ///
    /// # Errors
    /// [`Error::Capacity`] for memory that is too small; [`Error::NonFinite`] with the flat index of a NaN or
    /// infinite pixel; [`Error::Parameter`] for a pixel beyond [`super::MAX_PIXEL`] or another bank's gain tables;
    /// errors of the external memory. Only the last kind leaves `symmetry` changed.
    pub fn run<V: Vector, F: Fft<V>, G: Gains<V>>(
        &self,
        kernels: &Kernels<'_, F, G>,
        external: &mut External<'_>,
        memory: &mut StripSlices<'_, V>,
        progress: &mut dyn FnMut(usize),
    ) -> Result<(), Error> {
        self.spectrum(kernels, external.image, external.spectrum, memory)?;
        for filter in 0..self.filters() {
            for columns in self.column_strips() {
                let (spectrum, filtered) = (&mut *external.spectrum, &mut *external.filtered);
                self.filter_columns(kernels, filter, columns, spectrum, filtered, memory)?;
            }
            for rows in self.row_strips() {
                let sums: [&mut dyn WriteAt; 2] = [external.symmetry, external.amplitude];
                self.add_rows(kernels, filter, rows, external.filtered, sums, memory)?;
            }
            progress(filter + 1);
        }
        Ok(())
    }

    /// The vector to compute with, which is the memory's. Refuses memory that is too small and gains of
    /// another bank.
    pub(super) fn check<V: Vector, F: Fft<V>, G: Gains<V>>(
        &self,
        kernels: &Kernels<'_, F, G>,
        memory: &StripSlices<'_, V>,
    ) -> Result<V, Error> {
        kernels.gains.check(self)?;
        let sizes = self.sizes();
        for (name, actual, capacity) in [
            ("strip buffer", sizes.strip_len(), memory.strip.len()),
            ("sums buffer", sizes.sums_len(), memory.sums.len()),
            ("line buffer", sizes.line_len(), memory.line.len()),
            ("gain buffer", sizes.gains_len(), memory.gains.len()),
        ] {
            if actual > capacity {
                return Err(Error::capacity(name, actual, capacity));
            }
        }
        match memory.gains.first() {
            Some(gain) => Ok(gain.zero()),
            None => Err(Error::capacity("gain buffer", sizes.gains_len(), 0)),
        }
    }
}
