//! The scenes: random vertebrae under layers of tissue, clean and disturbed.

use crate::experiments::study::*;
use bonebeam::surface;
use rayon::prelude::*;

use super::super::common::drawn_bone::DrawnBone;
use super::super::surface::disturb::{Condition, Disturbances};
use super::super::surface::phantom;
use bonebeam_drive::coherence::of_first_frame;
use bonebeam_drive::config::{Beamform, Surface};
use bonebeam_drive::frame::beamform_channel_data;
use bonebeam_drive::surface::of_lines_with_coherence;

/// Conditions of the scenes.
pub const CONDITIONS: [Condition; 5] = [
    Condition::Clean,
    Condition::Aberration,
    Condition::Clutter,
    Condition::Noise,
    Condition::Together,
];
/// Length at the end of the lines in which the detector seeks no bone, m.
const END: f64 = 6e-3;

/// Parameters of the scenes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scenes {
    /// Array, pulse, transmit, noise.
    pub scanner: Settings,
    /// Thickness of the slab, m.
    pub thickness: f64,
    /// Scatterers per m³.
    pub density: f64,
    /// Strength of the disturbances.
    pub disturbances: Disturbances,
}

/// A bone's recordings.
pub struct Recorded {
    conditions: Vec<(Condition, ChannelData)>,
    bone: Outline,
}

/// Lines of a bone in a condition.
pub struct Frame {
    /// Condition of the scene.
    pub condition: Condition,
    lines: BeamformedLines,
    /// Coherence of the samples, [line, sample].
    coherence: Array2<f32>,
    /// The depth at which each line meets the bone, m.
    surface: Vec<Option<f64>>,
}

/// Result of a detector for a bone in a condition.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Found {
    pub condition: Condition,
    pub judged: Judged,
}

impl Scenes {
    /// Records a bone; its number is the seed of all random values.
    pub fn record(&self, context: &Context<'_>, number: u64, what: &str) -> Result<Recorded> {
        let drawn = DrawnBone::of(number);
        let settings = Settings {
            seed: number,
            ..self.scanner.clone()
        };
        let phantom = phantom(
            Some(&drawn.bone()),
            drawn.depth,
            [self.thickness, self.density],
            &settings,
        )?;
        let recorded = recording(context, ["tune", what], &settings, &phantom)?;
        let disturbed = self.disturbances.of(&settings, &recorded)?;
        let under = |condition| Ok((condition, disturbed.under(condition)?));
        let conditions = CONDITIONS.into_iter().map(under).collect::<Result<_>>()?;
        let none = || Error::Data("the image plane misses the bone".into());
        Ok(Recorded {
            conditions,
            bone: phantom.bone.ok_or_else(none)?,
        })
    }
}

impl Recorded {
    /// The lines in every condition, and the bone within the searched depths.
    pub fn frames(&self, beamform: &Beamform, searched: &Surface) -> Result<Vec<Frame>> {
        let frame = |(condition, data): &(Condition, ChannelData)| {
            let lines = beamform_channel_data(data, beamform, &|_| ())?;
            let end = lines.c / 2.0 * (lines.t0 + (lines.z.ncols() as f64 - 1.0) / lines.fs) - END;
            let start = searched
                .search_start
                .unwrap_or(surface::Settings::DEFAULT.depths[0]);
            let depths = start..=searched.search_end.unwrap_or(end);
            let hit = |x: &f64| self.bone.first_hit(*x).filter(|z| depths.contains(z));
            let surface = lines.beam_x.iter().map(hit).collect();
            Ok(Frame {
                condition: *condition,
                lines,
                coherence: of_first_frame(data, beamform)?,
                surface,
            })
        };
        self.conditions.iter().map(frame).collect()
    }
}

impl Frame {
    fn found(&self, surface: &Surface) -> Result<Found> {
        let mut answers = vec![None; self.surface.len()];
        for point in of_lines_with_coherence(&self.lines, self.coherence.view(), surface)? {
            answers[point.line] = Some(point.z);
        }
        let known = Known {
            x: &self.lines.beam_x,
            depths: &self.surface,
        };
        Ok(Found {
            condition: self.condition,
            judged: judge(&answers, known, TOLERANCE),
        })
    }
}

/// Runs a detector on frames.
pub fn found(frames: &[Frame], surface: &Surface) -> Result<Vec<Found>> {
    frames.par_iter().map(|f| f.found(surface)).collect()
}

/// The score: the mean of F1 over frames.
///
/// F1 is 0 in a frame without answers and without bone.
pub fn score<'a>(found: impl IntoIterator<Item = &'a Found>) -> f64 {
    let all: Vec<f64> = found
        .into_iter()
        .map(|found| found.judged.f1().unwrap_or(0.0))
        .collect();
    all.iter().sum::<f64>() / all.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_complex::Complex;

    /// Lines of tissue over a shadow, with bone at the depth of each line.
    fn frame(bone: impl Fn(usize) -> Option<f64>, known: impl Fn(usize) -> Option<f64>) -> Frame {
        let (count, samples, step) = (48, 1000, 0.0385e-3);
        let z = Array2::from_shape_fn((count, samples), |(line, n)| {
            let depth = n as f64 * step;
            let off = bone(line).map_or(-1.0, |bone| depth - bone);
            let level = match off {
                off if off.abs() < 0.2e-3 => 1.0,
                off if off > 0.0 => 1e-4,
                _ => 0.03,
            };
            Complex::new(level, 0.0)
        });
        Frame {
            condition: Condition::Clean,
            coherence: Array2::from_elem(z.dim(), 0.12),
            lines: {
                let x = (0..count).map(|k| 0.3e-3 * k as f64);
                BeamformedLines::straight(z, x.collect(), [1540.0 / (2.0 * step), 0.0, 1540.0])
            },
            surface: (0..count).map(known).collect(),
        }
    }

    /// Scores of known frames.
    ///
    /// Bone found on all lines: 1. Bone found where there is none, or missed: 0. Bone found on half of its lines: recall
    /// ½, precision 1, F1 ⅔.
    #[test]
    fn the_score_of_known_frames_is_known() {
        let depth = |_| Some(15e-3);
        let half = |line: usize| (line < 24).then_some(15e-3);
        let frames = [
            frame(depth, depth),
            frame(depth, |_| Some(25e-3)),
            frame(half, depth),
        ];
        let scores: Vec<f64> = frames
            .iter()
            .map(|f| score(&[f.found(&Surface::default()).unwrap()]))
            .collect();
        assert_eq!(scores[0], 1.0);
        assert_eq!(scores[1], 0.0);
        assert!((scores[2] - 2.0 / 3.0).abs() < 0.02, "{scores:?}");
        let all = found(&frames, &Surface::default()).unwrap();
        assert!((score(&all) - scores.iter().sum::<f64>() / 3.0).abs() < 1e-12);
    }
}
