//! Frames of the host have the bits of single lines, and cases that only a few methods meet.

use crate::common;

use bonebeam::beamform::{Beamformer, Method, Parameters, Postfilter};
use bonebeam::geometry::Active;
use bonebeam::simd::InstructionSet;
use bonebeam_drive::beamform::Plan;
use common::lines::{COVARIANCES, Line, METHODS, core, scalar, stacked};
use num_complex::Complex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The bits of every number, so that 0 and −0 differ.
fn bits(z: &[Complex<f32>]) -> Vec<(u32, u32)> {
    z.iter().map(|z| (z.re.to_bits(), z.im.to_bits())).collect()
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

/// Within a range of samples a line has the bits of its method, elsewhere of DAS.
///
/// The range may cut a run or a time window's block, over the host's threads and lanes.
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
                    for ((adaptive, das), z) in whole.iter().zip(frame.rows()) {
                        let expected: Vec<_> = (0..30)
                            .map(|n| {
                                if within.contains(&n) {
                                    adaptive[n]
                                } else {
                                    das[n]
                                }
                            })
                            .collect();
                        assert_eq!(bits(&z.to_vec()), bits(&expected), "{name}");
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
