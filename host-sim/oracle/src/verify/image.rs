//! A B-mode image, whole, against the f32 and the f64 reference.

use ndarray::Array2;

use crate::reference::{f32 as plain, f64 as equations};
use bonebeam_drive::image::{BModeImage, PixelGrid};
use bonebeam_files::BeamformedLines;

use super::tolerances::{EDGE, GREY_LEVEL_AT_60_DB};
use super::{Bits, Bound, largest};

/// Compares `image`, made from `lines` on `grid`, with both references.
///
/// The error is in grey levels.
pub fn check(
    image: &BModeImage,
    lines: &BeamformedLines,
    dynamic_range: f64,
    grid: &PixelGrid,
    median: bool,
) -> (Bits, Bound) {
    let (beams, samples) = lines.z.dim();
    let last = lines.beam_x[beams - 1];
    let beam_step = (last - lines.beam_x[0]) / (beams - 1) as f64;
    let first_depth = lines.c * lines.t0 / 2.0;
    let sample_step = lines.c / lines.fs / 2.0;

    let z = lines.z.as_standard_layout();
    let envelope = plain::image::envelope(z.as_slice().unwrap_or_default());
    let reference = envelope.iter().copied().fold(0.0, f32::max);
    let levels = plain::image::log_compression(&envelope, reference, dynamic_range as f32);
    let positions =
        |first: f64, step: f64, count: usize| plain::image::Positions { first, step, count };
    let mut expected = plain::image::resample(
        &levels,
        positions(lines.beam_x[0], beam_step, beams),
        positions(first_depth, sample_step, samples),
        positions(grid.z0, grid.pixel, grid.rows),
        positions(grid.x0, grid.pixel, grid.columns),
    );
    if median {
        expected = plain::image::median(&expected, grid.columns);
    }
    let pixels = image.pixels.as_standard_layout();
    let bits = Bits::real(pixels.as_slice().unwrap_or_default(), &expected);
    (bits, error(image, lines, dynamic_range, grid, median))
}

fn error(
    image: &BModeImage,
    lines: &BeamformedLines,
    dynamic_range: f64,
    grid: &PixelGrid,
    median: bool,
) -> Bound {
    let (beams, samples) = lines.z.dim();
    let beam_step = (lines.beam_x[beams - 1] - lines.beam_x[0]) / (beams - 1) as f64;
    let envelope = equations::image::envelope(lines.z.view());
    let levels = equations::image::log_compression(envelope.view(), dynamic_range);
    let on_edge = |at: f64, count: usize| {
        let end = (count - 1) as f64;
        if (-EDGE..0.0).contains(&at) {
            0.0
        } else if at > end && at <= end + EDGE {
            end
        } else {
            at
        }
    };
    let mut expected = Array2::from_shape_fn((grid.rows, grid.columns), |(row, column)| {
        let x = grid.x0 + grid.pixel * column as f64;
        let time = (grid.z0 + grid.pixel * row as f64) * 2.0 / lines.c;
        let beam = on_edge((x - lines.beam_x[0]) / beam_step, beams);
        let sample = on_edge((time - lines.t0) * lines.fs, samples);
        equations::image::bilinear(levels.view(), beam, sample)
    });
    if median {
        expected = equations::image::median(expected.view());
    }
    let errors = image.pixels.iter().zip(&expected);
    Bound {
        compared: expected.len(),
        largest_error: largest(errors.map(|(a, b)| (f64::from(*a) - b).abs())),
        bound: GREY_LEVEL_AT_60_DB * (60.0 / dynamic_range).max(1.0),
        ..Bound::default()
    }
}
