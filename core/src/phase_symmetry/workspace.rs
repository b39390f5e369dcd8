//! The memory that phase symmetry works in: the fast one and the external one.

use super::external::{Source, Store};
use num_complex::Complex;

/// The width of the half spectrum that [`External::spectrum`] holds: `columns/2 + 1`.
pub const fn spectrum_columns(columns: usize) -> usize {
    columns / 2 + 1
}

/// The five matrices in external memory, `rows` × `columns` unless noted. Their contents need
/// not be initialised.
pub struct External<'a> {
    /// The image, 0..255; only read.
    pub image: &'a mut dyn Source<f32>,
    /// The image's half spectrum, `rows` × [`spectrum_columns`].
    pub spectrum: &'a mut dyn Store<Complex<f32>>,
    /// One filter's columns on the way to its rows.
    pub filtered: &'a mut dyn Store<Complex<f32>>,
    /// Eq. 10's denominator on the way.
    pub amplitude: &'a mut dyn Store<f32>,
    /// Eq. 10's numerator on the way, and the phase symmetry map in the end.
    pub symmetry: &'a mut dyn Store<f32>,
}

/// Fast memory, borrowed: from a [`Workspace`], or from slices of a size that is known only at
/// run time. With N the longer side and S the strip height:
pub struct StripBuffers<'a> {
    /// S·N or more.
    pub strip: &'a mut [Complex<f32>],
    /// N or more.
    pub line: &'a mut [Complex<f32>],
    /// N or more.
    pub gains: &'a mut [f32],
    /// S·N or more.
    pub symmetry: &'a mut [f32],
    /// S·N or more.
    pub amplitude: &'a mut [f32],
}

/// Fast memory for images of sides up to `N` in strips of up to `S` rows or columns:
/// 16·S·N + 12·N bytes.
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
    strip: [[Complex<f32>; N]; S],
    line: [Complex<f32>; N],
    gains: [f32; N],
    symmetry: [[f32; N]; S],
    amplitude: [[f32; N]; S],
}

impl<const N: usize, const S: usize> Workspace<N, S> {
    /// What it takes.
    pub const BYTES: usize = size_of::<Self>();

    /// A workspace that fits a `static`.
    pub const fn new() -> Self {
        let zero = Complex::new(0.0, 0.0);
        Workspace {
            strip: [[zero; N]; S],
            line: [zero; N],
            gains: [0.0; N],
            symmetry: [[0.0; N]; S],
            amplitude: [[0.0; N]; S],
        }
    }

    /// The slices for [`super::PhaseSymmetry::run`].
    pub fn buffers(&mut self) -> StripBuffers<'_> {
        StripBuffers {
            strip: self.strip.as_flattened_mut(),
            line: &mut self.line,
            gains: &mut self.gains,
            symmetry: self.symmetry.as_flattened_mut(),
            amplitude: self.amplitude.as_flattened_mut(),
        }
    }
}

impl<const N: usize, const S: usize> Default for Workspace<N, S> {
    fn default() -> Self {
        Self::new()
    }
}
