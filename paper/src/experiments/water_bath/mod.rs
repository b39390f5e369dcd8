//! Registration of a vertebra in a water bath (the paper's Figs. 4 to 9, Table I).
//!
//! A specimen with four balls glued on is scanned by CT and by ultrasound. The balls are picked in both volumes,
//! the CT volume is registered to the ultrasound volume, and the images are measured against its surface at −524
//! HU. Every step is simulated, so each source of error can be switched off.

mod clutter;
mod comparisons;
mod contour;
mod figures;
mod images;
mod measures;
mod parameters;
mod plots;
mod registration;
mod specimen;
mod sweep;

use super::study::*;
use bonebeam_files::terminal::warn;

use contour::Sources;
use parameters::Shadow;
pub use parameters::WaterBath;
use registration::{Ct, Registrations};
use specimen::Specimen;

impl Experiment for WaterBath {
    /// Coarse parameters for a first run.
    ///
    /// Every fourth beam, a third of the volume's slices, pixels and voxels of twice the size, a thin slab.
    fn quick() -> Self {
        let mut quick = WaterBath::default();
        (quick.image.rows, quick.image.columns) = (Some(256), Some(256));
        (quick.simulation.beams, quick.simulation.beam_step) = (64, 2.0);
        (quick.sweep, quick.sweep_step) = (17, 1.8e-3);
        quick.sweep_density = 2.0;
        quick.thickness = 0.5e-3;
        quick.tried = vec![Shadow::quiet(0.0)];
        quick.ct_voxel = quick.ct_voxel.map(|v| 2.0 * v);
        quick
    }

    fn apply(&mut self, overrides: &Overrides) {
        overrides.replace_mesh(&mut self.mesh);
    }

    fn validate(&self) -> Result<()> {
        self.tried.iter().try_for_each(Shadow::validate)?;
        self.bone.validate(Self::NAME)?;
        self.clutter.validate(Self::NAME)
    }

    fn run(&self, context: &Context<'_>) -> Result<Outcome> {
        let progress = context.progress;
        progress("water bath: CT", 0.0);
        let length = self.sweep as f64 * self.sweep_step + 8e-3;
        let mesh = self.mesh.as_deref();
        let (specimen, warnings) = Specimen::new(mesh, self.height, self.depth, length)?;
        warnings.iter().for_each(|warning| warn(warning));
        let ct = Ct::new(self, &specimen)?;

        let volumes = self.volumes(&specimen, context)?;
        let targets = self.targets(&specimen, &ct.pose)?;
        let registrations = Registrations::new(self, &specimen, &ct, &volumes, &targets)?;
        let way = registrations.of(Sources::ALL).transform;
        let mut law = self.clutter;
        let mut tried = Vec::new();
        let mut slice = |k: usize| {
            let distance = self.outline(k, &ct, &way, true)?.distance_map(&self.grid());
            let recorded = self.record(k, &specimen, context)?;
            if k == 0 {
                law = self.law(&recorded, &distance)?;
            }
            self.try_shadows(&recorded, &distance, &law, context, &mut tried)?;
            let data = self.mixed(&recorded, law, &self.scanner_of(k))?;
            drop(recorded);
            self.images(k, &data, context)
        };
        let slices = [slice(0)?, slice(1)?];
        progress("water bath: measures", 0.0);
        let measured = slices.iter().enumerate();
        let measured = measured.map(|(k, slice)| self.measure(k, slice, &ct, &registrations));
        let measured = measured.collect::<Result<Vec<_>>>()?;
        let draws = self.draws(&slices, &specimen, &ct, &volumes[1])?;
        figures::outcome(figures::Found {
            bath: self,
            law,
            tried: &tried,
            ct: &ct,
            volume: &volumes[1],
            registrations: &registrations,
            slices: &slices,
            measured: &measured,
            draws: &draws,
        })
    }
}
