//! The vertebra in soft tissue of the paper's Fig. 3.

mod figures;
mod measure;
mod parameters;

use super::study::*;
use bonebeam_simulate::{Block, Bone, Layers, PAPER_DENSITY};

use measure::TissueResult;
use parameters::TISSUE;
pub use parameters::VertebraInTissue;

/// Beamformers shown: the paper's (a) to (d), and others.
#[rustfmt::skip]
const VARIANTS: [&str; 8] = [
    "das", "esmv-10", "esmv-1", "esmv-0.001", "esmv-rank1", "esmv-rank1-fb", "mv", "mv-fb",
];

impl Experiment for VertebraInTissue {
    /// Fewer beams at 40 MHz, and a thin slab of fewer scatterers.
    fn quick() -> Self {
        let full = VertebraInTissue::default();
        VertebraInTissue {
            tissue_density: 12.0,
            thickness: 0.5e-3,
            simulation: Settings {
                fs: 40e6,
                ..common::quick(full.simulation)
            },
            ..full
        }
    }

    fn apply(&mut self, overrides: &Overrides) {
        overrides.replace_mesh(&mut self.mesh);
    }

    fn validate(&self) -> Result<()> {
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
        block.fill(&mut phantom, Layers::Uniform, &|| ())?;
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
