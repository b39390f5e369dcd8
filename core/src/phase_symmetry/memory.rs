//! Memory of phase symmetry: sizes, fast memory and external memory.

use super::external::{ReadAt, WriteAt};
use crate::Error;
use crate::memory::{Need, Scratch};
use crate::simd::split_front;
use num_complex::Complex;

/// Image size and strip height, which determine all memory.
///
/// The lengths are constants if the sizes are. They saturate at `usize::MAX`.
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
    /// Columns of the image: 64, 128, 256, 512 or 1024.
    pub columns: usize,
    /// Rows or columns processed at a time, at least 1.
    ///
    /// A larger number than the image's means all of them. The strip height changes memory and time, never the
    /// result.
    pub strip: usize,
}

impl Sizes {
    /// An image of `rows` × `columns` pixels, in strips of `strip` rows or columns.
    pub const fn new(rows: usize, columns: usize, strip: usize) -> Self {
        Sizes {
            rows,
            columns,
            strip,
        }
    }

    /// Fast memory for one line at a time, for [`StripSlices::new`].
    ///
    /// `4·S·N + N` real numbers and N complex ones, 16·S·N + 12·N bytes, with N the longer side and S the strip
    /// height.
    ///
    /// | N \\ S | 1 | 16 | 64 | N |
    /// |---:|---:|---:|---:|---:|
    /// | 64 | 1.8 kB | 17.2 kB | 66.3 kB | 66.3 kB |
    /// | 128 | 3.6 kB | 34.3 kB | 132.6 kB | 263.7 kB |
    /// | 512 | 14.3 kB | 137.2 kB | 530.4 kB | 4.2 MB |
    ///
    /// The filter tables need [`super::LogGaborTables::BYTES`] more, for all sizes and scales. The external memory
    /// of R × C pixels is 20·R·C + 4·R·(C + 2) bytes, the image included: 98.8 kB for 64 × 64 and 6.3 MB for 512 ×
    /// 512.
    pub const fn need(&self) -> Need {
        let strips = Need::real(self.strip_len()).and(Need::real(self.sums_len()));
        strips.and(Need::new(self.gains_len(), self.line_len()))
    }

    /// Length of [`StripSlices::strip`]: `2·S·N` numbers.
    ///
    /// N is the longer side and S the strip height.
    pub const fn strip_len(&self) -> usize {
        self.height()
            .saturating_mul(self.longest())
            .saturating_mul(2)
    }

    /// Length of [`StripSlices::sums`]: that of the strip.
    pub const fn sums_len(&self) -> usize {
        self.strip_len()
    }

    /// Length of [`StripSlices::line`]: N complex vectors.
    pub const fn line_len(&self) -> usize {
        self.longest()
    }

    /// Length of [`StripSlices::gains`]: N vectors.
    pub const fn gains_len(&self) -> usize {
        self.longest()
    }

    /// Length of [`External::image`]: rows × columns.
    pub const fn image_len(&self) -> usize {
        self.rows.saturating_mul(self.columns)
    }

    /// Length of [`External::spectrum`]: 2 × rows × (columns/2 + 1).
    pub const fn spectrum_len(&self) -> usize {
        self.rows.saturating_mul(self.half()).saturating_mul(2)
    }

    /// Length of [`External::filtered`]: 2 × rows × columns.
    pub const fn filtered_len(&self) -> usize {
        self.image_len().saturating_mul(2)
    }

    /// Length of [`External::amplitude`]: rows × columns.
    pub const fn amplitude_len(&self) -> usize {
        self.image_len()
    }

    /// Length of [`External::symmetry`]: rows × columns.
    pub const fn symmetry_len(&self) -> usize {
        self.image_len()
    }

    /// Length of [`super::GainTables`] for a bank of `scales` scales.
    ///
    /// For R × C pixels and s scales `(C/2 + 1)·(s·(R/2 + 1) + 8·R)` numbers, 5.0 MB for 512² and three scales.
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

/// The five matrices in external memory, with any initial contents.
///
/// Every access covers one range or a few long ones. Complex numbers are stored in strips, each line after line:
/// the real parts of all its columns (or rows), then the imaginary parts.
pub struct External<'a> {
    /// The image, 0..255; only read. Row-major, [`Sizes::image_len`] long.
    pub image: &'a mut dyn ReadAt,
    /// The image's half spectrum in strips of columns, [`Sizes::spectrum_len`] long.
    pub spectrum: &'a mut dyn WriteAt,
    /// Columns of one filter, in strips of rows, [`Sizes::filtered_len`] long.
    ///
    /// Intermediate result between columns and rows.
    pub filtered: &'a mut dyn WriteAt,
    /// Denominator of Eq. 10, in strips of rows, [`Sizes::amplitude_len`] long.
    pub amplitude: &'a mut dyn WriteAt,
    /// Numerator of Eq. 10 in strips of rows, and finally the map, row-major.
    ///
    /// [`Sizes::symmetry_len`] long.
    pub symmetry: &'a mut dyn WriteAt,
}

/// Fast memory, divided into slices for an image's size.
///
/// [`StripSlices::new`] divides a scratch for one line at a time; for the lanes of a vector, fill the fields.
/// Slices may be longer than stated. A slice that is too short gives [`crate::Error::Capacity`].
///
/// `V` is the vector to compute with: `f32` for one line at a time, a processor's registers for one line per lane.
///
/// Strips of one step may be processed in parallel, each in slices of its own:
/// [`spectrum`](super::PhaseSymmetry::spectrum), then for each filter
/// [`filter_columns`](super::PhaseSymmetry::filter_columns) of every strip of columns and
/// [`add_rows`](super::PhaseSymmetry::add_rows) of every strip of rows. In sequence, [`super::PhaseSymmetry::run`] does
/// this.
pub struct StripSlices<'a, V> {
    /// Input of a strip, [`Sizes::strip_len`] long.
    pub strip: &'a mut [f32],
    /// Output of a strip, or the two sums of Eq. 10, [`Sizes::sums_len`] long.
    pub sums: &'a mut [f32],
    /// One line in each lane, [`Sizes::line_len`] long.
    pub line: &'a mut [Complex<V>],
    /// A filter's gains along the lines, [`Sizes::gains_len`] long.
    pub gains: &'a mut [V],
}

impl<'a> StripSlices<'a, f32> {
    /// Divides memory of [`Sizes::need`] for one line at a time.
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
