use ndarray::Array2;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use super::*;

/// Room for a few hundred roundings in f64.
const ROUNDING: f64 = 1e-12;

const PARAMETERS: Parameters = Parameters {
    covariance: Covariance::Forward,
    ..Parameters::DEFAULT
};

fn noise(samples: usize, elements: usize) -> Array2<Complex<f32>> {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    Array2::from_shape_fn((samples, elements), |_| {
        Complex::new(rng.random_range(-1.0..1.0), rng.random_range(-1.0..1.0))
    })
}

fn sample(x: &Array2<Complex<f32>>, n: usize, parameters: &Parameters) -> Sample {
    Sample::new(x.view(), n, (0, x.ncols()), parameters)
        .unwrap()
        .unwrap()
}

/// A line whose every sample has the same active elements, by one method.
fn line(
    x: &Array2<Complex<f32>>,
    active: (usize, usize),
    parameters: &Parameters,
    method: Method,
) -> Vec<Complex<f64>> {
    let parameters = Parameters {
        method,
        ..*parameters
    };
    let active = vec![active; x.nrows()];
    beamform(x.view(), &active, &parameters).unwrap()
}

#[test]
fn a_unit_signal_on_axis_gives_one() {
    for elements in [1, 2, 3, 9, 16] {
        let x = Array2::from_elem((3, elements), Complex::ONE);
        for method in Method::EXAMPLES {
            // All there is lies in the first eigenvector.
            let expected = if method == Method::EsmvExcludeFirst {
                0.0
            } else {
                1.0
            };
            for z in line(&x, (0, elements), &PARAMETERS, method) {
                assert!(
                    (z - expected).norm() < ROUNDING,
                    "{method:?}, M = {elements}: {z}"
                );
            }
        }
    }
}

#[test]
fn a_plane_wave_off_axis_has_the_closed_form_of_sherman_and_morrison() {
    // Snapshots e^{jφl}·d with d_i = e^{jφi}: R = ddᴴ, and with δ = Δ on the diagonal
    // R⁻¹a = (a − d·dᴴa/(δ + L))/δ.
    let (elements, subaperture, phase) = (8, 4, 0.7_f32);
    let x = Array2::from_shape_fn((1, elements), |(_, m)| Complex::cis(phase * m as f32));
    let d = Vector::from_fn(subaperture, |i, _| {
        Complex::cis(f64::from(phase) * i as f64)
    });
    let a = Vector::from_element(subaperture, Complex::ONE);
    let (delta, dimension) = (f64::from(PARAMETERS.diagonal_loading), subaperture as f64);
    let direction = &a - &d * (d.dotc(&a) / (delta + dimension));
    let w = &direction / a.dotc(&direction);
    // Eq. 4: the snapshots' own phases e^{jφl} are averaged.
    let positions = elements - subaperture + 1;
    let mean_phase = (0..positions)
        .map(|l| Complex::cis(f64::from(phase) * l as f64))
        .sum::<Complex<f64>>()
        / positions as f64;
    let expected = w.dotc(&d) * mean_phase;

    let z = line(&x, (0, elements), &PARAMETERS, Method::Mv)[0];
    // The data are rounded to f32.
    assert!((z - expected).norm() < 1e-6, "{z}, not {expected}");
    // The only eigenvector is d: rank 1 passes all of it, and without it nothing is left.
    let rank1 = line(&x, (0, elements), &PARAMETERS, Method::EsmvRank(1))[0];
    assert!((rank1 - expected).norm() < 1e-6, "{rank1}, not {expected}");
    let rest = line(&x, (0, elements), &PARAMETERS, Method::EsmvExcludeFirst)[0];
    assert!(rest.norm() < 1e-6, "{rest}");
}

#[test]
fn the_time_window_is_clamped_and_divided_by_what_was_added() {
    // One element: the covariance is the mean of |x|² over the window.
    let x = Array2::from_shape_fn((4, 1), |(n, _)| Complex::new(0.0, (n + 1) as f32));
    let means = |temporal_half_window: usize| -> Vec<f64> {
        let parameters = Parameters {
            temporal_half_window,
            diagonal_loading: 0.0,
            ..PARAMETERS
        };
        (0..4)
            .map(|n| sample(&x, n, &parameters).covariance[(0, 0)].re)
            .collect()
    };
    assert_eq!(means(0), [1.0, 4.0, 9.0, 16.0]);
    assert_eq!(means(1), [5.0 / 2.0, 14.0 / 3.0, 29.0 / 3.0, 25.0 / 2.0]);
    assert_eq!(means(usize::MAX), [30.0 / 4.0; 4]);
}

#[test]
fn the_covariance_is_the_sum_of_outer_products() {
    let x = noise(3, 5);
    let parameters = Parameters {
        temporal_half_window: 1,
        diagonal_loading: 0.0,
        subaperture_ratio: 0.6,
        ..PARAMETERS
    };
    let mut expected = Matrix::zeros(3, 3);
    for n in 0..2 {
        for l in 0..3 {
            let snapshot = Vector::from_fn(3, |i, _| {
                Complex::new(f64::from(x[[n, l + i]].re), f64::from(x[[n, l + i]].im))
            });
            expected += &snapshot * snapshot.adjoint() / Complex::from(6.0);
        }
    }
    let r = sample(&x, 0, &parameters).covariance;
    assert!((r - expected).norm() < ROUNDING);
}

#[test]
fn forward_backward_is_the_mean_with_the_reversed_conjugated_data() {
    let x = noise(1, 9);
    let reversed = Array2::from_shape_fn((1, 9), |(n, m)| x[[n, 8 - m]].conj());
    let forward = sample(&x, 0, &PARAMETERS).covariance;
    let backward = sample(&reversed, 0, &PARAMETERS).covariance;
    assert!((&forward - &backward).norm() > 0.1);
    let mean = (forward + backward) * Complex::from(0.5);
    let both = Parameters {
        covariance: Covariance::ForwardBackward,
        ..PARAMETERS
    };
    let both = sample(&x, 0, &both);
    assert!((both.covariance - mean).norm() < ROUNDING);
}

#[test]
fn the_response_to_the_steering_vector_is_one() {
    let x = noise(5, 20);
    for covariance in [Covariance::Forward, Covariance::ForwardBackward] {
        let parameters = Parameters {
            covariance,
            temporal_half_window: 1,
            ..PARAMETERS
        };
        for n in 0..5 {
            let sample = sample(&x, n, &parameters);
            let response = sample.minimum_variance.sum();
            assert!((response - 1.0).norm() < ROUNDING, "{response}");
        }
    }
}

#[test]
fn a_subaperture_of_one_element_is_delay_and_sum() {
    let x = noise(4, 6);
    let parameters = Parameters {
        subaperture_ratio: 0.1,
        ..PARAMETERS
    };
    let das = line(&x, (0, 6), &parameters, Method::Das);
    for method in [Method::Mv, Method::EsmvBeta(0.5), Method::EsmvRank(3)] {
        let z = line(&x, (0, 6), &parameters, method);
        for (z, das) in z.iter().zip(&das) {
            assert!((z - das).norm() < ROUNDING, "{method:?}: {z}, not {das}");
        }
    }
}

#[test]
fn eigenvectors_are_orthonormal_and_belong_to_their_descending_values() {
    let sample = sample(&noise(1, 24), 0, &PARAMETERS);
    let Eigenspace { values, vectors } = sample.eigenspace();
    let product = &sample.covariance * &vectors;
    let scaled = &vectors * Matrix::from_diagonal(&values.map(Complex::from));
    assert!((product - scaled).norm() < ROUNDING);
    assert!((vectors.adjoint() * &vectors - Matrix::identity(12, 12)).norm() < ROUNDING);
    assert!(
        values
            .as_slice()
            .is_sorted_by(|larger, smaller| larger >= smaller)
    );
    // Eq. 8: c_L = aᴴR⁻¹a, whose inverse is the output power wᴴRw.
    let total = *sample
        .eigenspace()
        .cross_spectral_sums(&sample.steering)
        .last()
        .unwrap();
    let w = &sample.minimum_variance;
    assert!((w.dotc(&(&sample.covariance * w)) * total - 1.0).norm() < ROUNDING);
}

#[test]
fn the_rank_is_the_smallest_whose_sum_reaches_beta() {
    // Unit eigenvectors have ρ = 1: c = 1/4, 3/4, 7/4.
    let eigenspace = Eigenspace {
        values: DVector::from_vec(vec![4.0, 2.0, 1.0]),
        vectors: Matrix::identity(3, 3),
    };
    let ones = DVector::from_element(3, Complex::ONE);
    assert_eq!(eigenspace.cross_spectral_sums(&ones), [0.25, 0.75, 1.75]);
    assert_eq!(
        [0.0, 0.1, 0.15, 0.4, 0.45, 1.0].map(|beta| eigenspace.rank(&ones, beta)),
        [1, 1, 2, 2, 3, 3]
    );
    assert_eq!(eigenspace.ranks(&ones, 3.0 / 7.0, 1e-3), 2..=3);
    assert_eq!(eigenspace.ranks(&ones, 0.4, 1e-3), 2..=2);
    assert_eq!(eigenspace.second_to_first(), 0.5);
}

#[test]
fn silence_gives_zero() {
    let x = Array2::zeros((2, 8));
    for method in Method::EXAMPLES {
        let z = line(&x, (0, 8), &PARAMETERS, method);
        assert_eq!(z, [Complex::ZERO; 2]);
    }
}

#[test]
fn elements_outside_the_active_set_are_left_out() {
    let x = noise(3, 12);
    let cut = x
        .slice_axis(ndarray::Axis(1), ndarray::Slice::from(2..9))
        .to_owned();
    for method in Method::EXAMPLES {
        let parameters = Parameters {
            temporal_half_window: 1,
            ..PARAMETERS
        };
        let part = line(&x, (2, 7), &parameters, method);
        let whole = line(&cut, (0, 7), &parameters, method);
        assert_eq!(part, whole, "{method:?}");
    }
}
