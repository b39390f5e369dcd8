//! The core's solvers on matrices whose eigenvalues are known.

use super::cholesky::factorise;
use super::dominant_eigenpair::dominant_eigenpair;
use super::eigen::eigen;
use super::householder::Reduction;
use super::lanczos::{self, ACCURACY, STEP_LIMIT, lanczos};
use super::panels::{PanelColumn, TILE, panel};
use super::power_iteration::power_iteration;
use super::tridiagonal::Tridiagonal;
use crate::simd::{ComplexVector, Scalar};
use nalgebra::{DMatrix, DVector};
use num_complex::Complex;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
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
/// Backward error of a Cholesky factor and of what it divides: 3·16 roundings of 6e-8 at most.
const CHOLESKY: f64 = 3e-6;
/// The condition of the matrices that it is tried on, that of Δ = 5 % and L = 50.
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
        ComplexVector {
            re: value.re as f32,
            im: value.im as f32,
        }
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

/// What a reduction works in.
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

fn assert_eigen<S: Entry>(real: bool) {
    for n in [1, 2, 3, 8, 15, 16].into_iter().step_by(crate::step(3)) {
        for (kind, values) in spectra(n).into_iter().enumerate().step_by(crate::step(3)) {
            let u = unitary(&random_direction(n, 1), 10 + n as u64, real);
            let a = with_eigenvalues(&values, &u);
            let mut computed = [0.0_f32; N];
            let mut rows = [[ComplexVector::from_real(0.0_f32); N]; N];
            let mut memory = Memory::<S>::new();
            for (i, row) in rows[..n].iter_mut().enumerate() {
                let mut scalars = [S::from_real(0.0); N];
                scalars[i] = S::from_real(1.0);
                row[i].re = 1.0;
                eigen(
                    0.0,
                    &panels::<S>(&a),
                    n,
                    &mut memory.reduction(&mut Tridiagonal::new(
                        [[0.0; N]; 4].each_mut().map(|x| &mut x[..]),
                    )),
                    &mut computed,
                    &mut scalars,
                    &mut row[..],
                );
                // The same of a vector of the matrix's own numbers.
                for (scalar, entry) in scalars.iter().zip(&row[..n]) {
                    assert_eq!(scalar.complex().lane(0), entry.lane(0));
                }
            }
            let name = format!("n = {n}, spectrum {kind}");

            let found = DVector::from_fn(n, |k, _| f64::from(computed[k]));
            let mut sorted: Vec<f64> = found.iter().copied().collect();
            sorted.sort_by(|a, b| b.total_cmp(a));
            for (found, value) in sorted.iter().zip(&values) {
                assert!(
                    (found - value).abs() <= EIGENVALUE,
                    "{name}: {found}, not {value}"
                );
            }
            // rows[i][k] = E(i, k)*.
            let e = Matrix::from_fn(n, n, |i, k| widen(rows[i][k].lane(0)).conj());
            let identity = (e.adjoint() * &e - Matrix::identity(n, n)).camax();
            assert!(
                identity <= ORTHONORMAL,
                "{name}: EᴴE is off 1 by {identity:e}"
            );
            let residual =
                (&a * &e - &e * Matrix::from_diagonal(&found.map(Complex::from))).camax();
            assert!(
                residual <= EIGENVALUE,
                "{name}: AE is off EΛ by {residual:e}"
            );
        }
    }
}

#[test]
fn eigenvalues_and_vectors_of_real_matrices() {
    assert_eigen::<f32>(true);
}

#[test]
fn eigenvalues_and_vectors_of_complex_matrices() {
    assert_eigen::<ComplexVector<f32>>(false);
}

/// How far the iteration's vector is from e₁ (but for phase), where it says that it has arrived.
fn distance_to_first<S: Entry>(a: &Matrix, e1: &DVector<Complex<f64>>) -> Option<f64> {
    let (v, done) = lanczos_vector::<S>(a, false);
    let parallel = e1.dotc(&v);
    done.then(|| (&v - e1 * parallel).norm())
}

/// The iteration's vector, and whether it says that it has arrived.
fn lanczos_vector<S: Entry>(a: &Matrix, ignored: bool) -> (DVector<Complex<f64>>, bool) {
    let n = a.nrows();
    let mut v = vec![[S::from_real(0.0); TILE]; n.div_ceil(TILE)];
    let mut basis = vec![[S::from_real(0.0); TILE]; STEP_LIMIT * v.len()];
    let mut memory = [[0.0_f32; N]; 4];
    let mut kept = [0.0_f32; N];
    let mut tridiagonal = Tridiagonal::new(memory.each_mut().map(|x| &mut x[..]));
    let (_, done) = lanczos(
        0.0,
        &panels::<S>(a),
        n,
        lanczos::Memory {
            basis: &mut basis,
            vector: &mut v,
            tridiagonal: &mut tridiagonal,
            kept: &mut kept,
        },
        ignored,
    );
    (DVector::from_fn(n, |i, _| wide(v.as_flattened()[i])), done)
}

#[test]
fn lanczos_does_not_arrive_where_it_is_ignored() {
    let a = Matrix::from_diagonal(&DVector::from_vec(vec![0.9, 0.1]).map(Complex::from));
    assert!(lanczos_vector::<f32>(&a, false).1);
    assert!(!lanczos_vector::<f32>(&a, true).1);
}

/// How far from e₁ the Lanczos iteration may end: the documented accuracy, and the rounding of the
/// matrix's product over the gap.
fn documented_distance(values: &[f64]) -> f64 {
    f64::from(ACCURACY) + PRODUCT / (1.0 - values[1] / values[0])
}

/// The scale of a matrix does not matter: a power of two takes the same steps to the same vector.
#[test]
fn lanczos_of_a_matrix_scaled_by_a_power_of_two() {
    let mut arrived = 0;
    for seed in (0..40).step_by(crate::step(20)) {
        let others = (1..N).map(|k| 0.1 / (k * k) as f64);
        let values: Vec<f64> = std::iter::once(1.0).chain(others).collect();
        let u = unitary(&random_direction(N, seed), 100 + seed, true);
        let e1 = u.column(0).into_owned();
        let a = with_eigenvalues(&values, &u).map(|z| wide(f32::entry(z)));
        let distance = distance_to_first::<f32>(&a, &e1);
        let scaled = &a * Complex::from(1.0 / 1024.0);
        arrived += usize::from(distance.is_some());
        assert_eq!(
            distance_to_first::<f32>(&scaled, &e1),
            distance,
            "seed {seed}"
        );
    }
    assert!(arrived > 0);
}

fn assert_lanczos<S: Entry>(real: bool) {
    // The documented start, to which e₁ is made orthogonal in half of the cases: the iteration then
    // sees nothing of e₁ at first and lingers at e₂.
    let start = DVector::from_fn(N, |i, _| {
        Complex::from(0.5 + (0.618034 * (i + 1) as f64).fract())
    });
    for seed in (0..8).step_by(crate::step(8)) {
        let random = random_direction(N, 20 + seed);
        let along = start.dotc(&random) / start.dotc(&start);
        for first in [random.clone(), &random - &start * along] {
            let u = unitary(&first, 40 + seed, real);
            let e1 = u.column(0).into_owned();
            let ratios = [0.0, 0.3, 0.6, 0.9, 0.97, 0.99, 0.999, 0.9999, 1.0];
            for ratio in ratios.into_iter().step_by(crate::step(8)) {
                for others in [1e-3, 0.05] {
                    let mut values = vec![others; N];
                    values[0] = 1.0;
                    values[1] = f64::max(ratio, others);
                    let a =
                        with_eigenvalues(&values, &u) / Complex::from(values.iter().sum::<f64>());
                    let distance = distance_to_first::<S>(&a, &e1);
                    let name = format!("seed {seed}, λ₂/λ₁ = {ratio}, others {others}");
                    if ratio <= 0.3 && others < 0.01 && first == random {
                        assert!(distance.is_some(), "{name}: did not arrive");
                    }
                    // Rounding the matrix turns e₁ too, the more the nearer λ₂ is.
                    let rounded = ROUNDED_MATRIX / (1.0 - values[1]);
                    let bound = documented_distance(&values) + rounded;
                    if let Some(distance) = distance {
                        assert!(distance <= bound, "{name}: {distance:e} from e₁");
                    }
                }
            }
        }
    }
}

#[test]
fn lanczos_arrives_or_says_that_it_did_not() {
    assert_lanczos::<f32>(true);
    assert_lanczos::<ComplexVector<f32>>(false);
}

/// From few snapshots to many, whose eigenvalues lie close together, and one that stands out.
fn assert_random_covariances<S: Entry>(real: bool) {
    let mut arrived = 0;
    for seed in (0..1000).step_by(crate::step(504)) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut number = || {
            let (re, im) = (centred(&mut random), centred(&mut random));
            Complex::new(re, if real { 0.0 } else { im })
        };
        let snapshots = (seed as usize % 8 + 1) * N;
        let mut x = Matrix::from_fn(N, snapshots, |_, _| number());
        // In most of them a source, too, as strong as the noise or stronger.
        let direction = DVector::from_fn(N, |_, _| number());
        let signal = DVector::from_fn(snapshots, |_, _| number());
        x += direction * signal.adjoint() * Complex::from((seed % 5) as f64);
        let a = &x * x.adjoint();
        let a = &a / a.trace();
        // What the solver sees.
        let eigen = a.map(|z| wide(S::entry(z))).symmetric_eigen();
        let e1 = eigen
            .eigenvectors
            .column(eigen.eigenvalues.imax())
            .into_owned();
        let mut values: Vec<f64> = eigen.eigenvalues.iter().copied().collect();
        values.sort_by(|a, b| b.total_cmp(a));
        match distance_to_first::<S>(&a, &e1) {
            Some(distance) => {
                arrived += 1;
                let bound = documented_distance(&values);
                assert!(
                    distance <= bound,
                    "seed {seed}: {distance:e} from e₁, bound {bound:e}"
                );
            }
            None => {
                let mut memory = Memory::<S>::new();
                let mut rows = [[0.0_f32; N]; 4];
                let mut tridiagonal = Tridiagonal::new(rows.each_mut().map(|x| &mut x[..]));
                let mut reduction = memory.reduction(&mut tridiagonal);
                dominant_eigenpair(0.0, &panels::<S>(&a), N, &mut reduction, true);
                let e = DVector::from_fn(N, |i, _| wide(reduction.vectors[i]));
                let distance = (&e - &e1 * e1.dotc(&e)).norm();
                let bound = EIGENVALUE / (values[0] - values[1]);
                assert!(
                    distance <= bound,
                    "seed {seed}: {distance:e} from e₁ directly, bound {bound:e}"
                );
            }
        }
    }
    // The weakest sources leave no gap.
    let arrived = arrived * crate::step(504);
    assert!((400..1000).contains(&arrived), "{arrived} arrived");
}

#[test]
fn first_eigenvectors_of_noise_with_and_without_a_source() {
    assert_random_covariances::<f32>(true);
    assert_random_covariances::<ComplexVector<f32>>(false);
}

/// The largest eigenvalue and its vector, directly: `‖Ae − θe‖`, `‖e‖` and `θ` for spectra of every
/// kind, those without a gap among them.
fn assert_dominant_eigenpair<S: Entry>(real: bool) {
    for n in [1, 2, 3, 4, 5, 8, 13, 16]
        .into_iter()
        .step_by(crate::step(4))
    {
        for (kind, values) in spectra(n).into_iter().enumerate().step_by(crate::step(3)) {
            // Random eigenvectors; those of the unit vectors, so that T is diagonal from the start.
            let turned = unitary(&random_direction(n, 7), 80 + n as u64, real);
            for u in [turned, Matrix::identity(n, n)] {
                let a = with_eigenvalues(&values, &u);
                let mut memory = Memory::<S>::new();
                let mut rows = [[0.0_f32; N]; 4];
                let mut tridiagonal = Tridiagonal::new(rows.each_mut().map(|x| &mut x[..]));
                let mut reduction = memory.reduction(&mut tridiagonal);
                let theta = dominant_eigenpair(0.0, &panels::<S>(&a), n, &mut reduction, true);
                let e = DVector::from_fn(n, |i, _| wide(reduction.vectors[i]));
                let name = format!("n = {n}, spectrum {kind}");
                assert!(
                    (e.norm() - 1.0).abs() <= ORTHONORMAL,
                    "{name}: {}",
                    e.norm()
                );
                let theta = f64::from(theta);
                assert!((theta - values[0]).abs() <= EIGENVALUE, "{name}: {theta}");
                let residual = (&a * &e - &e * Complex::from(theta)).norm();
                assert!(residual <= EIGENVALUE, "{name}: residual {residual:e}");
            }
        }
    }
}

#[test]
fn dominant_eigenpairs_of_all_spectra() {
    assert_dominant_eigenpair::<f32>(true);
    assert_dominant_eigenpair::<ComplexVector<f32>>(false);
}

/// `‖v − e₁e₁ᴴv‖` and the eigenvalue after `steps` of power iteration.
fn after_steps<S: Entry>(a: &Matrix, e1: &DVector<Complex<f64>>, steps: usize) -> (f64, f64) {
    let n = a.nrows();
    let mut memory = vec![[S::from_real(0.0); TILE]; 2 * n.div_ceil(TILE)];
    let (v, product) = memory.split_at_mut(n.div_ceil(TILE));
    let value = power_iteration(0.0, &panels::<S>(a), n, steps, v, product);
    let v = DVector::from_fn(n, |i, _| wide(v.as_flattened()[i]));
    ((&v - e1 * e1.dotc(&v)).norm(), f64::from(value))
}

/// The steps of [`LEFT`].
const STEPS: [usize; 6] = [1, 2, 4, 8, 16, 32];

/// What power iteration leaves of the other eigenvectors for each `λ₂/λ₁`, the others evenly between
/// `λ₂` and 0.01: the median and the 95th percentile of 400 random real matrices of 16 rows, as
/// docs/numerics.md has them.
const LEFT: [(f64, [[f64; 2]; 6]); 5] = [
    (
        0.1,
        [
            [0.19, 0.60],
            [1.6e-2, 6.2e-2],
            [1.2e-4, 5.0e-4],
            [6.5e-8, 1.0e-7],
            [6.3e-8, 9.5e-8],
            [6.3e-8, 9.0e-8],
        ],
    ),
    (
        0.3,
        [
            [0.50, 0.97],
            [0.14, 0.68],
            [1.0e-2, 6.0e-2],
            [6.7e-5, 3.7e-4],
            [6.9e-8, 1.0e-7],
            [7.1e-8, 1.0e-7],
        ],
    ),
    (
        0.5,
        [
            [0.72, 0.99],
            [0.39, 0.96],
            [8.5e-2, 0.55],
            [4.3e-3, 3.0e-2],
            [1.5e-5, 9.7e-5],
            [8.2e-8, 1.3e-7],
        ],
    ),
    (
        0.7,
        [
            [0.84, 1.00],
            [0.67, 0.99],
            [0.33, 0.94],
            [6.9e-2, 0.48],
            [3.5e-3, 2.9e-2],
            [1.1e-5, 9.4e-5],
        ],
    ),
    (
        0.9,
        [
            [0.91, 1.00],
            [0.84, 1.00],
            [0.71, 0.99],
            [0.48, 0.98],
            [0.20, 0.88],
            [3.5e-2, 0.30],
        ],
    ),
];

/// The table to a tenth, down to a few roundings of f32.
#[test]
#[cfg_attr(miri, ignore = "percentiles of 2000 matrices")]
fn what_power_iteration_leaves_is_documented() {
    let measured = LEFT.map(|(ratio, _)| {
        let other = |k: usize| ratio + (0.01 - ratio) * (k - 1) as f64 / (N - 2) as f64;
        let values: Vec<f64> = (0..N)
            .map(|k| if k == 0 { 1.0 } else { other(k) })
            .collect();
        let trace = Complex::from(values.iter().sum::<f64>());
        let matrices: Vec<(Matrix, DVector<Complex<f64>>)> = (0..400)
            .map(|seed| {
                let u = unitary(&random_direction(N, seed), 1000 + seed, true);
                (
                    with_eigenvalues(&values, &u) / trace,
                    u.column(0).into_owned(),
                )
            })
            .collect();
        STEPS.map(|steps| {
            let left = matrices
                .iter()
                .map(|(a, e1)| after_steps::<f32>(a, e1, steps).0);
            let mut left: Vec<f64> = left.collect();
            left.sort_by(f64::total_cmp);
            [left[200], left[380]]
        })
    });
    for ((ratio, _), row) in LEFT.iter().zip(&measured) {
        let row = row
            .iter()
            .map(|[half, most]| format!(" {half:.1e} ({most:.1e}) |"));
        std::println!("| {ratio} |{}", row.collect::<std::string::String>());
    }
    for ((ratio, documented), row) in LEFT.iter().zip(&measured) {
        for ((steps, documented), measured) in STEPS.iter().zip(documented).zip(row) {
            for (documented, measured) in documented.iter().zip(measured) {
                assert!(
                    (measured - documented).abs() <= 0.1 * documented + 1e-6,
                    "λ₂/λ₁ = {ratio}, {steps} steps: {measured:e}, not {documented:e}"
                );
            }
        }
    }
}

/// `A³u` of a matrix whose second diagonal entry is the largest, and of its mirror image.
#[test]
fn power_iteration_starts_where_the_diagonal_is_larger() {
    let small = Complex::from(0.1);
    for [d0, d1] in [[0.3, 0.6], [0.6, 0.3]] {
        let mut a = Matrix::from_diagonal(&DVector::from_vec(vec![d0, d1, 0.1]).map(Complex::from));
        (a[(0, 2)], a[(2, 0)]) = (small, small);
        let start = usize::from(d0 < d1);
        let mut u = DVector::from_element(3, Complex::ZERO);
        u[start] = Complex::ONE;
        let cube = &a * &a * &a * &u;
        let expected = &cube / Complex::from(cube.norm());
        for (left, value) in [
            after_steps::<f32>(&a, &expected, 3),
            after_steps::<ComplexVector<f32>>(&a, &expected, 3),
        ] {
            assert!(left <= PRODUCT, "{left:e}");
            let length = cube.norm() / (&a * &a * &u).norm();
            assert!((value - length).abs() <= PRODUCT, "{value}, not {length}");
        }
    }
}

/// The eigenvalue of a matrix of one row is its entry; the rows that fill up the tile take no part.
#[test]
fn power_iteration_on_one_row() {
    let one = DVector::from_element(1, Complex::ONE);
    for entry in [0.5, 2.0] {
        let a = Matrix::from_element(1, 1, Complex::from(entry));
        for left in [
            after_steps::<f32>(&a, &one, 2),
            after_steps::<ComplexVector<f32>>(&a, &one, 2),
        ] {
            assert_eq!(left, (0.0, entry));
        }
    }
}

fn assert_cholesky<S: Entry>(real: bool) {
    for n in [1, 2, 7, 16].into_iter().step_by(crate::step(2)) {
        let u = unitary(&random_direction(n, 2), 60, real);
        let values: Vec<f64> = (0..n)
            .map(|k| 10.0_f64.powf(-3.0 * k as f64 / n as f64))
            .collect();
        let a = with_eigenvalues(&values, &u);
        let a = &a / a.trace();
        let (right, wanted) = (random_direction(n, 4), Complex::ONE);
        let mut rows = vec![[S::from_real(0.0); TILE]; n.next_multiple_of(TILE)];
        for (i, row) in rows.iter_mut().enumerate().take(n) {
            row[0] = S::entry(wanted);
            row[1] = S::entry(right[i]);
        }
        let panels = panels::<S>(&a);
        let mut factor = panels.clone();
        assert!(factorise(
            0.0,
            &panels,
            &mut factor,
            &mut rows,
            n.div_ceil(TILE)
        ));
        // The rows hold (G⁻¹b)*; G·(G⁻¹b) is b again, and (G⁻¹b)ᴴ(G⁻¹b) is bᴴA⁻¹b.
        let whitened = DVector::from_fn(n, |i, _| wide(rows[i][0]).conj());
        let other = DVector::from_fn(n, |i, _| wide(rows[i][1]).conj());
        let ones = DVector::from_element(n, wanted);
        let solution = a.clone().lu().solve(&ones).expect("a regular matrix");
        let error = (whitened.dotc(&whitened) - ones.dotc(&solution)).norm();
        assert!(
            error <= CHOLESKY * CONDITION * ones.dotc(&solution).norm(),
            "n = {n}: {error:e}"
        );
        let cross = (other.dotc(&whitened) - right.dotc(&solution)).norm();
        let scale = right.norm() * solution.norm();
        assert!(cross <= CHOLESKY * CONDITION * scale, "n = {n}: {cross:e}");
        let g = Matrix::from_fn(n, n, |i, k| match i.cmp(&k) {
            std::cmp::Ordering::Less => Complex::ZERO,
            std::cmp::Ordering::Equal => 1.0 / wide(factor[panel(i / TILE) + k][i % TILE]),
            std::cmp::Ordering::Greater => wide(factor[panel(i / TILE) + k][i % TILE]),
        });
        let residual = (&g * g.adjoint() - &a).norm();
        assert!(residual <= CHOLESKY, "n = {n}: {residual:e}");
    }
}

#[test]
fn cholesky_solves() {
    assert_cholesky::<f32>(true);
    assert_cholesky::<ComplexVector<f32>>(false);
}

#[test]
fn cholesky_tells_a_singular_matrix() {
    // Of no and of rank 1; one of trace 1 with an eigenvalue of −0.1.
    let indefinite = DVector::from_vec(vec![0.6, 0.3, 0.2, -0.1]).map(Complex::from);
    for a in [
        Matrix::zeros(4, 4),
        Matrix::from_element(4, 4, Complex::from(0.25)),
        Matrix::from_diagonal(&indefinite),
    ] {
        let panels = panels::<ComplexVector<f32>>(&a);
        let mut factor = panels.clone();
        let mut rows = [[ComplexVector::from_real(0.0); TILE]; 4];
        assert!(!factorise(0.0, &panels, &mut factor, &mut rows, 1));
    }
}

/// With the eigenvalue 1, to which an entry of the eigenvector is `coupling` times the one in front.
fn falling(memory: &mut [[f32; 16]; 4], coupling: f32) -> Tridiagonal<'_, f32> {
    let tridiagonal = Tridiagonal::new(memory.each_mut().map(|x| &mut x[..]));
    tridiagonal.diagonal[0] = 1.0;
    tridiagonal.off_diagonal.fill(coupling);
    tridiagonal
}

#[test]
fn an_eigenvector_whose_squares_leave_f32_is_told() {
    let mut memory = [[0.0; 16]; 4];
    let mut tridiagonal = falling(&mut memory, 1e-6);
    let mut left = |rows: usize| tridiagonal.eigenvector_upwards(rows, 1.0, &[1e6; 15]);
    assert!(left(3) < 1e-9);
    // The squares only, and the entries too.
    assert_eq!(left(7), f32::INFINITY);
    assert_eq!(left(16), f32::INFINITY);
}

/// Each entry 10⁵ times the one behind, 10²⁵ in all: their squares fit since the last begins at 2⁻⁴⁰.
#[test]
fn an_eigenvector_whose_entries_part_by_25_orders() {
    let mut memory = [[0.0; 16]; 4];
    let mut tridiagonal = falling(&mut memory, 1e-5);
    assert!(tridiagonal.eigenvector_upwards(6, 1.0, &[1e5; 5]) < 1e-9);
    let expected = [1.0, 1e-5, 1e-10, 1e-15, 1e-20, 1e-25];
    for (&entry, expected) in tridiagonal.eigenvector.iter().zip(expected) {
        let error = (f64::from(entry) - expected).abs();
        assert!(error <= PRODUCT * expected, "{entry:e} for {expected:e}");
    }
}

/// Of as many rows as there is memory for: `[[2, 1], [1, 2]]`, whose eigenvalue 3 has equal entries.
#[test]
fn an_eigenvector_as_long_as_its_memory() {
    let mut memory = [[2.0f32, 2.0], [1.0, 0.0], [0.0; 2], [0.0; 2]];
    let mut tridiagonal = Tridiagonal::new(memory.each_mut().map(|x| &mut x[..]));
    assert!(tridiagonal.eigenvector_upwards(2, 3.0, &[1.0]) <= PRODUCT as f32);
    for entry in &*tridiagonal.eigenvector {
        assert!((f64::from(*entry) - 0.5f64.sqrt()).abs() <= PRODUCT);
    }
}

/// From as many steps as there are rows to the most, by one a row at most.
#[test]
fn the_limit_of_steps_grows_with_the_rows() {
    let limits: Vec<usize> = (0..200).map(lanczos::step_limit).collect();
    assert_eq!((limits[1], limits[8], limits[199]), (1, 8, STEP_LIMIT));
    for (n, pair) in limits.windows(2).enumerate() {
        assert!(
            pair[0] <= pair[1] && pair[1] <= pair[0] + 1,
            "{n}: {pair:?}"
        );
    }
}

/// Bits of a lane do not depend on the others.
#[cfg(feature = "simd")]
mod over_lanes {
    use super::*;
    use crate::simd::{InstructionSet, Mask, Task, Vector};

    /// The Lanczos iteration on a matrix in each lane, which take turns: the vectors' bits, and whether they arrived.
    struct LanczosInLanes<'a>(&'a [Matrix]);

    impl Task for LanczosInLanes<'_> {
        type Output = Vec<(Vec<u32>, bool)>;

        fn run<V: Vector>(self, zero: V) -> Self::Output {
            let mut columns: Vec<PanelColumn<V>> = Vec::new();
            for lane in 0..V::LANES {
                let own = panels::<f32>(&self.0[lane % self.0.len()]);
                columns.resize(own.len(), [zero; TILE]);
                for (column, own) in columns.iter_mut().zip(&own) {
                    for (entry, own) in column.iter_mut().zip(own) {
                        entry.lanes_mut()[lane] = *own;
                    }
                }
            }
            let n = self.0[0].nrows();
            let mut v = vec![[zero; TILE]; n.div_ceil(TILE)];
            let mut basis = vec![[zero; TILE]; STEP_LIMIT * v.len()];
            let mut memory = [[zero; N]; 4];
            let memory = lanczos::Memory {
                basis: &mut basis,
                vector: &mut v,
                tridiagonal: &mut Tridiagonal::new(memory.each_mut().map(|x| &mut x[..])),
                kept: &mut [zero; N],
            };
            let (_, done) = lanczos(zero, &columns, n, memory, zero.less(zero));
            let bits = |lane: usize| {
                let rows = &v.as_flattened()[..n];
                rows.iter().map(|x| x.lanes()[lane].to_bits()).collect()
            };
            let lanes = 0..V::LANES;
            lanes.map(|lane| (bits(lane), done.lane(lane))).collect()
        }
    }

    /// The first basis ends at once, and that lane is looked at. The second seems done then, but is not looked at: alone
    /// it takes another step. The third has no gap.
    #[test]
    fn a_lane_is_looked_at_as_if_it_were_alone() {
        let matrices = [[0.9, 0.1, 0.0], [0.9, 0.1, 1.3e-6], [0.5, 0.5, 0.3]].map(|[a, b, c]| {
            Matrix::from_fn(8, 8, |i, k| {
                Complex::from(match (i, k) {
                    (0, 0) => a,
                    (1, 1) => b,
                    (0, 1) | (1, 0) => c,
                    _ => 0.0,
                })
            })
        });
        let alone: Vec<_> = matrices
            .each_ref()
            .map(|a| {
                LanczosInLanes(std::slice::from_ref(a))
                    .run(0.0_f32)
                    .remove(0)
            })
            .into();
        assert!(alone[0].1 && alone[1].1);
        assert_ne!(alone[0].0, alone[1].0);
        for set in InstructionSet::available() {
            let together = set.dispatch(LanczosInLanes(&matrices));
            for (lane, found) in together.iter().enumerate() {
                assert_eq!(found, &alone[lane % 3], "{set:?}, lane {lane}");
            }
        }
    }
}
