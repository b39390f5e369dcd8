//! Phase symmetry of an image, through the core's strips.

use bonebeam::phase_symmetry::{
    External, LogGabor, LogGaborTables, PhaseSymmetry, SliceSource, SliceStore, StripBuffers,
    spectrum_columns,
};
use ndarray::{Array2, ArrayView2};
use num_complex::Complex;

use crate::{Error, Result};

/// What phase symmetry can be told.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    /// Characteristic radii `r₀` in cycles per pixel, 1 to 8 of them.
    pub scales: Vec<f64>,
    /// The noise threshold `T_n`, in the image's grey levels.
    pub threshold: f32,
    /// How many rows or columns are worked on at a time. It changes the time, never the result.
    pub strip: usize,
}

impl Parameters {
    /// A strip that keeps to a processor's cache.
    pub const STRIP: usize = 16;
}

/// The map `PS`, in `[0, 1)`, of an image 0..255. `progress` hears how many filters are done and
/// of how many.
///
/// # Errors
/// An image whose sides are not powers of two from 64 to 1024, a NaN or infinite pixel, or
/// parameters that the core refuses.
pub fn phase_symmetry(
    image: ArrayView2<f32>,
    parameters: &Parameters,
    mut progress: impl FnMut(usize, usize),
) -> Result<Array2<f32>> {
    let (rows, columns) = image.dim();
    check_size(rows, columns)?;
    let core = PhaseSymmetry::new(
        rows,
        columns,
        &parameters.scales,
        parameters.threshold,
        parameters.strip,
    )?;
    let mut tables = LogGaborTables::new();
    let filters = LogGabor::new(&mut tables);

    let zero = Complex::new(0.0, 0.0);
    let image = image.as_standard_layout();
    let half = spectrum_columns(columns);
    let mut spectrum = vec![zero; rows * half];
    let mut filtered = vec![zero; rows * columns];
    let mut amplitude = vec![0.0; rows * columns];
    let mut symmetry = Array2::zeros((rows, columns));

    let longest = rows.max(columns);
    let strip = parameters.strip.min(longest) * longest;
    let (mut strip_buffer, mut line) = (vec![zero; strip], vec![zero; longest]);
    let mut gains = vec![0.0; longest];
    let (mut symmetry_strip, mut amplitude_strip) = (vec![0.0; strip], vec![0.0; strip]);

    let total = core.filters();
    core.run(
        &filters,
        &mut External {
            image: &mut SliceSource::new(image.as_slice().unwrap_or_default(), columns)?,
            spectrum: &mut SliceStore::new(&mut spectrum, half)?,
            filtered: &mut SliceStore::new(&mut filtered, columns)?,
            amplitude: &mut SliceStore::new(&mut amplitude, columns)?,
            symmetry: &mut SliceStore::new(symmetry.as_slice_mut().unwrap_or_default(), columns)?,
        },
        &mut StripBuffers {
            strip: &mut strip_buffer,
            line: &mut line,
            gains: &mut gains,
            symmetry: &mut symmetry_strip,
            amplitude: &mut amplitude_strip,
        },
        &mut |done| progress(done, total),
    )?;
    Ok(symmetry)
}

fn check_size(rows: usize, columns: usize) -> Result<()> {
    let supported = |side: usize| side.is_power_of_two() && (64..=1024).contains(&side);
    if supported(rows) && supported(columns) {
        return Ok(());
    }
    let nearest = |side: usize| {
        let above = side.clamp(64, 1024).next_power_of_two();
        let below = (above / 2).max(64);
        // The nearer in ratio, as resizing is a matter of ratios.
        if side * side < above * below {
            below
        } else {
            above
        }
    };
    Err(Error::Data(format!(
        "the image has {rows} rows and {columns} columns, phase symmetry needs powers of two from \
         64 to 1024: --resize {}x{} makes it so",
        nearest(rows),
        nearest(columns)
    )))
}
