//! Stand-ins for the paper's Figs. 10 to 12, which show a volunteer.
//!
//! They are three views of a lumbar spine under layers of tissue.

use super::study::*;
use bonebeam_simulate::Bone;

use super::common::layers::fill_layers;

/// Range of the muscle, lateral and in depth, m, for the bone's relative level.
const LATERAL: [f64; 2] = [-18e-3, 18e-3];
const MUSCLE: f64 = 14e-3;

parameters! {
    /// Section `[spine]`.
    Spine "spine" [simulation, receive, image] {
        /// Thickness of the slab, m.
        thickness: f64 = 4e-3;
        /// Scatterers per m³; together they are as bright as 60 per mm³.
        density: f64 = 30e9;
        /// How the bone's surface scatters.
        bone: BoneSurface = BoneSurface::default();
        /// Diffuse clutter in the bone's shadow.
        clutter: DiffuseClutter = DiffuseClutter {
            level: -24.0,
            coherence: Some(2e-3),
            ..DiffuseClutter::default()
        };
        /// K: half the time window, samples.
        half_window: usize = 2;
        /// Array, pulse, transmit, noise.
        simulation: Settings = Settings {
            fs: 40e6,
            beams: 255,
            beam_step: 0.5,
            depth_end: 44.2e-3,
            focus: 20e-3,
            noise: Some(-60.0),
            noise_spectrum: NoiseSpectrum::Amplifier,
            ..Settings::volume()
        } => Settings::validate;
        /// Delay and beamformer.
        receive: Receive = Receive::to(44.2e-3) => Receive::validate;
        /// The B-mode image; each figure has its own dynamic range.
        image: Image = Image { median: true, ..Image::default() } => Image::validate;
        /// The threshold of phase symmetry; each figure has its own scales.
        threshold: f64 = 15.0;
    }
}

/// A figure of the paper.
struct SpineScene {
    figure: u32,
    name: &'static str,
    heading: &'static str,
    bone: Bone<'static>,
    /// Depth of the bone's shallowest point, m.
    depth: f64,
    /// Dynamic range, dB.
    range: f64,
    /// Exponents of the scales.
    scales: [i32; 2],
}

const SCENES: [SpineScene; 3] = [
    SpineScene {
        figure: 10,
        name: "laminae, sagittal",
        heading: "Fig. 10: laminae along the spine",
        bone: Bone::Laminae,
        depth: 25e-3,
        range: 50.0,
        scales: [8, 9],
    },
    SpineScene {
        figure: 11,
        name: "spinous processes, sagittal",
        heading: "Fig. 11: spinous processes along the spine",
        bone: Bone::SpinousProcesses,
        depth: 16e-3,
        range: 40.0,
        scales: [7, 9],
    },
    SpineScene {
        figure: 12,
        name: "laminae and facet joint, transversal",
        heading: "Fig. 12: laminae and a facet joint across the spine",
        bone: Bone::FacetJoint,
        depth: 22e-3,
        range: 50.0,
        scales: [7, 9],
    },
];

/// Beamformers of every figure.
const VARIANTS: [&str; 4] = ["das", "esmv-0.001", "esmv-rank1-fb", "mv"];

/// Results of one figure.
#[derive(Clone, Debug, Serialize)]
struct SceneResult {
    figure: u32,
    name: &'static str,
    /// The bone over the tissue, DAS.
    brightness: Option<Brightness>,
    beamformers: Vec<Measured>,
    #[serde(skip)]
    outline: Vec<Vec<(f64, f64)>>,
}

#[derive(Clone, Debug, Serialize)]
struct Measured {
    beamformer: String,
    name: String,
    phase_symmetry: BoneMeasure,
    /// Mean grey level of the B-mode image outside the bone.
    tissue: Option<f64>,
    pictures: [Picture; 2],
}

impl Experiment for Spine {
    fn quick() -> Self {
        let full = Spine::default();
        Spine {
            thickness: 0.5e-3,
            density: 12e9,
            simulation: common::quick(full.simulation),
            ..full
        }
    }

    fn validate(&self) -> Result<()> {
        self.bone.validate(Self::NAME)?;
        self.clutter.validate(Self::NAME)?;
        SCENES
            .iter()
            .try_for_each(|scene| self.filter(scene).validate())
    }

    fn run(&self, context: &Context<'_>) -> Result<Outcome> {
        let scenes = SCENES.iter().map(|scene| self.scene(context, scene));
        let scenes = scenes.collect::<Result<Vec<_>>>()?;
        let mut parts = vec![Section::Text(format!(
            "The paper's Figs. 10 to 12 show a volunteer. Three vertebrae of the built-in model under skin, \
             fat, fasciae and muscle stand in for the views, not for the person. K = {}, L = M/2, F# 1.5, 3 × \
             3 median; dynamic range and r₀ are the paper's for each view. An orange line is drawn 1 mm above \
             the surface that a beam meets first.",
            self.half_window
        ))];
        for (scene, result) in SCENES.iter().zip(&scenes) {
            parts.push(Section::Heading(scene.heading));
            parts.push(Section::Text(format!(
                "The bone's surface is {} dB above the muscle's RMS in DAS (median; 10th to 90th percentile \
                 of the columns).",
                Brightness::text(result.brightness.as_ref())
            )));
            let views = result.beamformers.iter();
            let views = views.map(|m| (m.name.clone(), m.pictures.to_vec()));
            parts.extend(SideBySide::of(
                format!("fig{}", scene.figure),
                views,
                0,
                result.outline.clone(),
                scales(scene.range),
            ));
        }
        Ok(Outcome {
            title: "Figs. 10–12: stand-ins for a volunteer's spine",
            parts,
            tables: scenes.iter().map(table).collect(),
            data: data(&scenes)?,
            ..Outcome::default()
        })
    }
}

impl Spine {
    fn filter(&self, scene: &SpineScene) -> PhaseSymmetry {
        PhaseSymmetry {
            scales: octaves(scene.scales),
            threshold: self.threshold,
            ..PhaseSymmetry::default()
        }
    }

    fn phantom(&self, scene: &SpineScene) -> Result<Phantom> {
        let (mut phantom, _) = scene.bone.phantom(
            scene.depth,
            self.thickness,
            Some((&self.bone, self.simulation.seed)),
        )?;
        let settings = &self.simulation;
        phantom.check_within(settings)?;
        let slab = [self.thickness, self.density];
        fill_layers(&mut phantom, slab, settings)?;
        let clutter = Clutter {
            diffuse: Some(self.clutter),
            reverberation: None,
            thickness: self.thickness,
            depth_end: settings.depth_end,
            seed: settings.seed,
        };
        clutter.add(&mut phantom)?;
        Ok(phantom)
    }

    fn scene(&self, context: &Context<'_>, scene: &SpineScene) -> Result<SceneResult> {
        let what = format!("fig{}", scene.figure);
        let phantom = self.phantom(scene)?;
        let keys = (&VARIANTS[..], self.half_window);
        let (simulation, receive) = (&self.simulation, &self.receive);
        let names = [&what[..]; 2];
        let Scene {
            variants, lines, ..
        } = Scene::of(context, names, simulation, &phantom, receive, keys)?;
        let view = View::of_lines(phantom.bone.as_ref(), &lines[0], &self.image)?;
        let filter = self.filter(scene);
        let measured = variants.into_iter().zip(&lines).map(|(variant, lines)| {
            let image = b_mode(lines, scene.range as f32, &view.grid, self.image.median)?;
            let map = ridges(&image.pixels, &filter)?;
            Ok(Measured {
                phase_symmetry: view.measure(&map, Region::PHASE_SYMMETRY),
                tissue: view.measure(&image.pixels, Region::B_MODE).intensity_b,
                pictures: pair(
                    &format!("{what}-{}", variant.key),
                    &format!("{}: {}, ", variant.name, scene.name),
                    scene.range,
                    [image.pixels, map],
                    &view.grid,
                ),
                beamformer: variant.key,
                name: variant.name,
            })
        });
        Ok(SceneResult {
            figure: scene.figure,
            name: scene.name,
            brightness: Brightness::of(&lines[0], &view, LATERAL, [MUSCLE, 45e-3])?,
            beamformers: measured.collect::<Result<_>>()?,
            outline: beside(&view.hits, &view.grid),
        })
    }
}

fn table(scene: &SceneResult) -> Table {
    Table::of(
        format!("Fig. {}: {}", scene.figure, scene.name),
        &scene.beamformers,
        &[
            ("", |m| m.name.clone()),
            ("US B", |m| number(m.tissue)),
            ("PS B", |m| number(m.phase_symmetry.intensity_b)),
            ("PS C", |m| number(m.phase_symmetry.intensity_c)),
            ("surface found", |m| percent(m.phase_symmetry.found)),
            ("thickness, mm", |m| number(m.phase_symmetry.thickness_mm)),
            ("average precision", |m| {
                number(m.phase_symmetry.average_precision)
            }),
        ],
    )
}
