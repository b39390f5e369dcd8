//! Parameters of the vertebra in tissue.

use crate::experiments::study::*;
use bonebeam_simulate::PAPER_DENSITY;

/// Block of tissue: from and to, lateral and in depth, m.
pub const TISSUE: [[f64; 2]; 2] = [[-15e-3, 15e-3], [12e-3, 37e-3]];

parameters! {
    /// Section `[vertebra_in_tissue]`.
    VertebraInTissue "vertebra_in_tissue" [simulation, receive, image] {
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
