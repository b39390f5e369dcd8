//! Legs: one-way paths between elements and sources.

use bonebeam::simd::{ComplexVector, Vector};
use num_complex::Complex;

use super::basis::{Basis, DIRECTIVITY_STEPS};
use super::elevation::ElevationAxis;
use super::input::{Beam, CellSumInput};
use super::powers::{Powers, plus_product};
use crate::fourier::unit;
use crate::scatterer::PointSource;

/// Number of sources processed at a time; their legs stay in the cache.
pub const BLOCK: usize = 64;

/// A source, and the elements that receive its echo.
pub struct Heard {
    x: f64,
    pub y: f64,
    z: f64,
    /// √amplitude, imaginary for a negative amplitude.
    ///
    /// So the product of the two legs of an echo has the amplitude.
    root: Complex<f64>,
    /// Visibility, one bit per element.
    seen: Vec<u64>,
}

impl Heard {
    pub fn new(source: &PointSource, input: &CellSumInput<'_>) -> Self {
        let mut seen = vec![0; input.element_x.len().div_ceil(64)];
        input.shadow.seen(source, input.element_x, &mut seen);
        let root = source.amplitude.abs().sqrt();
        Heard {
            x: source.x,
            y: source.y,
            z: source.z,
            root: match source.amplitude < 0.0 {
                true => Complex::new(0.0, root),
                false => Complex::new(root, 0.0),
            },
            seen,
        }
    }

    pub fn sees(&self, element: usize) -> bool {
        self.seen[element / 64] >> (element % 64) & 1 == 1
    }
}

/// Legs from one element to the sources of a block.
pub struct Leg<'a, V> {
    pub input: &'a CellSumInput<'a>,
    pub basis: &'a Basis<V>,
    pub element: usize,
    pub origin: i64,
    pub elevation_axis: Option<ElevationAxis>,
    pub elevation: &'a [ComplexVector<V>],
}

impl<V: Vector> Leg<'_, V> {
    /// Fills `[vector][source]`.
    #[inline(always)]
    pub fn fill(&self, zero: V, heard: &[Heard], legs: &mut [ComplexVector<V>]) {
        let Leg { input, basis, .. } = self;
        let (response, window) = (&input.response, &input.window);
        let x = input.element_x[self.element];
        let vectors = basis.vectors;
        let from = 0.5 * window.start + self.origin as f64 / window.rate;
        for (s, heard) in heard.iter().enumerate() {
            if !heard.sees(self.element) {
                for vector in 0..vectors {
                    legs[vector * BLOCK + s] = ComplexVector::from_real(zero);
                }
                continue;
            }
            let dx = heard.x - x;
            let rho = (dx * dx + heard.z * heard.z).sqrt();
            let range = (rho * rho + heard.y * heard.y).sqrt();
            let time = range / response.c - from;
            let loss = response.attenuation(range);
            let amplitude = response.amplitude(range, heard.z);
            let faded = |f: f64| match loss == 0.0 {
                true => 1.0,
                false => libm::exp(-loss * f),
            };
            let first = unit(-basis.lowest * time) * (amplitude * faded(basis.lowest)) * heard.root;
            let ratio = unit(-basis.step * time) * faded(basis.step);
            let mut powers = Powers::new(first, ratio);

            let at = (dx.abs() / range * DIRECTIVITY_STEPS as f64).min(DIRECTIVITY_STEPS as f64);
            let step = (at as usize).min(DIRECTIVITY_STEPS - 1);
            let fraction = zero.splat((at - step as f64) as f32);
            let table = &basis.directivity[step * vectors..(step + 2) * vectors];
            let (here, next) = table.split_at(vectors);

            let around = self.elevation_axis.map(|elevation_axis| {
                let (first, weights) = elevation_axis.around(rho);
                let table = (s * elevation_axis.count + first) * vectors;
                (
                    &self.elevation[table..table + 6 * vectors],
                    weights.map(|w| zero.splat(w)),
                )
            });
            for vector in 0..vectors {
                let directivity = here[vector] + fraction * (next[vector] - here[vector]);
                let leg = powers.get(zero, vector);
                let mut leg = ComplexVector::new(leg.re * directivity, leg.im * directivity);
                if let Some((table, weights)) = &around {
                    let mut e = ComplexVector::from_real(zero);
                    for (k, weight) in weights.iter().enumerate() {
                        let at = table[k * vectors + vector];
                        e.re = e.re + *weight * at.re;
                        e.im = e.im + *weight * at.im;
                    }
                    leg = ComplexVector::new(
                        leg.re * e.re - leg.im * e.im,
                        leg.re * e.im + leg.im * e.re,
                    );
                }
                legs[vector * BLOCK + s] = leg;
            }
        }
    }
}

/// Legs of a beam's elements, summed with their delays: `[vector][source]`.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
pub fn beam_leg<V: Vector>(
    zero: V,
    beam: &Beam,
    input: &CellSumInput<'_>,
    basis: &Basis<V>,
    origins: &[i64],
    left: i64,
    legs: &[ComplexVector<V>],
    out: &mut [ComplexVector<V>],
) {
    out.fill(ComplexVector::from_real(zero));
    for (i, advance) in beam.elements.clone().zip(&beam.advance) {
        let time = (origins[i] - left) as f64 / input.window.rate - advance;
        let mut phases = Powers::new(unit(-basis.lowest * time), unit(-basis.step * time));
        for vector in 0..basis.vectors {
            let phase = phases.get(zero, vector);
            let legs = &legs[(i * basis.vectors + vector) * BLOCK..][..BLOCK];
            let out = &mut out[vector * BLOCK..(vector + 1) * BLOCK];
            for (sum, leg) in out.iter_mut().zip(legs) {
                *sum = plus_product(*sum, *leg, phase);
            }
        }
    }
}
