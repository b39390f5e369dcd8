//! The parameters of the water bath.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::experiments::common::Receive;
use crate::measure::registration::Point;
use bonebeam_drive::config::Image;
use bonebeam_simulate::{BoneSurface, DiffuseClutter, Settings};

/// The paper's threshold, HU.
pub const THRESHOLD: f64 = -524.0;
/// Pose of the specimen on the CT scanner's table: angles in rad and a shift in m.
///
/// Its values are arbitrary.
pub const POSE: ([f64; 3], Point) = ([0.09, -0.14, 0.05], [12e-3, -7e-3, 31e-3]);
/// Beamformers of the paper, and exact rank 1; the paper's rank 1 is β = 0.001 %.
pub const METHODS: [&str; 3] = ["das", "esmv-0.001", "esmv-rank1"];
/// Beamformers that are measured under every combination of sources.
pub const FEATURED: [&str; 2] = ["das", "esmv-rank1"];
/// The kinds of image.
pub const KINDS: [&str; 2] = ["US", "PS"];

/// Content of a bone's shadow, in a table `[[water_bath.tried]]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shadow {
    /// Coherence length of the clutter, m; infinite for clutter that focuses perfectly.
    pub coherence: f64,
    /// Noise at depth 0, dB relative to the largest sample.
    pub noise: f64,
    /// Increase of the noise with depth, dB per m.
    pub noise_rise: f64,
}

impl Shadow {
    const TRIED: [Shadow; 10] = [
        Shadow::quiet(f64::INFINITY),
        Shadow::quiet(3e-3),
        Shadow::quiet(1e-3),
        Shadow::quiet(0.0),
        Shadow::noisy(f64::INFINITY),
        Shadow::noisy(10e-3),
        Shadow::noisy(3e-3),
        Shadow::noisy(1e-3),
        Shadow::noisy(0.0),
        Shadow {
            noise: -52.0,
            ..Shadow::noisy(2e-3)
        },
    ];

    /// Noise of −60 dB.
    pub(super) const fn quiet(coherence: f64) -> Self {
        Shadow {
            coherence,
            noise: -60.0,
            noise_rise: 0.0,
        }
    }

    /// Noise of −58 dB that rises by 5 dB/cm.
    const fn noisy(coherence: f64) -> Self {
        Shadow {
            coherence,
            noise: -58.0,
            noise_rise: 500.0,
        }
    }
}

/// Section `[water_bath]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WaterBath {
    /// Closed surface (PLY, STL or OBJ file) in place of the built-in vertebra.
    ///
    /// In mm, +x towards the front, +z towards the head.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) mesh: Option<PathBuf>,
    /// Height of the vertebra at the middle of the sweep, m.
    ///
    /// It counts from the middle of its body towards the head.
    pub(super) height: f64,
    /// Depth of its shallowest point, m.
    pub(super) depth: f64,
    /// Elevations of slices 1 and 2, m from the middle of the sweep.
    pub(super) slices: [f64; 2],
    /// Depths of the lines across them, m.
    pub(super) lines: [f64; 2],
    /// Slices of the volume.
    pub(super) sweep: usize,
    /// Distance between them, m.
    pub(super) sweep_step: f64,
    /// Scatterers on bone in the sweep, per mm² (assumed).
    ///
    /// There are fewer than in the two slices, to save time.
    pub(super) sweep_density: f64,
    /// Thickness of the slab with scatterers around a slice, m.
    pub(super) thickness: f64,
    /// Speed of sound that the scanner assumes, m/s; the water's is `simulation.c`.
    pub(super) assumed_sound_speed: f64,
    /// The CT scanner's voxels, m.
    pub(super) ct_voxel: [f64; 3],
    /// Full width at half maximum of its point spread, m (assumed).
    pub(super) ct_blur: f64,
    /// Density of bone, HU (assumed).
    pub(super) ct_bone: f64,
    /// Density of the plastic balls, HU (assumed).
    pub(super) ct_ball: f64,
    /// Standard deviation of a further picking error along each axis, m (assumed).
    ///
    /// It applies to the repeated registrations.
    pub(super) picking_error: f64,
    /// Motion of the specimen along each axis over the sweep, m (assumed).
    ///
    /// It applies to the rows with motion in the tables of sources.
    pub(super) motion: f64,
    /// Delay of trigger and lens that the scanner does not correct, s (assumed).
    ///
    /// It applies to the table of the bias of Fig. 8a: 1 mm of a lens of 1000 m/s, both ways.
    pub(super) delay_error: f64,
    /// Scattering of the bone's surface in the two slices.
    ///
    /// In the sweep it is smooth.
    pub(super) bone: BoneSurface,
    /// Level of the bone's echo that the array reflects, dB (assumed).
    pub(super) reverberation: f64,
    /// Grey level to which the clutter is fitted; 0 keeps the level of `clutter`.
    ///
    /// It is the mean of region C of DAS in slice 1, B-mode.
    pub(super) fitted_c: f64,
    /// Diffuse clutter in the bone's shadow, in both slices.
    pub(super) clutter: DiffuseClutter,
    /// Shadows to try beside that of `clutter` and `simulation`.
    ///
    /// Each has its own fitted level.
    pub(super) tried: Vec<Shadow>,
    /// Array, pulse, transmit, noise.
    pub(super) simulation: Settings,
    /// Delay and beamformer.
    pub(super) receive: Receive,
    /// The B-mode image.
    pub(super) image: Image,
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
            motion: 0.5e-3,
            delay_error: 0.7e-6,
            bone: BoneSurface::default(),
            reverberation: -25.0,
            fitted_c: 92.41,
            clutter: DiffuseClutter {
                level: 10.0,
                coherence: Some(2e-3),
                fall: 0.0,
            },
            tried: Shadow::TRIED.to_vec(),
            // Two beams per element, as the paper's 256, at the rate of its receiver; water at 20 °C.
            simulation: Settings {
                beams: 255,
                beam_step: 0.5,
                fs: 40e6,
                c: 1480.0,
                depth_end: 45e-3,
                noise: Some(-58.0),
                noise_rise: 500.0,
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
