//! A filter bank for images of one size: validated parameters and strips.

use super::log_gabor::{ORIENTATIONS, Scale};
use super::memory::Sizes;
use crate::Error;
use crate::error::{at_least_one, attempt, not_negative};
use core::ops::Range;

/// Maximum number of scales of a bank.
pub const MAX_SCALES: usize = 8;

/// The parameters of a bank of filters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameters<'a> {
    /// The image's size and the strip height.
    pub sizes: Sizes,
    /// Centre frequencies `r₀` of the filters in cycles per pixel.
    ///
    /// From 2⁻¹⁰ to 2⁻¹; 1 to [`MAX_SCALES`] of them. The paper uses some of 2⁻⁵ to 2⁻⁹.
    pub scales: &'a [f64],
    /// The noise threshold `T_n`, in units of the image.
    pub threshold: f32,
}

/// Phase symmetry of images of one size: validated parameters.
///
/// ```
/// use bonebeam::prelude::stages::*;
/// use bonebeam::phase_symmetry::{Kernels, Parameters, Sizes};
///
/// const SIZES: Sizes = Sizes { rows: 64, columns: 64, strip: 16 };
/// const NEED: Need = SIZES.need();
/// // On a microcontroller these are statics; all but the first two may lie in slow memory.
/// let mut tables = LogGaborTables::new();
/// let mut memory = Memory::<{ NEED.real }, { NEED.complex }>::new();
/// let mut spectrum = [0.0; SIZES.spectrum_len()];
/// let mut filtered = [0.0; SIZES.filtered_len()];
/// let mut amplitude = [0.0; SIZES.amplitude_len()];
/// let mut symmetry = [0.0; SIZES.symmetry_len()];
///
/// // A bright line across, in row 20.
/// let mut image = [10.0; SIZES.image_len()];
/// image[20 * 64..21 * 64].fill(200.0);
///
/// let bank = PhaseSymmetry::new(&Parameters {
///     sizes: SIZES,
///     scales: &[1.0 / 8.0, 1.0 / 16.0],
///     threshold: 3.0,
/// })?;
/// bank.run(
///     &Kernels {
///         fft: &Microfft,
///         gains: &LogGabor::new(&mut tables),
///     },
///     &mut External {
///         image: &mut &image[..],
///         spectrum: &mut &mut spectrum[..],
///         filtered: &mut &mut filtered[..],
///         amplitude: &mut &mut amplitude[..],
///         symmetry: &mut &mut symmetry[..],
///     },
///     &mut StripSlices::new(SIZES, memory.scratch())?,
///     &mut |_| {},
/// )?;
/// assert!(symmetry[20 * 64] > 0.3 && symmetry[50 * 64] < 0.1);
/// # Ok::<(), Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PhaseSymmetry {
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) strip: usize,
    pub(super) scales: [Scale; MAX_SCALES],
    pub(super) scale_count: usize,
    pub(super) threshold: f32,
}

impl Parameters<'_> {
    /// Checks all values; a `const` can call it.
    ///
    /// # Errors
    /// As [`PhaseSymmetry::new`].
    pub const fn check(&self) -> Result<(), Error> {
        let Parameters {
            sizes,
            scales,
            threshold,
        } = *self;
        if scales.len() > MAX_SCALES {
            return Err(Error::capacity(
                "number of scales",
                scales.len(),
                MAX_SCALES,
            ));
        }
        attempt!(at_least_one("number of scales", scales.len()));
        attempt!(at_least_one("strip height", sizes.strip));
        attempt!(not_negative("noise threshold", threshold));
        attempt!(Scale::check(sizes.rows, sizes.columns, 0.5));
        let mut k = 0;
        while k < scales.len() {
            attempt!(Scale::check(sizes.rows, sizes.columns, scales[k]));
            k += 1;
        }
        Ok(())
    }
}

impl PhaseSymmetry {
    /// A bank of six orientations at each scale.
    ///
    /// The orientations are 0 and −π/2 + kπ/6 for k = 0, ±1, ±2.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a side other than 64, 128, 256, 512 or 1024, for no scales or one outside
    /// 2⁻¹⁰..=2⁻¹, for a threshold that is negative or not finite, and for a strip height of 0; [`Error::Capacity`]
    /// for more than [`MAX_SCALES`] scales.
    pub fn new(parameters: &Parameters<'_>) -> Result<Self, Error> {
        let Parameters {
            sizes,
            scales,
            threshold,
        } = *parameters;
        parameters.check()?;
        let Sizes { rows, columns, .. } = sizes;
        let mut filled = [Scale::new(rows, columns, 0.5)?; MAX_SCALES];
        for (filled, &scale) in filled.iter_mut().zip(scales) {
            *filled = Scale::new(rows, columns, scale)?;
        }
        Ok(PhaseSymmetry {
            rows,
            columns,
            strip: sizes.height(),
            scales: filled,
            scale_count: scales.len(),
            threshold,
        })
    }

    /// Image size and strip height, at most the longer side.
    pub const fn sizes(&self) -> Sizes {
        Sizes::new(self.rows, self.columns, self.strip)
    }

    /// Number of filters: six per scale.
    ///
    /// The order is scale by scale as given, and within a scale 0, −π/6, −π/3, −π/2, −2π/3, −5π/6.
    pub const fn filters(&self) -> usize {
        self.scale_count * ORIENTATIONS.len()
    }

    /// Length of the [`super::GainTables`] of this bank: [`Sizes::gain_tables_len`].
    pub const fn gain_tables_len(&self) -> usize {
        self.sizes().gain_tables_len(self.scale_count)
    }

    /// Strips of rows, from the top.
    pub fn row_strips(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        strips(self.rows, self.strip)
    }

    /// Strips of columns of the half spectrum, from the left.
    pub fn column_strips(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        strips(self.sizes().half(), self.strip)
    }

    /// Refuses a filter that the bank does not have and lines that are not one of its strips.
    pub(super) fn check_step(
        &self,
        filter: usize,
        strip: &Range<usize>,
        mut strips: impl Iterator<Item = Range<usize>>,
    ) -> Result<(), Error> {
        if filter >= self.filters() {
            return Err(Error::capacity(
                "number of the filter",
                filter,
                self.filters() - 1,
            ));
        }
        if strips.any(|known| known == *strip) {
            return Ok(());
        }
        let expected = "one of the bank's strips";
        let value = strip.start as f64;
        Err(Error::parameter("first line of a strip", value, expected))
    }
}

fn strips(lines: usize, strip: usize) -> impl Iterator<Item = Range<usize>> {
    // A bank's are never 0, which the compiler does not know.
    (0..lines)
        .step_by(strip.max(1))
        .map(move |start| start..start + strip.min(lines - start))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_that_the_bank_does_not_have_are_refused() {
        let bank = PhaseSymmetry::new(&Parameters {
            sizes: Sizes::new(64, 128, 48),
            scales: &[0.1, 0.2],
            threshold: 3.0,
        })
        .unwrap();
        let rows = |filter, strip| bank.check_step(filter, &strip, bank.row_strips());
        let columns = |filter, strip| bank.check_step(filter, &strip, bank.column_strips());
        for filter in [0, 11] {
            assert_eq!(rows(filter, 0..48), Ok(()));
            assert_eq!(rows(filter, 48..64), Ok(()));
            assert_eq!(columns(filter, 48..65), Ok(()));
        }
        for filter in [12, usize::MAX] {
            let refused = Err(Error::capacity("number of the filter", filter, 11));
            assert_eq!(rows(filter, 0..48), refused);
            assert_eq!(columns(filter, 0..48), refused);
        }
        for strip in [0..0, 0..47, 1..48, 48..65, 64..112] {
            assert!(matches!(rows(0, strip), Err(Error::Parameter { .. })));
        }
        assert!(matches!(columns(0, 48..64), Err(Error::Parameter { .. })));
    }
}
