//! Measures on the image of a point scatterer (the paper's Fig. 2d).

use crate::{Error, Result};
use bonebeam_files::BeamformedLines;
use ndarray::{ArrayBase, Data, Ix2};
use num_complex::Complex;

use super::profile::{Profile, largest, side_lobe, width};

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
        let brightest = largest(&beams[peak]).unwrap_or(0);
        let sample = brightest as f64 + around(&beams[peak], brightest);
        let along = 0.5 * lines.c * (lines.t0 + sample / lines.fs);
        Ok(LateralProfile {
            x: (0..maxima.len())
                .map(|beam| lines.point(beam, along)[0])
                .collect(),
            level: re(&maxima, maxima[peak]),
            peak,
            peak_depth: lines.point(peak, along)[1],
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
        side_lobe(&self.level, self.peak)
    }

    /// Largest level farther than `distance` m from the peak, dB; `None` without beams.
    pub fn level_beyond(&self, distance: f64) -> Option<f64> {
        let far = |x: f64| (x - self.x[self.peak]).abs() > distance;
        let levels = self.x.iter().zip(&self.level).filter(|(x, _)| far(**x));
        levels.map(|(_, level)| *level).reduce(f64::max)
    }
}

/// Profiles through the largest envelope, across the lines and along its line.
///
/// [`LateralProfile`] takes the largest envelope over depth instead, as the paper's figure does: it is wider where the
/// echo is curved.
#[derive(Clone, Debug, PartialEq)]
pub struct PointSpread {
    /// Lateral position of the largest envelope, m.
    pub x: f64,
    /// Its depth, m.
    pub z: f64,
    /// The largest envelope.
    pub envelope: f64,
    /// The envelopes of the lines at the sample of the largest.
    ///
    /// Positions of rays are along an arc.
    pub lateral: Profile,
    /// The envelope of its line, over depth along the line.
    pub axial: Profile,
}

impl PointSpread {
    /// Profiles through the largest envelope of all, or of those near a place.
    ///
    /// `near` is (x, z) in m. The envelope is within `reach` m of it to either side and in depth; `reach` also bounds both
    /// profiles.
    ///
    /// # Errors
    /// No sample there, or every sample is 0.
    pub fn new<S: Data<Elem = Complex<f32>>>(
        lines: &BeamformedLines<ArrayBase<S, Ix2>>,
        near: Option<[f64; 2]>,
        reach: f64,
    ) -> Result<Self> {
        let depth = |sample: usize| 0.5 * lines.c * (lines.t0 + sample as f64 / lines.fs);
        let envelope = |beam: usize, sample: usize| {
            let z = lines.z[[beam, sample]];
            f64::from(z.re).hypot(f64::from(z.im))
        };
        let within = |[x, z]: [f64; 2]| {
            near.is_none_or(|[x0, z0]| (x - x0).abs() <= reach && (z - z0).abs() <= reach)
        };
        let mut best = (0.0, 0, 0);
        for ((beam, sample), _) in lines.z.indexed_iter() {
            let value = envelope(beam, sample);
            if value > best.0 && within(lines.point(beam, depth(sample))) {
                best = (value, beam, sample);
            }
        }
        let (largest, beam, sample) = best;
        if largest == 0.0 {
            let there = near.map_or(String::new(), |[x, z]| {
                let reach = 1e3 * reach;
                format!(" within {reach} mm of x = {x} m, z = {z} m")
            });
            return Err(Error::Data(format!(
                "no sample of the lines{there} is above 0"
            )));
        }
        let (beams, samples) = lines.z.dim();
        let places: Vec<[f64; 2]> = (0..beams).map(|k| lines.point(k, depth(sample))).collect();
        let steps = places
            .windows(2)
            .map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]));
        let across: Vec<f64> = std::iter::once(0.0)
            .chain(steps.scan(0.0, |sum, step| {
                *sum += step;
                Some(*sum)
            }))
            .collect();
        let profile = |at: Vec<f64>, values: Vec<f64>, peak: usize| {
            let near = |k: &usize| (at[*k] - at[peak]).abs() <= reach;
            let range: Vec<usize> = (0..at.len()).filter(near).collect();
            Profile {
                peak: peak - range[0],
                at: range.iter().map(|&k| at[k]).collect(),
                level: re(
                    &range.iter().map(|&k| values[k]).collect::<Vec<_>>(),
                    largest,
                ),
            }
        };
        let row = (0..beams).map(|k| envelope(k, sample)).collect();
        let column: Vec<f64> = (0..samples).map(|k| envelope(beam, k)).collect();
        let [x, z] = lines.point(
            beam,
            depth(sample) + 0.5 * lines.c / lines.fs * around(&column, sample),
        );
        Ok(PointSpread {
            x,
            z,
            envelope: largest,
            lateral: profile(across, row, beam),
            axial: profile((0..samples).map(depth).collect(), column, sample),
        })
    }
}

/// Values in decibels relative to `reference`.
fn re(values: &[f64], reference: f64) -> Vec<f64> {
    let decibels = |v: &f64| (20.0 * (v / reference).log10()).max(FLOOR_DB);
    values.iter().map(decibels).collect()
}

/// Offset of the vertex of the parabola through index `k` and its neighbours; 0 at an end.
fn around(values: &[f64], k: usize) -> f64 {
    let beside = k.checked_sub(1).zip(values.get(k + 1));
    let Some((before, &c)) = beside else {
        return 0.0;
    };
    let (a, b) = (values[before], values[k]);
    let curvature = a - 2.0 * b + c;
    match curvature < 0.0 {
        true => 0.5 * (a - c) / curvature,
        false => 0.0,
    }
}
