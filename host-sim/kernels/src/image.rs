//! Pixels of an image, and their median.

use bonebeam::dispatch;
use bonebeam::image as core;
use bonebeam::prelude::stages::*;
use ndarray::{Array2, ArrayView2};

use crate::Result;

/// Pixels from the grey levels of all lines, `[row, column]`.
///
/// # Errors
/// [`Error::Core`](crate::Error::Core) for another number of levels than the plan's.
pub fn pixels(set: InstructionSet, b_mode: &BMode, levels: &[f32]) -> Result<Array2<f32>> {
    let grid = b_mode.parameters().grid;
    let mut pixels = Array2::zeros((grid.rows, grid.columns));
    let mut scratch = vec![0.0; b_mode.pixels_need().real];
    let out = pixels.as_slice_mut().unwrap_or_default();
    dispatch!(set, zero => b_mode.pixels(zero, levels, &mut scratch, out))?;
    Ok(pixels)
}

/// The 3 × 3 median of an image in row-major order.
///
/// # Errors
/// [`Error::Core`](crate::Error::Core) for an image in another order.
pub fn median(set: InstructionSet, image: ArrayView2<'_, f32>) -> Result<Array2<f32>> {
    let mut filtered = Array2::zeros(image.dim());
    let (columns, image) = (image.ncols(), image.to_slice().unwrap_or_default());
    let out = filtered.as_slice_mut().unwrap_or_default();
    dispatch!(set, zero => core::median(zero, image, columns, out))?;
    Ok(filtered)
}
