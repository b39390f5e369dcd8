//! The core's solvers on matrices whose eigenvalues are known.

mod cholesky;
mod eigen;
mod first_eigenvector;
mod power_iteration;

use super::cholesky::{divide_backward, factorise};
use super::dominant_eigenpair::dominant_eigenpair;
use super::eigen::eigen;
use super::householder::Reduction;
use super::lanczos::{self, STEP_LIMIT, lanczos};
use super::panels::{PanelColumn, TILE, panel};
use super::power_iteration::power_iteration;
use super::size::{Known, Size};
use super::tridiagonal::Tridiagonal;
use crate::simd::{ComplexVector, Scalar};
use nalgebra::{DMatrix, DVector};
use num_complex::Complex;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::format;
use std::vec;
use std::vec::Vec;

/// The most rows; under Miri half as many, which are an eighth of the work.
const N: usize = 16 / crate::step(2);

/// Eigenvalues and AE − EΛ of matrices with trace 1 and up to 16 rows: some 3·16 reflections and
/// rotations, 6e-8 each at most, and the matrix's own rounding.
const EIGENVALUE: f64 = 3e-6;

/// EᴴE − 1 of as many reflections and rotations.
const ORTHONORMAL: f64 = 3e-6;

/// The rounding of the Lanczos iteration's last product, 16 terms of 6e-8.
const PRODUCT: f64 = 1e-6;

/// A matrix of 16 rows rounded to f32: its norm changes by at most 16·6e-8 of itself.
const ROUNDED_MATRIX: f64 = 1e-6;

/// Backward error of a Cholesky factor and its solves: 3·16 roundings of 6e-8.
const CHOLESKY: f64 = 3e-6;

/// Condition of the tested matrices: that of Δ = 5 % and L = 50.
const CONDITION: f64 = 1000.0;

type Matrix = DMatrix<Complex<f64>>;

/// A number of the solvers, from a complex one.
trait Entry: Scalar<f32> {
    fn entry(value: Complex<f64>) -> Self;
}

impl Entry for f32 {
    fn entry(value: Complex<f64>) -> Self {
        value.re as f32
    }
}

impl Entry for ComplexVector<f32> {
    fn entry(value: Complex<f64>) -> Self {
        ComplexVector::new(value.re as f32, value.im as f32)
    }
}

/// A unitary matrix whose first column is along `first`, from random others; real where `first` is
/// and `real` is asked for.
fn unitary(first: &DVector<Complex<f64>>, seed: u64, real: bool) -> Matrix {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut columns = Matrix::from_fn(first.len(), first.len(), |_, _| {
        let (re, im) = (centred(&mut random), centred(&mut random));
        Complex::new(re, if real { 0.0 } else { im })
    });
    columns.set_column(0, first);
    columns.qr().q()
}

fn random_direction(n: usize, seed: u64) -> DVector<Complex<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    DVector::from_fn(n, |_, _| Complex::from(centred(&mut random)))
}

/// Uniform in [−1, 1).
fn centred(random: &mut ChaCha8Rng) -> f64 {
    2.0 * random.random::<f64>() - 1.0
}

/// The same number in f64.
fn widen(z: Complex<f32>) -> Complex<f64> {
    Complex::new(f64::from(z.re), f64::from(z.im))
}

/// U·diag(λ)·Uᴴ.
fn with_eigenvalues(values: &[f64], unitary: &Matrix) -> Matrix {
    let diagonal = DVector::from_iterator(values.len(), values.iter().map(|&x| Complex::from(x)));
    unitary * Matrix::from_diagonal(&diagonal) * unitary.adjoint()
}

/// The matrix in panels; rows of the identity fill up the last.
fn panels<S: Entry>(a: &Matrix) -> Vec<PanelColumn<S>> {
    let count = a.nrows().div_ceil(TILE);
    let mut columns = Vec::new();
    for index in 0..count {
        assert_eq!(columns.len(), panel(index));
        for k in 0..TILE * (index + 1) {
            columns.push(std::array::from_fn(|r| {
                let i = TILE * index + r;
                let value = if i < a.nrows() && k < a.nrows() {
                    a[(i, k)]
                } else if i == k {
                    Complex::ONE
                } else {
                    Complex::ZERO
                };
                S::entry(value)
            }));
        }
    }
    columns
}

fn wide<S: Entry>(value: S) -> Complex<f64> {
    widen(value.complex().lane(0))
}

/// Memory of a reduction.
struct Memory<S> {
    panels: Vec<PanelColumn<S>>,
    vectors: Vec<S>,
    phases: Vec<S>,
}

impl<S: Entry> Memory<S> {
    fn new() -> Self {
        let zero = S::from_real(0.0);
        Memory {
            panels: vec![[zero; TILE]; panel(N.div_ceil(TILE))],
            vectors: vec![zero; 4 * N],
            phases: vec![zero; N],
        }
    }

    fn reduction<'a, 't>(
        &'a mut self,
        tridiagonal: &'a mut Tridiagonal<'t, f32>,
    ) -> Reduction<'a, 't, S, f32> {
        Reduction {
            panels: &mut self.panels,
            vectors: &mut self.vectors,
            phases: &mut self.phases,
            tridiagonal,
        }
    }
}

/// Eigenvalues of many kinds, descending, of trace 1.
fn spectra(n: usize) -> Vec<Vec<f64>> {
    let kinds: [&dyn Fn(usize) -> f64; 6] = [
        // One strong source in white noise, none, two alike, a decay by 30 dB, ranks 1 and n/2.
        &|k| if k == 0 { 100.0 } else { 1.0 },
        &|_| 1.0,
        &|k| if k < 2 { 100.0 } else { 1.0 + 0.01 * k as f64 },
        &|k| 10.0_f64.powf(-3.0 * k as f64 / n as f64),
        &|k| if k == 0 { 1.0 } else { 0.0 },
        &|k| if k <= n / 2 { 1.0 } else { 0.0 },
    ];
    kinds
        .iter()
        .map(|kind| {
            let mut values: Vec<f64> = (0..n).map(kind).collect();
            values.sort_by(|a, b| b.total_cmp(a));
            let trace: f64 = values.iter().sum();
            values.iter().map(|value| value / trace).collect()
        })
        .collect()
}

/// Bits of a lane do not depend on the others.
#[cfg(feature = "simd")]
mod over_lanes;
