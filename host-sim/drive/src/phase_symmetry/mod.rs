//! Phase symmetry of images, with the widest vectors that the processor has.

mod noise;
mod scales;
#[cfg(test)]
mod tests;

use bonebeam::simd::InstructionSet;
use bonebeam_kernels::phase_symmetry::DIRECTIONS;
pub use bonebeam_kernels::phase_symmetry::{Memory, Parameters, Plan};
use ndarray::{Array2, ArrayView2};

use crate::Result;
use crate::config;
use crate::image::{resize, square_side, squared};
use noise::Noise;
pub use scales::{FROM_IMAGE, with_scales};

/// The map `PS`, in `[0, 1)`, of one image 0..255.
///
/// `progress` receives the numbers of filters done and of all.
///
/// # Errors
/// As [`Plan::new`] and [`Plan::run`].
pub fn phase_symmetry(
    image: ArrayView2<f32>,
    parameters: &Parameters,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<Array2<f32>> {
    Plan::new(image.dim(), parameters)?.run(image, InstructionSet::detect(), progress)
}

/// The map of an image 0..255 with the parameters of the section.
///
/// The image is resampled first, or padded with black; then the map is cut to its size again. `pixel` are the distances
/// of its columns and rows, m, if known. An image of other pixels than square ones is filtered on [`squared`] ones, and
/// the map has its own pixels again.
///
/// # Errors
/// As [`phase_symmetry`], [`resize`] and [`with_scales`]; wavelengths without the size of a pixel.
pub fn of_image(
    mut image: Array2<f32>,
    section: &config::PhaseSymmetry,
    pixel: Option<[f64; 2]>,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<Array2<f32>> {
    if let Some(pixel) = pixel
        && let Some(square) = squared(image.view(), pixel)?
    {
        let map = of_image(square, section, Some([square_side(pixel); 2]), progress)?;
        return match section.resize {
            Some(_) => Ok(map),
            None => resize(map.view(), image.nrows(), image.ncols()),
        };
    }
    let pixel = pixel.map(square_side);
    let section = &with_scales(image.view(), section)?;
    if let Some(size) = section.resize {
        image = resize(image.view(), size.rows, size.columns)?;
    }
    let shown = image.dim();
    if let Some(sides) = section.padded(shown) {
        let level = |at: (usize, usize)| image.get(at).copied().unwrap_or(0.0);
        image = Array2::from_shape_fn(sides, level);
    }
    let parameters = Parameters {
        scales: section.centre_frequencies(pixel)?,
        threshold: section.threshold as f32,
        strip: section.strip,
    };
    let thresholds = match section.noise_deviations {
        None => [parameters.threshold; DIRECTIONS],
        Some(deviations) => {
            let noise = noise_of(image.view(), shown, &parameters)?;
            noise.thresholds(deviations, section.noise_by_direction)
        }
    };
    let mut plan = Plan::new(image.dim(), &parameters)?;
    plan.set_thresholds(&parameters, thresholds)?;
    let map = plan.run(image.view(), InstructionSet::detect(), progress)?;
    Ok(Array2::from_shape_fn(shown, |at| map[at]))
}

/// Filters an image with the finest scale.
///
/// Only the first `shown` rows and columns count; the others are padding.
///
/// # Errors
/// As [`Plan::new`] and [`Plan::run`].
fn noise_of(
    image: ArrayView2<f32>,
    shown: (usize, usize),
    parameters: &Parameters,
) -> Result<Noise> {
    let finest = parameters.scales.iter().copied().fold(0.0, f64::max);
    // Amplitudes stay in memory up to the last filter but one; all that are needed come before the second scale.
    let mut plan = Plan::new(
        image.dim(),
        &Parameters {
            scales: vec![finest; 2],
            ..parameters.clone()
        },
    )?;
    let (rows, columns) = image.dim();
    let strip = plan.bank().sizes().strip;
    // Amplitudes lie in strips of rows, column by column.
    let place = |row: usize, column: usize| {
        let first = row - row % strip;
        first * columns + column * strip.min(rows - first) + row - first
    };
    let mut before = vec![0.0; rows * columns];
    let mut directions: Vec<Vec<f32>> = Vec::new();
    let mut map = Array2::zeros((rows, columns));
    let after = &mut |_, sum: &[f32]| {
        let rows = 0..shown.0;
        let places = rows.flat_map(|row| (0..shown.1).map(move |column| place(row, column)));
        directions.push(places.map(|k| sum[k] - before[k]).collect());
        before.copy_from_slice(sum);
        directions.len() < DIRECTIONS
    };
    plan.run_while(image, InstructionSet::detect(), after, map.view_mut())?;
    Ok(Noise { directions })
}
