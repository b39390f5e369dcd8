//! Parameters of the vertebra.

use std::path::PathBuf;

use crate::experiments::common::Receive;
use crate::experiments::parameters::positive;
use crate::parameters;
use bonebeam_drive::config::Image;
use bonebeam_files::settings::LENGTHS;
use bonebeam_simulate::Settings;

parameters! {
    /// Section `[vertebra]`.
    Vertebra "vertebra" [simulation, receive, image] {
        /// Closed surface as a PLY file in mm in place of the built-in vertebra.
        ///
        /// +x towards the front, +z towards the head.
        #[serde(skip_serializing_if = "Option::is_none")]
        mesh: Option<PathBuf> = None;
        /// Height of the slice, m, from the middle of the body towards the head.
        slice: f64 = -4e-3;
        /// Depth of the spinous process's tip, m.
        depth: f64 = 15e-3, positive(LENGTHS, " (m)");
        /// Depth of the lateral image line through the laminae, m.
        lateral_line: f64 = 25.5e-3, positive(LENGTHS, " (m)");
        /// Array, pulse, transmit, noise.
        ///
        /// Two beams an element, as the paper's 256 in the water bath; as deep as the image of 512 pixels across the array.
        simulation: Settings = Settings {
            beams: 255,
            beam_step: 0.5,
            depth_end: 44.2e-3,
            ..Settings::vertebra()
        } => Settings::validate;
        /// Delay and beamformer.
        receive: Receive = Receive::to(44.2e-3) => Receive::validate;
        /// The B-mode image.
        image: Image = Image {
            dynamic_range: 70.0,
            median: true,
            ..Image::default()
        } => Image::validate;
    }
}
