//! All eigenvalues and eigenvectors, by implicit QL.

use super::*;

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
                    &panels::<S>(&a),
                    &mut memory.reduction(&mut Tridiagonal::new(
                        [[0.0; N]; 4].each_mut().map(|x| &mut x[..]),
                    )),
                    &mut computed[..n],
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

/// With the eigenvalue 1, to which an entry of the eigenvector is `coupling` times the one in front.
fn falling(memory: &mut [[f32; 16]; 4], coupling: f32) -> Tridiagonal<'_, f32> {
    let tridiagonal = Tridiagonal::new(memory.each_mut().map(|x| &mut x[..]));
    tridiagonal.diagonal[0] = 1.0;
    tridiagonal.off_diagonal.fill(coupling);
    tridiagonal
}

#[test]
fn an_eigenvector_whose_squares_leave_f32_is_reported() {
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
