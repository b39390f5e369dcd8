//! Phase symmetry of images of one size, by the core's strips on all threads.

mod bands;

use std::ops::Range;

use bonebeam::dispatch;
use bonebeam::phase_symmetry::{self as core, Kernels, Sizes, WriteAt};
use bonebeam::prelude::stages::*;
use ndarray::{Array2, ArrayView2, ArrayViewMut2};
use num_complex::Complex;
use rayon::prelude::*;

use crate::{Error, Result};
use bands::{Band, MatrixPart, Whole};

/// Directions of the filters of a scale.
pub const DIRECTIONS: usize = 6;

/// Parameters of phase symmetry.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameters {
    /// Characteristic radii `r₀` in cycles per pixel, 1 to 8 of them.
    pub scales: Vec<f64>,
    /// The noise threshold `T_n`, in the image's grey levels.
    pub threshold: f32,
    /// Number of rows or columns processed at a time.
    ///
    /// It changes the time, never the result.
    pub strip: usize,
}

impl Parameters {
    /// Number of rows or columns in a strip that fits a processor's cache.
    pub const STRIP: usize = 16;
}

/// Phase symmetry of many images of one size, with gains and memory made once.
///
/// The strips of each step are shared among the threads of the rayon pool in which [`Plan::run`] is called. The
/// map's bits depend neither on their number nor on the instruction set.
#[derive(Debug)]
pub struct Plan {
    /// The bank for the filters of each direction; only thresholds differ.
    directions: [PhaseSymmetry; DIRECTIONS],
    fft: LaneFft,
    gains: GainTables<Vec<f32>>,
    spectrum: Vec<f32>,
    filtered: Vec<f32>,
    amplitude: Vec<f32>,
}

impl Plan {
    /// Computes the filters' gains for images of `(rows, columns)` pixels.
    ///
    /// # Errors
    /// Sides that are not powers of two from 64 to 1024, or parameters that the core rejects.
    pub fn new((rows, columns): (usize, usize), parameters: &Parameters) -> Result<Self> {
        check_size(rows, columns)?;
        let sizes = Sizes::new(rows, columns, parameters.strip);
        Self::of(bank(sizes, parameters, parameters.threshold)?)
    }

    /// Sets the thresholds of the directions, in the order of the bank's filters.
    ///
    /// `parameters` are those of the plan.
    ///
    /// # Errors
    /// A threshold that the core rejects.
    pub fn set_thresholds(
        &mut self,
        parameters: &Parameters,
        thresholds: [f32; DIRECTIONS],
    ) -> Result<()> {
        let sizes = self.bank().sizes();
        for (direction, threshold) in self.directions.iter_mut().zip(thresholds) {
            *direction = bank(sizes, parameters, threshold)?;
        }
        Ok(())
    }

    /// From a plan of the core.
    pub fn of(bank: PhaseSymmetry) -> Result<Self> {
        let sizes = bank.sizes();
        let mut filters = LogGaborTables::new();
        let filters = LogGabor::new(&mut filters);
        let gains = vec![0.0; bank.gain_tables_len()];
        Ok(Plan {
            directions: [bank; DIRECTIONS],
            fft: LaneFft::new(),
            gains: GainTables::new(&filters, &bank, gains)?,
            spectrum: vec![0.0; sizes.spectrum_len()],
            filtered: vec![0.0; sizes.filtered_len()],
            amplitude: vec![0.0; sizes.amplitude_len()],
        })
    }

    /// The map `PS`, in `[0, 1)`, of an image 0..255, with a given instruction set.
    ///
    /// `progress` receives the numbers of filters done and of all.
    ///
    /// # Errors
    /// An image of another size, or with a pixel that is NaN, infinite or beyond 1e12.
    pub fn run(
        &mut self,
        image: ArrayView2<f32>,
        set: InstructionSet,
        progress: &mut dyn FnMut(usize, usize),
    ) -> Result<Array2<f32>> {
        let mut map = Array2::zeros(image.dim());
        self.run_into(image, set, progress, map.view_mut())?;
        Ok(map)
    }

    /// The same into the caller's memory.
    ///
    /// # Errors
    /// As [`Plan::run`], and [`Error::Data`] if `map` is not in row-major order or of another size. After an error,
    /// the content of `map` is undefined.
    pub fn run_into(
        &mut self,
        image: ArrayView2<f32>,
        set: InstructionSet,
        progress: &mut dyn FnMut(usize, usize),
        map: ArrayViewMut2<f32>,
    ) -> Result<()> {
        let filters = self.bank().filters();
        let after = &mut |filter, _: &[f32]| {
            progress(filter + 1, filters);
            true
        };
        self.run_while(image, set, after, map)
    }

    /// As [`Plan::run_into`], with `after` called after each filter.
    ///
    /// `false` ends the computation. `after` receives the filter's index and the sums of amplitudes so far: strips of rows, column by column.
    ///
    /// # Errors
    /// As [`Plan::run_into`].
    pub fn run_while(
        &mut self,
        image: ArrayView2<f32>,
        set: InstructionSet,
        after: &mut dyn FnMut(usize, &[f32]) -> bool,
        map: ArrayViewMut2<f32>,
    ) -> Result<()> {
        dispatch!(set, zero => self.map(zero, image, after, map))
    }

    fn map<V: Vector>(
        &mut self,
        zero: V,
        image: ArrayView2<f32>,
        after: &mut dyn FnMut(usize, &[f32]) -> bool,
        map: ArrayViewMut2<f32>,
    ) -> Result<()> {
        let bank = *self.bank();
        let kernels = Kernels::new(&self.fft, &self.gains);
        let sizes = bank.sizes();
        let Sizes {
            rows,
            columns,
            strip,
        } = sizes;
        if image.dim() != (rows, columns) {
            return Err(Error::Data(format!(
                "the image has {} rows and {} columns; the plan of its phase symmetry has {rows} and \
                 {columns}",
                image.nrows(),
                image.ncols()
            )));
        }
        let shape = map.dim();
        let sums = map.into_slice().filter(|_| shape == (rows, columns));
        let sums = sums.ok_or_else(|| {
            Error::Data(format!(
                "the map has shape {shape:?}; expected ({rows}, {columns}), row by row"
            ))
        })?;
        sums.fill(0.0);
        let image = image.as_standard_layout();

        let threads = rayon::current_num_threads();
        let memory = Memory::new(zero, 0.0, sizes);
        let mut memories = vec![memory; threads];
        bank.spectrum(
            &kernels,
            &mut image.as_slice().unwrap_or_default(),
            &mut self.spectrum.as_mut_slice(),
            &mut memories[0].slices(),
        )?;
        let column_strips: Vec<Range<usize>> = bank.column_strips().collect();
        let row_strips: Vec<Range<usize>> = bank.row_strips().collect();
        let column_share = column_strips.len().div_ceil(threads);
        let row_share = row_strips.len().div_ceil(threads);
        let band = row_share * strip * columns;
        let width = 2 * strip * columns;
        for filter in 0..bank.filters() {
            let spectrum = self.spectrum.as_slice();
            let shares = column_strips.chunks(column_share);
            Band::cut(&mut self.filtered, width, shares, columns)
                .into_par_iter()
                .zip(column_strips.par_chunks(column_share))
                .zip(&mut memories)
                .try_for_each(|((mut filtered, strips), memory)| {
                    strips.iter().try_for_each(|strip| {
                        bank.filter_columns(
                            &kernels,
                            filter,
                            strip.clone(),
                            &mut Whole(spectrum),
                            &mut filtered,
                            &mut memory.slices(),
                        )
                    })
                })?;
            let filtered = self.filtered.as_slice();
            let bank = self.directions[filter % DIRECTIONS];
            row_strips
                .par_chunks(row_share)
                .zip(sums.par_chunks_mut(band))
                .zip(self.amplitude.par_chunks_mut(band))
                .zip(&mut memories)
                .enumerate()
                .try_for_each(|(k, (((strips, symmetry), amplitude), memory))| {
                    let mut symmetry = MatrixPart::new(symmetry, k * band);
                    let mut amplitude = MatrixPart::new(amplitude, k * band);
                    strips.iter().try_for_each(|strip| {
                        let filtered = &mut Whole(filtered);
                        let sums: [&mut dyn WriteAt; 2] = [&mut symmetry, &mut amplitude];
                        let (rows, memory) = (strip.clone(), &mut memory.slices());
                        bank.add_rows(&kernels, filter, rows, filtered, sums, memory)
                    })
                })?;
            if !after(filter, &self.amplitude) {
                break;
            }
        }
        Ok(())
    }

    /// The bank of filters.
    pub fn bank(&self) -> &PhaseSymmetry {
        self.gains.bank()
    }
}

/// A bank of filters for images of these sizes.
fn bank(sizes: Sizes, parameters: &Parameters, threshold: f32) -> Result<PhaseSymmetry> {
    Ok(PhaseSymmetry::new(&core::Parameters {
        sizes,
        scales: &parameters.scales,
        threshold,
    })?)
}

/// Fast memory of one thread.
#[derive(Clone)]
pub struct Memory<V> {
    strip: Vec<f32>,
    sums: Vec<f32>,
    line: Vec<Complex<V>>,
    gains: Vec<V>,
}

impl<V: Vector> Memory<V> {
    /// Memory for images and strips of these sizes, filled with `value`.
    pub fn new(zero: V, value: f32, sizes: Sizes) -> Self {
        let lanes = zero.splat(value);
        Memory {
            strip: vec![value; sizes.strip_len()],
            sums: vec![value; sizes.sums_len()],
            line: vec![Complex::new(lanes, lanes); sizes.line_len()],
            gains: vec![lanes; sizes.gains_len()],
        }
    }

    /// The slices for the core.
    pub fn slices(&mut self) -> StripSlices<'_, V> {
        StripSlices {
            strip: &mut self.strip,
            sums: &mut self.sums,
            line: &mut self.line,
            gains: &mut self.gains,
        }
    }
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
        "the image has {rows} rows and {columns} columns; phase symmetry needs powers of two from \
         64 to 1024; --pad puts it into such an image, --resize {}x{} makes it one",
        nearest(rows),
        nearest(columns)
    )))
}
