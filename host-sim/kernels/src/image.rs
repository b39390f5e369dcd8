//! Pixels of an image, and their median.

use bonebeam::image::{self as core, BMode};
use bonebeam::simd::{InstructionSet, Task, Vector};
use ndarray::{Array2, ArrayView2};

use crate::Result;

/// Pixels from the grey levels of all lines, `[row, column]`.
///
/// # Errors
/// [`Error::Core`](crate::Error::Core) for another number of levels than the plan's.
pub fn pixels(set: InstructionSet, b_mode: &BMode, levels: &[f32]) -> Result<Array2<f32>> {
    set.dispatch(Pixels { b_mode, levels })
}

struct Pixels<'a> {
    b_mode: &'a BMode,
    levels: &'a [f32],
}

impl Task for Pixels<'_> {
    type Output = Result<Array2<f32>>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let Pixels { b_mode, levels } = self;
        let grid = b_mode.parameters().grid;
        let mut pixels = Array2::zeros((grid.rows, grid.columns));
        let mut scratch = vec![0.0; b_mode.pixels_need().real];
        let out = pixels.as_slice_mut().unwrap_or_default();
        b_mode.pixels(zero, levels, &mut scratch, out)?;
        Ok(pixels)
    }
}

/// The 3 × 3 median of an image in row-major order.
///
/// # Errors
/// [`Error::Core`](crate::Error::Core) for an image in another order.
pub fn median(set: InstructionSet, image: ArrayView2<'_, f32>) -> Result<Array2<f32>> {
    set.dispatch(Median(image))
}

struct Median<'a>(ArrayView2<'a, f32>);

impl Task for Median<'_> {
    type Output = Result<Array2<f32>>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let mut out = Array2::zeros(self.0.dim());
        let (image, columns) = (self.0.as_slice().unwrap_or_default(), self.0.ncols());
        core::median(zero, image, columns, out.as_slice_mut().unwrap_or_default())?;
        Ok(out)
    }
}
