//! Sub-lines: the core's bits against the f32 reference, its error against f64.
//!
//! Also the consequences of their definition.

mod directions;
mod frames;

use crate::common;

use bonebeam::Error;
use bonebeam::beamform::Method;
use bonebeam::beamform::{
    AlignedLine, Apodization, Beamformer, Parameters, Postfilter, Segment, SteeredSegments,
    constant_segments,
};
use bonebeam::covariance::Covariance;
use bonebeam::geometry::{Active, Array, Axis, Depth, Lines, Scan, ScanParameters, Steering};
use bonebeam::simd::{InstructionSet, Task, Vector};
use bonebeam_drive::beamform::Memory;
use bonebeam_oracle::reference::f64::beamform::Sample;
use common::lines::{COVARIANCES, Line, METHODS, core, scalar_sub_lines, widen};
use num_complex::Complex;

const PITCH: f64 = 0.3e-3;

fn parameters<'a>(array: Array<'a>, lines: Lines<'a>, samples: usize) -> ScanParameters<'a> {
    ScanParameters {
        array,
        lines,
        sound_speed: 1540.0,
        centre_frequency: 5e6,
        sampling_rate: 20e6,
        record_samples: 4096,
        output_rate: 20e6,
        start: Depth::Seconds(6e-6),
        end: Depth::Seconds(6e-6 + (samples - 1) as f64 / 20e6),
        f_number: 1.5,
        min_elements: 8,
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

/// The core over lanes, a line for each, with apertures that grow alike.
struct OverLanes<'a> {
    lines: &'a [Line],
    steering: &'a [Steering<'a>],
    parameters: Parameters,
    covariance: Covariance,
}

impl Task for OverLanes<'_> {
    type Output = Vec<Vec<Complex<f32>>>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let beamformer = Beamformer::new(Parameters {
            covariance: self.covariance,
            ..self.parameters
        })
        .expect("valid parameters");
        let count = self.parameters.sub_lines;
        let most = self.lines[0].active.iter().map(|set| set.count).max();
        let sizes = beamformer.sizes(most.unwrap_or(0));
        let mut memory = Memory::new(zero, sizes).expect("memory");
        let mut z: Vec<Vec<Complex<f32>>> = Vec::new();
        let groups = self.lines.chunks(V::LANES);
        for (lines, steering) in groups.zip(self.steering.chunks(V::LANES)) {
            let samples = lines[0].active.len();
            let mut of_group =
                vec![vec![Complex::new(f32::NAN, 0.0); samples * count]; lines.len()];
            for (first, length, set) in constant_segments(samples, |n| lines[0].active[n]) {
                let segments: Vec<_> = lines
                    .iter()
                    .map(|line| Segment {
                        line: aligned(line),
                        first_element: line.active[first].first,
                        first_sample: first,
                    })
                    .collect();
                let mut out: Vec<_> = of_group
                    .iter_mut()
                    .map(|z| &mut z[first * count..(first + length) * count])
                    .collect();
                let lines = SteeredSegments {
                    segments: &segments,
                    steering,
                };
                beamformer
                    .sub_line_segments(&mut memory.view(), lines, set.count, &mut out)
                    .expect("segments that fit");
            }
            z.extend(of_group);
        }
        z
    }
}

fn aligned(line: &Line) -> AlignedLine<'_> {
    AlignedLine::new(line.x.as_slice().expect("in order"), line.x.ncols()).expect("finite")
}

/// The core over one lane, a whole line.
fn sub_lines(
    line: &Line,
    steering: Steering<'_>,
    parameters: Parameters,
    covariance: Covariance,
) -> Vec<Complex<f32>> {
    let beamformer = Beamformer::new(Parameters {
        covariance,
        ..parameters
    })
    .expect("valid parameters");
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

fn bits(z: &[Complex<f32>]) -> Vec<(u32, u32)> {
    z.iter().map(|z| (z.re.to_bits(), z.im.to_bits())).collect()
}

/// One lane and every instruction set.
fn assert_bits(line: &Line, parameters: Parameters) {
    let samples = line.active.len();
    let scan = linear(line.x.ncols(), samples);
    let mut memories = [0, 1, 2].map(|_| memory(samples, parameters.sub_lines));
    let mut at = 0;
    let steering = memories.each_mut().map(|memory| {
        at += 1;
        let line = at * scan.lines() / 4;
        Steering::new(&scan, line, parameters.sub_lines, memory).expect("memory that fits")
    });
    let lines = [
        line.clone(),
        line.map(|x| x * Complex::I),
        line.map(|x| x.conj()),
    ];
    for covariance in COVARIANCES {
        for method in METHODS {
            let parameters = Parameters {
                method,
                ..parameters
            };
            let name = format!(
                "{} elements, {covariance:?}, {parameters:?}",
                line.x.ncols()
            );
            let expected: Vec<_> = lines
                .iter()
                .zip(steering)
                .map(|(line, steering)| scalar_sub_lines(line, steering, parameters, covariance))
                .collect();
            let alone = sub_lines(line, steering[0], parameters, covariance);
            assert!(alone.iter().all(|z| z.is_finite()), "{name}");
            assert_eq!(bits(&alone), bits(&expected[0]), "{name}");
            for set in InstructionSet::available() {
                let z = set.dispatch(OverLanes {
                    lines: &lines,
                    steering: &steering,
                    parameters,
                    covariance,
                });
                for (z, expected) in z.iter().zip(&expected) {
                    assert_eq!(bits(z), bits(expected), "{set:?}, {name}");
                }
            }
        }
    }
}

#[test]
fn every_size_has_the_bits_of_the_reference() {
    for elements in [1, 2, 3, 5, 9, 16, 31, 64] {
        for (sub_lines, temporal_half_window) in [(2, 0), (4, 2), (8, 0)] {
            let line = Line::noise(elements as u64, 5, elements);
            let parameters = Parameters {
                sub_lines,
                temporal_half_window,
                ..Parameters::default()
            };
            assert_bits(&line, parameters);
        }
    }
}

#[test]
fn every_number_of_sub_lines_and_every_ratio_of_subapertures() {
    for (sub_lines, subaperture_ratio) in [(16, 0.4), (32, 1.0), (2, 0.7)] {
        let parameters = Parameters {
            sub_lines,
            subaperture_ratio,
            ..Parameters::default()
        };
        assert_bits(&Line::noise(3, 3, 20), parameters);
    }
}

/// An empty aperture, one that grows, silence, and an echo on a sub-line.
#[test]
fn hard_lines_have_the_bits_of_the_reference() {
    let mut growing = Line::noise(7, 24, 24);
    for (n, active) in growing.active.iter_mut().enumerate() {
        *active = match n / 4 {
            0 => Active { first: 0, count: 0 },
            step => Active {
                first: 4,
                count: 3 * step + step % 2,
            },
        };
    }
    let wave = |m: usize| Complex::cis(0.05 * m as f32);
    for line in [
        growing,
        Line::from_fn(4, 16, |n, m| wave(m) * (n % 2) as f32),
        Line::from_fn(4, 17, |_, m| wave(m) * 1e30),
        Line::from_fn(4, 16, |n, m| wave(m) * if n == 0 { 1.0 } else { 1e-25 }),
    ] {
        let without = (Postfilter::None, Apodization::None, 0.0);
        let unapodized = Postfilter::EXAMPLES.map(|by| (by, Apodization::None, 0.05));
        let apodized = Postfilter::EXAMPLES.map(|by| (by, Apodization::Hamming, 0.05));
        let all = unapodized.into_iter().chain(apodized).chain([without]);
        for (postfilter, apodization, diagonal_loading) in all {
            let parameters = Parameters {
                sub_lines: 4,
                postfilter,
                apodization,
                diagonal_loading,
                temporal_half_window: 1,
                ..Parameters::default()
            };
            assert_bits(&line, parameters);
        }
    }
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
                method,
                temporal_half_window: 2,
                ..Parameters::default()
            };
            let z = sub_lines(&line, steering, parameters, covariance);
            assert_eq!(
                bits(&z),
                bits(&core(&line, parameters, covariance)),
                "{method:?}"
            );
        }
    }
}

/// The f64 reference of a sample in a direction.
fn exact(
    line: &Line,
    n: usize,
    [slope, constant]: [f64; 2],
    parameters: &Parameters,
    covariance: Covariance,
) -> Vec<Complex<f64>> {
    let set = line.active[n];
    let sample = Sample::new(
        line.x.view(),
        n,
        (set.first, set.count),
        parameters,
        covariance,
    )
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
                            method,
                            postfilter,
                            apodization,
                            sub_lines: sub_lines_of,
                            temporal_half_window: 1,
                            ..Parameters::default()
                        };
                        let z = sub_lines(&line, steering, parameters, covariance);
                        let largest = z.iter().map(|z| widen(*z).norm()).fold(0.0, f64::max);
                        for (i, z) in z.iter().enumerate().step_by(5) {
                            let (n, k) = (i / sub_lines_of, i % sub_lines_of);
                            let [half, phase] = steering.direction(n, k).map(widen);
                            let direction = [2.0 * half.arg(), -phase.arg()];
                            let right = exact(&line, n, direction, &parameters, covariance);
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
                        method,
                        sub_lines: 8,
                        ..Parameters::default()
                    };
                    let z = sub_lines(&line, steering, parameters, covariance);
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
    let of = |sub_lines| Parameters {
        sub_lines,
        ..Parameters::default()
    };
    for sub_lines in [0, 3, 5, 33, 64, usize::MAX] {
        let refused = Beamformer::new(of(sub_lines)).err();
        let expected = "1, 2, 4, 8, 16 or 32";
        let value = sub_lines as f64;
        let name = "sub_lines";
        assert_eq!(
            refused,
            Some(Error::Parameter {
                name,
                value,
                expected
            })
        );
    }
    let line = Line::noise(1, 6, 8);
    let scan = linear(8, 6);
    let beamformer = Beamformer::new(of(4)).expect("valid parameters");
    let (mut four, mut two) = (memory(6, 4), memory(6, 2));
    let refused = Steering::new(&scan, 0, 4, &mut two);
    assert!(matches!(
        refused,
        Err(Error::Length {
            name: "steering",
            ..
        })
    ));
    let four = Steering::new(&scan, 3, 4, &mut four).expect("memory that fits");
    let two = Steering::new(&scan, 3, 2, &mut two).expect("memory that fits");
    let run = |steering: Steering<'_>, sizes_for: usize, length: usize, samples: usize| {
        let sizes = Beamformer::new(of(sizes_for)).expect("valid").sizes(8);
        let mut memory = Memory::new(0.0, sizes).expect("memory");
        let mut z = vec![Complex::ZERO; length];
        let all = |_| Active { first: 0, count: 8 };
        let x = line.x.as_slice().expect("in order");
        let line = AlignedLine::new(&x[..samples * 8], 8).expect("finite");
        beamformer.sub_lines(&mut memory.view(), (line, steering), all, &mut z)
    };
    assert_eq!(run(four, 4, 24, 6), Ok(()));
    assert!(matches!(
        run(four, 4, 23, 6),
        Err(Error::Length { name: "z", .. })
    ));
    let capacity = Error::Capacity {
        name: "sub_lines",
        actual: 4,
        capacity: 2,
    };
    assert_eq!(run(four, 2, 24, 6), Err(capacity));
    let refused = run(two, 4, 24, 6);
    assert!(matches!(
        refused,
        Err(Error::Parameter {
            name: "sub_lines of the steering",
            ..
        })
    ));
    let mut every_second = memory(3, 4);
    let every_second = Steering::of_step(&scan, 3, (4, 2), &mut every_second);
    let refused = run(every_second.expect("memory that fits"), 4, 24, 6);
    assert!(matches!(
        refused,
        Err(Error::Parameter {
            name: "depth_step of the steering",
            ..
        })
    ));
    let mut short = memory(3, 4);
    let shallow = linear(8, 3);
    let short = Steering::new(&shallow, 3, 4, &mut short).expect("memory that fits");
    let refused = run(short, 4, 24, 6);
    assert!(matches!(
        refused,
        Err(Error::Length {
            name: "samples of the steering",
            ..
        })
    ));
}
