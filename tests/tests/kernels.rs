//! Every kernel on many plans: the bits of the f32 reference, in every way that the catalogue knows.

use bonebeam::Complex;
use bonebeam::beamform::{Method, Parameters};
use bonebeam::geometry::{Axis, Steering};
use bonebeam::image::Logarithm;
use bonebeam_oracle::reference::f32 as plain;
use bonebeam_tests::kernel::{Kernel, bits, judge_seeds};
use bonebeam_tests::kernels::delay::Input;
use bonebeam_tests::kernels::{
    beamform, coherence, delay, image, phase_symmetry, pipeline, scan, surface, upsampled,
};

/// A kernel with a reference in f32.
trait Plain: Kernel {
    /// Number of plans.
    const PLANS: u64;

    /// The result in plain loops; `None` where the reference has no such choice.
    fn plain(&self) -> Option<Vec<Self::Number>> {
        None
    }
}

fn check<K: Plain>() {
    judge_seeds(K::PLANS, |kernel: &K, numbers| {
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
                Input::Rf(stage, rf) => plain::delay::line(stage.parameters(), &line, rf, &mut out),
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
        let (parameters, covariance) = (self.parameters, self.parameters.covariance);
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
                let z =
                    plain::sub_lines::sub_lines(&x, &active, &directions, &parameters, covariance);
                all.extend(z.concat());
                continue;
            }
            let of = |method| {
                plain::beamform::beamform(
                    &x,
                    &active,
                    &Parameters {
                        method,
                        ..parameters
                    },
                    covariance,
                )
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

/// The references of coherence are in f64: `coherence.rs`.
impl Plain for coherence::Shares {
    const PLANS: u64 = 1000;
}

impl Plain for coherence::ShortLag {
    const PLANS: u64 = 1000;
}

impl Plain for scan::Apertures {
    const PLANS: u64 = 4000;
}
