//! The first eigenvector, by the Lanczos iteration and by its fallback.

use super::*;

/// Distance of the iteration's vector from e₁, up to phase, if it has converged.
fn distance_to_first<S: Entry>(a: &Matrix, e1: &DVector<Complex<f64>>) -> Option<f64> {
    let (v, done) = lanczos_vector::<S>(a, false);
    let parallel = e1.dotc(&v);
    done.then(|| (&v - e1 * parallel).norm())
}

/// The iteration's vector, and whether it reports convergence.
fn lanczos_vector<S: Entry>(a: &Matrix, ignored: bool) -> (DVector<Complex<f64>>, bool) {
    let n = a.nrows();
    let mut v = vec![[S::from_real(0.0); TILE]; n.div_ceil(TILE)];
    let mut basis = vec![[S::from_real(0.0); TILE]; STEP_LIMIT * v.len()];
    let mut memory = [[0.0_f32; N]; 4];
    let mut kept = [0.0_f32; N];
    let mut tridiagonal = Tridiagonal::new(memory.each_mut().map(|x| &mut x[..]));
    let (_, done) = lanczos::<_, _, STEP_LIMIT>(
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

/// Largest distance of the Lanczos iteration's vector from e₁.
///
/// It is the documented accuracy, 2·10⁻⁶, plus the rounding of the matrix's product over the gap.
fn documented_distance(values: &[f64]) -> f64 {
    2e-6 + PRODUCT / (1.0 - values[1] / values[0])
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
    // In half of the cases e₁ is orthogonal to both coordinates with which the iteration may start: it then sees
    // nothing of e₁ at first and lingers at e₂.
    for seed in (0..8).step_by(crate::step(8)) {
        let random = random_direction(N, 20 + seed);
        let mut hidden = random.clone();
        hidden.rows_mut(0, 2).fill(Complex::ZERO);
        for first in [random.clone(), hidden] {
            let u = unitary(&first, 40 + seed, real);
            let e1 = u.column(0).into_owned();
            let ratios = [0.0, 0.3, 0.6, 0.9, 0.97, 0.99, 0.999, 0.9999, 1.0];
            for ratio in ratios.into_iter().step_by(crate::step(8)) {
                for others in [1e-3, 0.05] {
                    // All different, so that no early step ends the basis.
                    let mut values: Vec<f64> =
                        (0..N).map(|k| others * (N - k) as f64 / N as f64).collect();
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

/// From few snapshots to many, whose eigenvalues are close, with one far above.
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
        // The solver's view of the matrix.
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
