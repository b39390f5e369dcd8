//! The core's beamformers: bits of every instruction set and of scalar loops.
//!
//! All instruction sets give the bits of plain scalar loops.

use crate::common;

use bonebeam::beamform::{Beamformer, Method, Parameters, Postfilter};
use bonebeam::geometry::Active;
use bonebeam::simd::InstructionSet;
use bonebeam_drive::beamform::Plan;
use common::lines::{
    COVARIANCES, Gaussian, Line, METHODS, core, core_lanes, core_within, frame, scalar, stacked,
    variants,
};
use ndarray::Array2;
use num_complex::Complex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The bits of every number, so that 0 and −0 differ.
fn bits(z: &[Complex<f32>]) -> Vec<(u32, u32)> {
    z.iter().map(|z| (z.re.to_bits(), z.im.to_bits())).collect()
}

fn assert_core_is_scalar(line: &Line, parameters: Parameters, name: &str) {
    for covariance in COVARIANCES {
        for method in METHODS {
            let parameters = Parameters {
                method,
                ..parameters
            };
            let name = format!("{name}: {covariance:?}, {parameters:?}");
            let z = core(line, parameters, covariance);
            assert!(z.iter().all(|z| z.is_finite()), "{name}");
            let expected = scalar(line, parameters, covariance);
            assert_eq!(bits(&z), bits(&expected), "{name}");
        }
    }
}

#[test]
fn every_size_and_time_window() {
    // Odd and even subapertures, and one of one element.
    for elements in [1, 2, 3, 9, 16, 31, 64] {
        let line = Line::noise(elements as u64, 12, elements);
        for temporal_half_window in 0..=10 {
            let parameters = Parameters {
                temporal_half_window,
                ..Parameters::default()
            };
            assert_core_is_scalar(&line, parameters, &format!("{elements} elements"));
        }
    }
}

/// The tests allocate memory of exactly the required size.
#[test]
fn every_length_of_subaperture() {
    for elements in 1..=36 {
        let line = Line::noise(elements as u64, 6, elements);
        for subaperture_ratio in [0.5, 1.0] {
            let parameters = Parameters {
                temporal_half_window: 1,
                subaperture_ratio,
                ..Parameters::default()
            };
            assert_core_is_scalar(&line, parameters, &format!("{elements} elements"));
        }
    }
}

#[test]
fn the_full_array() {
    let line = Line::noise(1, 24, 128);
    let parameters = Parameters {
        temporal_half_window: 10,
        ..Parameters::default()
    };
    assert_core_is_scalar(&line, parameters, "128 elements");
}

#[test]
fn every_subaperture_ratio_and_loading() {
    let line = Line::noise(2, 8, 20);
    for subaperture_ratio in [0.01, 0.3, 0.75, 1.0] {
        for diagonal_loading in [0.0, 1e-3, 0.05, 1e6] {
            let parameters = Parameters {
                subaperture_ratio,
                diagonal_loading,
                temporal_half_window: 1,
                ..Parameters::default()
            };
            assert_core_is_scalar(&line, parameters, "20 elements");
        }
    }
}

/// Also with silent samples, samples tiny beside others, and extreme floats.
#[test]
fn every_postfilter_and_the_example_of_every_parameter() {
    let mut line = Line::noise(7, 64, 48);
    line.active = growing(64, 4);
    for parameters in variants() {
        assert_core_is_scalar(&line, parameters, "growing aperture");
        for (name, line) in hard_lines() {
            assert_core_is_scalar(&line, parameters, name);
        }
    }
}

/// Covariances that are singular except for rounding errors, with little loading.
///
/// A factorisation would let these errors grow without bound.
#[test]
fn singular_covariances() {
    let wave = |angle: f32, m: usize| Complex::cis(angle * m as f32);
    for (name, line) in [
        ("a wave", Line::from_fn(4, 48, |_, m| wave(0.7, m))),
        (
            "two waves",
            Line::from_fn(4, 48, |_, m| wave(0.7, m) + wave(-1.1, m) * 0.5),
        ),
        (
            "a decay by 160 dB",
            Line::from_fn(4, 48, |_, m| {
                wave(0.7, m) * (10.0_f32).powf(m as f32 / -6.0)
            }),
        ),
        ("noise", Line::noise(6, 4, 48)),
    ] {
        for subaperture_ratio in [0.5, 0.75, 1.0] {
            for diagonal_loading in [0.0, 1e-8, 1e-6] {
                let parameters = Parameters {
                    subaperture_ratio,
                    diagonal_loading,
                    ..Parameters::default()
                };
                assert_core_is_scalar(&line, parameters, name);
            }
        }
    }
}

/// An aperture that is empty at first, grows, and is cut at the array's start.
fn growing(samples: usize, shift: usize) -> Vec<Active> {
    (0..samples)
        .map(|n| match n / 5 {
            0 => Active { first: 0, count: 0 },
            step => Active {
                first: shift,
                count: 3 * step + step % 2,
            },
        })
        .collect()
}

#[test]
fn growing_apertures() {
    let mut line = Line::noise(3, 64, 48);
    line.active = growing(64, 4);
    for temporal_half_window in [0, 2, 7] {
        let parameters = Parameters {
            temporal_half_window,
            ..Parameters::default()
        };
        assert_core_is_scalar(&line, parameters, "growing aperture");
    }
}

/// Lines that stress the arithmetic: no power, equal eigenvalues, extreme floats.
fn hard_lines() -> Vec<(&'static str, Line)> {
    let mut gaussian = Gaussian::new(4);
    let wave = |angle: f32, m: usize| Complex::cis(angle * m as f32);
    let noise = Line::noise(5, 10, 18);
    let scaled = |factor: f32| noise.map(|x| x * factor);
    vec![
        ("zeros", noise.map(|_| Complex::ZERO)),
        ("real data", noise.map(|x| Complex::from(x.re))),
        ("on axis", noise.map(|_| Complex::new(1.0, -1.0))),
        ("off axis", Line::from_fn(10, 18, |_, m| wave(0.9, m))),
        (
            "two waves",
            Line::from_fn(10, 18, |_, m| wave(0.4, m) + wave(-0.4, m)),
        ),
        (
            "zero sum",
            Line::from_fn(10, 18, |_, m| wave(std::f32::consts::PI, m)),
        ),
        (
            "one hot element",
            Line::from_fn(10, 18, |n, m| {
                if (n, m) == (4, 7) {
                    Complex::new(3e30, -2e30)
                } else {
                    Complex::ZERO
                }
            }),
        ),
        (
            "silence after an echo",
            Line::from_fn(10, 18, |n, _| {
                if n < 5 {
                    gaussian.next()
                } else {
                    Complex::ZERO
                }
            }),
        ),
        (
            "a shadow of 60 dB",
            Line::from_fn(10, 18, |n, m| {
                noise.x[[n, m]] * if n < 5 { 1.0 } else { 1e-3 }
            }),
        ),
        (
            "beyond the range of the covariance",
            Line::from_fn(10, 18, |n, m| {
                noise.x[[n, m]] * if n < 5 { 1.0 } else { 1e-20 }
            }),
        ),
        ("subnormal", scaled(1e-42)),
        ("small", scaled(1e-30)),
        ("large", scaled(1e30)),
        ("largest", noise.map(|_| Complex::new(f32::MAX, -f32::MAX))),
    ]
}

#[test]
fn hard_data() {
    for (name, line) in hard_lines() {
        for temporal_half_window in [0, 3] {
            let parameters = Parameters {
                temporal_half_window,
                ..Parameters::default()
            };
            assert_core_is_scalar(&line, parameters, name);
        }
    }
}

#[test]
fn every_number_of_lanes() {
    // Lines of different data, position and length, so that lanes stop at different times. Hard data are beside them,
    // so that a silent or slowly converging lane is not alone.
    let mut lines: Vec<Line> = (0..19)
        .map(|k| {
            let samples = 40 + k % 4;
            let mut line = Line::noise(10 + k as u64, samples, 48);
            line.active = growing(samples, k);
            line
        })
        .collect();
    lines[3].x.fill(Complex::ZERO);
    lines[6].x.fill(Complex::ONE);
    lines[12] = lines[12].map(|x| x * 1e-25);
    for covariance in COVARIANCES {
        for method in METHODS {
            let windows = [0, 4].map(|temporal_half_window| Parameters {
                temporal_half_window,
                ..Parameters::default()
            });
            for parameters in windows.into_iter().chain(variants()) {
                let parameters = Parameters {
                    method,
                    ..parameters
                };
                let expected: Vec<_> = lines
                    .iter()
                    .map(|line| bits(&scalar(line, parameters, covariance)))
                    .collect();
                let all =
                    |z: Vec<Vec<Complex<f32>>>| -> Vec<_> { z.iter().map(|z| bits(z)).collect() };
                let name = format!("{covariance:?}, {parameters:?}");
                let one = lines.iter().map(|line| core(line, parameters, covariance));
                assert_eq!(all(one.collect()), expected, "1 lane: {name}");
                for set in InstructionSet::available() {
                    let lanes = core_lanes(set, &lines, parameters, covariance);
                    assert_eq!(all(lanes), expected, "{}: {name}", set.name());
                }
            }
        }
    }
}

/// Nine beams of noise whose apertures grow at different depths.
fn growing_frame(seed: u64) -> Vec<Line> {
    let line = |k: u64| {
        let mut line = Line::noise(seed + k, 30, 40);
        line.active = growing(30, k as usize);
        line
    };
    (0..9).map(line).collect()
}

#[test]
fn frame_after_frame_on_any_number_of_threads() {
    let frames = [growing_frame(40), growing_frame(50)];
    for covariance in COVARIANCES {
        for method in [Method::Das, Method::EsmvRank1] {
            let parameters = Parameters {
                method,
                temporal_half_window: 2,
                ..Parameters::default()
            };
            for threads in [1, 2, 7] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
                let pool = pool.build().expect("threads");
                let set = InstructionSet::detect();
                let plan = Plan::new(
                    set,
                    Parameters {
                        covariance,
                        ..parameters
                    },
                    40,
                )
                .expect("a size that fits");
                // One frame's contents of the plan's memory must not reach the next frame.
                for lines in &frames {
                    let x = stacked(lines);
                    let active = |beam: usize, sample: usize| lines[beam].active[sample];
                    let z = pool.install(|| plan.run(x.view(), &active, &|_| {}));
                    let z = z.expect("a frame that fits");
                    for (line, z) in lines.iter().zip(z.rows()) {
                        let expected = scalar(line, parameters, covariance);
                        let name = format!("{covariance:?}, {method:?}, {threads} threads");
                        assert_eq!(bits(&z.to_vec()), bits(&expected), "{name}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_frame_on_all_threads() {
    let lines = growing_frame(40);
    for covariance in COVARIANCES {
        for method in [Method::Das, Method::EsmvRank1] {
            let parameters = Parameters {
                method,
                temporal_half_window: 2,
                ..Parameters::default()
            };
            let z: Array2<Complex<f32>> = frame(&lines, parameters, covariance);
            for (line, z) in lines.iter().zip(z.rows()) {
                let expected = scalar(line, parameters, covariance);
                assert_eq!(
                    bits(&z.to_vec()),
                    bits(&expected),
                    "{covariance:?}, {method:?}"
                );
            }
        }
    }
}

/// Within a range of samples a line has the bits of its method, elsewhere of DAS.
///
/// The range may cut a run or a time window's block, in the core and over the host's threads and lanes.
#[test]
fn adaptive_within_and_das_elsewhere() {
    let lines = growing_frame(70);
    let x = stacked(&lines);
    for covariance in COVARIANCES {
        for method in METHODS {
            let coherent = Parameters {
                postfilter: Postfilter::CoherenceFactor,
                ..Parameters::default()
            };
            let windows = [0, 1, 4].map(|temporal_half_window| Parameters {
                temporal_half_window,
                ..Parameters::default()
            });
            for parameters in windows.into_iter().chain([coherent]) {
                let of = |method| Parameters {
                    method,
                    ..parameters
                };
                let adaptive = |line| scalar(line, of(method), covariance);
                let das = |line| scalar(line, of(Method::Das), covariance);
                let whole: Vec<_> = lines.iter().map(|l| (adaptive(l), das(l))).collect();
                for within in [0..30, 0..1, 7..8, 5..30, 11..23, 29..30, 17..17, 40..50] {
                    let name = format!("{covariance:?}, {:?}, {within:?}", of(method));
                    let active = |beam: usize, sample: usize| lines[beam].active[sample];
                    let parameters = of(method);
                    let set = InstructionSet::detect();
                    let plan = Plan::new(
                        set,
                        Parameters {
                            covariance,
                            ..parameters
                        },
                        40,
                    )
                    .expect("a size that fits");
                    let plan = plan.within(within.clone());
                    let count = AtomicUsize::new(0);
                    let progress = |n: usize| _ = count.fetch_add(n, Ordering::Relaxed);
                    let frame = plan.run(x.view(), &active, &progress);
                    let frame = frame.expect("a frame that fits");
                    // Each output is reported once.
                    assert_eq!(count.into_inner(), frame.len());
                    for ((line, (adaptive, das)), z) in lines.iter().zip(&whole).zip(frame.rows()) {
                        let expected: Vec<_> = (0..30)
                            .map(|n| {
                                if within.contains(&n) {
                                    adaptive[n]
                                } else {
                                    das[n]
                                }
                            })
                            .collect();
                        assert_eq!(bits(&z.to_vec()), bits(&expected), "host: {name}");
                        let z = core_within(line, within.clone(), parameters, covariance);
                        assert_eq!(bits(&z), bits(&expected), "{name}");
                    }
                }
            }
        }
    }
}

/// The memory need only fit the adaptive samples.
///
/// An active set that does not fit is refused, also beside others.
#[test]
fn memory_for_what_is_adaptive() {
    let line = &growing_frame(80)[4];
    let within = 0..10;
    let largest =
        |range: std::ops::Range<usize>| line.active[range].iter().map(|set| set.count).max();
    assert!(largest(0..10) < largest(0..30));
    let beamformer = Beamformer::new(Parameters::default()).expect("valid parameters");
    let sizes = beamformer.sizes(largest(within.clone()).unwrap_or(0));
    let mut memory = bonebeam_drive::beamform::Memory::new(0.0, sizes).expect("memory");
    let x = line.x.as_slice().expect("standard layout");
    let x = bonebeam::beamform::AlignedLine::new(x, line.x.ncols()).expect("finite samples");
    let mut z = vec![Complex::ZERO; 30];
    let active = |n: usize| line.active[n];
    let mut run = |within| beamformer.line_within(&mut memory.view(), x, active, within, &mut z);
    assert_eq!(run(within), Ok(()));
    assert!(matches!(
        run(0..30),
        Err(bonebeam::Error::Capacity {
            name: "active elements",
            ..
        })
    ));
}

/// Two subapertures of seven elements without loading are of rank 2.
///
/// With the backward ones the rank is 4. In f32 a Cholesky factorisation fails.
#[test]
fn a_singular_covariance_takes_the_eigensolver() {
    for turn in [0.3, 0.7, 1.1] {
        let line = Line::from_fn(6, 8, |n, m| {
            Complex::from_polar(1.0 + n as f32, turn * (m * m + n * m) as f32)
        });
        for covariance in COVARIANCES {
            let z = |method| {
                let parameters = Parameters {
                    method,
                    diagonal_loading: 0.0,
                    subaperture_ratio: 0.9,
                    ..Parameters::default()
                };
                bits(&core(&line, parameters, covariance))
            };
            assert_eq!(
                z(Method::EsmvRank1),
                z(Method::EsmvRank(1)),
                "{covariance:?}"
            );
        }
    }
}

/// Constant time has no eigensolver: a noise-free wave gives 0 if its loaded covariance is singular in f32.
///
/// That is so for tiny loadings, and never from a thousandth on.
#[test]
fn steps_serve_a_wave_with_a_loading_of_a_thousandth() {
    let zeros = |elements, diagonal_loading| {
        let line = Line::from_fn(4, elements, |_, m| Complex::cis(0.7 * m as f32));
        let parameters = Parameters {
            method: Method::EsmvRank1Steps(8),
            diagonal_loading,
            ..Parameters::default()
        };
        COVARIANCES.map(|covariance| {
            let z = core(&line, parameters, covariance);
            z.iter().filter(|z| z.norm() == 0.0).count()
        })
    };
    for elements in [8, 32, 128] {
        assert_eq!(zeros(elements, 1e-3), [0, 0], "{elements}");
    }
    assert!(zeros(128, 1e-7).iter().all(|&zeros| zeros > 0));
}
