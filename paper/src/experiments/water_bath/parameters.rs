//! The parameters of the water bath.

use crate::experiments::study::*;
use crate::measure::registration::Point;

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

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the key, the value and the range.
    pub(super) fn validate(&self) -> Result<()> {
        const SECTION: &str = "water_bath";
        if self.coherence.is_nan() || self.coherence < 0.0 {
            let (value, key) = (self.coherence, "tried.coherence");
            let expected = "at least 0 (m), inf for clutter that focuses perfectly";
            return Err(out_of_range(SECTION, key, value, expected));
        }
        level().check(&self.noise, SECTION, "tried.noise")?;
        let rise = within([0.0, 2000.0], " (dB per m)");
        rise.check(&self.noise_rise, SECTION, "tried.noise_rise")
    }
}

parameters! {
    /// Section `[water_bath]`.
    WaterBath "water_bath" [simulation, receive, image] {
        /// Closed surface (PLY, STL or OBJ file) in place of the built-in vertebra.
        ///
        /// In mm, +x towards the front, +z towards the head.
        #[serde(skip_serializing_if = "Option::is_none")]
        mesh: Option<PathBuf> = None;
        /// Height of the vertebra at the middle of the sweep, m.
        ///
        /// It counts from the middle of its body towards the head.
        height: f64 = -4e-3, within([-0.1, 0.1], " (m)");
        /// Depth of its shallowest point, m.
        depth: f64 = 15e-3, positive(LENGTHS, " (m)");
        /// Elevations of slices 1 and 2, m from the middle of the sweep.
        slices: [f64; 2] = [0.0, -4.5e-3], within([-0.1, 0.1], " (m)");
        /// Depths of the lines across them, m.
        lines: [f64; 2] = [17.5e-3, 17.5e-3], positive(LENGTHS, " (m)");
        /// Slices of the volume.
        sweep: usize = 61, within([2.0, 1000.0], "");
        /// Distance between them, m.
        sweep_step: f64 = 0.5e-3, positive(LENGTHS, " (m)");
        /// Scatterers on bone in the sweep, per mm² (assumed).
        ///
        /// There are fewer than in the two slices, to save time.
        sweep_density: f64 = 10.0, within([0.1, 1000.0], " (per mm²)");
        /// Thickness of the slab with scatterers around a slice, m.
        thickness: f64 = 6e-3, positive(LENGTHS, " (m)");
        /// Speed of sound that the scanner assumes, m/s; the water's is `simulation.c`.
        assumed_sound_speed: f64 = 1540.0, within([1000.0, 2000.0], " (m/s)");
        /// The CT scanner's voxels, m.
        ct_voxel: [f64; 3] = [0.19e-3, 0.19e-3, 0.3e-3], positive(LENGTHS, " (m)");
        /// Full width at half maximum of its point spread, m (assumed).
        ct_blur: f64 = 0.8e-3, within([0.0, 5e-3], " (m)");
        /// Density of bone, HU (assumed).
        ct_bone: f64 = 1200.0, within([0.0, 5000.0], " (HU)");
        /// Density of the plastic balls, HU (assumed).
        ct_ball: f64 = 100.0, within([-400.0, 5000.0], " (HU)");
        /// Standard deviation of a further picking error along each axis, m (assumed).
        ///
        /// It applies to the repeated registrations.
        picking_error: f64 = 0.1e-3, within([0.0, 5e-3], " (m)");
        /// Motion of the specimen along each axis over the sweep, m (assumed).
        ///
        /// It applies to the rows with motion in the tables of sources.
        motion: f64 = 0.5e-3, within([0.0, 5e-3], " (m)");
        /// Delay of trigger and lens that the scanner does not correct, s (assumed).
        ///
        /// It applies to the table of the bias of Fig. 8a: 1 mm of a lens of 1000 m/s, both ways.
        delay_error: f64 = 0.7e-6, within([0.0, 1e-5], " (s)");
        /// Scattering of the bone's surface in the two slices.
        ///
        /// In the sweep it is smooth.
        bone: BoneSurface = BoneSurface::default();
        /// Level of the bone's echo that the array reflects, dB (assumed).
        reverberation: f64 = -25.0, level();
        /// Grey level to which the clutter is fitted; 0 keeps the level of `clutter`.
        ///
        /// It is the mean of region C of DAS in slice 1, B-mode.
        fitted_c: f64 = 92.41, within([0.0, 255.0], " (grey level)");
        /// Diffuse clutter in the bone's shadow, in both slices.
        clutter: DiffuseClutter = DiffuseClutter {
            level: 10.0,
            coherence: Some(2e-3),
            fall: 0.0,
        };
        /// Shadows to try beside that of `clutter` and `simulation`.
        ///
        /// Each has its own fitted level.
        tried: Vec<Shadow> = Shadow::TRIED.to_vec();
        /// Array, pulse, transmit, noise.
        ///
        /// Two beams per element, as the paper's 256, at the rate of its receiver; water at 20 °C.
        simulation: Settings = Settings {
            beams: 255,
            beam_step: 0.5,
            fs: 40e6,
            c: 1480.0,
            depth_end: 45e-3,
            noise: Some(-58.0),
            noise_rise: 500.0,
            ..Settings::volume()
        } => Settings::validate;
        /// Delay and beamformer.
        receive: Receive = Receive::to(44.4e-3) => Receive::validate;
        /// The B-mode image.
        image: Image = Image {
            dynamic_range: 70.0,
            rows: Some(512),
            columns: Some(512),
            median: true,
            ..Image::default()
        } => Image::validate;
    }
}
