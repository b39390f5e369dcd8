//! The vertebra slice in a water bath (the paper's Fig. 4 to 9 and Table I).

mod figures;
mod measure;
mod parameters;

use crate::Result;
use bonebeam_drive::image::grid_of_picture;
use bonebeam_files::settings::out_of_range;
use bonebeam_simulate::{Outline, Phantom, Summation, channel_data};

use super::common::lines::beamform_all;
use super::common::pictures::Studio;
use super::{Context, Experiment, Outcome, Overrides, Parameters};
use measure::measured;
pub use parameters::Vertebra;

impl Experiment for Vertebra {
    /// A quarter of the beams, recorded at 40 MHz.
    fn quick() -> Self {
        let mut vertebra = Vertebra::default();
        (vertebra.image.rows, vertebra.image.columns) = (Some(256), Some(256));
        vertebra.simulation.beams = 64;
        vertebra.simulation.beam_step = 2.0;
        vertebra.simulation.fs = 40e6;
        vertebra
    }

    fn apply(&mut self, overrides: &Overrides) {
        overrides.replace_mesh(&mut self.mesh);
        self.slice = overrides.slice.unwrap_or(self.slice);
    }

    fn validate(&self) -> Result<()> {
        if !self.slice.is_finite() {
            let expected = "a finite number (m)";
            return Err(out_of_range(Self::NAME, "slice", self.slice, expected));
        }
        // A mesh may turn out not to be one.
        self.phantom().map(drop)
    }

    fn run(&self, context: &Context<'_>) -> Result<Outcome> {
        let Context {
            common, progress, ..
        } = *context;
        let phantom = self.phantom()?;
        let data = channel_data(&self.simulation, &phantom, Summation::Cells, &|done| {
            progress("vertebra: simulate", done);
        })?;
        let (lines, mut checks) = beamform_all(
            "vertebra",
            &data,
            &self.receive,
            context.checking(),
            progress,
        )?;
        drop(data);

        progress("vertebra: pictures", 0.0);
        let grid = grid_of_picture(&lines[0], &self.image)?;
        let studio = Studio {
            what: "vertebra",
            grid,
            image: &self.image,
            phase_symmetry: &common.phase_symmetry,
            rows: 0..grid.rows,
            centre: 0.0,
            references: context.references,
        };
        let (pictures, found) = studio.pictures(&lines)?;
        checks.extend(found);

        progress("vertebra: measures", 0.0);
        let bone = phantom.bone.as_ref().map(Outline::without_holes);
        let bone = bone.expect("a vertebra has a bone")?;
        let result = measured(&bone, &grid, self.lateral_line, pictures);
        figures::outcome(&result, self, checks)
    }
}

impl Vertebra {
    /// The slice of the vertebra in its water bath.
    fn phantom(&self) -> Result<Phantom> {
        let phantom = Phantom::slice(self.mesh.as_deref(), self.slice, self.depth, None)?;
        phantom.check_within(&self.simulation)?;
        Ok(phantom)
    }
}
