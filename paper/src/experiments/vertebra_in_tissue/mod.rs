//! The vertebra in soft tissue of the paper's Fig. 3.

mod figures;
mod measure;

use super::study::*;
use bonebeam_simulate::{Block, Bone, Layers, PAPER_DENSITY};

use measure::TissueResult;

/// Block of tissue: from and to, lateral and in depth, m.
const TISSUE: [[f64; 2]; 2] = [[-15e-3, 15e-3], [12e-3, 37e-3]];

/// Beamformers shown: the paper's (a) to (d), and others.
#[rustfmt::skip]
const VARIANTS: [&str; 8] = [
    "das", "esmv-10", "esmv-1", "esmv-0.001", "esmv-rank1", "esmv-rank1-fb", "mv", "mv-fb",
];

parameters! {
    /// Section `[vertebra_in_tissue]`.
    VertebraInTissue "vertebra_in_tissue" {
        /// A closed surface in mm in place of the built-in vertebra.
        #[serde(skip_serializing_if = "Option::is_none")]
        mesh: Option<PathBuf> = None;
        /// Height of the slice, m.
        slice: f64 = -4e-3;
        /// Depth of the spinous process's tip, m.
        depth: f64 = 15e-3, positive(LENGTHS, " (m)");
        /// Thickness of the slab, m.
        thickness: f64 = 6e-3, positive([1e-6, 0.1], " (m)");
        /// Scatterers of tissue per mm³. Together they are as bright as the paper's 222.
        tissue_density: f64 = 1e-9 * PAPER_DENSITY, positive([1e-3, 1e4], " (per mm³)");
        /// How the bone's surface scatters.
        bone: BoneSurface = BoneSurface::default();
        /// Amplitude of the bone's image at twice its depth, dB; `None` leaves it out.
        #[serde(skip_serializing_if = "Option::is_none")]
        reverberation: Option<f64> = Some(-20.0), level();
        /// Diffuse clutter in the bone's shadow; `None` leaves it out.
        #[serde(skip_serializing_if = "Option::is_none")]
        clutter: Option<DiffuseClutter> = Some(DiffuseClutter {
            level: 14.0,
            coherence: Some(2e-3),
            ..DiffuseClutter::default()
        });
        /// Array, pulse, transmit, noise.
        simulation: Settings = Settings { depth_end: 44.2e-3, ..Settings::volume() } => Settings::validate;
        /// Delay and beamformer.
        receive: Receive = Receive::to(44.2e-3) => Receive::validate;
        /// K: half the time window, samples.
        half_window: usize = 10;
        /// The B-mode image.
        image: Image = Image::default() => Image::validate;
        /// The ridge filter.
        phase_symmetry: PhaseSymmetry = PhaseSymmetry::default() => PhaseSymmetry::validate;
    }
}

impl Experiment for VertebraInTissue {
    /// Half the beams at 40 MHz, and a slab of fewer scatterers.
    fn quick() -> Self {
        let full = VertebraInTissue::default();
        VertebraInTissue {
            tissue_density: 20.0,
            thickness: 3e-3,
            simulation: Settings {
                fs: 40e6,
                ..common::quick(full.simulation)
            },
            ..full
        }
    }

    fn resolve(&mut self) {
        common::resolve(&self.simulation, &mut self.receive, &mut self.image);
    }

    fn apply(&mut self, overrides: &Overrides) {
        overrides.replace(&mut self.simulation.seed, Some(&mut self.mesh));
    }

    fn validate(&self) -> Result<()> {
        self.check()?;
        self.bone.validate(Self::NAME)?;
        self.clutter
            .iter()
            .try_for_each(|clutter| clutter.validate(Self::NAME))
    }

    fn run(&self, context: &Context<'_>) -> Result<Outcome> {
        let phantom = self.phantom()?;
        let keys = (&VARIANTS[..], self.half_window);
        let (simulation, receive) = (&self.simulation, &self.receive);
        let scene = Scene::of(context, ["fig3"; 2], simulation, &phantom, receive, keys)?;
        let lines = scene.lines;
        let view = View::of_lines(phantom.bone.as_ref(), &lines[0], &self.image)?;
        let measures = scene.variants.into_iter().zip(&lines);
        let measures = measures.map(|(variant, lines)| self.measure(variant, lines, &view));
        let measures = measures.collect::<Result<Vec<_>>>()?;
        let range = self.image.dynamic_range;
        let das = measures[0].b_mode.intensity_c;
        let result = TissueResult {
            das_c_db: das.map(|grey| range * (grey / 255.0 - 1.0)),
            brightness: Brightness::of(&lines[0], &view, TISSUE[0], TISSUE[1])?,
            uniform: REGIONS.map(|region| view.uniform(region)),
            beamformers: measures,
        };
        figures::outcome(&result, self, beside(&view.hits, &view.grid))
    }
}

impl VertebraInTissue {
    pub(crate) fn phantom(&self) -> Result<Phantom> {
        let bone = Bone::Vertebra {
            mesh: self.mesh.as_deref(),
            slice: self.slice,
        };
        let (mut phantom, _) = bone.phantom(
            self.depth,
            self.thickness,
            Some((&self.bone, self.simulation.seed)),
        )?;
        phantom.check_within(&self.simulation)?;
        let density = 1e9 * self.tissue_density;
        let block = Block {
            x: TISSUE[0],
            thickness: self.thickness,
            z: TISSUE[1],
            density,
            seed: self.simulation.seed,
        };
        block.fill(&mut phantom, Layers::Uniform)?;
        // Fewer scatterers are each brighter, so that the speckle is as bright.
        let amplitude = (PAPER_DENSITY / density).sqrt();
        for scatterer in &mut phantom.scatterers[phantom.on_bone..] {
            scatterer.amplitude = amplitude;
        }
        let clutter = Clutter {
            diffuse: self.clutter,
            reverberation: self.reverberation,
            thickness: self.thickness,
            depth_end: self.simulation.depth_end,
            seed: self.simulation.seed,
        };
        clutter.add(&mut phantom)?;
        Ok(phantom)
    }
}
