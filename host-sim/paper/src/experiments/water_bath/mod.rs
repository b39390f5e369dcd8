//! The registration of a vertebra in a water bath (the paper's Figs. 4 to 9 and Table I).
//!
//! A specimen with four balls glued on is scanned by CT and by ultrasound. The balls are picked in both
//! volumes, the CT volume is registered to the ultrasound one, and its surface at −524 HU is what the images
//! are measured against. Every step is simulated, so that each source of error can be taken out.

mod comparisons;
mod contour;
mod figures;
mod images;
mod measures;
mod profiles;
mod registration;
mod specimen;
mod sweep;

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::Result;
use crate::measure::registration::Point;
use bonebeam_drive::config::Image;
use bonebeam_files::settings::{LENGTHS, check_level, check_positive, out_of_range};
use bonebeam_files::terminal::warn;
use bonebeam_simulate::Settings;

use super::common::{self, Receive};
use super::{Context, Experiment, Outcome, Overrides, Shows};
use registration::{Ct, Registrations};
use specimen::Specimen;

/// The paper's threshold, HU.
const THRESHOLD: f64 = -524.0;
/// Where the specimen lies on the CT scanner's table: angles in radians and a shift in m. Any would do.
const POSE: ([f64; 3], Point) = ([0.09, -0.14, 0.05], [12e-3, -7e-3, 31e-3]);
/// The beamformers, as the paper has them: its rank 1 by β = 0.001 %, and exactly.
const METHODS: [&str; 3] = ["das", "esmv-0.001", "esmv-rank1"];
/// Those that are measured under every combination of sources.
const FEATURED: [&str; 2] = ["das", "esmv-rank1"];

/// Section `[water_bath]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WaterBath {
    /// A closed surface as a PLY, STL or OBJ file in mm (+x towards the front, +z towards the head) in place of
    /// the built-in vertebra.
    #[serde(skip_serializing_if = "Option::is_none")]
    mesh: Option<PathBuf>,
    /// The vertebra's height at the middle of the sweep, m from the middle of its body towards the head.
    height: f64,
    /// Depth of its shallowest point, m.
    depth: f64,
    /// Elevations of slices 1 and 2, m from the middle of the sweep.
    slices: [f64; 2],
    /// Depths of the lines across them, m.
    lines: [f64; 2],
    /// Slices of the volume.
    sweep: usize,
    /// Distance between them, m.
    sweep_step: f64,
    /// Scatterers on bone in the sweep, per mm² (assumed: fewer than in the two slices, for time).
    sweep_density: f64,
    /// Thickness of the slab around a slice that has scatterers, m.
    thickness: f64,
    /// Speed of sound that the scanner takes for granted, m/s; the water's is `simulation.c`.
    assumed_sound_speed: f64,
    /// The CT scanner's voxels, m.
    ct_voxel: [f64; 3],
    /// Full width at half maximum of its point spread, m (assumed).
    ct_blur: f64,
    /// Density of bone and of the plastic balls, HU (assumed).
    ct_bone: f64,
    /// See `ct_bone`.
    ct_ball: f64,
    /// Standard deviation of a further error of picking along each axis, m, in the repeated registrations
    /// (assumed).
    picking_error: f64,
    /// Amplitude of the bone's echo that the array throws back, dB (assumed).
    reverberation: f64,
    /// Amplitude of diffuse clutter in the bone's shadow in either slice, dB of a scatterer of bone. It gives
    /// region C of DAS the level of the paper's Table I.
    clutter: [f64; 2],
    /// Array, pulse, transmit, noise.
    simulation: Settings,
    /// Delay and beamformer.
    receive: Receive,
    /// The B-mode image.
    image: Image,
}

impl Default for WaterBath {
    fn default() -> Self {
        let mut receive = Receive::default();
        receive.0.depth_end = Some(44.4e-3);
        WaterBath {
            mesh: None,
            height: -4e-3,
            depth: 15e-3,
            slices: [0.0, -4.5e-3],
            lines: [17.5e-3, 17.5e-3],
            sweep: 61,
            sweep_step: 0.5e-3,
            sweep_density: 10.0,
            thickness: 6e-3,
            assumed_sound_speed: 1540.0,
            ct_voxel: [0.19e-3, 0.19e-3, 0.3e-3],
            ct_blur: 0.8e-3,
            ct_bone: 1200.0,
            ct_ball: 100.0,
            picking_error: 0.1e-3,
            reverberation: -25.0,
            clutter: [3.0, 13.0],
            // Two beams an element as the paper's 256, at the rate of its receiver; water of 20 °C.
            simulation: Settings {
                beams: 255,
                beam_step: 0.5,
                fs: 40e6,
                c: 1480.0,
                depth_end: 45e-3,
                ..Settings::volume()
            },
            receive,
            image: Image {
                dynamic_range: 70.0,
                rows: Some(512),
                columns: Some(512),
                median: true,
                ..Image::default()
            },
        }
    }
}

impl Experiment for WaterBath {
    const NAME: &'static str = "water_bath";
    const SHOWS: Shows = Shows {
        figures: &[4, 5, 6, 7, 8, 9],
        tables: &[1],
        claims: false,
    };

    const FLAGS: &'static [&'static str] = &["--mesh", "--keep"];

    /// Every fourth beam, half the volume's slices, pixels and voxels of twice the size, a thin slab.
    fn quick() -> Self {
        let mut quick = WaterBath::default();
        (quick.image.rows, quick.image.columns) = (Some(256), Some(256));
        (quick.simulation.beams, quick.simulation.beam_step) = (64, 2.0);
        (quick.sweep, quick.sweep_step) = (31, 1e-3);
        quick.sweep_density = 4.0;
        quick.thickness = 1e-3;
        quick.ct_voxel = quick.ct_voxel.map(|v| 2.0 * v);
        quick
    }

    fn resolve(&mut self) {
        common::resolve(&self.simulation, &mut self.receive, &mut self.image);
    }

    fn apply(&mut self, overrides: &Overrides) {
        overrides.replace(&mut self.simulation.seed, Some(&mut self.mesh));
    }

    fn validate(&self) -> Result<()> {
        common::validate(&self.simulation, &self.receive, &self.image)?;
        for (key, value) in [
            ("depth", self.depth),
            ("lines[0]", self.lines[0]),
            ("lines[1]", self.lines[1]),
            ("sweep_step", self.sweep_step),
            ("thickness", self.thickness),
            ("ct_voxel[0]", self.ct_voxel[0]),
            ("ct_voxel[1]", self.ct_voxel[1]),
            ("ct_voxel[2]", self.ct_voxel[2]),
        ] {
            check_positive(Self::NAME, key, value, LENGTHS, " (m)")?;
        }
        for (key, value, [least, most], unit) in [
            ("height", self.height, [-0.1, 0.1], " (m)"),
            ("slices[0]", self.slices[0], [-0.1, 0.1], " (m)"),
            ("slices[1]", self.slices[1], [-0.1, 0.1], " (m)"),
            ("sweep", self.sweep as f64, [2.0, 1000.0], ""),
            (
                "sweep_density",
                self.sweep_density,
                [0.1, 1000.0],
                " (per mm²)",
            ),
            (
                "assumed_sound_speed",
                self.assumed_sound_speed,
                [1000.0, 2000.0],
                " (m/s)",
            ),
            ("ct_blur", self.ct_blur, [0.0, 5e-3], " (m)"),
            ("ct_bone", self.ct_bone, [0.0, 5000.0], " (HU)"),
            ("ct_ball", self.ct_ball, [-400.0, 5000.0], " (HU)"),
            ("picking_error", self.picking_error, [0.0, 5e-3], " (m)"),
        ] {
            if !(least..=most).contains(&value) {
                let expected = format!("{least} to {most}{unit}");
                return Err(out_of_range(Self::NAME, key, value, &expected));
            }
        }
        let [first, second] = self.clutter;
        for (key, level) in [
            ("reverberation", self.reverberation),
            ("clutter[0]", first),
            ("clutter[1]", second),
        ] {
            check_level(Self::NAME, key, Some(level))?;
        }
        Ok(())
    }

    fn run(&self, context: &Context<'_>) -> Result<Outcome> {
        let progress = context.progress;
        progress("water bath: CT", 0.0);
        let length = self.sweep as f64 * self.sweep_step + 8e-3;
        let mesh = self.mesh.as_deref();
        let (specimen, doubts) = Specimen::new(mesh, self.height, self.depth, length)?;
        doubts.iter().for_each(|doubt| warn(doubt));
        let ct = Ct::new(self, &specimen)?;

        let volumes = self.volumes(&specimen, context)?;
        let targets = self.targets(&specimen, &ct.pose)?;
        let registrations = Registrations::new(self, &specimen, &ct, &volumes, &targets)?;
        let slices = [
            self.slice(0, &specimen, context)?,
            self.slice(1, &specimen, context)?,
        ];
        progress("water bath: measures", 0.0);
        let mut measured = Vec::new();
        for (k, slice) in slices.iter().enumerate() {
            measured.push(self.measure(k, slice, &ct, &registrations)?);
        }
        let draws = self.draws(&slices, &specimen, &ct, &volumes[1])?;
        figures::outcome(figures::Found {
            bath: self,
            ct: &ct,
            volume: &volumes[1],
            registrations: &registrations,
            slices: &slices,
            measured: &measured,
            draws: &draws,
        })
    }
}
