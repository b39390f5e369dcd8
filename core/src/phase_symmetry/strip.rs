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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::Scratch;
    use crate::phase_symmetry::external::ReadAt;
    use crate::phase_symmetry::{LogGabor, Microfft, Parameters, Sizes};
    use num_complex::Complex;
    use std::vec::Vec;

    /// Memory that fails where a number is read before it is written.
    struct Unwritten(Vec<Option<f32>>);

    impl ReadAt for Unwritten {
        fn read_at(&mut self, first: usize, into: &mut [f32]) -> Result<(), Error> {
            for (to, from) in into.iter_mut().zip(&self.0[first..]) {
                *to = from.ok_or(Error::Memory)?;
            }
            Ok(())
        }
    }

    impl WriteAt for Unwritten {
        fn write_at(&mut self, first: usize, from: &[f32]) -> Result<(), Error> {
            for (to, &from) in self.0[first..].iter_mut().zip(from) {
                *to = Some(from);
            }
            Ok(())
        }
    }

    #[test]
    #[cfg_attr(miri, ignore = "six filters over 64 × 64 pixels")]
    fn nothing_is_read_before_it_is_written_and_the_filters_are_counted() {
        let sizes = Sizes {
            rows: 64,
            columns: 64,
            strip: 24,
        };
        let bank = PhaseSymmetry::new(&Parameters {
            sizes,
            scales: &[0.1],
            threshold: 1.0,
        })
        .unwrap();
        let image: [f32; 64 * 64] =
            core::array::from_fn(|k| if k / 64 == 20 { 200.0 } else { 10.0 });
        let unwritten = |length| Unwritten(std::vec![None; length]);
        let mut symmetry = unwritten(sizes.symmetry_len());
        let mut external = External {
            image: &mut &image[..],
            spectrum: &mut unwritten(sizes.spectrum_len()),
            filtered: &mut unwritten(sizes.filtered_len()),
            amplitude: &mut unwritten(sizes.amplitude_len()),
            symmetry: &mut symmetry,
        };
        let kernels = Kernels {
            fft: &Microfft,
            gains: &LogGabor::fixed(),
        };
        let need = sizes.need();
        let mut real = std::vec![0.0; need.real];
        let mut complex = std::vec![Complex::ZERO; need.complex];
        let scratch = Scratch::new(&mut real, &mut complex);
        let mut memory = StripSlices::new(sizes, scratch).unwrap();
        let mut heard = Vec::new();
        let mut progress = |done| heard.push(done);
        bank.run(&kernels, &mut external, &mut memory, &mut progress)
            .unwrap();
        assert!((1..=6).eq(heard));
        let map: Option<Vec<f32>> = symmetry.0.into_iter().collect();
        let map = map.unwrap();
        assert!(map[20 * 64] > 0.3 && map[50 * 64] < 0.1);
    }
}
