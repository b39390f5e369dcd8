//! The share of the largest eigenvalue, against f64 references.
//!
//! `kernels.rs` has the reference of short-lag coherence.

use crate::common::kit::*;
use bonebeam::beamform::Parameters;
use bonebeam_tests::kernel::judge;
use bonebeam_tests::kernels::beamform::Lines;
use bonebeam_tests::kernels::coherence::{Coherence, Shares};

/// Shares of the largest eigenvalue, the same over any lanes.
fn shares(line: &Line, parameters: Parameters) -> Vec<f32> {
    let (samples, elements) = line.x.dim();
    let kernel: Shares = Coherence(Lines {
        parameters,
        elements,
        lines: vec![(line.x.iter().copied().collect(), 0)],
        counts: line.active.iter().map(|set| set.count).collect(),
        turn: samples,
        within: 0..samples,
        block: 1,
    });
    judge(&kernel, InstructionSet::available()).unwrap()
}

/// An echo across the array in noise of `noise` of its amplitude, and a growing aperture.
fn echo_in_noise(seed: u64, samples: usize, elements: usize, noise: f32) -> Line {
    let mut line = Line::noise(seed, samples, elements);
    line.x.indexed_iter_mut().for_each(|((n, m), x)| {
        *x = *x * noise + Complex::from_polar(1.0, 0.03 * (n * m) as f32);
    });
    for (n, active) in line.active.iter_mut().enumerate() {
        let count = elements.min(elements * (n + 2) / 20);
        *active = Active::new(0, count);
    }
    line
}

/// The share of `λ₁` of a covariance loaded with `Δ/L` of its trace, from which `Δ` is taken off again.
#[test]
fn the_share_of_the_largest_eigenvalue_is_that_of_an_f64_eigensolver() {
    for (seed, (elements, samples, half_window)) in
        [(1, 5, 0), (5, 30, 2), (16, 40, 0), (64, 24, 3)]
            .into_iter()
            .enumerate()
    {
        for (covariance, depth_step) in [(Covariance::Forward, 1), (Covariance::ForwardBackward, 3)]
        {
            let parameters = Parameters {
                covariance,
                temporal_half_window: half_window,
                depth_step,
                ..Parameters::default()
            };
            let delta = f64::from(parameters.diagonal_loading);
            for noise in [0.0, 0.1, 1.0, 30.0] {
                let line = echo_in_noise(seed as u64, samples, elements, noise);
                let found = shares(&line, parameters);
                for (&found, n) in found.iter().zip((0..).step_by(depth_step)) {
                    let Active { first, count } = line.active[n];
                    let x = line.x.view();
                    let sample = Sample::new(x, n, (first, count), &parameters);
                    let expected = sample.unwrap().map_or(0.0, |sample| {
                        let values = sample.eigenspace().values;
                        values[0] * (1.0 + delta) / values.sum() - delta / values.len() as f64
                    });
                    let error = (f64::from(found) - expected).abs();
                    assert!(
                        error <= 1e-5,
                        "{elements}, {n}, {noise}: {found} and {expected}"
                    );
                }
            }
        }
    }
}

/// Of `n` independent snapshots of `L` elements, `λ₁/tr R` is about `(1 + √(L/n))²/L` less the mean of Tracy and Widom.
#[test]
fn the_largest_eigenvalue_of_independent_noise_is_that_of_wishart_matrices() {
    let (elements, half_window) = (16, 200);
    let parameters = Parameters {
        covariance: Covariance::Forward,
        temporal_half_window: half_window,
        subaperture_ratio: 1.0,
        ..Parameters::default()
    };
    let [l, n] = [elements as f64, (2 * half_window + 1) as f64];
    // Johnstone (2001): the mean of the limit law is −1.771 for complex numbers.
    let centre = (l.sqrt() + n.sqrt()).powi(2);
    let width = (l.sqrt() + n.sqrt()) * (1.0 / l.sqrt() + 1.0 / n.sqrt()).cbrt();
    let expected = (centre - 1.771 * width) / (n * l);
    let found: Vec<f64> = (0..20)
        .map(|seed| {
            let line = Line::noise(seed, 2 * half_window + 1, elements);
            f64::from(shares(&line, parameters)[half_window])
        })
        .collect();
    let mean = found.iter().sum::<f64>() / found.len() as f64;
    // The law's deviation is 0.9 widths, 2.6 %: 0.6 % of the mean of 20; the law itself is a limit.
    assert!(
        (mean / expected - 1.0).abs() < 0.03,
        "{mean} and {expected}"
    );
}

#[test]
fn equal_echoes_have_one_eigenvalue_and_silence_none() {
    let mut line = Line::from_fn(30, 24, |n, _| Complex::from_polar(1.0 + n as f32, n as f32));
    line.x.row_mut(20).fill(Complex::ZERO);
    for (n, active) in line.active.iter_mut().enumerate() {
        active.count = n.min(24);
    }
    for covariance in [Covariance::Forward, Covariance::ForwardBackward] {
        let found = shares(
            &line,
            changed(Parameters::DEFAULT, |p| p.covariance = covariance),
        );
        for (n, share) in found.iter().enumerate() {
            let expected = if [0, 20].contains(&n) { 0.0 } else { 1.0 };
            assert!((share - expected).abs() < 1e-6, "{n}: {share}");
        }
    }
}
