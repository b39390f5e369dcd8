//! Lines with a depth step, and their images.

use crate::common;
use crate::common::kit::*;
use bonebeam::beamform::Parameters;
use bonebeam::image::envelope;
use bonebeam::pipeline;
use bonebeam_oracle::reference::f64::depth_interpolation as exact;
use common::frames::PARAMETERS;
use std::f64::consts::LN_2;

/// Every `step`-th number.
fn every(z: &[Complex<f32>], step: usize) -> Vec<Complex<f32>> {
    z.iter().step_by(step).copied().collect()
}

type Lines = Vec<Complex<f32>>;

fn stepped(depth_step: usize, sub_lines: usize, block: usize) -> pipeline::Parameters<'static> {
    pipeline::Parameters {
        beamformer: Parameters {
            depth_step,
            sub_lines,
            ..PARAMETERS.beamformer
        },
        block,
        ..PARAMETERS
    }
}

/// With a depth step of two a line needs half the memory for its samples.
#[test]
fn lines_with_a_depth_step_take_less_memory() {
    let need = |depth_step, sub_lines| {
        let parameters = stepped(depth_step, sub_lines, 16);
        parameters.need(Input::Rf, 1).unwrap().complex
    };
    let samples = Pipeline::new(PARAMETERS).unwrap().lines().scan().samples();
    for depth_step in 2..=8 {
        let saved = need(1, 1) - need(depth_step, 1);
        assert_eq!(saved, samples - samples.div_ceil(depth_step));
    }
    // With many sub-lines the interpolation needs more than the beamformer.
    let of_many = [1, 2, 4, 8].map(|depth_step| need(depth_step, 8));
    assert!(of_many.is_sorted_by(|a, b| a > b), "{of_many:?}");
}

fn interpolated(z: &[Complex<f32>], grid: (usize, usize, f64)) -> (Vec<f32>, Lines) {
    let (samples, depth_step, cycles) = grid;
    let interpolation = DepthInterpolation::new(samples, depth_step, cycles).unwrap();
    assert_eq!(interpolation.line_samples(), z.len());
    let mut scratch = vec![Complex::new(f32::NAN, f32::NAN); interpolation.need(1).complex];
    let (mut levels, mut line) = (vec![f32::NAN; samples], vec![Complex::ZERO; samples]);
    let one = (1, Pooling::Largest);
    interpolation
        .envelope(z, one, &mut scratch, &mut levels)
        .unwrap();
    interpolation.line(z, &mut scratch, &mut line).unwrap();
    (levels, line)
}

/// Against the definition in f64: 4·10⁻⁶ of the largest magnitude.
///
/// Holds for any number of samples and any carrier.
#[test]
fn interpolation_is_the_definition() {
    for depth_step in 1..=8 {
        for samples in [1usize, 2, depth_step, depth_step + 1, 50, 1003] {
            for cycles in [0.0, 0.25, 0.31, 1.0 / 3.0, 2.2, -0.1] {
                let outputs = samples.div_ceil(depth_step);
                let z = Line::noise(outputs as u64, outputs, 1)
                    .x
                    .into_raw_vec_and_offset()
                    .0;
                let grid = (samples, depth_step, cycles);
                let (levels, line) = interpolated(&z, grid);
                let expected = exact::line(&z, grid);
                let largest = expected.iter().map(|z| z.norm()).fold(0.0, f64::max);
                for (n, exact) in expected.iter().enumerate() {
                    let error = (widen(line[n]) - exact).norm();
                    let of_level = (f64::from(levels[n]) - exact.norm()).abs();
                    let bound = 4e-6 * largest;
                    assert!(
                        error < bound && of_level < bound,
                        "{grid:?} {n}: {error} {of_level}"
                    );
                }
            }
        }
    }
}

/// The samples of the line keep their bits.
#[test]
fn samples_of_the_line_are_not_interpolated() {
    let z = Line::noise(3, 40, 1).x.into_raw_vec_and_offset().0;
    let mut expected = vec![0.0; z.len()];
    envelope(&z, &mut expected).unwrap();
    for depth_step in 1..=8 {
        let (levels, line) = interpolated(&z, (39 * depth_step + 1, depth_step, 0.3));
        assert_eq!(bits(&every(&line, depth_step)), bits(&z));
        let own: Vec<f32> = levels.into_iter().step_by(depth_step).collect();
        assert_eq!(own, expected);
    }
}

/// Tones around the carrier, within the line's band of `1/step` cycles a sample.
///
/// The error of the filter's response is 0.010 in the middle half and 0.091 in three quarters, for any depth step.
#[test]
fn a_tone_errs_by_the_filters_response() {
    for depth_step in 2..=8 {
        for (part, bound) in [(0.0, 1e-6), (0.25, 0.010), (0.5, 0.010), (0.75, 0.091)] {
            let cycles = 0.25 + part / 2.0 / depth_step as f64;
            let at = |n: usize| {
                let z = Complex::from_polar(1.0, TAU * (cycles * n as f64).fract());
                Complex::new(z.re as f32, z.im as f32)
            };
            let full: Lines = (0..401).map(at).collect();
            let (levels, line) = interpolated(&every(&full, depth_step), (401, depth_step, 0.25));
            // Away from the ends, beyond which the baseband is extended by its last sample.
            for n in 4 * depth_step..401 - 5 * depth_step {
                let error = (line[n] - full[n]).norm().max((levels[n] - 1.0).abs());
                assert!(error < bound, "{depth_step} {part} {n}: {error}");
            }
        }
    }
}

/// Error of the envelope of a 60 % pulse at 4·f₀, relative to its maximum.
///
/// The pulse may be anywhere between two samples.
#[test]
fn a_pulses_envelope_errs_by_what_its_band_leaves_out() {
    let width = 0.3 / (2.0 * LN_2).sqrt();
    for (depth_step, bound) in [(2, 5e-3), (3, 0.04)] {
        for place in 0..20u32 {
            let middle = 100.0 + f64::from(place) / 7.0;
            let at = |n: usize| {
                let t = (n as f64 - middle) / 4.0;
                let level = (-2.0 * (std::f64::consts::PI * width * t).powi(2)).exp();
                let z = Complex::from_polar(level, TAU * t);
                Complex::new(z.re as f32, z.im as f32)
            };
            let full: Lines = (0..201).map(at).collect();
            let (levels, _) = interpolated(&every(&full, depth_step), (201, depth_step, 0.25));
            for (level, full) in levels.iter().zip(&full) {
                let error = (level - full.norm()).abs();
                assert!(error < bound, "{depth_step} {place}: {error}");
            }
        }
    }
}

#[test]
fn what_is_no_line_is_refused() {
    for (depth_step, cycles, name) in [
        (0, 0.25, "depth_step"),
        (9, 0.25, "depth_step"),
        (2, f64::NAN, "cycles of the carrier"),
    ] {
        assert_refused(
            DepthInterpolation::new(9, depth_step, cycles),
            &format!("parameter {name} "),
        );
    }
    let row = Parameters::TABLE
        .into_iter()
        .find(|row| row.name == "depth_step");
    let range = row.expect("a row").range;
    assert_eq!((range.least, range.most), (1.0, 8.0));

    let interpolation = DepthInterpolation::new(9, 2, 0.25).unwrap();
    let mut z = [Complex::ONE; 6];
    let mut scratch = [Complex::ZERO; 13];
    let mut out = [7.0; 10];
    let run = |z: &[Complex<f32>], scratch: usize, out: &mut [f32]| {
        let scratch = &mut vec![Complex::ZERO; scratch][..];
        interpolation.envelope(z, (1, Pooling::Largest), scratch, out)
    };
    for (samples, scratch, length, words) in [
        (5, 12, 10, "length envelope output 10 for 9"),
        (6, 12, 9, "length sub-lines 6 for 5"),
        (5, 13, 9, "length scratch 13 for 12"),
    ] {
        let short = run(&z[..samples], scratch, &mut out[..length]);
        assert_eq!(refused(short), words);
    }
    z[3].im = f32::NAN;
    let bad = "non-finite analytic signal 3";
    assert_eq!(refused(run(&z[..5], 12, &mut out[..9])), bad);
    assert_eq!(out, [7.0; 10]);
    let mut line = [Complex::ZERO; 9];
    let of_line = interpolation.line(&z[..5], &mut scratch[..12], &mut line);
    assert_eq!(refused(of_line), bad);
    // Magnitudes beyond the largest number become that number.
    let sign = [1.0, -1.0, 1.0, -1.0, 1.0];
    let largest = sign.map(|sign| Complex::new(f32::MAX, f32::MAX) * sign);
    run(&largest, 12, &mut out[..9]).unwrap();
    assert!(out[..9].iter().all(|level| *level == f32::MAX));
}
