//! The parameters of the vertebra in tissue, and its phantom.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::Result;
use crate::experiments::common::Receive;
use bonebeam_drive::config::{Image, PhaseSymmetry};
use bonebeam_simulate::{
    Block, Bone, BoneSurface, Clutter, DiffuseClutter, Layers, PAPER_DENSITY, Phantom, Settings,
};

/// Block of tissue: from and to, lateral and in depth, m.
pub const TISSUE: [[f64; 2]; 2] = [[-15e-3, 15e-3], [12e-3, 37e-3]];

/// Section `[vertebra_in_tissue]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct VertebraInTissue {
    /// A closed surface in mm in place of the built-in vertebra.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) mesh: Option<PathBuf>,
    /// Height of the slice, m.
    pub(super) slice: f64,
    /// Depth of the spinous process's tip, m.
    pub(super) depth: f64,
    /// Thickness of the slab, m.
    pub(super) thickness: f64,
    /// Scatterers of tissue per mm³. Together they are as bright as the paper's 222.
    pub(super) tissue_density: f64,
    /// How the bone's surface scatters.
    pub(super) bone: BoneSurface,
    /// Amplitude of the bone's image at twice its depth, dB; `None` leaves it out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) reverberation: Option<f64>,
    /// Diffuse clutter in the bone's shadow; `None` leaves it out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) clutter: Option<DiffuseClutter>,
    /// Array, pulse, transmit, noise.
    pub(crate) simulation: Settings,
    /// Delay and beamformer.
    pub(crate) receive: Receive,
    /// K: half the time window, samples.
    pub(super) half_window: usize,
    /// The B-mode image.
    pub(crate) image: Image,
    /// The ridge filter.
    pub(crate) phase_symmetry: PhaseSymmetry,
}

impl Default for VertebraInTissue {
    fn default() -> Self {
        let mut receive = Receive::default();
        receive.0.depth_end = Some(44.2e-3);
        VertebraInTissue {
            mesh: None,
            slice: -4e-3,
            depth: 15e-3,
            thickness: 6e-3,
            tissue_density: 1e-9 * PAPER_DENSITY,
            bone: BoneSurface::default(),
            reverberation: Some(-20.0),
            clutter: Some(DiffuseClutter {
                level: 14.0,
                coherence: Some(2e-3),
                ..DiffuseClutter::default()
            }),
            simulation: Settings {
                depth_end: 44.2e-3,
                ..Settings::volume()
            },
            receive,
            half_window: 10,
            image: Image::default(),
            phase_symmetry: PhaseSymmetry::default(),
        }
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
        block.fill(&mut phantom, Layers::Uniform)?;
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
