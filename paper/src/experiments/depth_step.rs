//! Image errors of a depth step, beside images of all samples.
//!
//! Lines are beamformed at every second to fourth sample and interpolated.

use super::study::*;
use ndarray::Axis;
use num_complex::Complex;

use bonebeam::image::DepthInterpolation;

use super::vertebra_in_tissue::VertebraInTissue;

/// The depth steps.
const STEPS: [usize; 3] = [2, 3, 4];
/// Grey levels from here on are the bright half.
const BRIGHT: f32 = 127.5;

parameters! {
    /// Section `[depth_step]`: the vertebra in tissue of Fig. 3, default covariance.
    DepthStep "depth_step" [scene.simulation, scene.receive, scene.image] {
        /// The scene, its recording and its images.
        scene: VertebraInTissue = VertebraInTissue::default() => VertebraInTissue::check;
    }
}

/// Errors of one beamformer with one depth step.
#[derive(Clone, Debug, Serialize)]
struct StepError {
    beamformer: String,
    name: String,
    depth_step: usize,
    /// RMS over the image, grey levels.
    rms: f64,
    /// RMS over the bright half of the grey scale.
    bright_rms: f64,
    /// Change of the bone's localization error, mm: B-mode, then phase symmetry.
    ///
    /// Relative to images of all samples.
    bone_mm: [Option<f64>; 2],
}

impl Experiment for DepthStep {
    fn quick() -> Self {
        DepthStep {
            scene: VertebraInTissue::quick(),
        }
    }

    fn apply(&mut self, overrides: &Overrides) {
        self.scene.apply(overrides);
    }

    fn validate(&self) -> Result<()> {
        self.scene.validate()
    }

    fn run(&self, context: &Context<'_>) -> Result<Outcome> {
        let VertebraInTissue {
            simulation,
            receive,
            image,
            ..
        } = &self.scene;
        let phantom = self.scene.phantom()?;
        let (names, keys) = (["fig3", "depth_step"], ["das", "mv-fb", "esmv-rank1-fb"]);
        let scene = Scene::of(context, names, simulation, &phantom, receive, (&keys, 0))?;
        let all = &scene.lines;
        let view = View::of_lines(phantom.bone.as_ref(), &all[0], image)?;
        let cycles = scene.data.f0 / receive.0.rate_of(&scene.data);
        let mut results = Vec::new();
        for (variant, lines) in scene.variants.iter().zip(all) {
            let all = self.images(lines, &view)?;
            for depth_step in STEPS {
                let images = self.images(&interpolated(lines, depth_step, cycles)?, &view)?;
                results.push(error(variant, depth_step, &view, [&all, &images]));
            }
        }
        outcome(&results)
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
    let rms = |least: f32| {
        let pairs = all[0].iter().zip(&stepped[0]);
        let pairs = pairs.filter(|(level, _)| **level >= least);
        mean(pairs.map(|(level, other)| f64::from(other - level).powi(2))).map_or(0.0, f64::sqrt)
    };
    let bone = |images: &[Array2<f32>; 2], k: usize| view.measure(&images[k], REGIONS[k]).mean_mm;
    let difference = |k: usize| Some(bone(stepped, k)? - bone(all, k)?);
    StepError {
        beamformer: variant.key.clone(),
        name: variant.name.clone(),
        depth_step,
        rms: rms(0.0),
        bright_rms: rms(BRIGHT),
        bone_mm: [0, 1].map(difference),
    }
}

/// The outcome of all beamformers and depth steps.
fn outcome(results: &[StepError]) -> Result<Outcome> {
    let table = Table::of(
        "Depth step: images compared with those of all samples",
        results,
        &[
            ("", |e| e.name.clone()),
            ("depth step", |e| e.depth_step.to_string()),
            ("rms, grey levels", |e| number(e.rms)),
            ("rms, bright half", |e| number(e.bright_rms)),
            ("bone shift, B-mode, mm", |e| thousandths(e.bone_mm[0])),
            ("bone shift, phase symmetry, mm", |e| {
                thousandths(e.bone_mm[1])
            }),
        ],
    );
    let text = "The vertebra in tissue of Fig. 3, K = 0, forward-backward covariance. Lines of every second to \
         fourth sample are interpolated and compared with lines of all samples. Images have 255 grey levels; \
         the bright half is above 127. The bone shift is the difference of the bone's mean signed distance, in \
         B-mode and in phase symmetry.";
    Ok(Outcome {
        title: "Depth step: errors of images",
        parts: vec![Section::Text(text.into())],
        tables: vec![table],
        data: data(&results)?,
        ..Outcome::default()
    })
}

/// A difference as text, without a negative zero.
fn thousandths(value: Option<f64>) -> String {
    value.map_or("–".into(), |value| {
        format!("{:+.3}", (1e3 * value).round() / 1e3 + 0.0)
    })
}
