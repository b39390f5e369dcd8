//! The point scatterer of the paper's Fig. 2.

mod figures;
mod measure;

use serde::{Deserialize, Serialize};

use crate::{Error, Result, parameters};
use bonebeam_drive::check::Check;
use bonebeam_drive::config::Image;
use bonebeam_drive::image::PixelGrid;
use bonebeam_files::BeamformedLines;
use bonebeam_simulate::{Phantom, Settings, Summation, channel_data};

use super::common::Receive;
use super::common::lines::beamform_all;
use super::common::pictures::{Pair, Studio};
use super::{Context, Experiment, Outcome};
use measure::{PointResult, measure};

/// Depth of the image shown on either side of the point, m.
const SHOWN: f64 = 1.5e-3;

parameters! {
    /// Section `[point]`.
    Point "point" [simulation, receive, image] {
        /// Array, pulse, transmit. `sampling` sets the beams.
        simulation: Settings = Settings::point();
        /// Delay and beamformer.
        receive: Receive = Receive::of_point() => Receive::validate;
        /// The B-mode image.
        image: Image = Image {
            dynamic_range: 50.0,
            width: Some(5e-3),
            ..Image::default()
        } => Image::validate;
        /// Sets of beams; the images show the last.
        ///
        /// One beam per element as in the paper, at three phases of the beam grid, and beams so close that the sampling no
        /// longer shows.
        sampling: Vec<Sampling> = vec![
            Sampling { beams: 19, step: 1.0, offset: 0.0 },
            Sampling { beams: 19, step: 1.0, offset: 0.25 },
            Sampling { beams: 19, step: 1.0, offset: 0.5 },
            Sampling { beams: 131, step: 0.125, offset: 0.0 },
        ];
    }
}

/// A set of beams over the point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sampling {
    /// Number of beams, centred on element 64 of 128, odd.
    beams: usize,
    /// Distance between neighbouring beams, in pitches.
    step: f64,
    /// Distance of the point to the right of the middle beam, in pitches.
    offset: f64,
}

impl Experiment for Point {
    fn quick() -> Self {
        let mut point = Point::default();
        (point.image.rows, point.image.columns) = (Some(256), Some(256));
        point
    }

    fn validate(&self) -> Result<()> {
        let usage = |message: String| Err(Error::Usage(message));
        if self.sampling.is_empty() {
            return usage("`sampling` in [point] is empty; expected at least one set".into());
        }
        for s in &self.sampling {
            self.settings(s).validate()?;
            if s.beams < 3 || s.beams % 2 == 0 || !s.offset.is_finite() {
                return usage(format!(
                    "`sampling` in [point] has {} beams at an offset of {}; expected an odd number \
                     of at least 3 and a finite offset",
                    s.beams, s.offset
                ));
            }
        }
        Ok(())
    }

    fn run(&self, context: &Context<'_>) -> Result<Outcome> {
        let progress = context.progress;
        let mut samplings = Vec::new();
        let mut checks = Vec::new();
        let mut lines = Vec::new();
        for (index, sampling) in self.sampling.iter().enumerate() {
            let settings = self.settings(sampling);
            let phantom = Phantom::point(&settings, sampling.offset * settings.pitch);
            phantom.check_within(&settings)?;
            let step = format!("point: simulate {}", index + 1);
            let data = channel_data(&settings, &phantom, Summation::Direct, &|done| {
                progress(&step, done);
            })?;
            // One set of beams is enough to check; it is the one that is shown.
            let last = index + 1 == self.sampling.len();
            let extent = context.checking().filter(|_| last);
            let (all, found) = beamform_all("point", &data, &self.receive, extent, progress)?;
            checks.extend(found);
            let [spacing, offset] = [sampling.step, sampling.offset].map(|p| p * settings.pitch);
            samplings.push(measure(spacing, offset, &all)?);
            lines = all;
        }
        progress("point: pictures", 0.0);
        let (pictures, found) = self.pictures(context, &lines)?;
        checks.extend(found);
        let result = PointResult {
            samplings,
            pictures,
        };
        figures::outcome(&result, self.image.dynamic_range, checks)
    }
}

impl Point {
    /// The simulation's settings for one set of beams.
    fn settings(&self, sampling: &Sampling) -> Settings {
        let middle = (self.simulation.elements / 2) as f64;
        Settings {
            beams: sampling.beams,
            beam_step: sampling.step,
            first_beam: middle - (sampling.beams / 2) as f64 * sampling.step,
            ..self.simulation.clone()
        }
    }

    /// Pictures of the point.
    ///
    /// Phase symmetry uses the whole square; the pictures show the paper's 3 mm of depth.
    fn pictures(
        &self,
        context: &Context<'_>,
        lines: &[BeamformedLines],
    ) -> Result<(Vec<Pair>, Vec<Check>)> {
        let Some(first) = lines.first() else {
            return Err(Error::Data("the point has no lines".into()));
        };
        let centre = first.beam_x[first.beam_x.len() / 2];
        let half = self.image.width.unwrap_or(5e-3) / 2.0;
        let across = [centre - half, centre + half];
        let [first, last] = self.receive.depths();
        let [rows, columns] = self.image.sides(2.0 * half, last - first)?;
        let grid = PixelGrid::cover(across, [first, last], rows, columns);
        let row = |depth: f64| ((depth - grid.z0) / grid.pixel).round().max(0.0) as usize;
        let focus = self.simulation.focus;
        let rows = row(focus - SHOWN).min(grid.rows)..(row(focus + SHOWN) + 1).min(grid.rows);
        let studio = Studio {
            what: "point",
            grid,
            image: &self.image,
            phase_symmetry: &context.common.phase_symmetry,
            rows,
            centre,
            references: context.references,
        };
        studio.pictures(lines)
    }
}
