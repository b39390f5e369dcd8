//! Every kernel on many plans: the bits of the f32 reference, in every way that the catalogue knows.

use crate::common::changed;
use bonebeam::Complex;
use bonebeam::beamform::Method;
use bonebeam::delay::Stage;
use bonebeam::geometry::{Axis, Steering};
use bonebeam::image::{Logarithm, Pooling};
use bonebeam::pipeline::Pipeline;
use bonebeam::simd::InstructionSet;
use bonebeam_drive::beamform::Plan;
use bonebeam_drive::pipeline::Frames;
use bonebeam_drive::source::{LineSource, Recorded};
use bonebeam_drive::threads::pool;
use bonebeam_oracle::reference::f32 as plain;
use bonebeam_oracle::reference::f64::coherence::short_lag_coherence;
use bonebeam_tests::draw::Seed;
use bonebeam_tests::kernel::{Kernel, bits, judge, judge_seeds};
use bonebeam_tests::kernels::delay::Input;
use bonebeam_tests::kernels::{
    beamform, coherence, delay, depth_interpolation, frame, image, phase_symmetry, pipeline, scan,
    surface, upsampled,
};
use ndarray::{Array2, Array3};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Frames of the host's driver have the bits of single lines, by any number of threads.
///
/// A frame's contents of the memory do not reach the next frame, and each sample is reported once.
#[test]
fn frames_of_the_host() {
    let (mut frames, sets) = (0, InstructionSet::available().collect::<Vec<_>>());
    let pools = [1, 2, 7].map(|threads| pool(threads).expect("threads"));
    for seed in 0..1500 {
        let Ok(mut kernel) = beamform::Lines::draw(&mut Seed(seed)) else {
            continue;
        };
        let (elements, samples) = (kernel.elements, kernel.counts.len());
        let whole = samples * elements;
        kernel.lines.retain(|(x, _)| x.len() == whole);
        let (false, 1) = (kernel.lines.is_empty(), kernel.parameters.sub_lines) else {
            continue;
        };
        let Ok(expected) = judge(&kernel, []) else {
            continue;
        };
        let set = sets[seed as usize % sets.len()];
        let plan = Plan::new(set, kernel.parameters, elements).expect("memory");
        let plan = plan.within(kernel.within.clone());
        let x: Vec<_> = kernel
            .lines
            .iter()
            .flat_map(|(x, _)| x.iter().copied())
            .collect();
        let x = Array3::from_shape_vec((kernel.lines.len(), samples, elements), x).expect("lines");
        let active = |line: usize, sample: usize| kernel.active(line, sample);
        let reported = AtomicUsize::new(0);
        let progress = |outputs: usize| _ = reported.fetch_add(outputs, Ordering::Relaxed);
        let before = x.mapv(|x| Complex::new(0.3, -0.1) - x * 0.5);
        let run = |x: &Array3<_>| plan.run(x.view(), &active, &progress);
        let [_, z] = [before, x].map(|x| pools[frames % 3].install(|| run(&x)).expect("a frame"));
        assert_eq!(reported.into_inner(), 2 * kernel.lines.len() * samples);
        let z = z.into_raw_vec_and_offset().0;
        assert!(bits(&z) == bits(&expected), "seed {seed}: {kernel:?}");
        frames += 1;
    }
    assert!(frames > 400, "{frames}");
}

/// A kernel with a reference in f32.
trait Plain: Kernel {
    /// Number of plans.
    const PLANS: u64;

    /// The result in plain loops; `None` where the reference has no such choice.
    fn plain(&self) -> Option<Vec<Self::Number>> {
        None
    }

    /// Asserts the bound of the error beside the reference in f64, if there is one here.
    fn exact(&self, _: &[Self::Number]) {}
}

fn check<K: Plain>() {
    judge_seeds(K::PLANS, |kernel: &K, numbers| {
        kernel.exact(numbers);
        let Some(plain) = kernel.plain() else {
            return;
        };
        let (ours, plain) = (bits(numbers), bits(&plain));
        let at = ours.iter().zip(&plain).position(|(a, b)| a != b);
        assert!(
            at.is_none() && ours.len() == plain.len(),
            "other bits than the reference at {at:?}"
        );
    });
}

#[test]
fn delayed_lines() {
    check::<delay::Lines>();
}

#[test]
fn upsampled_lines() {
    check::<upsampled::Waves>();
}

#[test]
fn beamformed_lines() {
    check::<beamform::Lines>();
}

#[test]
fn coherence_of_lines() {
    check::<coherence::Shares>();
    check::<coherence::ShortLag>();
}

#[test]
fn images() {
    check::<image::Image>();
    check::<depth_interpolation::Envelopes>();
}

#[test]
fn bone_maps() {
    check::<phase_symmetry::Map>();
}

#[test]
fn surfaces() {
    check::<surface::Frame>();
}

#[test]
fn lines_of_a_pipeline() {
    check::<pipeline::Line>();
}

/// Over the host's threads, too: their lines, image and map.
#[test]
fn frames_of_a_pipeline() {
    check::<frame::Frame>();
}

#[test]
fn apertures_of_scans() {
    check::<scan::Apertures>();
}

impl Plain for delay::Lines {
    const PLANS: u64 = 6000;

    fn plain(&self) -> Option<Vec<Complex<f32>>> {
        let mut out = vec![Complex::new(7.0, 7.0); self.numbers()];
        for line in self.lines() {
            match &self.input {
                Input::Rf(stage, rf, in_f32) => {
                    let plain = match in_f32 {
                        true => plain::delay::line_in_f32,
                        false => plain::delay::line,
                    };
                    plain(stage.parameters(), &line, rf, &mut out);
                }
                Input::Iq(stage, iq) => {
                    let samples = (&iq.planar[..], iq.counts.unwrap_or(1.0), iq.phase);
                    plain::iq::line(stage.parameters(), &line, samples, &mut out);
                }
            }
        }
        Some(out)
    }
}

impl Plain for upsampled::Waves {
    const PLANS: u64 = 1000;

    fn plain(&self) -> Option<Vec<Complex<f32>>> {
        let lines: Vec<_> = self.lines().map(|line| (line, &self.rf[..])).collect();
        let mut out = vec![Complex::new(7.0, 7.0); self.numbers()];
        plain::delay::upsampled(self.delay.parameters(), &lines, &mut out);
        Some(out)
    }
}

/// Within the adaptive samples the method, elsewhere DAS.
impl Plain for beamform::Lines {
    const PLANS: u64 = 6000;

    fn plain(&self) -> Option<Vec<Complex<f32>>> {
        let parameters = self.parameters;
        let mut all = Vec::new();
        for (line, (x, _)) in self.lines.iter().enumerate() {
            let x: Vec<_> = x.chunks(self.elements).map(<[_]>::to_vec).collect();
            let active = (0..x.len()).map(|n| self.active(line, n));
            let active: Vec<_> = active.map(|set| (set.first, set.count)).collect();
            if parameters.sub_lines > 1 {
                let directions = self.directions(line).expect("directions");
                let steering = Steering::of(&directions, parameters.sub_lines);
                let of_sample = |n| {
                    (0..parameters.sub_lines)
                        .map(|k| steering.direction(n, k))
                        .collect()
                };
                let directions: Vec<Vec<_>> = (0..x.len()).map(of_sample).collect();
                let z = plain::sub_lines::sub_lines(&x, &active, &directions, &parameters);
                all.extend(z.concat());
                continue;
            }
            let of = |method| {
                plain::beamform::beamform(&x, &active, &changed(parameters, |p| p.method = method))
            };
            let (adaptive, das) = (of(parameters.method), of(Method::Das));
            let within = |i: usize| self.within.contains(&(i * parameters.depth_step));
            all.extend((0..das.len()).map(|i| if within(i) { adaptive[i] } else { das[i] }));
        }
        Some(all)
    }
}

/// Parallel lines and the exact logarithm.
impl Plain for image::Image {
    const PLANS: u64 = 3000;

    fn plain(&self) -> Option<Vec<f32>> {
        let p = self.stage.parameters();
        if self.in_fan || p.logarithm == Logarithm::Polynomial {
            return None;
        }
        let envelopes = plain::image::envelope(&self.z);
        let largest = envelopes.iter().copied().fold(0.0, f32::max);
        let levels = plain::image::log_compression(&envelopes, largest, p.dynamic_range);
        let at = |Axis { first, step, count }| plain::image::Positions { first, step, count };
        let (rows, columns) = (at(p.grid.row_axis()), at(p.grid.column_axis()));
        let pixels = plain::image::resample(&levels, at(p.lines), at(p.samples), rows, columns);
        Some(match p.median && !pixels.is_empty() {
            true => plain::image::median(&pixels, p.grid.columns),
            false => pixels,
        })
    }
}

impl Plain for depth_interpolation::Envelopes {
    const PLANS: u64 = 1000;

    fn plain(&self) -> Option<Vec<f32>> {
        let (sub_lines, pooling) = self.of_line;
        let of_sub_line = |k: usize| {
            let z: Vec<_> = self.z.iter().skip(k).step_by(sub_lines).copied().collect();
            plain::image::envelope(&plain::depth_interpolation::for_envelope(&z, self.grid))
        };
        let all: Vec<Vec<f32>> = (0..sub_lines).map(of_sub_line).collect();
        let pooled = |n: usize| {
            let levels = all.iter().map(|envelope| envelope[n]);
            let largest = levels.clone().fold(0.0, f32::max);
            if pooling == Pooling::Largest || largest == 0.0 || sub_lines == 1 {
                return largest;
            }
            let squares = levels.map(|level| (level / largest) * (level / largest));
            let sum = squares.fold(0.0, |sum, square| sum + square);
            largest * (sum / sub_lines as f32).sqrt()
        };
        // Phases of more cycles are those of other roundings.
        (self.grid.2.abs() < 1e3).then(|| (0..self.grid.0).map(pooled).collect())
    }
}

impl Plain for phase_symmetry::Map {
    const PLANS: u64 = 60;

    fn plain(&self) -> Option<Vec<f32>> {
        let [rows, columns] = self.shape;
        let map = plain::phase_symmetry::phase_symmetry;
        Some(map(
            &self.image,
            rows,
            columns,
            &self.scales,
            self.threshold,
        ))
    }
}

impl Plain for surface::Frame {
    const PLANS: u64 = 200;

    fn plain(&self) -> Option<Vec<Self::Number>> {
        Some(match &self.coherence {
            None => plain::surface::surface(&self.parameters, &self.grey),
            Some(coherence) => {
                plain::surface::surface_with_coherence(&self.parameters, &self.grey, coherence)
            }
        })
    }
}

/// One of its ways is by the stages, which have their own references.
impl Plain for pipeline::Line {
    const PLANS: u64 = 2000;
}

/// Lines, image and map of the host's threads.
fn by_the_host<D: Stage + Sync>(
    pipeline: &Pipeline<'_, D>,
    source: &LineSource<'_>,
    pooling: Pooling,
) -> (Array2<Complex<f32>>, Array2<f32>, Array2<f32>) {
    let mut frames = Frames::new(pipeline).expect("memory").with_pooling(pooling);
    let lines = frames.lines(source).expect("lines");
    let image = frames.image(lines.view()).expect("an image");
    let map = frames.run(source).expect("a map");
    (lines, image, map)
}

impl Plain for frame::Frame {
    const PLANS: u64 = 150;

    fn exact(&self, numbers: &[f32]) {
        let (parameters, line) = (self.parameters(0), &self.line);
        let of_line = &|_: usize| 0..line.transmits.len();
        let transmits: Vec<_> = line.transmits(&()).map(|(transmit, _)| transmit).collect();
        let host = match line.input() {
            Some(input) => line.with_iq(|record| {
                let pipeline = line.gated_frame(Pipeline::of_iq(parameters, input)?)?;
                let source = LineSource::Iq(Recorded {
                    pipeline: pipeline.lines().by_reference(),
                    transmits: &transmits,
                    records: &vec![*record; transmits.len()],
                    of_line,
                });
                Ok(by_the_host(&pipeline, &source, self.pooling))
            }),
            None => line.with_rf(|record| {
                let pipeline = line.gated_frame(Pipeline::new(parameters)?)?;
                let source = LineSource::Rf(Recorded {
                    pipeline: pipeline.lines().by_reference(),
                    transmits: &transmits,
                    records: &vec![*record; transmits.len()],
                    of_line,
                });
                Ok(by_the_host(&pipeline, &source, self.pooling))
            }),
        };
        let (host, image, map) = host.expect("a frame");
        let (lines, rest) = numbers.split_at(self.of_lines());
        // The host's lines are `[sub-line][computed sample]`.
        let (sub_lines, samples) = (line.beamformer.sub_lines, host.ncols());
        for (n, z) in lines.as_chunks::<2>().0.iter().enumerate() {
            let (sample, k) = (n / sub_lines % samples, n % sub_lines);
            let host = host[[n / (sub_lines * samples) * sub_lines + k, sample]];
            assert_eq!(*z, [host.re, host.im], "sample {sample}, sub-line {k}");
        }
        let pictures = image.iter().chain(&map).copied();
        assert!(
            rest.iter()
                .copied()
                .take(2 * frame::SIDE * frame::SIDE)
                .eq(pictures)
        );
    }
}

/// The reference of shares is in f64: `coherence.rs`.
impl Plain for coherence::Shares {
    const PLANS: u64 = 1000;
}

impl Plain for coherence::ShortLag {
    const PLANS: u64 = 1000;

    /// Sums of positive powers err by fewer units in the last place than they have terms, and products no more.
    fn exact(&self, numbers: &[f32]) {
        let lines = &self.0;
        let window = lines.parameters.temporal_half_window;
        let terms = 2.0 * (2 * window + 1) as f64 * lines.elements as f64;
        let mut found = numbers.iter();
        for (line, (x, _)) in lines.lines.iter().enumerate() {
            // Squares within the range of f32.
            let parts = x.iter().flat_map(|x| [x.re.abs(), x.im.abs()]);
            let moderate = parts
                .clone()
                .all(|x| x == 0.0 || (1e-15..1e15).contains(&x));
            for (n, found) in (0..lines.samples(line)).zip(&mut found) {
                let active = |n: usize| lines.active(line, n);
                let expected = short_lag_coherence(x, lines.elements, active, window, n);
                let error = (f64::from(*found) - expected).abs();
                let bound = terms * f64::from(f32::EPSILON);
                assert!(!moderate || error <= bound, "{n}: {found} and {expected}");
            }
        }
    }
}

impl Plain for scan::Apertures {
    const PLANS: u64 = 4000;
}
