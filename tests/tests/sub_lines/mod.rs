//! Sub-lines: the core's error against f64.
//!
//! Also the consequences of their definition.

mod directions;

use crate::common;
use crate::common::kit::*;
use bonebeam::beamform::Parameters;
use bonebeam_drive::beamform::Memory;
use common::lines::core;

const PITCH: f64 = 0.3e-3;

fn parameters<'a>(array: Array<'a>, lines: Lines<'a>, samples: usize) -> ScanParameters<'a> {
    ScanParameters {
        array,
        lines,
        record_samples: 4096,
        start: Depth::Seconds(6e-6),
        end: Depth::Seconds(6e-6 + (samples - 1) as f64 / 20e6),
        ..ScanParameters::EXAMPLE
    }
}

/// A line for each element.
fn linear(elements: usize, samples: usize) -> Scan<'static> {
    let lines = Lines::Even(Axis::centred(elements.max(2), PITCH));
    Scan::new(parameters(Array::linear(elements, PITCH), lines, samples)).expect("a valid scan")
}

fn memory(samples: usize, sub_lines: usize) -> Vec<Complex<f32>> {
    vec![Complex::ZERO; Steering::need(samples, sub_lines).complex]
}

fn aligned(line: &Line) -> AlignedLine<'_> {
    AlignedLine::new(line.x.as_slice().expect("in order"), line.x.ncols()).expect("finite")
}

/// The core over one lane, a whole line.
fn sub_lines(line: &Line, steering: Steering<'_>, parameters: Parameters) -> Vec<Complex<f32>> {
    let beamformer = Beamformer::new(parameters).expect("valid parameters");
    let most = line.active.iter().map(|set| set.count).max();
    let sizes = beamformer.sizes(most.unwrap_or(0));
    let mut memory = Memory::new(0.0, sizes).expect("memory");
    let mut z = vec![Complex::new(f32::NAN, 0.0); line.active.len() * parameters.sub_lines];
    let active = |n: usize| line.active[n];
    beamformer
        .sub_lines(
            &mut memory.view(),
            (aligned(line), steering),
            active,
            &mut z,
        )
        .expect("a line that fits");
    z
}

#[test]
fn one_sub_line_is_the_line() {
    let line = Line::noise(1, 20, 24);
    let scan = linear(24, 20);
    let mut memory = memory(20, 1);
    let steering = Steering::new(&scan, 5, 1, &mut memory).expect("memory that fits");
    assert!(
        steering
            .direction(7, 0)
            .iter()
            .all(|turn| (turn - 1.0).norm() < 1e-7)
    );
    for covariance in COVARIANCES {
        for method in METHODS {
            let parameters = Parameters {
                covariance,
                temporal_half_window: 2,
                ..Parameters::of(method)
            };
            let z = sub_lines(&line, steering, parameters);
            assert_eq!(bits(&z), bits(&core(&line, parameters)), "{method:?}");
        }
    }
}

/// The f64 reference of a sample in a direction.
fn exact(
    line: &Line,
    n: usize,
    [slope, constant]: [f64; 2],
    parameters: &Parameters,
) -> Vec<Complex<f64>> {
    let set = line.active[n];
    let sample = Sample::new(line.x.view(), n, (set.first, set.count), parameters)
        .expect("a regular covariance")
        .expect("power");
    let sample = sample
        .towards(slope, constant, parameters)
        .expect("regular");
    let answers = sample
        .answers(&sample.eigenspace(), parameters.method, 1e-3)
        .into_iter();
    answers
        .map(|answer| Complex::new(answer.z.re, answer.z.im))
        .collect()
}

/// Noise with an echo beside the line.
///
/// For all methods the error is at most 10⁻⁴ of the line's largest |z|.
#[test]
fn the_error_beside_the_f64_reference_is_within_the_bound() {
    let samples = 12;
    for elements in [16, 33, 64] {
        let scan = linear(elements, samples);
        let noise = Line::noise(elements as u64, samples, elements);
        let echo = |m: usize| Complex::cis(0.02 * m as f32) * 3.0;
        let line = Line::from_fn(samples, elements, |n, m| noise.x[[n, m]] + echo(m));
        for sub_lines_of in [4, 16] {
            let mut memory = memory(samples, sub_lines_of);
            let at = elements / 3;
            let steering = Steering::new(&scan, at, sub_lines_of, &mut memory).expect("memory");
            for covariance in COVARIANCES {
                for method in METHODS {
                    let windows = Apodization::EXAMPLES.into_iter().cycle();
                    for (postfilter, apodization) in Postfilter::EXAMPLES.into_iter().zip(windows) {
                        let parameters = Parameters {
                            covariance,
                            postfilter,
                            apodization,
                            sub_lines: sub_lines_of,
                            temporal_half_window: 1,
                            ..Parameters::of(method)
                        };
                        let z = sub_lines(&line, steering, parameters);
                        let largest = z.iter().map(|z| widen(*z).norm()).fold(0.0, f64::max);
                        for (i, z) in z.iter().enumerate().step_by(5) {
                            let (n, k) = (i / sub_lines_of, i % sub_lines_of);
                            let [half, phase] = steering.direction(n, k).map(widen);
                            let direction = [2.0 * half.arg(), -phase.arg()];
                            let right = exact(&line, n, direction, &parameters);
                            let error = |right: &Complex<f64>| (widen(*z) - right).norm();
                            let error = right.iter().map(error).fold(f64::INFINITY, f64::min);
                            assert!(
                                error <= 1e-4 * largest,
                                "{:e}: sample {n}, sub-line {k}, {elements}, {covariance:?}, {parameters:?}",
                                error / largest
                            );
                        }
                    }
                }
            }
        }
    }
}

/// An echo with the phases of a sub-line has gain 1 there, by DAS, MV and rank 1.
#[test]
fn an_echo_on_a_sub_line_has_its_own_level_there() {
    for elements in [15, 16, 64] {
        let scan = linear(elements, 2);
        let mut memory = memory(2, 8);
        let steering = Steering::new(&scan, 7, 8, &mut memory).expect("memory that fits");
        for k in 0..8 {
            let [half, phase] = steering.direction(0, k);
            let (slope, constant) = (2.0 * half.arg(), -phase.arg());
            let centre = (elements - 1) as f32 / 2.0;
            let echo = |m: usize| Complex::cis(constant + slope * (m as f32 - centre));
            let line = Line::from_fn(2, elements, |_, m| echo(m));
            for covariance in COVARIANCES {
                for method in [
                    Method::Das,
                    Method::Mv,
                    Method::EsmvRank1,
                    Method::EsmvBeta(0.5),
                ] {
                    let parameters = Parameters {
                        covariance,
                        sub_lines: 8,
                        ..Parameters::of(method)
                    };
                    let z = sub_lines(&line, steering, parameters);
                    let error = (z[k] - 1.0).norm();
                    assert!(
                        error < 1e-5,
                        "{method:?} {covariance:?} {elements}: {}",
                        z[k]
                    );
                }
            }
        }
    }
}

#[test]
fn what_does_not_fit_is_refused() {
    let of = |sub_lines| changed(Parameters::default(), |p| p.sub_lines = sub_lines);
    let line = Line::noise(1, 6, 8);
    let scan = linear(8, 6);
    let beamformer = Beamformer::new(of(4)).expect("valid parameters");
    let (mut four, mut two) = (memory(6, 4), memory(6, 2));
    assert_refused(Steering::new(&scan, 0, 4, &mut two), "length steering ");
    let four = Steering::new(&scan, 3, 4, &mut four).expect("memory that fits");
    let two = Steering::new(&scan, 3, 2, &mut two).expect("memory that fits");
    let run = |steering: Steering<'_>, sizes_for: usize, length: usize, samples: usize| {
        let sizes = Beamformer::new(of(sizes_for)).expect("valid").sizes(8);
        let mut memory = Memory::new(0.0, sizes).expect("memory");
        let mut z = vec![Complex::ZERO; length];
        let all = |_| Active::new(0, 8);
        let x = line.x.as_slice().expect("in order");
        let line = AlignedLine::new(&x[..samples * 8], 8).expect("finite");
        beamformer.sub_lines(&mut memory.view(), (line, steering), all, &mut z)
    };
    assert_eq!(run(four, 4, 24, 6), Ok(()));
    assert_eq!(refused(run(four, 4, 23, 6)), "length z 23 for 24");
    assert_eq!(refused(run(four, 2, 24, 6)), "capacity sub_lines 4 over 2");
    assert_refused(run(two, 4, 24, 6), "parameter sub_lines of the steering ");
    let mut every_second = memory(3, 4);
    let every_second = Steering::of_step(&scan, 3, (4, 2), &mut every_second);
    let every_second = run(every_second.expect("memory that fits"), 4, 24, 6);
    assert_refused(every_second, "parameter depth_step of the steering ");
    let mut short = memory(3, 4);
    let shallow = linear(8, 3);
    let short = Steering::new(&shallow, 3, 4, &mut short).expect("memory that fits");
    assert_refused(run(short, 4, 24, 6), "length samples of the steering ");
}
