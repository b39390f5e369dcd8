//! Cholesky factors.

use super::*;

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
        assert!(factorise(0.0, &panels, &mut factor, &mut rows, n));
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
    // Ranks 0 and 1; a matrix of trace 1 with an eigenvalue of −0.1.
    let indefinite = DVector::from_vec(vec![0.6, 0.3, 0.2, -0.1]).map(Complex::from);
    for a in [
        Matrix::zeros(4, 4),
        Matrix::from_element(4, 4, Complex::from(0.25)),
        Matrix::from_diagonal(&indefinite),
    ] {
        let panels = panels::<ComplexVector<f32>>(&a);
        let mut factor = panels.clone();
        let mut rows = [[ComplexVector::from_real(0.0); TILE]; 4];
        assert!(!factorise(0.0, &panels, &mut factor, &mut rows, TILE));
    }
}

/// Both solves of one size; the factor and the rows.
fn solved(n: usize, size: impl Size) -> (Vec<PanelColumn<f32>>, Vec<[f32; 2]>) {
    let u = unitary(&random_direction(n, 2), 60, true);
    let values: Vec<f64> = (1..=n).map(|k| 1.0 / (k * n) as f64).collect();
    let panels = panels::<f32>(&with_eigenvalues(&values, &u));
    let mut rows = vec![[0.0; 2]; n.next_multiple_of(TILE)];
    for (k, row) in rows.iter_mut().enumerate().take(n) {
        *row = [1.0 + k as f32, 0.5 - k as f32];
    }
    let mut factor = panels.clone();
    assert!(factorise(0.0, &panels, &mut factor, &mut rows, size));
    divide_backward::<f32, f32, 2>(&factor, &mut rows, size);
    (factor, rows)
}

/// A constant leaves out the padding of the last panel; a number does not.
#[test]
fn a_constant_size_has_the_bits_of_a_number() {
    assert_eq!(solved(1, Known::<1>), solved(1, 1));
    assert_eq!(solved(3, Known::<3>), solved(3, 3));
    assert_eq!(solved(5, Known::<5>), solved(5, 5));
    assert_eq!(solved(6, Known::<6>), solved(6, 6));
    assert_eq!(solved(8, Known::<8>), solved(8, 8));
}
