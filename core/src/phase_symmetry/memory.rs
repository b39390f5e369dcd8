//! The memory that phase symmetry works in: how much of it, the fast one and the external one.

use super::external::{ReadAt, WriteAt};
use crate::Error;
use crate::memory::{Need, Scratch};
use crate::simd::split_front;
use num_complex::Complex;

/// An image's size, and how much of it is worked on at a time. What memory they take follows, at compile
/// time as well; a length beyond `usize::MAX` is given as that:
///
/// ```
/// use bonebeam::phase_symmetry::Sizes;
///
/// const SIZES: Sizes = Sizes { rows: 128, columns: 64, strip: 16 };
/// static SPECTRUM: [f32; SIZES.spectrum_len()] = [0.0; SIZES.spectrum_len()];
/// assert_eq!(SPECTRUM.len(), 2 * 128 * 33);
/// assert_eq!(SIZES.need().real, 2 * SIZES.strip_len() + 128);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sizes {
    /// Rows of the image: 64, 128, 256, 512 or 1024.
    pub rows: usize,
    /// Columns of the image, likewise.
    pub columns: usize,
    /// How many rows or columns are worked on at a time, at least 1; more than the image has means all of
    /// them. It changes memory and time, never the result.
    pub strip: usize,
}

impl Sizes {
    /// The fast memory for one line at a time, [`StripSlices::new`]: `4·S·N + N` real numbers and N complex ones,
    /// 16·S·N + 12·N bytes, with N the longer side and S the strip height.
    ///
    /// | N \\ S | 1 | 16 | 64 | N |
    /// |---:|---:|---:|---:|---:|
    /// | 64 | 1.8 kB | 17.2 kB | 66.3 kB | 66.3 kB |
    /// | 128 | 3.6 kB | 34.3 kB | 132.6 kB | 263.7 kB |
    /// | 512 | 14.3 kB | 137.2 kB | 530.4 kB | 4.2 MB |
    ///
    /// With it go the filter tables, [`super::LogGaborTables::BYTES`] for all sizes and scales. The external memory
    /// of R × C pixels is 20·R·C + 4·R·(C + 2) bytes, the image included: 98.8 kB for 64 × 64 and 6.3 MB for
    /// 512 × 512.
    pub const fn need(&self) -> Need {
        let strips = Need::real(self.strip_len()).and(Need::real(self.sums_len()));
        strips.and(Need {
            real: self.gains_len(),
            complex: self.line_len(),
        })
    }

    /// Numbers in [`StripSlices::strip`]: `2·S·N`, with N the longer side and S the strip height.
    pub const fn strip_len(&self) -> usize {
        self.height()
            .saturating_mul(self.longest())
            .saturating_mul(2)
    }

    /// Numbers in [`StripSlices::sums`]: as many.
    pub const fn sums_len(&self) -> usize {
        self.strip_len()
    }

    /// Complex vectors in [`StripSlices::line`]: N.
    pub const fn line_len(&self) -> usize {
        self.longest()
    }

    /// Vectors in [`StripSlices::gains`]: N.
    pub const fn gains_len(&self) -> usize {
        self.longest()
    }

    /// Numbers in [`External::image`]: rows × columns.
    pub const fn image_len(&self) -> usize {
        self.rows.saturating_mul(self.columns)
    }

    /// Numbers in [`External::spectrum`]: 2 × rows × (columns/2 + 1).
    pub const fn spectrum_len(&self) -> usize {
        self.rows.saturating_mul(self.half()).saturating_mul(2)
    }

    /// Numbers in [`External::filtered`]: 2 × rows × columns.
    pub const fn filtered_len(&self) -> usize {
        self.image_len().saturating_mul(2)
    }

    /// Numbers in [`External::amplitude`]: rows × columns.
    pub const fn amplitude_len(&self) -> usize {
        self.image_len()
    }

    /// Numbers in [`External::symmetry`]: rows × columns.
    pub const fn symmetry_len(&self) -> usize {
        self.image_len()
    }

    /// Numbers in [`super::GainTables`] of a bank of so many scales: for R × C pixels and s scales
    /// `(C/2 + 1)·(s·(R/2 + 1) + 8·R)`, 5.0 MB for 512² and three scales.
    pub const fn gain_tables_len(&self, scales: usize) -> usize {
        let radial = scales.saturating_mul(self.rows / 2 + 1);
        let angular = super::log_gabor::TURNS.saturating_mul(self.rows);
        self.half().saturating_mul(radial.saturating_add(angular))
    }

    /// The width of the half spectrum that a real image needs.
    pub(super) const fn half(&self) -> usize {
        self.columns / 2 + 1
    }

    /// The longer side.
    pub(super) const fn longest(&self) -> usize {
        if self.rows > self.columns {
            self.rows
        } else {
            self.columns
        }
    }

    /// The strip height, at most the longer side.
    pub(super) const fn height(&self) -> usize {
        if self.strip < self.longest() {
            self.strip
        } else {
            self.longest()
        }
    }
}

/// The five matrices in external memory. Their contents need not be initialised.
///
/// What is read and written at a time lies in one range or in a few long ones: complex numbers are
/// in strips, and of each strip line after line, the real parts of all its columns (or rows), then
/// the imaginary ones.
pub struct External<'a> {
    /// The image, 0..255; only read. Row-major, [`Sizes::image_len`] long.
    pub image: &'a mut dyn ReadAt,
    /// The image's half spectrum in strips of columns, [`Sizes::spectrum_len`] long.
    pub spectrum: &'a mut dyn WriteAt,
    /// One filter's columns on the way to its rows, in strips of rows, [`Sizes::filtered_len`] long.
    pub filtered: &'a mut dyn WriteAt,
    /// Eq. 10's denominator on the way, in strips of rows, [`Sizes::amplitude_len`] long.
    pub amplitude: &'a mut dyn WriteAt,
    /// Eq. 10's numerator on the way, likewise, and the phase symmetry map in the end, row-major,
    /// [`Sizes::symmetry_len`] long.
    pub symmetry: &'a mut dyn WriteAt,
}

/// Fast memory, cut to an image's size: by [`StripSlices::new`], or for the lanes of a vector by hand. Each slice may
/// be longer than said. Whatever is too short is refused with [`crate::Error::Capacity`].
///
/// The vectors are those that are computed with: `f32` for one line at a time, a processor's registers for
/// as many as they have lanes.
///
/// Strips of one step may be worked on side by side, each in slices of its own. One after the other, this
/// is what [`super::PhaseSymmetry::run`] does:
///
/// ```
/// use bonebeam::Error;
/// use bonebeam::phase_symmetry::{
///     GainTables, Kernels, LaneFft, LogGabor, LogGaborTables, Parameters, PhaseSymmetry, Sizes,
///     StripSlices, scale_for_display,
/// };
/// use bonebeam::simd::Vector;
/// use num_complex::Complex;
///
/// fn map<V: Vector>(zero: V, image: &[f32], parameters: &Parameters) -> Result<Vec<f32>, Error> {
///     let bank = PhaseSymmetry::new(parameters)?;
///     let sizes = bank.sizes();
///     let mut tables = LogGaborTables::new();
///     let gains = vec![0.0; bank.gain_tables_len()];
///     let kernels = Kernels {
///         fft: &LaneFft::new(),
///         gains: &GainTables::new(&LogGabor::new(&mut tables), &bank, gains)?,
///     };
///     let mut memory = StripSlices {
///         strip: &mut vec![0.0; sizes.strip_len()],
///         sums: &mut vec![0.0; sizes.sums_len()],
///         line: &mut vec![Complex::new(zero, zero); sizes.line_len()],
///         gains: &mut vec![zero; sizes.gains_len()],
///     };
///     let mut spectrum = vec![0.0; sizes.spectrum_len()];
///     let mut filtered = vec![0.0; sizes.filtered_len()];
///     let mut amplitude = vec![0.0; sizes.amplitude_len()];
///     let mut symmetry = vec![0.0; sizes.symmetry_len()];
///     let (mut image, mut spectrum) = (image, &mut spectrum[..]);
///     let mut filtered = &mut filtered[..];
///     bank.spectrum(&kernels, &mut image, &mut spectrum, &mut memory)?;
///     for filter in 0..bank.filters() {
///         for columns in bank.column_strips() {
///             bank.filter_columns(&kernels, filter, columns, &mut spectrum, &mut filtered, &mut memory)?;
///         }
///         for rows in bank.row_strips() {
///             let (mut above, mut below) = (&mut symmetry[..], &mut amplitude[..]);
///             bank.add_rows(&kernels, filter, rows, &mut filtered, [&mut above, &mut below], &mut memory)?;
///         }
///     }
///     scale_for_display(&mut symmetry)?;
///     Ok(symmetry)
/// }
///
/// let sizes = Sizes { rows: 64, columns: 128, strip: 7 };
/// let mut image = vec![10.0; sizes.image_len()];
/// image[20 * 128..21 * 128].fill(200.0);
/// let parameters = Parameters { sizes, scales: &[1.0 / 8.0], threshold: 3.0 };
/// let map = map(0.0f32, &image, &parameters)?;
/// assert!(map[20 * 128] > 254.0 && map[50 * 128] < 25.0);
/// # Ok::<(), Error>(())
/// ```
pub struct StripSlices<'a, V> {
    /// What a strip reads, [`Sizes::strip_len`].
    pub strip: &'a mut [f32],
    /// What it gives, or Eq. 10's two sums, [`Sizes::sums_len`].
    pub sums: &'a mut [f32],
    /// As many lines as a vector has lanes, [`Sizes::line_len`].
    pub line: &'a mut [Complex<V>],
    /// A filter's gains along them, [`Sizes::gains_len`].
    pub gains: &'a mut [V],
}

impl<'a> StripSlices<'a, f32> {
    /// The buffers for one line at a time, in memory of [`Sizes::need`].
    ///
    /// # Errors
    /// [`Error::Length`] if the memory is shorter.
    pub fn new(sizes: Sizes, scratch: Scratch<'a>) -> Result<Self, Error> {
        let mut scratch = scratch;
        let mut scratch = scratch.take(sizes.need())?;
        Ok(StripSlices {
            strip: split_front(&mut scratch.real, sizes.strip_len()),
            sums: split_front(&mut scratch.real, sizes.sums_len()),
            line: scratch.complex,
            gains: scratch.real,
        })
    }
}
