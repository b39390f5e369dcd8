//! The kernels of the catalogue, each by the reference in f32.

use bonebeam::beamform::Parameters;
use bonebeam::prelude::stages::*;
use bonebeam_tests::kernel::Kernel;
use bonebeam_tests::kernels::delay::Input;
use bonebeam_tests::kernels::{
    beamform, coherence, delay, depth_interpolation, frame, image, phase_symmetry, pipeline, scan,
    surface, upsampled,
};

use super::f32 as plain;

/// A kernel that may have a reference in f32.
pub trait Plain: Kernel {
    /// The result in plain loops; `None` where the reference has no such choice.
    fn plain(&self) -> Option<Vec<Self::Number>> {
        None
    }
}

impl Plain for delay::Lines {
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
    fn plain(&self) -> Option<Vec<Complex<f32>>> {
        let lines: Vec<_> = self.lines().collect();
        let mut out = vec![Complex::new(7.0, 7.0); self.numbers()];
        plain::delay::upsampled(self.delay.parameters(), &lines, &mut out);
        Some(out)
    }
}

/// Within the adaptive samples the method, elsewhere DAS.
impl Plain for beamform::Lines {
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
                let parameters = Parameters {
                    method,
                    ..parameters
                };
                plain::beamform::beamform(&x, &active, &parameters)
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
    fn plain(&self) -> Option<Vec<f32>> {
        let p = self.stage.parameters();
        if self.fan.is_some() || p.logarithm == Logarithm::Polynomial {
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
impl Plain for pipeline::Line {}

impl Plain for frame::Frame {}

/// The reference of shares is in f64: `coherence.rs`.
impl<const SHARES: bool> Plain for coherence::Coherence<SHARES> {}

impl Plain for coherence::Speeds {}

impl Plain for scan::Apertures {}
