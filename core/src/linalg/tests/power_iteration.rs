//! The first eigenvector, by steps of power iteration.

use super::*;

/// `‖v − e₁e₁ᴴv‖` and the eigenvalue after `steps` of power iteration.
fn after_steps<S: Entry>(a: &Matrix, e1: &DVector<Complex<f64>>, steps: usize) -> (f64, f64) {
    let n = a.nrows();
    let mut memory = vec![[S::from_real(0.0); TILE]; 2 * n.div_ceil(TILE)];
    let (v, product) = memory.split_at_mut(n.div_ceil(TILE));
    let value = power_iteration(&panels::<S>(a), n, steps, v, product).expect("a matrix");
    let v = DVector::from_fn(n, |i, _| wide(v.as_flattened()[i]));
    ((&v - e1 * e1.dotc(&v)).norm(), f64::from(value))
}

/// The steps of [`LEFT`].
const STEPS: [usize; 6] = [1, 2, 4, 8, 16, 32];

/// Remainder of the other eigenvectors after power iteration, for each `λ₂/λ₁`.
///
/// The others are evenly spaced between `λ₂` and 0.01. Median and 95th percentile of 400 random real matrices of 16
/// rows, as in docs/numerics.md.
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
