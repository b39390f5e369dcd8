//! The memory that phase symmetry works in: the fast one and the external one.

use super::external::{Source, Store};
use num_complex::Complex;

/// The width of the half spectrum that [`External::spectrum`] holds: `columns/2 + 1`.
pub const fn spectrum_columns(columns: usize) -> usize {
    columns / 2 + 1
}

/// The five matrices in external memory. Their contents need not be initialised.
///
/// What is read and written at a time lies in one piece or in a few long ones: complex numbers are
/// in strips, and of each strip line after line, the real parts of all its columns (or rows), then
/// the imaginary ones.
pub struct External<'a> {
    /// The image, 0..255; only read. Rows × columns, row-major.
    pub image: &'a mut dyn Source,
    /// The image's half spectrum in strips of columns, 2 × rows × [`spectrum_columns`].
    pub spectrum: &'a mut dyn Store,
    /// One filter's columns on the way to its rows, in strips of rows, 2 × rows × columns.
    pub filtered: &'a mut dyn Store,
    /// Eq. 10's denominator on the way, in strips of rows, rows × columns.
    pub amplitude: &'a mut dyn Store,
    /// Eq. 10's numerator on the way, likewise, and the phase symmetry map in the end, row-major.
    pub symmetry: &'a mut dyn Store,
}

/// Fast memory, borrowed: from a [`Workspace`], or from slices of a size that is known only at
/// run time. With N the longer side and S the strip height:
pub struct StripBuffers<'a, V> {
    /// 2·S·N or more: what a strip reads.
    pub strip: &'a mut [f32],
    /// 2·S·N or more: what it gives, or Eq. 10's two sums.
    pub sums: &'a mut [f32],
    /// N or more: as many lines as a vector has lanes.
    pub line: &'a mut [Complex<V>],
    /// N or more.
    pub gains: &'a mut [V],
}

/// Fast memory for images of sides up to `N` in strips of up to `S` rows or columns, one line at a
/// time: 16·S·N + 12·N bytes.
///
/// | N \\ S | 1 | 16 | 64 | N |
/// |---:|---:|---:|---:|---:|
/// | 64 | 1.8 kB | 17.2 kB | 66.3 kB | 66.3 kB |
/// | 128 | 3.6 kB | 34.3 kB | 132.6 kB | 263.7 kB |
/// | 512 | 14.3 kB | 137.2 kB | 530.4 kB | 4.2 MB |
///
/// With them go the filter tables, [`super::LogGaborTables::BYTES`] for all sizes and scales. The
/// external memory of R × C pixels is 20·R·C + 4·R·(C + 2) bytes, the image included: 98.8 kB for
/// 64 × 64 and 6.3 MB for 512 × 512.
#[derive(Clone, Debug)]
pub struct Workspace<const N: usize, const S: usize> {
    strip: [[[f32; N]; 2]; S],
    sums: [[[f32; N]; 2]; S],
    line: [Complex<f32>; N],
    gains: [f32; N],
}

impl<const N: usize, const S: usize> Workspace<N, S> {
    /// What it takes.
    pub const BYTES: usize = size_of::<Self>();

    /// A workspace that fits a `static`.
    pub const fn new() -> Self {
        Workspace {
            strip: [[[0.0; N]; 2]; S],
            sums: [[[0.0; N]; 2]; S],
            line: [Complex::new(0.0, 0.0); N],
            gains: [0.0; N],
        }
    }

    /// The slices for [`super::PhaseSymmetry::run`].
    pub fn buffers(&mut self) -> StripBuffers<'_, f32> {
        StripBuffers {
            strip: self.strip.as_flattened_mut().as_flattened_mut(),
            sums: self.sums.as_flattened_mut().as_flattened_mut(),
            line: &mut self.line,
            gains: &mut self.gains,
        }
    }
}

impl<const N: usize, const S: usize> Default for Workspace<N, S> {
    fn default() -> Self {
        Self::new()
    }
}
