//! The point scatterer of the paper's Fig. 2: images and profiles.
//!
//! Widths and side lobes depend on the point's position between the beams and on the channel SNR.

mod figures;
mod measure;

use super::study::*;
use bonebeam_simulate::{Summation, add_noise, channel_data};

use super::outcome::View;
use measure::{PhaseResult, PointSpreadResult, SnrResult, measured};

/// Half the shown depth, and half the width, m: the paper's 3 mm × 5 mm.
const SHOWN: [f64; 2] = [1.5e-3, 2.5e-3];
/// Pixels across the images.
const COLUMNS: usize = 500;

/// Beamformers shown of the noise-free point: the paper's (a) to (c), and others.
#[rustfmt::skip]
const SHOWN_OF: [&str; 7] = [
    "das", "esmv-rank1", "esmv-without-first", "mv", "esmv-rank1-fb", "esmv-without-first-fb", "mv-fb",
];
/// Beamformers measured in noise.
const NOISY: [&str; 4] = ["das", "esmv-rank1", "esmv-rank1-fb", "mv"];

parameters! {
    /// Section `[point_spread]`.
    PointSpread "point_spread" {
        /// Array, pulse, transmit. `phases` and `reach` set its beams.
        simulation: Settings = Settings::point();
        /// Delay and beamformer.
        receive: Receive = Receive::of_point() => Receive::validate;
        /// The B-mode image; its size is the paper's.
        image: Image = Image { dynamic_range: 50.0, ..Image::default() } => Image::validate;
        /// Beams per element: the number of phases of a grid with one beam per element.
        phases: usize = 8, within([1.0, 64.0], "");
        /// Elements on either side of the point that have beams.
        reach: usize = 9, within([1.0, 64.0], "");
        /// Channel SNRs, dB: the largest sample over the RMS of the noise.
        snr: Vec<f64> = vec![80.0, 60.0, 40.0, 20.0], within([0.0, 200.0], " (dB)");
        /// Number of noise seeds at each SNR.
        seeds: u64 = 8, within([1.0, 1000.0], "");
    }
}

impl Experiment for PointSpread {
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
        let seed = &mut self.simulation.seed;
        *seed = overrides.seed.unwrap_or(*seed);
    }

    fn validate(&self) -> Result<()> {
        self.settings(None, 1).validate()
    }

    fn run(&self, context: &Context<'_>) -> Result<Outcome> {
        let progress = context.progress;
        let quiet = self.settings(None, self.simulation.seed);
        let phantom = Phantom::point(&quiet, 0.0);
        let free = channel_data(&quiet, &phantom, Summation::Direct, &|done| {
            progress("point: simulate", done);
        })?;
        let shown = SHOWN_OF.map(|key| Variant::of(key, 0));
        let all = lines_of("point", &free, &self.receive, &shown, progress)?;
        let point = phantom.scatterers.first().map_or(0.0, |s| s.x);
        let phases = (0..=self.phases / 2).map(|phase| {
            let thinned: Vec<_> = all.iter().map(|l| self.one_an_element(l, phase)).collect();
            Ok(PhaseResult {
                offset_pitches: phase as f64 / self.phases as f64,
                beamformers: measured(&shown, &thinned, point)?,
            })
        });
        let noisy = NOISY.map(|key| Variant::of(key, 0));
        let snrs = self.snr.iter().map(|&snr| {
            let measures = (0..self.seeds).map(|k| {
                let settings = self.settings(Some(-snr), self.simulation.seed.wrapping_add(k));
                let mut data = free.clone();
                add_noise(&settings, &mut data)?;
                let what = format!("point at {snr} dB");
                let lines = lines_of(&what, &data, &self.receive, &noisy, progress)?;
                measured(&noisy, &lines, point)
            });
            let measures = measures.collect::<Result<Vec<_>>>()?;
            Ok(SnrResult::new(snr, &noisy, &measures))
        });
        let result = PointSpreadResult {
            beam_spacing_mm: 1e3 * self.simulation.pitch / self.phases as f64,
            fine: measured(&shown, &all, point)?,
            phases: phases.collect::<Result<_>>()?,
            snrs: snrs.collect::<Result<_>>()?,
        };
        let views = self.views(&shown, &all)?;
        figures::outcome(&result, self.image.dynamic_range, views)
    }
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

    /// The picture of each beamformer.
    fn views(&self, variants: &[Variant], all: &[BeamformedLines]) -> Result<Vec<View>> {
        let x = &all[0].beam_x;
        let centre = x[x.len() / 2];
        let pixel = 2.0 * SHOWN[1] / (COLUMNS - 1) as f64;
        let grid = PixelGrid::new(
            [centre - SHOWN[1], self.simulation.focus - SHOWN[0]],
            pixel,
            [(2.0 * SHOWN[0] / pixel).round() as usize + 1, COLUMNS],
        );
        let placed = PixelGrid {
            x0: grid.x0 - centre,
            ..grid
        };
        let range = self.image.dynamic_range;
        let view = |(variant, lines): (&Variant, &BeamformedLines)| {
            let image = b_mode(lines, range as f32, &grid, self.image.median)?;
            let (key, name) = (&variant.key, &variant.name);
            let caption = format!("{name}: a point scatterer over {range} dB");
            let made = picture(format!("fig2-{key}.png"), caption, image.pixels, &placed);
            Ok((name.clone(), vec![made]))
        };
        variants.iter().zip(all).map(view).collect()
    }
}
