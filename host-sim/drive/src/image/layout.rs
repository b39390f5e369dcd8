//! Layout of the lines' beams: evenly spaced, a fan, or any other.

use bonebeam::geometry::Axis;
use bonebeam::image::Fan;
use ndarray::{ArrayBase, Data, Ix2};
use num_complex::Complex;

use bonebeam_files::{BeamRays, BeamformedLines};

use super::lattice::{Lattice, sample_axis};
use crate::{Error, Result};

/// Layout of an image's beams.
pub(crate) enum Layout {
    /// Straight down, evenly spaced.
    Even(Axis),
    /// From one position, at even angles.
    Fan { fan: Fan, angles: Axis },
    /// Any other beams from left to right.
    Any(Lattice),
}

pub(crate) fn layout<S: Data<Elem = Complex<f32>>>(
    lines: &BeamformedLines<ArrayBase<S, Ix2>>,
) -> Result<Layout> {
    let found = match &lines.rays {
        None => beam_axis(&lines.beam_x).map(Layout::Even),
        Some(rays) => fan(lines, rays),
    };
    found.map_or_else(|| Lattice::new(lines).map(Layout::Any), Ok)
}

/// Extent of the lines, across and down, m.
pub fn extent<S: Data<Elem = Complex<f32>>>(
    lines: &BeamformedLines<ArrayBase<S, Ix2>>,
) -> [[f64; 2]; 2] {
    let samples = sample_axis(lines);
    let mut extent = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
    for beam in 0..lines.beam_x.len() {
        for r in [samples.first, samples.last()] {
            for (range, at) in extent.iter_mut().zip(lines.point(beam, r)) {
                *range = [range[0].min(at), range[1].max(at)];
            }
        }
    }
    extent
}

/// The fan of beams at even angles from one position; `None` for others.
///
/// Angles must be even to a hundredth of a step. Beams must begin on the arc through the first and the last, to a
/// hundredth of their distance.
fn fan<S: Data<Elem = Complex<f32>>>(
    lines: &BeamformedLines<ArrayBase<S, Ix2>>,
    rays: &BeamRays,
) -> Option<Layout> {
    let last = lines.beam_x.len() - 1;
    let (first_angle, last_angle) = (rays.angle[0], rays.angle[last]);
    let step = (last_angle - first_angle) / last.max(1) as f64;
    if step.is_nan() || step <= 0.0 {
        return None;
    }
    let radius = (lines.beam_x[last] - lines.beam_x[0]) / (last_angle.sin() - first_angle.sin());
    let x = lines.beam_x[0] - radius * first_angle.sin();
    let z = rays.z[0] - radius * first_angle.cos();
    // A sector's radius is 0 but for rounding.
    let deepest = sample_axis(lines).last();
    let tolerance = 0.01 * step * (radius.abs() + deepest);
    if radius < -tolerance {
        return None;
    }
    for beam in 0..=last {
        let even = first_angle + beam as f64 * step;
        let angle = rays.angle[beam];
        let beside = (lines.beam_x[beam] - x - radius * angle.sin())
            .hypot(rays.z[beam] - z - radius * angle.cos());
        if (angle - even).abs() > 0.01 * step || beside > tolerance {
            return None;
        }
    }
    Some(Layout::Fan {
        fan: Fan {
            x,
            z,
            radius: radius.max(0.0),
        },
        angles: Axis::new(first_angle, step, last + 1),
    })
}

/// The axis of evenly spaced beams; `None` for others.
///
/// Positions must be on the grid through the first and the last, to a hundredth of the spacing.
fn beam_axis(beam_x: &[f64]) -> Option<Axis> {
    let (&[first, .., last], intervals) = (beam_x, beam_x.len().saturating_sub(1)) else {
        return None;
    };
    let step = (last - first) / intervals as f64;
    let is_even = |(beam, &x): (usize, &f64)| (x - first - beam as f64 * step).abs() <= 0.01 * step;
    let even = step.is_finite() && step > 0.0 && beam_x.iter().enumerate().all(is_even);
    even.then_some(Axis::new(first, step, beam_x.len()))
}

/// Checks before a long computation that lines at these positions make an image.
///
/// # Errors
/// As [`b_mode`](super::b_mode), on the beams.
pub fn check_beams(beam_x: &[f64]) -> Result<()> {
    if beam_x.len() < 2 {
        return Err(Error::Data(format!(
            "an image needs at least 2 beams; the lines have {}",
            beam_x.len()
        )));
    }
    match beam_x
        .windows(2)
        .position(|pair| pair[0].partial_cmp(&pair[1]) != Some(std::cmp::Ordering::Less))
    {
        None => Ok(()),
        Some(beam) => Err(Error::Data(format!(
            "an image needs beams from left to right; beam {beam} is at {} m, the next one at {} m",
            beam_x[beam],
            beam_x[beam + 1]
        ))),
    }
}
