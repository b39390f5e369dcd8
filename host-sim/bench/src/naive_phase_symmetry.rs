//! Phase symmetry, implemented directly with rustfft.
//!
//! Filters are dense, with one complex inverse transform of the whole image per filter.

use std::sync::Arc;

use ndarray::{Array2, ArrayView2};
use num_complex::Complex;
use rustfft::{Fft, FftPlanner};

use bonebeam_oracle::reference::f64::phase_symmetry::log_gabor;

/// Six orientations at each scale.
const ORIENTATIONS: [i32; 6] = [-2, -1, 0, 1, 2, 3];
const EPSILON: f32 = 1e-10;

/// A square image's filters and transforms, with all memory.
pub struct Naive {
    side: usize,
    /// Transposed filters, which include the inverse transform's 1/N².
    filters: Vec<Vec<f32>>,
    threshold: f32,
    forward: Arc<dyn Fft<f32>>,
    inverse: Arc<dyn Fft<f32>>,
    spectrum: Vec<Complex<f32>>,
    work: [Vec<Complex<f32>>; 2],
    scratch: Vec<Complex<f32>>,
    sums: [Vec<f32>; 2],
}

impl Naive {
    /// Filters for scales `r₀` in cycles per pixel.
    ///
    /// `rustfft` chooses the instruction set.
    pub fn new(side: usize, scales: &[f64], threshold: f32) -> Self {
        let scale = (side * side) as f64;
        let filters = scales.iter().flat_map(|&r0| {
            ORIENTATIONS.map(|k| {
                let angle = std::f64::consts::PI * (-0.5 + f64::from(k) / 6.0);
                let filter = log_gabor((side, side), r0, angle);
                filter.t().iter().map(|g| (g.re / scale) as f32).collect()
            })
        });
        let filters = filters.collect();
        let mut planner = FftPlanner::new();
        let forward = planner.plan_fft_forward(side);
        let inverse = planner.plan_fft_inverse(side);
        let scratch = forward
            .get_inplace_scratch_len()
            .max(inverse.get_inplace_scratch_len());
        let zero = Complex::ZERO;
        Naive {
            side,
            filters,
            threshold,
            forward,
            inverse,
            spectrum: vec![zero; side * side],
            work: [vec![zero; side * side], vec![zero; side * side]],
            scratch: vec![zero; scratch],
            sums: [vec![0.0; side * side], vec![0.0; side * side]],
        }
    }

    /// The map of an image, in `map`.
    pub fn run(&mut self, image: ArrayView2<'_, f32>, map: &mut Array2<f32>) {
        let [work, transposed] = &mut self.work;
        for (value, &pixel) in work.iter_mut().zip(image) {
            *value = Complex::new(pixel, 0.0);
        }
        self.forward.process_with_scratch(work, &mut self.scratch);
        transpose(work, &mut self.spectrum, self.side);
        self.forward
            .process_with_scratch(&mut self.spectrum, &mut self.scratch);
        let [symmetry, amplitude] = &mut self.sums;
        symmetry.fill(0.0);
        amplitude.fill(0.0);
        for filter in &self.filters {
            for ((value, &bin), &gain) in transposed.iter_mut().zip(&self.spectrum).zip(filter) {
                *value = bin * gain;
            }
            self.inverse
                .process_with_scratch(transposed, &mut self.scratch);
            transpose(transposed, work, self.side);
            self.inverse.process_with_scratch(work, &mut self.scratch);
            for ((c, symmetry), amplitude) in work.iter().zip(&mut *symmetry).zip(&mut *amplitude) {
                *symmetry += (c.re - c.im.abs() - self.threshold).max(0.0);
                *amplitude += (c.re * c.re + c.im * c.im).sqrt();
            }
        }
        for ((map, symmetry), amplitude) in map.iter_mut().zip(symmetry).zip(amplitude) {
            *map = *symmetry / (*amplitude + EPSILON);
        }
    }
}

/// Transposes in blocks that stay in the cache.
fn transpose(from: &[Complex<f32>], to: &mut [Complex<f32>], side: usize) {
    const BLOCK: usize = 8;
    for row in (0..side).step_by(BLOCK) {
        for column in (0..side).step_by(BLOCK) {
            for r in row..side.min(row + BLOCK) {
                for c in column..side.min(column + BLOCK) {
                    to[c * side + r] = from[r * side + c];
                }
            }
        }
    }
}
