//! Image errors of a depth step, beside images of all samples.
//!
//! Lines are beamformed at every second to fourth sample and interpolated.

mod show;

use ndarray::{Array2, Axis};
use num_complex::Complex;
use serde::{Deserialize, Serialize};

use crate::Result;
use crate::measure::signed_distance::Region;
use bonebeam::image::DepthInterpolation;
use bonebeam_drive::image::b_mode;
use bonebeam_files::BeamformedLines;

use super::common::bone::View;
use super::common::pictures::ridges;
use super::common::recording::recording;
use super::common::variants::{Aligned, Variant};
use super::vertebra_in_tissue::VertebraInTissue;
use super::{Context, Experiment, Outcome, Overrides};
use show::StepError;

/// The depth steps.
const STEPS: [usize; 3] = [2, 3, 4];
/// Grey levels from here on are the bright half.
const BRIGHT: f32 = 127.5;

/// Section `[depth_step]`: the vertebra in tissue of Fig. 3, default covariance.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DepthStep {
    /// The scene, its recording and its images.
    scene: VertebraInTissue,
}

impl Experiment for DepthStep {
    const NAME: &'static str = "depth_step";

    const FLAGS: &'static [&'static str] = &["--mesh", "--keep"];

    fn quick() -> Self {
        DepthStep {
            scene: VertebraInTissue::quick(),
        }
    }

    fn resolve(&mut self) {
        self.scene.resolve();
    }

    fn apply(&mut self, overrides: &Overrides) {
        self.scene.apply(overrides);
    }

    fn validate(&self) -> Result<()> {
        self.scene.validate()
    }

    fn run(&self, context: &Context<'_>) -> Result<Outcome> {
        let scene = &self.scene;
        let phantom = scene.phantom()?;
        let data = recording(context, "fig3", &scene.simulation, &phantom, &|done| {
            (context.progress)("depth_step: simulate", done);
        })?;
        let aligned = Aligned::new(&data, &scene.receive)?;
        let cycles = data.f0 / scene.receive.0.rate_of(&data);
        let mut results = Vec::new();
        let mut view = None;
        let variants = [
            Variant::forward("das", 0),
            Variant::forward_backward("mv", 0),
            Variant::forward_backward("esmv-rank1", 0),
        ];
        for variant in variants {
            let lines = aligned.lines(&variant, &scene.receive, "depth_step", context.progress)?;
            let view = View::once(&mut view, phantom.bone.as_ref(), &lines, &scene.image)?;
            let all = self.images(&lines, view)?;
            for depth_step in STEPS {
                let stepped = interpolated(&lines, depth_step, cycles)?;
                let images = self.images(&stepped, view)?;
                results.push(error(&variant, depth_step, view, [&all, &images]));
            }
        }
        show::outcome(&results)
    }
}

impl DepthStep {
    /// The image of lines, and its phase symmetry.
    fn images(&self, lines: &BeamformedLines, view: &View) -> Result<[Array2<f32>; 2]> {
        let section = &self.scene.image;
        let range = section.dynamic_range as f32;
        let image = b_mode(lines, range, &view.grid, section.median)?.pixels;
        let map = ridges(&image, &self.scene.phase_symmetry)?;
        Ok([image, map])
    }
}

/// Lines with a depth step.
///
/// Every `depth_step`-th sample keeps its bits; the others are interpolated.
fn interpolated(
    lines: &BeamformedLines,
    depth_step: usize,
    cycles: f64,
) -> Result<BeamformedLines> {
    let interpolation = DepthInterpolation::new(lines.z.ncols(), depth_step, cycles)?;
    let mut scratch = vec![Complex::ZERO; interpolation.need(1).complex];
    let mut out = vec![Complex::ZERO; lines.z.ncols()];
    let mut stepped = lines.clone();
    for mut line in stepped.z.axis_iter_mut(Axis(0)) {
        let computed: Vec<_> = line.iter().step_by(depth_step).copied().collect();
        interpolation.line(&computed, &mut scratch, &mut out)?;
        for (z, &value) in line.iter_mut().zip(&out) {
            *z = value;
        }
    }
    Ok(stepped)
}

/// Errors of images with a depth step, relative to those of all samples.
fn error(
    variant: &Variant,
    depth_step: usize,
    view: &View,
    [all, stepped]: [&[Array2<f32>; 2]; 2],
) -> StepError {
    let rms = |wanted: &dyn Fn(f32) -> bool| {
        let pairs = all[0]
            .iter()
            .zip(&stepped[0])
            .filter(|(level, _)| wanted(**level));
        let (mut sum, mut count) = (0.0, 0usize);
        for (level, other) in pairs {
            sum += f64::from(other - level).powi(2);
            count += 1;
        }
        (sum / count.max(1) as f64).sqrt()
    };
    let regions = [Region::B_MODE, Region::PHASE_SYMMETRY];
    let mean = |images: &[Array2<f32>; 2], k: usize| view.measure(&images[k], regions[k]).mean_mm;
    let difference = |k: usize| Some(mean(stepped, k)? - mean(all, k)?);
    StepError {
        beamformer: variant.key.clone(),
        name: variant.name.clone(),
        depth_step,
        rms: rms(&|_| true),
        bright_rms: rms(&|level| level >= BRIGHT),
        bone_mm: [0, 1].map(difference),
    }
}
