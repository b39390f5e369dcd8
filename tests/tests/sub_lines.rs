//! Sub-lines: the core's bits beside the f32 reference, its error beside the f64 reference, and what follows from
//! their definition.

use crate::common;

use bonebeam::Error;
use bonebeam::beamform::{
    AlignedLine, Apodization, Beamformer, Method, Parameters, Postfilter, Segment, SteeredSegments,
    constant_segments,
};
use bonebeam::covariance::{Averaging, Covariance, Forward, ForwardBackward};
use bonebeam::delay::Record;
use bonebeam::geometry::{
    Active, Array, Axis, Depth, Element, Lines, Ray, Scan, ScanParameters, Steering, SteeringTable,
};
use bonebeam::image::Pooling;
use bonebeam::memory::Scratch;
use bonebeam::pipeline::{self, DepthGate, Frame, Pipeline};
use bonebeam::simd::{InstructionSet, Task, Vector};
use bonebeam_drive::beamform::Memory;
use bonebeam_drive::pipeline::Frames;
use bonebeam_drive::source::{LineSource, Recorded};
use bonebeam_oracle::reference::f64::beamform::Sample;
use bonebeam_oracle::reference::f64::steering::direction;
use common::frames::{ELEMENTS, LINES, PARAMETERS, focused, record};
use common::lines::{COVARIANCES, Line, METHODS, core, scalar_sub_lines, widen};
use num_complex::Complex;
use std::f64::consts::TAU;

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

/// A line an element.
fn linear(elements: usize, samples: usize) -> Scan<'static> {
    let lines = Lines::Even(Axis::centred(elements.max(2), PITCH));
    Scan::new(parameters(Array::linear(elements, PITCH), lines, samples)).expect("a valid scan")
}

fn memory(samples: usize, sub_lines: usize) -> Vec<Complex<f32>> {
    vec![Complex::ZERO; Steering::need(samples, sub_lines).complex]
}

/// The core over lanes: up to as many lines as there are, whose apertures grow alike.
struct OverLanes<'a> {
    lines: &'a [Line],
    steering: &'a [Steering<'a>],
    parameters: Parameters,
    covariance: Covariance,
}

impl Task for OverLanes<'_> {
    type Output = Vec<Vec<Complex<f32>>>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        match self.covariance {
            Covariance::Forward => self.averaged::<Forward, V>(zero),
            Covariance::ForwardBackward => self.averaged::<ForwardBackward, V>(zero),
        }
    }
}

impl OverLanes<'_> {
    fn averaged<A: Averaging<V>, V: Vector>(&self, zero: V) -> Vec<Vec<Complex<f32>>> {
        let beamformer = Beamformer::new(self.parameters).expect("valid parameters");
        let count = self.parameters.sub_lines;
        let most = self.lines[0].active.iter().map(|set| set.count).max();
        let sizes = beamformer.sizes(most.unwrap_or(0));
        let mut memory = Memory::<A, V>::new(zero, sizes).expect("memory");
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
    fn of<A: Averaging<f32>>(
        line: &Line,
        steering: Steering<'_>,
        parameters: Parameters,
    ) -> Vec<Complex<f32>> {
        let beamformer = Beamformer::new(parameters).expect("valid parameters");
        let most = line.active.iter().map(|set| set.count).max();
        let sizes = beamformer.sizes(most.unwrap_or(0));
        let mut memory = Memory::<A, f32>::new(0.0, sizes).expect("memory");
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
    match covariance {
        Covariance::Forward => of::<Forward>(line, steering, parameters),
        Covariance::ForwardBackward => of::<ForwardBackward>(line, steering, parameters),
    }
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
        for (postfilter, diagonal_loading) in
            [(Postfilter::None, 0.0), (Postfilter::CoherenceFactor, 0.05)]
        {
            let parameters = Parameters {
                sub_lines: 4,
                postfilter,
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

/// The reference in f64 of a sample in a direction.
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

/// Noise with an echo beside the line: of all methods the error is at most 10⁻⁴ of the line's largest |z|.
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
                    for postfilter in [Postfilter::None, Postfilter::CoherenceFactor] {
                        let parameters = Parameters {
                            method,
                            postfilter,
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

/// An echo whose phases are those of a sub-line has the gain 1 there, by DAS, MV and rank 1.
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

/// Arrays with their lines: linear, a sector, curved.
fn geometries(check: impl Fn(&Scan<'_>)) {
    let arc: Vec<Element> = (0..32)
        .map(|m| Element::convex(32, 0.4e-3, 40e-3, m))
        .collect();
    let curved = Array::At {
        elements: &arc,
        pitch: 0.4e-3,
    };
    let phased = Array::linear(32, 0.15e-3);
    let sector: Vec<Ray> = (0..31)
        .map(|line| Ray::new(0.0, 0.0, -0.7 + 1.4 / 30.0 * f64::from(line)))
        .collect();
    let normals: Vec<Ray> = (0..63)
        .map(|line| curved.normal(f64::from(line) / 2.0))
        .collect();
    let uneven = [-2e-3, -1e-3, 0.5e-3, 0.7e-3];
    for (array, lines) in [
        (
            Array::linear(32, PITCH),
            Lines::Even(Axis::centred(32, PITCH)),
        ),
        (Array::linear(32, PITCH), Lines::At(&uneven)),
        (phased, Lines::Rays(&sector)),
        (curved, Lines::Rays(&normals)),
    ] {
        check(&Scan::new(parameters(array, lines, 300)).expect("a valid scan"));
    }
}

#[test]
fn directions_are_those_of_the_definition() {
    geometries(|scan| {
        for sub_lines in [2, 4, 16] {
            assert_directions(scan, sub_lines);
        }
    });
}

/// Of more than four sub-lines within what the polynomial errs.
fn assert_directions(scan: &Scan<'_>, sub_lines: usize) {
    let need = SteeringTable::need(scan.lines(), scan.samples(), sub_lines);
    let mut memory = vec![Complex::ZERO; need.complex];
    let table = SteeringTable::new(scan, sub_lines, &mut memory).expect("memory that fits");
    let p = scan.parameters();
    let wave = TAU * p.centre_frequency / p.sound_speed;
    for line in [0, 1, scan.lines() / 2, scan.lines() - 1] {
        let steering = table.line(line).expect("a line of the scan");
        assert_eq!((steering.samples(), steering.sub_lines()), (300, sub_lines));
        for n in [0, 17, 299] {
            let depth = scan.depth(n);
            let point = |ray: Ray| ray.point(depth);
            let ends = [0, sub_lines - 1].map(|k| point(p.lines.sub_line(line, k, sub_lines)));
            let half = (ends[1][0] - ends[0][0]).hypot(ends[1][1] - ends[0][1]) / 2.0;
            let bound = match sub_lines {
                2 | 4 => 1e-7,
                _ => 1e-7 + wave * half * (half / depth).powi(4) / 5.0,
            };
            for k in 0..sub_lines {
                let sub_line = p.lines.sub_line(line, k, sub_lines);
                let points = [scan.ray(line), sub_line].map(point);
                let active = scan.active(line, n);
                let [slope, constant] = direction(&p.array, active, points, wave);
                let expected = [Complex::cis(slope / 2.0), Complex::cis(-constant)];
                for (found, expected) in steering.direction(n, k).into_iter().zip(expected) {
                    let error = (widen(found) - expected).norm();
                    assert!(error < bound, "{line} {n} {k}: {error:e}, {bound:e}");
                }
            }
        }
    }
    assert!(table.line(scan.lines()).is_none());
}

/// Half way between two lines, the outermost sub-lines of both are half a sub-line away.
#[test]
fn sub_lines_divide_the_lines_cells_evenly() {
    geometries(|scan| {
        let lines = scan.parameters().lines;
        if let Lines::At(x) = lines {
            // From -1.5 to -0.25 mm.
            assert_eq!(x[1], -1e-3);
            for (k, x) in [-1.34375e-3, -1.03125e-3, -0.71875e-3, -0.40625e-3]
                .iter()
                .enumerate()
            {
                assert!((lines.sub_line(1, k, 4).x() - x).abs() < 1e-15);
            }
            return;
        }
        let all: Vec<Ray> = (0..scan.lines())
            .flat_map(|line| (0..4).map(move |k| lines.sub_line(line, k, 4)))
            .collect();
        let steps = |along: fn(&Ray) -> f64| {
            let steps: Vec<f64> = all
                .windows(2)
                .map(|ray| along(&ray[1]) - along(&ray[0]))
                .collect();
            steps
        };
        for step in steps(Ray::angle) {
            assert!((step - steps(Ray::angle)[0]).abs() < 1e-9);
        }
        // Along an arc the lateral steps change slowly.
        for pair in steps(Ray::x).windows(2) {
            assert!((pair[1] - pair[0]).abs() < 1e-3 * pair[0].abs() + 1e-15);
        }
        assert_eq!(Lines::At(&[1e-3]).sub_line(0, 1, 4), Ray::down(1e-3));
    });
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
    let apodized = Parameters {
        apodization: Apodization::Hann,
        ..of(2)
    };
    let generalized = Parameters {
        postfilter: Postfilter::GeneralizedCoherenceFactor,
        ..of(2)
    };
    for parameters in [apodized, generalized] {
        let refused = Beamformer::new(parameters).err();
        let expected = Parameters::WITHOUT_SUB_LINES;
        let (name, value) = ("sub_lines", 2.0);
        assert_eq!(
            refused,
            Some(Error::Parameter {
                name,
                value,
                expected
            })
        );
        let one = Parameters {
            sub_lines: 1,
            ..parameters
        };
        assert!(Beamformer::new(one).is_ok());
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
        let mut memory = Memory::<ForwardBackward, f32>::new(0.0, sizes).expect("memory");
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

/// The core's frame in blocks of any length, lines by themselves and the host's threads: the same sub-lines, and the same
/// image of them; inside a depth gate those of the method, outside those of DAS.
#[test]
fn frames_have_the_same_sub_lines_and_image() {
    let beamformer = Parameters {
        sub_lines: 4,
        ..PARAMETERS.beamformer
    };
    let gate = DepthGate {
        from: 6e-3,
        to: 9e-3,
    };
    let of = |method, block| pipeline::Parameters {
        beamformer: Parameters {
            method,
            ..beamformer
        },
        block,
        ..PARAMETERS
    };
    let rf: Vec<Vec<f32>> = (0..LINES).map(record).collect();
    let records: Vec<Record> = rf
        .iter()
        .map(|rf| Record::new(rf, ELEMENTS).unwrap())
        .collect();
    let all = |pipeline: &Pipeline<'_>, pooling| {
        let need = pipeline.need(Covariance::ForwardBackward);
        let (mut real, mut complex) = (vec![0.0; need.real], vec![Complex::ZERO; need.complex]);
        let scratch = Scratch {
            real: &mut real,
            complex: &mut complex,
        };
        let mut frame = Frame::new(pipeline, scratch).unwrap().with_pooling(pooling);
        let mut z = Vec::new();
        for (line, record) in records.iter().enumerate() {
            z.extend_from_slice(frame.line(line, [(focused(), record)]).unwrap());
        }
        (z, frame.image().unwrap().to_vec())
    };
    let rank1 = PARAMETERS.beamformer.method;
    let whole = Pipeline::new(of(rank1, usize::MAX)).unwrap();
    for pooling in [Pooling::Largest, Pooling::Rms] {
        let (z, image) = all(&whole, pooling);
        for block in [1, 50] {
            let blocks = Pipeline::new(of(rank1, block)).unwrap();
            assert_eq!(all(&blocks, pooling), (z.clone(), image.clone()), "{block}");
        }
        let frames = Frames::new(&whole, Covariance::ForwardBackward).unwrap();
        let frames = frames.with_pooling(pooling);
        let source = LineSource::Rf(Recorded {
            pipeline: whole.lines().by_reference(),
            transmits: &[focused(); LINES],
            records: &records,
            of_line: &|line| line..line + 1,
        });
        let lines = frames.lines(&source).unwrap();
        let samples = whole.lines().scan().samples();
        assert_eq!(lines.dim(), (4 * LINES, samples));
        for (line, of_line) in z.chunks_exact(4 * samples).enumerate() {
            for (n, of_sample) in of_line.chunks_exact(4).enumerate() {
                for (k, z) in of_sample.iter().enumerate() {
                    assert_eq!(*z, lines[[4 * line + k, n]], "{line} {n} {k}");
                }
            }
        }
        let pixels = frames.image(lines.view()).unwrap();
        assert_eq!(pixels.as_slice().unwrap(), image);
    }
    let (z, _) = all(&whole, Pooling::Largest);
    let das = Pipeline::new(of(Method::Das, usize::MAX)).unwrap();
    let (by_das, _) = all(&das, Pooling::Largest);
    let inside = gate.samples(&whole.lines().scan().depths()).unwrap();
    let gated = Pipeline::new(of(rank1, 50))
        .unwrap()
        .with_gate(gate)
        .unwrap();
    let samples = whole.lines().scan().samples();
    for (i, found) in all(&gated, Pooling::Largest).0.iter().enumerate() {
        let expected = match inside.contains(&(i / 4 % samples)) {
            true => z[i],
            false => by_das[i],
        };
        assert_eq!(*found, expected, "{i}");
    }
}
