//! The bone surface of a frame of grey levels.

use std::vec::Vec;

use bonebeam::prelude::stages::*;
use bonebeam::surface::{Parameters, Point, Settings, Survey, Tracker, grey};

use crate::draw::Draw;
use crate::kernel::{Kernel, Number};

/// A frame of grey levels.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The parameters of the detector.
    pub parameters: Parameters,
    /// Number of lines.
    pub lines: usize,
    /// Grey levels `[line][sample]`.
    pub grey: Vec<u8>,
    /// The coherence of each sample, if it is used.
    pub coherence: Option<Vec<u8>>,
}

/// Settings of all kinds, near the usual ones unless `wild`.
pub fn settings(draw: &mut impl Draw, wild: bool) -> Settings {
    let mut settings = draw.one_of(&[Settings::DEFAULT, Settings::COHERENCE, Settings::LEARNT]);
    let mut at = |usual| draw.number(wild, usual);
    let far = at([1e-2, 4e-2]);
    settings.depths = [
        at([0.0, 2e-3]),
        if far > 2e-2 { f64::INFINITY } else { far },
    ];
    settings.cell = at([0.01e-3, 0.3e-3]);
    settings.absence = at([-6.0, 1.0]);
    settings.end = at([0.0, 6.0]);
    settings.jump = at([0.0, 20.0]);
    settings.step = at([0.0, 5e-3]);
    settings.piece = at([0.0, 1.0]) as f32;
    settings.slope = at([0.0, 1e4]);
    settings.margin = at([0.0, 1.0]);
    settings.onset_weight = at([0.0, 2.0]);
    settings.rest_from = at([0.0, 3e-3]);
    settings.rest_block = at([0.0, 2e-3]);
    settings.near = [0.2e-3, at([0.3e-3, 2e-3])];
    settings.above = [0.1e-3, at([0.2e-3, 6e-3])];
    let Settings {
        contrast,
        level,
        rest,
        shadow,
        coherence,
        ..
    } = &mut settings;
    for ramp in [contrast, level, rest, shadow, coherence] {
        ramp.weight = at([-3.0, 3.0]);
        ramp.centre += at([-0.1, 0.1]);
        ramp.width *= at([0.7, 2.0]);
    }
    settings
}

/// A point of a line, or none.
impl Number for Option<Point> {
    const DIRT: Self = None;

    fn bits(self) -> Option<[u32; 2]> {
        let Some(point) = self else {
            return Some([0; 2]);
        };
        let sign = u32::from(point.begins) << 31;
        let valid = point.depth.is_finite() && (0.0..=1.0).contains(&point.confidence);
        valid.then(|| [point.depth.to_bits(), point.confidence.to_bits() | sign])
    }
}

impl Kernel for Frame {
    type Number = Option<Point>;

    fn draw(draw: &mut impl Draw) -> Result<Self, Error> {
        let wild = draw.once_in(8);
        let (lines, count) = (draw.size(12, 40), draw.size(400, 2000));
        let mut at = |usual| draw.number(wild, usual);
        let samples = Axis::new(at([-1e-3, 3e-3]), at([0.02e-3, 0.2e-3]), count);
        let spacing = at([0.05e-3, 0.6e-3]);
        let settings = settings(draw, wild);
        let latency = draw.below(lines);
        let parameters = Parameters {
            samples,
            spacing,
            settings,
            latency,
        };
        Detector::new(parameters)?;
        let bones: Vec<_> = (0..lines)
            .map(|line| (draw.byte() > 32).then(|| count / 4 + 3 * line + draw.below(6)))
            .collect();
        let any = draw.flag();
        let coherent = draw.flag();
        let numbers = draw.samples(lines * count);
        let mut levels = std::vec![0; lines * count];
        grey(&numbers, &mut levels)?;
        if !any {
            for (n, level) in levels.iter_mut().enumerate() {
                let (sample, bone) = (n % count, bones[n / count].unwrap_or(count));
                let speckle = (numbers[n].to_bits() >> 16) as u8 % 60;
                *level = match sample {
                    _ if sample > bone + 8 => speckle / 6,
                    _ if sample >= bone => 180 + speckle,
                    _ => 90 + speckle,
                };
            }
        }
        let coherence = coherent.then(|| levels.iter().map(|level| level / 2).collect());
        Ok(Frame {
            parameters,
            lines,
            grey: levels,
            coherence,
        })
    }

    fn need(&self, _: usize, _: usize) -> [Need; 2] {
        let need = self.parameters.need();
        [need.unwrap_or_default(), Need::default()]
    }

    fn numbers(&self) -> usize {
        self.lines
    }

    fn run<V: Vector>(
        &self,
        _: V,
        way: usize,
        (mut scratch, _): (Scratch<'_>, Scratch<'_, V>),
        out: &mut [Option<Point>],
    ) -> Result<(), Error> {
        let detector = Detector::new(self.parameters)?;
        match (way, &self.coherence) {
            (0, None) => detector.frame(&self.grey, scratch, out)?,
            (0, Some(coherence)) => {
                detector.frame_with_coherence(&self.grey, coherence, scratch, out)?
            }
            (_, coherence) => {
                // The lines one by one.
                let count = self.parameters.samples.count;
                let mut survey = Survey::new(&detector, scratch.reborrow())?;
                for line in self.grey.chunks(count).step_by(Survey::EVERY) {
                    survey.line(line)?;
                }
                let levels = survey.levels();
                let mut tracker = Tracker::new(&detector, scratch)?;
                let mut points = Vec::new();
                for (line, grey) in self.grey.chunks(count).enumerate() {
                    points.extend(match coherence {
                        None => tracker.line(grey, levels)?,
                        Some(coherence) => tracker.line_with_coherence(
                            grey,
                            &coherence[line * count..][..count],
                            levels,
                        )?,
                    });
                }
                tracker.finish(|point| points.push(point));
                assert_eq!(points.len(), self.lines);
                out.copy_from_slice(&points);
                detector.keep_sure_pieces(out);
            }
        }
        let Axis { first, step, .. } = self.parameters.samples;
        let last = self.parameters.samples.last();
        let rounded = 1e-6 * (first.abs() + last.abs());
        let inside = first - step - rounded..=last + step + rounded;
        assert!(
            out.iter()
                .flatten()
                .all(|point| inside.contains(&f64::from(point.depth))),
            "a depth beyond the samples"
        );
        Ok(())
    }

    fn ways(&self) -> Vec<usize> {
        std::vec![1]
    }
}
