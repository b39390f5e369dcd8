//! Measures on the image of a point scatterer (the paper's Fig. 2d).

use crate::{Error, Result};
use bonebeam_files::BeamformedLines;

use super::profile::{largest, width};

/// Level given to a beam whose envelope is zero, dB.
const FLOOR_DB: f64 = -300.0;

/// The lateral profile: the largest envelope over depth for every beam.
///
/// It is in decibels relative to the largest of all.
#[derive(Clone, Debug, PartialEq)]
pub struct LateralProfile {
    /// Lateral positions of the beams, m, ascending.
    ///
    /// Of rays at the distance of the peak.
    pub x: Vec<f64>,
    /// Levels, dB, at most 0.
    pub level: Vec<f64>,
    /// The largest envelope of each beam.
    pub maxima: Vec<f64>,
    /// Index of the beam with the largest envelope.
    pub peak: usize,
    /// Depth of the largest envelope, m, by a parabola through three samples.
    pub peak_depth: f64,
}

impl LateralProfile {
    /// The profile of beamformed lines. It is an error if every sample is 0.
    pub fn new(lines: &BeamformedLines) -> Result<Self> {
        let envelope = lines.z.mapv(|z| f64::from(z.re).hypot(f64::from(z.im)));
        let beams: Vec<Vec<f64>> = envelope
            .rows()
            .into_iter()
            .map(|row| row.to_vec())
            .collect();
        let maxima: Vec<f64> = beams
            .iter()
            .map(|row| largest(row).map_or(0.0, |k| row[k]))
            .collect();
        let peak = largest(&maxima)
            .filter(|&k| maxima[k] > 0.0)
            .ok_or_else(|| Error::Data("lateral profile: every sample of the lines is 0".into()))?;
        let sample = largest(&beams[peak]).unwrap_or(0) as f64 + vertex(&beams[peak]);
        let along = 0.5 * lines.c * (lines.t0 + sample / lines.fs);
        let (x, peak_depth) = match &lines.rays {
            None => (lines.beam_x.clone(), along),
            Some(rays) => (
                (lines.beam_x.iter().zip(&rays.angle))
                    .map(|(x, angle)| x + along * angle.sin())
                    .collect(),
                rays.z[peak] + along * rays.angle[peak].cos(),
            ),
        };
        Ok(LateralProfile {
            x,
            level: re(&maxima, maxima[peak]),
            peak,
            peak_depth,
            maxima,
        })
    }

    /// The level of each beam relative to the peak of another profile, dB.
    pub fn re(&self, reference: &LateralProfile) -> Vec<f64> {
        re(&self.maxima, reference.maxima[reference.peak])
    }

    /// Width of the main lobe at `level` dB (−12 in the paper), m.
    ///
    /// Crossings are interpolated linearly in decibels between beams. `None` if the profile does not fall to the
    /// level on both sides.
    pub fn width(&self, level: f64) -> Option<f64> {
        width(&self.x, &self.level, self.peak, level)
    }

    /// Peak side-lobe level, dB: the largest level outside the main lobe.
    ///
    /// The main lobe reaches from the peak to the first local minimum on either side. `None` if the profile has no
    /// minimum.
    pub fn side_lobe(&self) -> Option<f64> {
        let v = &self.level;
        let mut left = self.peak;
        while left > 0 && v[left - 1] < v[left] {
            left -= 1;
        }
        let mut right = self.peak;
        while right + 1 < v.len() && v[right + 1] < v[right] {
            right += 1;
        }
        v[..left]
            .iter()
            .chain(&v[right + 1..])
            .copied()
            .reduce(f64::max)
    }

    /// Largest level farther than `distance` m from the peak, dB; `None` without beams.
    pub fn level_beyond(&self, distance: f64) -> Option<f64> {
        let far = |x: f64| (x - self.x[self.peak]).abs() > distance;
        let levels = self.x.iter().zip(&self.level).filter(|(x, _)| far(**x));
        levels.map(|(_, level)| *level).reduce(f64::max)
    }
}

/// Values in decibels relative to `reference`.
fn re(values: &[f64], reference: f64) -> Vec<f64> {
    let decibels = |v: &f64| (20.0 * (v / reference).log10()).max(FLOOR_DB);
    values.iter().map(decibels).collect()
}

/// Offset of the vertex of a parabola at the largest value, samples.
fn vertex(values: &[f64]) -> f64 {
    match largest(values) {
        Some(k) if k > 0 && k + 1 < values.len() => {
            let (a, b, c) = (values[k - 1], values[k], values[k + 1]);
            let curvature = a - 2.0 * b + c;
            if curvature < 0.0 {
                0.5 * (a - c) / curvature
            } else {
                0.0
            }
        }
        _ => 0.0,
    }
}
