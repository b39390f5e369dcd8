//! Sub-lines of a recording's lines: their default number, and their output.

use bonebeam::geometry::{Lines, Ray};
use bonebeam::image::{self, DepthInterpolation};
use ndarray::{ArrayView2, ArrayViewMut2, Axis};
use num_complex::Complex;
use rayon::prelude::*;

use crate::Result;
use crate::beams::{Beams, array_of, elements_of};
use crate::config::Beamform;
use crate::limits::depths_of;
use crate::methods::MethodName;
use bonebeam_files::{ChannelData, Transmits};

/// Loss of a point between two sub-lines that sets their number, dB.
///
/// The loss of the transmits adds to it.
const LOSS: f64 = 2.0;
/// Numbers of sub-lines to choose from; DAS alone may take the first.
const COUNTS: [usize; 5] = [2, 4, 8, 16, 32];
/// Largest ratio of an echo's power to the noise in its covariance.
///
/// It is that of channel data with 40 dB.
const CLEAN: f64 = 1e4;

/// Largest distance between output lines, m, or as a share of their depth where that is more.
///
/// A parabola through three pooled lines errs by up to a fifth of it.
const SPACING: f64 = 0.1e-3;
const SHARE: f64 = 1.0 / 400.0;

/// The aligned lines, their sub-lines, and the output lines.
pub(crate) struct SubLines {
    /// Sub-lines of each aligned line.
    pub(crate) count: usize,
    /// Sub-lines of an output line; `None` if each sub-line is output.
    pooled: Option<usize>,
    /// The output lines.
    pub(crate) rays: Vec<Ray>,
    /// Approximate largest loss of a point between two lines and their sub-lines, dB; `None` for DAS of all depths.
    pub(crate) loss: Option<f64>,
}

impl SubLines {
    /// The sub-lines of `beams` that the parameters ask for.
    pub(crate) fn new(data: &ChannelData, beams: &Beams, parameters: &Beamform) -> Self {
        let loss = |count: usize| loss(data, &beams.rays, parameters, count);
        let adaptive = parameters.method != MethodName::Das;
        let chosen = || {
            let mut counts = COUNTS.into_iter().skip(usize::from(adaptive));
            let enough = counts.find(|&count| loss(count) <= LOSS);
            enough.unwrap_or(COUNTS[COUNTS.len() - 1])
        };
        let lines = Lines::Rays(&beams.rays);
        let divided = |parts: usize| {
            let of_line = |line| (0..parts).map(move |k| lines.sub_line(line, k, parts));
            (0..beams.rays.len()).flat_map(of_line).collect()
        };
        let (count, pooled, rays) = match parameters.sub_lines {
            None if beams.divided => {
                let count = chosen();
                let parts = parts(data, &beams.rays, parameters, count);
                (count, Some(count / parts), divided(parts))
            }
            None if adaptive => {
                let count = chosen();
                (count, Some(count), beams.rays.clone())
            }
            None | Some(1) => (1, None, beams.rays.clone()),
            Some(count) => (count, None, divided(count)),
        };
        SubLines {
            count,
            pooled,
            rays,
            loss: (adaptive || count > 1)
                .then(|| loss(count) + transmit_loss(data, beams, parameters)),
        }
    }

    /// Number of consecutive sub-lines that are beams of an output line; 1 if pooled.
    pub(crate) fn put_out(&self) -> usize {
        match self.pooled {
            Some(_) => 1,
            None => self.count,
        }
    }

    /// Number of sub-lines pooled into each output line; `None` if each is output.
    pub(crate) fn pooled(&self) -> Option<usize> {
        self.pooled
    }

    /// The output lines, `[line, sample]`: at each sample the largest sub-line.
    ///
    /// `all` is [sub-line, computed sample]. The largest is by magnitude; of equal ones, the first.
    ///
    /// # Errors
    /// A sample that is not finite.
    pub(crate) fn pool(
        &self,
        all: ArrayView2<'_, Complex<f32>>,
        interpolation: &DepthInterpolation,
        mut z: ArrayViewMut2<'_, Complex<f32>>,
    ) -> Result<()> {
        let size = self.pooled.unwrap_or(1);
        let lines: Vec<_> = z.rows_mut().into_iter().enumerate().collect();
        lines.into_par_iter().try_for_each(|(line, mut z)| {
            let mut levels = [vec![0.0; z.len()], vec![0.0; z.len()]];
            let mut scratch = vec![Complex::ZERO; interpolation.need(1).complex];
            let mut interpolated = vec![Complex::ZERO; z.len()];
            let own = all.axis_iter(Axis(0)).skip(line * size).take(size);
            for (k, computed) in own.enumerate() {
                let [largest, level] = &mut levels;
                let computed = computed.to_slice().expect("a row of an array in order");
                let own = match interpolation.depth_step() {
                    1 => computed,
                    _ => {
                        interpolation.line(computed, &mut scratch, &mut interpolated)?;
                        &interpolated
                    }
                };
                image::envelope(own, level)?;
                let so_far = z.iter_mut().zip(largest).zip(&*level);
                for (((z, largest), &level), &value) in so_far.zip(own) {
                    if k == 0 || level > *largest {
                        (*z, *largest) = (value, level);
                    }
                }
            }
            Ok(())
        })
    }
}

/// Numbers of aligned lines of a recording, and of sub-lines of each.
///
/// # Errors
/// As [`Beams::new`].
pub(crate) fn count(data: &ChannelData, parameters: &Beamform) -> Result<(usize, usize)> {
    let elements = elements_of(data);
    let beams = Beams::new(data, &array_of(data, &elements), parameters)?;
    let sub_lines = SubLines::new(data, &beams, parameters);
    Ok((beams.rays.len(), sub_lines.count))
}

/// Largest distance between neighbouring lines at a depth, m.
fn widest(rays: &[Ray], depth: f64) -> f64 {
    let distance = |pair: &[Ray]| {
        let [[ax, az], [bx, bz]] = [pair[0].point(depth), pair[1].point(depth)];
        (bx - ax).hypot(bz - az)
    };
    rays.windows(2).map(distance).fold(0.0, f64::max)
}

/// Number of output lines of an aligned line with `most` sub-lines: a power of two.
fn parts(data: &ChannelData, rays: &[Ray], parameters: &Beamform, most: usize) -> usize {
    // The distance grows evenly with depth, the limit from here on.
    let [first, last] = depths_of(data, parameters);
    let depths = [first, last, SPACING / SHARE].into_iter();
    let needed = depths.map(|depth| widest(rays, depth) / (SHARE * depth).max(SPACING));
    let needed = needed.fold(1.0, f64::max).ceil() as usize;
    needed.next_power_of_two().min(most)
}

/// Approximate largest loss of transmits that are compounded on lines, half way between two of these, dB.
///
/// Sub-lines turn what is received; the transmit delays stay those of the line. It is `20·lg |mean e^{jkΔ}|` over the
/// transmits, with the difference `Δ` of their paths to the line and to the point beside it, in the array's middle.
fn transmit_loss(data: &ChannelData, beams: &Beams, parameters: &Beamform) -> f64 {
    if beams.own {
        return 0.0;
    }
    let wave = std::f64::consts::TAU * data.f0 / parameters.sound_speed.unwrap_or(data.c);
    let ray = beams.rays[beams.rays.len() / 2];
    let [first, last] = depths_of(data, parameters);
    let at = |depth: f64| {
        let [x, z] = ray.point(depth);
        let beside = widest(&beams.rays, depth) / 2.0;
        let to = [
            x + beside * ray.angle().cos(),
            z - beside * ray.angle().sin(),
        ];
        let further = |source: [f64; 2]| {
            let path = |[x, z]: [f64; 2]| (x - source[0]).hypot(z - source[1]);
            path(to) - path([x, z])
        };
        let differences: Vec<f64> = match &data.transmits {
            Transmits::Plane { angle } => angle
                .iter()
                .map(|angle| (to[0] - x) * angle.sin() + (to[1] - z) * angle.cos())
                .collect(),
            Transmits::Element { index } => {
                index.iter().map(|&m| further(data.element(m))).collect()
            }
            Transmits::VirtualSource { x, z } => {
                x.iter().zip(z).map(|(&x, &z)| further([x, z])).collect()
            }
            Transmits::Focused { .. } | Transmits::Delays { .. } => return 0.0,
        };
        let sum: Complex<f64> = differences
            .iter()
            .map(|d| Complex::from_polar(1.0, wave * d))
            .sum();
        -20.0 * (sum.norm() / differences.len() as f64).max(0.1).log10()
    };
    let depths = [first, (first + last) / 2.0, last].into_iter();
    depths
        .filter(|&depth| depth > 0.0)
        .map(at)
        .fold(0.0, f64::max)
}

/// Approximate largest loss between two sub-lines of `count` per line, dB.
///
/// It is that of a single wave half way between them, at the depths where the receive apertures begin, end, and are
/// full.
///
/// With the phase `ψ` of the echo over a subaperture of `L` elements, and `ρ` times as much power as noise in an
/// element of its covariance, which is loaded by `Δ`, minimum variance loses `1 + L·ρ·ψ²/12`: the inverse of `ψ`
/// weighs as `1 − ψ²/12` in its covariance. DAS loses the inverse of `sin(ψ/2)/(ψ/2)` over all active elements.
fn loss(data: &ChannelData, rays: &[Ray], parameters: &Beamform, count: usize) -> f64 {
    let c = parameters.sound_speed.unwrap_or(data.c);
    let [first, last] = depths_of(data, parameters);
    let elements = data.element_x.len() as f64;
    let pitch = data.pitch();
    let (f_number, least) = (parameters.f_number, parameters.min_elements as f64);
    let full = (f_number * elements * pitch).clamp(first, last.max(first));
    let loading = f64::from(parameters.diagonal_loading as f32);
    let power = 1.0 / (loading + 1.0 / CLEAN);
    let at = |depth: f64| {
        let active = (depth / (f_number * pitch)).clamp(least.min(elements), elements);
        let subaperture = parameters.subaperture_ratio * active;
        // The path from a point to an element `x` beside it grows by `δ·x/z`, and near the array by less.
        let beside = widest(rays, depth) / (2 * count) as f64;
        let slope = beside * pitch / depth.hypot(active * pitch / 2.0);
        let phase = |elements: f64| std::f64::consts::TAU * data.f0 / c * slope * elements;
        if parameters.method == MethodName::Das {
            let half = phase(active) / 2.0;
            let level = if half > 0.0 { half.sin() / half } else { 1.0 };
            return -20.0 * level.max(0.1).log10();
        }
        let phase = phase(subaperture);
        20.0 * (1.0 + subaperture * power * phase * phase / 12.0).log10()
    };
    let depths = [first, full, (first + last) / 2.0, last];
    let depths = depths.into_iter().filter(|&depth| depth > 0.0);
    depths.map(at).fold(0.0, f64::max)
}
