//! The point scatterer of the paper's Fig. 2: images and profiles.
//!
//! Widths and side lobes depend on the point's position between the beams and on the channel SNR.

mod figures;
mod measure;

use serde::{Deserialize, Serialize};

use crate::{Error, Result};
use bonebeam_drive::config::Image;
use bonebeam_drive::image::{PixelGrid, b_mode};
use bonebeam_files::BeamformedLines;
use bonebeam_files::settings::out_of_range;
use bonebeam_simulate::{Phantom, Settings, Summation, add_noise, channel_data};

use super::common::Receive;
use super::common::pictures::picture;
use super::common::variants::{Aligned, Variant};
use super::outcome::View;
use super::{Context, Covers, Experiment, Outcome, Overrides};
use measure::{PhaseResult, PointSpreadResult, ProfileMeasure, SnrResult};

/// Half the shown depth, and half the width, m: the paper's 3 mm × 5 mm.
const SHOWN: [f64; 2] = [1.5e-3, 2.5e-3];
/// Pixels across the images.
const COLUMNS: usize = 500;

/// Section `[point_spread]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PointSpread {
    /// Array, pulse, transmit. `phases` and `reach` set its beams.
    simulation: Settings,
    /// Delay and beamformer.
    receive: Receive,
    /// The B-mode image; its size is the paper's.
    image: Image,
    /// Beams per element: the number of phases of a grid with one beam per element.
    phases: usize,
    /// Elements on either side of the point that have beams.
    reach: usize,
    /// Channel SNRs, dB: the largest sample over the RMS of the noise.
    snr: Vec<f64>,
    /// Number of noise seeds at each SNR.
    seeds: u64,
}

impl Default for PointSpread {
    fn default() -> Self {
        let mut receive = Receive::default();
        receive.0.f_number = 2.5;
        receive.0.depth_start = Some(12.5e-3);
        receive.0.depth_end = Some(17.5e-3);
        PointSpread {
            simulation: Settings::point(),
            receive,
            image: Image {
                dynamic_range: 50.0,
                ..Image::default()
            },
            phases: 8,
            reach: 9,
            snr: vec![80.0, 60.0, 40.0, 20.0],
            seeds: 8,
        }
    }
}

impl Experiment for PointSpread {
    const NAME: &'static str = "point_spread";

    const COVERS: Covers = Covers {
        figures: &[2],
        tables: &[],
        claims: false,
    };

    fn quick() -> Self {
        PointSpread {
            phases: 4,
            snr: vec![60.0, 40.0],
            seeds: 2,
            ..PointSpread::default()
        }
    }

    fn resolve(&mut self) {
        self.receive.resolve(&self.simulation);
    }

    fn apply(&mut self, overrides: &Overrides) {
        overrides.replace(&mut self.simulation.seed, None);
    }

    fn validate(&self) -> Result<()> {
        self.image.validate()?;
        self.receive.0.validate()?;
        let count = |key: &str, value: usize, most: usize| {
            if (1..=most).contains(&value) {
                return Ok(());
            }
            let expected = format!("1 to {most}");
            Err(out_of_range(Self::NAME, key, value, &expected))
        };
        count("phases", self.phases, 64)?;
        count("reach", self.reach, 64)?;
        count("seeds", self.seeds as usize, 1000)?;
        for snr in &self.snr {
            if !(0.0..=200.0).contains(snr) {
                return Err(out_of_range(Self::NAME, "snr", snr, "0 to 200 (dB)"));
            }
        }
        self.settings(None, 1).validate()
    }

    fn run(&self, context: &Context<'_>) -> Result<Outcome> {
        let progress = context.progress;
        let quiet = self.settings(None, self.simulation.seed);
        let phantom = Phantom::point(&quiet, 0.0);
        let free = channel_data(&quiet, &phantom, Summation::Direct, &|done| {
            progress("point: simulate", done);
        })?;
        let aligned = Aligned::new(&free, &self.receive)?;
        let shown = shown();
        let mut profiles = Vec::new();
        let mut all = Vec::new();
        for variant in &shown {
            let lines = aligned.lines(variant, &self.receive, "point", progress)?;
            all.push(lines);
        }
        drop(aligned);
        let point = phantom.scatterers.first().map_or(0.0, |s| s.x);
        for (variant, lines) in shown.iter().zip(&all) {
            profiles.push(ProfileMeasure::new(variant, lines, &all[0], point)?);
        }
        let (views, pictures) = self.pictures(&shown, &all)?;
        let phases = (0..=self.phases / 2).map(|phase| {
            let thinned: Vec<BeamformedLines> =
                all.iter().map(|l| self.one_an_element(l, phase)).collect();
            let measures = shown.iter().zip(&thinned);
            let measures = measures
                .map(|(variant, lines)| ProfileMeasure::new(variant, lines, &thinned[0], point));
            Ok(PhaseResult {
                offset_pitches: phase as f64 / self.phases as f64,
                beamformers: measures.collect::<Result<_>>()?,
            })
        });
        let phases = phases.collect::<Result<Vec<_>>>()?;

        let noisy = noisy();
        let mut snrs = Vec::new();
        for &snr in &self.snr {
            let mut measures = Vec::new();
            for k in 0..self.seeds {
                let settings = self.settings(Some(-snr), self.simulation.seed.wrapping_add(k));
                let mut data = free.clone();
                add_noise(&settings, &mut data)?;
                let aligned = Aligned::new(&data, &self.receive)?;
                let what = format!("point at {snr} dB");
                let lines = noisy
                    .iter()
                    .map(|v| aligned.lines(v, &self.receive, &what, progress))
                    .collect::<Result<Vec<_>>>()?;
                let found = noisy.iter().zip(&lines);
                let found = found.map(|(v, l)| ProfileMeasure::new(v, l, &lines[0], point));
                measures.push(found.collect::<Result<Vec<_>>>()?);
            }
            snrs.push(SnrResult::new(snr, &noisy, &measures));
        }
        let result = PointSpreadResult {
            beam_spacing_mm: 1e3 * self.simulation.pitch / self.phases as f64,
            fine: profiles,
            phases,
            snrs,
        };
        figures::outcome(&result, self.image.dynamic_range, views, pictures)
    }
}

/// Beamformers shown of the noise-free point: the paper's (a) to (c), and others.
fn shown() -> Vec<Variant> {
    vec![
        Variant::forward("das", 0),
        Variant::forward("esmv-rank1", 0),
        Variant::forward("esmv-without-first", 0),
        Variant::forward("mv", 0),
        Variant::forward_backward("esmv-rank1", 0),
        Variant::forward_backward("esmv-without-first", 0),
        Variant::forward_backward("mv", 0),
    ]
}

/// Beamformers measured in noise.
fn noisy() -> Vec<Variant> {
    vec![
        Variant::forward("das", 0),
        Variant::forward("esmv-rank1", 0),
        Variant::forward_backward("esmv-rank1", 0),
        Variant::forward("mv", 0),
    ]
}

impl PointSpread {
    /// The scanner: `phases` beams per element, the middle one on the point.
    fn settings(&self, noise: Option<f64>, seed: u64) -> Settings {
        let middle = (self.simulation.elements / 2) as f64;
        Settings {
            beams: 2 * self.reach * self.phases + 1,
            beam_step: 1.0 / self.phases as f64,
            first_beam: middle - self.reach as f64,
            noise,
            seed,
            ..self.simulation.clone()
        }
    }

    /// One beam per element, selected from the lines.
    ///
    /// The point is `phase` steps to the right of the nearest beam.
    fn one_an_element(&self, lines: &BeamformedLines, phase: usize) -> BeamformedLines {
        let middle = lines.beam_x.len() / 2;
        let first = (middle - phase.min(middle)) % self.phases;
        let kept: Vec<usize> = (first..lines.beam_x.len()).step_by(self.phases).collect();
        BeamformedLines {
            z: lines.z.select(ndarray::Axis(0), &kept),
            beam_x: kept.iter().map(|&k| lines.beam_x[k]).collect(),
            ..lines.clone()
        }
    }

    fn pictures(
        &self,
        variants: &[Variant],
        all: &[BeamformedLines],
    ) -> Result<(Vec<View>, Vec<super::outcome::Picture>)> {
        let Some(first) = all.first() else {
            return Err(Error::Data("the point has no lines".into()));
        };
        let centre = first.beam_x[first.beam_x.len() / 2];
        let focus = self.simulation.focus;
        let pixel = 2.0 * SHOWN[1] / (COLUMNS - 1) as f64;
        let grid = PixelGrid {
            x0: centre - SHOWN[1],
            z0: focus - SHOWN[0],
            pixel,
            rows: (2.0 * SHOWN[0] / pixel).round() as usize + 1,
            columns: COLUMNS,
        };
        let range = self.image.dynamic_range;
        let mut views = Vec::new();
        let mut pictures = Vec::new();
        for (variant, lines) in variants.iter().zip(all) {
            let image = b_mode(lines, range as f32, &grid, self.image.median)?;
            let placed = PixelGrid {
                x0: grid.x0 - centre,
                ..grid
            };
            let made = picture(
                format!("fig2-{}.png", variant.key),
                format!("{}: a point scatterer over {range} dB", variant.name),
                image.pixels,
                &placed,
            );
            pictures.push(made.clone());
            views.push(View {
                name: variant.name.clone(),
                pictures: vec![made],
            });
        }
        Ok((views, pictures))
    }
}
