//! The image stage.

use crate::geometry::{arrays, axis, parameters as scan_parameters};
use crate::{opaque, take};
use bonebeam::image::{
    PixelGrid, envelope, largest, log_compression, log_compression_with, median, pooled_envelope,
    resample, scan_convert,
};
use bonebeam::prelude::stages::*;

/// Calls all functions.
pub fn all() {
    let (z, from) = ([Complex::ZERO; 100], [0.0; 100]);
    let mut to = [0.0; 100];
    let (from, to) = (opaque(&from[..]), opaque(&mut to[..]));
    take(envelope(opaque(&z[..]), to));
    let pooling = opaque(Pooling::default());
    take(pooled_envelope(opaque(&z[..]), opaque(2), pooling, to));
    take(interpolation(opaque(&z[..]), to));
    take(largest(from));
    take(log_compression(from, opaque(1.0), opaque(1.0), to));
    let logarithm = opaque(Logarithm::Exact);
    let [reference, range] = opaque([1.0; 2]);
    take(log_compression_with(logarithm, from, reference, range, to));
    take(resample(from, [axis(), axis()], [axis(), axis()], to));
    take(scan_convert(
        from,
        fan(),
        [axis(), axis()],
        [axis(), axis()],
        to,
    ));
    take(median(0.0f32, from, opaque(1), to));
    take(b_mode(from, to));
}

fn interpolation(z: &[Complex<f32>], to: &mut [f32]) -> Result<(), Error> {
    let interpolation = opaque(DepthInterpolation::new(opaque(9), opaque(2), opaque(0.25))?);
    take((
        interpolation.depth_step(),
        interpolation.samples(),
        interpolation.line_samples(),
        interpolation.need(opaque(2)),
    ));
    let (mut scratch, mut line) = ([Complex::ZERO; 100], [Complex::ZERO; 100]);
    let (scratch, line) = (opaque(&mut scratch[..]), opaque(&mut line[..]));
    take(interpolation.line(z, scratch, line));
    let of_line = opaque((2, Pooling::Rms));
    take(interpolation.envelope(z, of_line, scratch, to));
    let x = [0.0; 5];
    for array in arrays(&x) {
        let scan = Scan::of_iq(scan_parameters(array, Lines::Even(axis())))?;
        take(DepthInterpolation::of(&scan, opaque(2)));
    }
    Ok(())
}

fn fan() -> Fan {
    let [x, z, radius] = opaque([1.0; 3]);
    Fan { x, z, radius }
}

fn b_mode(from: &[f32], to: &mut [f32]) -> Result<(), Error> {
    let [rows, columns] = opaque([1; 2]);
    let [x, z] = opaque([[0.0, 1.0]; 2]);
    let grid = PixelGrid::cover(x, z, rows, columns);
    take((grid.row_axis(), grid.column_axis(), grid.pixels()));
    take(PixelGrid::new(x, opaque(1.0), [rows, columns]));
    let (lines, samples) = (axis(), axis());
    let parameters = opaque(BModeParameters {
        lines,
        samples,
        grid: PixelGrid::of_lines(&lines, &samples, rows, columns),
        dynamic_range: opaque(1.0),
        logarithm: opaque(Logarithm::Exact),
        median: opaque(true),
    });
    pixels(&BMode::new(parameters)?, from, to)?;
    pixels(&BMode::of_fan(parameters, fan())?, from, to)
}

fn pixels(b_mode: &BMode, from: &[f32], to: &mut [f32]) -> Result<(), Error> {
    take(b_mode.parameters());
    take((
        b_mode.envelopes_len(),
        b_mode.need().real,
        b_mode.pixels_need().real,
    ));
    let mut work = [0.0; 100];
    let work = opaque(&mut work[..]);
    b_mode.levels(from, opaque(1.0), to)?;
    b_mode.pixels(0.0f32, from, work, to)?;
    take(b_mode.image(0.0f32, from, work, to));
    b_mode.image_in_steps(0.0f32, from, work, to, &mut |steps| take(steps))
}
