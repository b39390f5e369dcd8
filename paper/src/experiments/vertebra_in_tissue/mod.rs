//! The vertebra in soft tissue of the paper's Fig. 3.

mod figures;
mod measure;
mod parameters;

use crate::measure::signed_distance::Region;
use crate::{Error, Result};
use bonebeam_files::settings::{LENGTHS, check_level, check_positive};
use bonebeam_simulate::Settings;

use super::common;
use super::common::bone::View;
use super::common::brightness::Brightness;
use super::common::recording::recording;
use super::common::truth::beside;
use super::common::variants::{Aligned, Variant};
use super::{Context, Covers, Experiment, Outcome, Overrides};
use measure::TissueResult;
use parameters::TISSUE;
pub use parameters::VertebraInTissue;

impl Experiment for VertebraInTissue {
    const NAME: &'static str = "vertebra_in_tissue";

    const COVERS: Covers = Covers {
        figures: &[3],
        tables: &[],
        claims: false,
    };

    const FLAGS: &'static [&'static str] = &["--mesh", "--keep"];

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
        common::validate(&self.simulation, &self.receive, &self.image)?;
        self.phase_symmetry.validate()?;
        check_positive(Self::NAME, "depth", self.depth, LENGTHS, " (m)")?;
        check_positive(Self::NAME, "thickness", self.thickness, [1e-6, 0.1], " (m)")?;
        let density = self.tissue_density;
        check_positive(
            Self::NAME,
            "tissue_density",
            density,
            [1e-3, 1e4],
            " (per mm³)",
        )?;
        self.bone.validate(Self::NAME)?;
        check_level(Self::NAME, "reverberation", self.reverberation)?;
        self.clutter
            .map_or(Ok(()), |clutter| clutter.validate(Self::NAME))
    }

    fn run(&self, context: &Context<'_>) -> Result<Outcome> {
        let phantom = self.phantom()?;
        let data = recording(context, "fig3", &self.simulation, &phantom, &|done| {
            (context.progress)("fig3: simulate", done);
        })?;
        let aligned = Aligned::new(&data, &self.receive)?;
        let mut measures = Vec::new();
        let (mut view, mut brightness) = (None, None);
        for variant in variants(self.half_window) {
            let lines = aligned.lines(&variant, &self.receive, "fig3", context.progress)?;
            let view = View::once(&mut view, phantom.bone.as_ref(), &lines, &self.image)?;
            if measures.is_empty() {
                let [lateral, depths] = TISSUE;
                brightness = Brightness::of(&lines, view, lateral, depths)?;
            }
            measures.push(self.measure(&variant, &lines, view)?);
        }
        let view = view.ok_or_else(|| Error::Data("no beamformer was selected".into()))?;
        let regions = [Region::B_MODE, Region::PHASE_SYMMETRY];
        let range = self.image.dynamic_range;
        let das = measures.first().and_then(|m| m.b_mode.intensity_c);
        let result = TissueResult {
            das_c_db: das.map(|grey| range * (grey / 255.0 - 1.0)),
            brightness,
            uniform: regions.map(|region| view.uniform(region)),
            beamformers: measures,
        };
        figures::outcome(&result, self, beside(&view.hits, &view.grid))
    }
}

/// Beamformers shown: the paper's (a) to (d), and others.
fn variants(half_window: usize) -> Vec<Variant> {
    vec![
        Variant::forward("das", half_window),
        Variant::forward("esmv-10", half_window),
        Variant::forward("esmv-1", half_window),
        Variant::forward("esmv-0.001", half_window),
        Variant::forward("esmv-rank1", half_window),
        Variant::forward_backward("esmv-rank1", half_window),
        Variant::forward("mv", half_window),
        Variant::forward_backward("mv", half_window),
    ]
}
