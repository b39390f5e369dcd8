//! Elevation response of a cell, interpolated over 1/ρ.

use std::f64::consts::TAU;

use bonebeam::simd::{ComplexVector, Vector};

use super::basis::Basis;
use super::input::CellSumInput;
use super::powers::Powers;
use crate::cells::Cell;
use crate::fourier::unit;

/// Largest phase step of the elevation response between positions, rad.
///
/// Interpolation by polynomials of degree 5 is then within −95 dB.
const ELEVATION_STEP: f64 = 0.4;

/// Largest number of nodes over an element's height.
///
/// Beyond some tens of cycles of difference, the response vanishes.
pub const MOST_NODES: usize = 128;

/// Positions in 1/ρ at which the elevation response of a cell is known.
#[derive(Clone, Copy)]
pub struct ElevationAxis {
    first: f64,
    step: f64,
    /// Their number.
    pub count: usize,
}

impl ElevationAxis {
    /// Enough positions for the cell and all elements; `None` without elevation.
    pub fn of(cell: &Cell, input: &CellSumInput<'_>, highest: f64) -> Option<Self> {
        let response = &input.response;
        if response.height == 0.0 {
            return None;
        }
        let across = (input.element_x.iter())
            .map(|x| (cell.corner[0] - x).abs().max((cell.end[0] - x).abs()))
            .fold(0.0, f64::max);
        let [nearest, deepest] = cell.depths;
        let furthest = (across * across + deepest * deepest).sqrt();
        let [low, high] = [1.0 / furthest, 1.0 / nearest];
        let phase = [-0.5, 0.5].map(|edge| {
            let delay = |rho| {
                response
                    .patch(edge * response.height, rho, cell.elevation)
                    .0
            };
            TAU * highest * (delay(nearest) - delay(furthest)).abs()
        });
        // Two positions beyond either end, all at a distance above 0.
        let intervals = (phase[0].max(phase[1]) / ELEVATION_STEP)
            .max(4.0 * (high - low) / low)
            .ceil()
            .max(1.0);
        let step = ((high - low) / intervals).max(1e-3 * low);
        Some(ElevationAxis {
            first: low - 2.0 * step,
            step,
            count: intervals as usize + 6,
        })
    }

    /// First of the six positions around one, and their weights.
    #[inline(always)]
    pub fn around(&self, rho: f64) -> (usize, [f32; 6]) {
        let at = (1.0 / rho - self.first) / self.step;
        let first = (at as usize).clamp(2, self.count - 4) - 2;
        let t = at - first as f64;
        let d = [t, t - 1.0, t - 2.0, t - 3.0, t - 4.0, t - 5.0];
        let weights = [
            d[1] * d[2] * d[3] * d[4] * d[5] / -120.0,
            d[0] * d[2] * d[3] * d[4] * d[5] / 24.0,
            d[0] * d[1] * d[3] * d[4] * d[5] / -12.0,
            d[0] * d[1] * d[2] * d[4] * d[5] / 12.0,
            d[0] * d[1] * d[2] * d[3] * d[5] / -24.0,
            d[0] * d[1] * d[2] * d[3] * d[4] / 120.0,
        ];
        (first, weights.map(|w| w as f32))
    }
}

/// Elevation response of a source at elevation `y`, all positions and frequencies.
#[inline(always)]
pub fn elevations<V: Vector>(
    zero: V,
    input: &CellSumInput<'_>,
    basis: &Basis<V>,
    y: f64,
    axis: ElevationAxis,
    quadratures: &[Vec<(f64, f64)>],
    table: &mut [ComplexVector<V>],
) {
    let response = &input.response;
    let highest = basis.highest();
    for (index, out) in table.chunks_exact_mut(basis.vectors).enumerate() {
        let rho = 1.0 / (axis.first + index as f64 * axis.step);
        let [least, greatest] = response.patch_delays(rho, y);
        let nodes = 6 + (2.2 * highest * (greatest - least)).ceil() as usize;
        out.fill(ComplexVector::from_real(zero));
        for &(at, weight) in &quadratures[nodes.min(MOST_NODES - 1)] {
            let (delay, ratio) = response.patch(0.5 * response.height * at, rho, y);
            let first = unit(-basis.lowest * delay) * (0.5 * weight * ratio);
            let mut powers = Powers::new(first, unit(-basis.step * delay));
            for (vector, sum) in out.iter_mut().enumerate() {
                *sum = *sum + powers.get(zero, vector);
            }
        }
    }
}
