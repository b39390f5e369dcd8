//! Properties of the core's beamformers for any data.

use crate::common;
use crate::common::kit::*;
use bonebeam::beamform::Parameters;
use common::lines::core;
use common::tolerances::{
    BEAMFORMED, BEAMFORMED_TWICE, HEAVY_LOADING, OUTPUT_POWER, SIGNAL_SUBSPACE, UNIT_RESPONSE,
};
use nalgebra::DVector;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn methods() -> impl Strategy<Value = Method> {
    prop::sample::select(METHODS.to_vec())
}

fn postfilters() -> impl Strategy<Value = Postfilter> {
    prop::sample::select(Postfilter::EXAMPLES.to_vec())
}

/// Parameters with a window that fits `samples`; the caller chooses the method.
fn parameters(samples: usize, largest_ratio: f64) -> impl Strategy<Value = Parameters> {
    let choices = (
        prop::sample::select(Apodization::EXAMPLES.to_vec()),
        prop::sample::select(COVARIANCES.to_vec()),
    );
    let numbers = (0..samples, 0.3..=largest_ratio, 0..4_usize, 0.0..=1.0_f32);
    (choices, numbers).prop_map(|((apodization, covariance), numbers)| {
        let (temporal_half_window, subaperture_ratio, coherence_cutoff, tukey_taper) = numbers;
        Parameters {
            apodization,
            covariance,
            temporal_half_window,
            subaperture_ratio,
            coherence_cutoff,
            tukey_taper,
            ..Parameters::default()
        }
    })
}

const SAMPLES: usize = 6;

fn noise() -> impl Strategy<Value = Line> {
    (any::<u64>(), 2_usize..=24).prop_map(|(seed, elements)| Line::noise(seed, SAMPLES, elements))
}

/// A wave from about straight ahead and noise 20 dB below it.
///
/// λ₁ is far above the rest, so that the rank-1 results are well defined too.
fn signal() -> impl Strategy<Value = Line> {
    (any::<u64>(), 4_usize..=24, -0.02_f32..0.02).prop_map(|(seed, elements, turns)| {
        let mut gaussian = Gaussian::new(seed);
        Line::from_fn(SAMPLES, elements, |n, m| {
            let phase = std::f32::consts::TAU * (turns * m as f32 + 0.3 * n as f32);
            Complex::cis(phase) + gaussian.next() * 0.1
        })
    })
}

/// The methods with results that are continuous in the data, if λ₁ is far above λ₂.
fn smooth_methods() -> impl Strategy<Value = Method> {
    prop::sample::select(vec![
        Method::Das,
        Method::Mv,
        Method::EsmvRank(1),
        Method::EsmvRank1,
        Method::EsmvExcludeFirst,
    ])
}

/// Parameters for two computations of the same result.
///
/// They average over at least a quarter of the elements. Towards `L = M` the covariance has rank 1, and f32 exceeds
/// the contract's bound.
fn averaging_parameters() -> impl Strategy<Value = Parameters> {
    parameters(SAMPLES, 0.75)
}

/// The largest |z| of MV: the scale of every method's error.
fn largest(line: &Line, parameters: Parameters) -> f32 {
    let parameters = changed(parameters, |p| p.method = Method::Mv);
    let z = core(line, parameters);
    z.iter().map(|z| z.norm()).fold(0.0, f32::max)
}

fn assert_close(z: &[Complex<f32>], expected: &[Complex<f32>], error: f32) {
    for (n, (z, expected)) in z.iter().zip(expected).enumerate() {
        assert!(
            (z - expected).norm() <= error,
            "sample {n}: {z}, not {expected}, within {error:e}"
        );
    }
}

fn exact(line: &Line, n: usize, parameters: Parameters) -> Sample {
    let active = (0, line.x.ncols());
    Sample::new(line.x.view(), n, active, &parameters)
        .expect("a loaded covariance")
        .expect("a sample with power")
}

fn wide_weights(line: &Line, n: usize, parameters: Parameters) -> DVector<Complex<f64>> {
    let weights = core_weights(line, n, parameters);
    DVector::from_iterator(weights.len(), weights.into_iter().map(widen))
}

fn reversed(line: &Line) -> Line {
    let last = line.x.ncols() - 1;
    Line::from_fn(line.x.nrows(), last + 1, |n, m| line.x[[n, last - m]])
}

proptest! {
    // A failure prints its smallest case; nothing is written into the source tree. The same cases
    // every time; PROPTEST_CASES=100000 tries further ones.
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(2),
        // A fixed share of the cases is rejected (a subspace without a gap).
        max_global_rejects: u32::MAX,
        ..ProptestConfig::default()
    })]

    #[test]
    fn the_response_to_the_steering_vector_is_one(
        line in noise(),
        parameters in parameters(SAMPLES, 1.0),
        n in 0..SAMPLES,
    ) {
        let response = wide_weights(&line, n, parameters).sum();
        prop_assert!((response - 1.0).norm() <= UNIT_RESPONSE, "{response}");
    }

    #[test]
    fn weights_and_output_belong_together(
        line in noise(),
        parameters in parameters(SAMPLES, 1.0),
        method in methods(),
        n in 0..SAMPLES,
    ) {
        let parameters = Parameters { method, ..parameters };
        let z = core(&line, parameters)[n];
        let sample = exact(&line, n, parameters);
        let weights = wide_weights(&line, n, parameters);
        // A method without covariance has a weight for every element.
        let expected = match weights.len() == sample.elements.len() {
            true => weights.dotc(&sample.elements),
            false => sample.output(&weights),
        };
        // The largest element bounds every output.
        let scale = line.x.iter().map(|x| x.norm()).fold(0.0, f32::max);
        prop_assert!((widen(z) - expected).norm() <= BEAMFORMED * f64::from(scale));
    }

    #[test]
    fn a_signal_on_axis_comes_out_as_it_is(
        elements in 1_usize..=64,
        parameters in parameters(SAMPLES, 1.0),
        method in methods(),
        postfilter in postfilters(),
        seed in any::<u64>(),
    ) {
        let mut gaussian = Gaussian::new(seed);
        let signal: Vec<_> = (0..SAMPLES).map(|_| gaussian.next()).collect();
        let line = Line::from_fn(SAMPLES, elements, |n, _| signal[n]);
        let z = core(&line, Parameters { method, postfilter, ..parameters });
        let expected = match method {
            Method::EsmvExcludeFirst => vec![Complex::ZERO; SAMPLES],
            _ => signal.clone(),
        };
        let scale = signal.iter().map(|x| x.norm()).fold(0.0, f32::max);
        assert_close(&z, &expected, BEAMFORMED as f32 * scale);
    }

    #[test]
    fn a_power_of_two_goes_through_to_the_bit(
        line in noise(),
        parameters in parameters(SAMPLES, 1.0),
        method in methods(),
        postfilter in postfilters(),
        exponent in -60..=60,
    ) {
        let parameters = Parameters { method, postfilter, ..parameters };
        let factor = 2.0_f32.powi(exponent);
        let scaled = core(&line.map(|x| x * factor), parameters);
        let expected: Vec<_> =
            core(&line, parameters).iter().map(|z| z * factor).collect();
        prop_assert_eq!(scaled, expected);
    }

    /// A postfilter multiplies by a real number from 0 to 1, the same for every method.
    #[test]
    fn a_postfilter_is_a_factor_of_any_method(
        line in noise(),
        parameters in parameters(SAMPLES, 1.0),
        method in methods(),
        postfilter in postfilters(),
    ) {
        let of = |method, postfilter| {
            core(&line, Parameters { method, postfilter, ..parameters })
        };
        let das = of(Method::Das, Postfilter::None).into_iter().zip(of(Method::Das, postfilter));
        let z = of(method, Postfilter::None).into_iter().zip(of(method, postfilter));
        for ((das, filtered_das), (z, filtered)) in das.zip(z) {
            prop_assert!(filtered.norm() <= z.norm() * (1.0 + f32::EPSILON));
            let error = (filtered * das - z * filtered_das).norm();
            prop_assert!(error <= 4.0 * f32::EPSILON * z.norm() * das.norm(), "{error:e}");
        }
    }

    #[test]
    fn any_factor_goes_through(
        line in signal(),
        parameters in averaging_parameters(),
        method in smooth_methods(),
        length in 0.1_f32..10.0,
        phase in 0.0..std::f32::consts::TAU,
    ) {
        let parameters = Parameters { method, ..parameters };
        let factor = Complex::from_polar(length, phase);
        let scaled = core(&line.map(|x| x * factor), parameters);
        let expected: Vec<_> =
            core(&line, parameters).iter().map(|z| z * factor).collect();
        let scale = length * largest(&line, parameters);
        assert_close(&scaled, &expected, BEAMFORMED_TWICE * scale);
    }

    #[test]
    fn the_order_of_the_elements_does_not_matter(
        line in signal(),
        parameters in averaging_parameters(),
        method in smooth_methods(),
    ) {
        let parameters = Parameters { method, ..parameters };
        let z = core(&line, parameters);
        let scale = largest(&line, parameters);
        assert_close(
            &core(&reversed(&line), parameters),
            &z,
            BEAMFORMED_TWICE * scale,
        );
    }

    #[test]
    fn conjugate_data_give_the_conjugate(
        line in signal(),
        parameters in averaging_parameters(),
        method in smooth_methods(),
    ) {
        let parameters = Parameters { method, ..parameters };
        let expected: Vec<_> =
            core(&line, parameters).iter().map(|z| z.conj()).collect();
        let z = core(&line.map(|x| x.conj()), parameters);
        let scale = largest(&line, parameters);
        assert_close(&z, &expected, BEAMFORMED_TWICE * scale);
    }

    #[test]
    fn heavy_loading_tends_to_das_over_subapertures(
        line in noise(),
        parameters in parameters(SAMPLES, 1.0),
    ) {
        let parameters = Parameters { diagonal_loading: 1e6, ..parameters };
        let z = core(&line, parameters);
        let scale = line.x.iter().map(|x| x.norm()).fold(0.0, f32::max);
        for n in 0..SAMPLES {
            let sample = exact(&line, n, parameters);
            let length = sample.snapshots.nrows();
            let das = sample.output(&DVector::from_element(length, Complex::from(1.0 / length as f64)));
            prop_assert!((widen(z[n]) - das).norm() <= HEAVY_LOADING * f64::from(scale));
        }
    }

    #[test]
    fn minimum_variance_is_below_das_over_subapertures(
        line in noise(),
        parameters in parameters(SAMPLES, 1.0),
        n in 0..SAMPLES,
    ) {
        let r = exact(&line, n, parameters).covariance;
        let power = |w: &DVector<Complex<f64>>| w.dotc(&(&r * w)).re;
        let w = wide_weights(&line, n, parameters);
        let das = DVector::from_element(w.len(), Complex::from(1.0 / w.len() as f64));
        prop_assert!(power(&w) <= power(&das) * (1.0 + OUTPUT_POWER));
    }

    #[test]
    fn projected_weights_lie_in_the_signal_subspace(
        line in prop_oneof![noise(), signal()],
        parameters in parameters(SAMPLES, 1.0),
        n in 0..SAMPLES,
    ) {
        let sample = exact(&line, n, parameters);
        let eigenspace = sample.eigenspace();
        let (values, subaperture) = (&eigenspace.values, eigenspace.values.len());
        // A subspace is defined if a gap separates it from the rest.
        let gap = |rank: usize| values[rank - 1] - values[rank];
        let rank = (1..subaperture).max_by(|&i, &j| gap(i).total_cmp(&gap(j)));
        prop_assume!(rank.is_some_and(|rank| gap(rank) > 0.02 * values[0]));
        let rank = rank.unwrap_or(1);
        let bound = SIGNAL_SUBSPACE * sample.minimum_variance.norm();
        let parameters = Parameters { method: Method::EsmvRank(rank), ..parameters };
        let w = wide_weights(&line, n, parameters);
        prop_assert!(eigenspace.project(&w, rank..subaperture).norm() <= bound);
        if rank == 1 {
            let parameters = Parameters { method: Method::EsmvExcludeFirst, ..parameters };
            let w = wide_weights(&line, n, parameters);
            prop_assert!(eigenspace.project(&w, 0..1).norm() <= bound);
        }
    }

    #[test]
    fn finite_data_give_finite_output(
        bits in prop::collection::vec(any::<(u32, u32)>(), SAMPLES * 9),
        kind in 0..4,
        parameters in parameters(SAMPLES, 1.0),
        diagonal_loading in prop::sample::select(vec![0.0, 1e-6, 0.05, 1e6]),
        method in methods(),
        postfilter in postfilters(),
    ) {
        let number = |bits: u32| {
            let value = f32::from_bits(bits);
            if value.is_finite() { value } else { f32::MAX.copysign(value) }
        };
        let value = |i: usize| Complex::new(number(bits[i].0), number(bits[i].1));
        let line = Line::from_fn(SAMPLES, 9, |n, m| match kind {
            // Every exponent of the format, in one line.
            0 => value(n * 9 + m),
            // All equal.
            1 => value(0),
            // One nonzero element in one sample.
            2 if (n, m) == (2, 4) => value(0),
            2 => Complex::ZERO,
            // One value for each sample.
            _ => value(n),
        });
        let parameters = Parameters { method, postfilter, diagonal_loading, ..parameters };
        for z in core(&line, parameters) {
            prop_assert!(z.re.is_finite() && z.im.is_finite(), "{z}");
        }
        for w in core_weights(&line, 0, parameters) {
            prop_assert!(w.re.is_finite() && w.im.is_finite(), "{w}");
        }
    }

    #[test]
    fn data_that_are_not_finite_are_refused_with_their_index(
        line in noise(),
        position in any::<prop::sample::Index>(),
        value in prop::sample::select(vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY]),
        imaginary in any::<bool>(),
    ) {
        let elements = line.x.ncols();
        let mut x = line.x.into_raw_vec_and_offset().0;
        let index = position.index(x.len());
        if imaginary {
            x[index].im = value;
        } else {
            x[index].re = value;
        }
        let refused = AlignedLine::new(&x, elements).map(|_| ());
        let name = "aligned samples";
        prop_assert_eq!(refused, Err(Error::NonFinite { name, index }));
    }
}
