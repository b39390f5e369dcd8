//! The parameters of the vertebra in water, and its phantom.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::Result;
use crate::experiments::common::Receive;
use bonebeam_drive::config::Image;
use bonebeam_simulate::{Phantom, Settings};

/// Section `[vertebra]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Vertebra {
    /// Closed surface as a PLY file in mm in place of the built-in vertebra.
    ///
    /// +x towards the front, +z towards the head.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) mesh: Option<PathBuf>,
    /// Height of the slice, m, from the middle of the body towards the head.
    pub(super) slice: f64,
    /// Depth of the spinous process's tip, m.
    pub(super) depth: f64,
    /// Depth of the lateral image line through the laminae, m.
    pub(super) lateral_line: f64,
    /// Array, pulse, transmit, noise.
    pub(super) simulation: Settings,
    /// Delay and beamformer.
    pub(super) receive: Receive,
    /// The B-mode image.
    pub(super) image: Image,
}

impl Default for Vertebra {
    fn default() -> Self {
        let mut receive = Receive::default();
        receive.0.depth_end = Some(44.2e-3);
        Vertebra {
            mesh: None,
            slice: -4e-3,
            depth: 15e-3,
            lateral_line: 25.5e-3,
            // Two beams an element, as the paper's 256 in the water bath; as deep as the image of 512
            // pixels across the array.
            simulation: Settings {
                beams: 255,
                beam_step: 0.5,
                depth_end: 44.2e-3,
                ..Settings::vertebra()
            },
            receive,
            image: Image {
                dynamic_range: 70.0,
                median: true,
                ..Image::default()
            },
        }
    }
}

impl Vertebra {
    /// The slice of the vertebra in its water bath.
    pub(super) fn phantom(&self) -> Result<Phantom> {
        let phantom = Phantom::slice(self.mesh.as_deref(), self.slice, self.depth, None)?;
        phantom.check_within(&self.simulation)?;
        Ok(phantom)
    }
}
