//! Tables that depend only on the length of a cell's echoes.

use bonebeam::simd::{ComplexVector, Vector};
use num_complex::Complex;

use super::input::CellSumInput;
use super::powers::GROUP;
use super::shape::Shape;
use crate::fourier::unit;
use crate::pulse::FLOOR;

/// Steps of the table of directivities over sin θ from 0 to 1.
///
/// Linear interpolation is within −105 dB for a width of two wavelengths.
pub const DIRECTIVITY_STEPS: usize = 512;

/// Tables that depend only on the length of a cell's echoes.
pub struct Basis<V> {
    /// The frequencies are `lowest` + k·`step`, Hz.
    pub lowest: f64,
    /// See `lowest`.
    pub step: f64,
    /// Their number.
    pub frequencies: usize,
    /// Vectors of frequencies.
    pub vectors: usize,
    /// `[frequency][sample]`: the inverse transform with the pulse's spectrum.
    pub transform: Vec<ComplexVector<V>>,
    /// `[step of sin θ][vector of frequencies]`.
    pub directivity: Vec<V>,
}

impl<V: Vector> Basis<V> {
    /// The tables for echoes of this shape.
    pub fn new(zero: V, input: &CellSumInput<'_>, shape: &Shape) -> Self {
        let [samples, before] = [shape.samples, shape.before];
        let step = input.window.rate / samples as f64;
        let [lowest, highest] = input.pulse.band(FLOOR);
        let first = (lowest / step).ceil().max(1.0);
        let frequencies = ((highest / step).floor() - first + 1.0).max(1.0) as usize;
        // Never more than the row's rate tells apart.
        let frequencies = frequencies.min(samples);
        let padded = frequencies.next_multiple_of(GROUP);
        let frequency = |k: usize| (first + k as f64) * step;
        let transform = (0..frequencies)
            .flat_map(|k| {
                let weight = input.pulse.spectrum(frequency(k)) * step;
                let value = move |sample: usize| {
                    let cycles = (first + k as f64) * (sample as f64 - before as f64);
                    unit(cycles / samples as f64) * weight
                };
                (0..samples).step_by(V::LANES).map(move |sample| {
                    let mut vector = ComplexVector::from_real(zero);
                    for lane in 0..V::LANES {
                        let Complex { re, im } = value(sample + lane);
                        vector.set_lane(lane, Complex::new(re as f32, im as f32));
                    }
                    vector
                })
            })
            .collect();
        let directivity = (0..=DIRECTIVITY_STEPS)
            .flat_map(|at| {
                let sin = at as f64 / DIRECTIVITY_STEPS as f64;
                (0..padded).step_by(V::LANES).map(move |k| {
                    let mut vector = zero;
                    for (lane, value) in vector.lanes_mut().iter_mut().enumerate() {
                        *value = input.response.directivity(frequency(k + lane), sin) as f32;
                    }
                    vector
                })
            })
            .collect();
        Basis {
            lowest: first * step,
            step,
            frequencies,
            vectors: padded / V::LANES,
            transform,
            directivity,
        }
    }

    /// The frequency after the last, Hz.
    pub fn highest(&self) -> f64 {
        self.lowest + self.frequencies as f64 * self.step
    }
}
