//! Layers of tissue around a bone.

use crate::Result;
use bonebeam_simulate::{Block, Layers, Phantom, Settings};

/// Density that the layers' amplitudes refer to, scatterers per m³.
const DENSITY: f64 = 60e9;

/// Fills a slab with skin, fat, fasciae and muscle around the bone of `phantom`.
///
/// The slab has a thickness, m, and a number of scatterers per m³, which together are as bright as 60 per mm³.
///
/// # Errors
/// A slab that cannot be filled.
pub fn fill_layers(
    phantom: &mut Phantom,
    [thickness, density]: [f64; 2],
    settings: &Settings,
) -> Result<()> {
    let block = Block {
        x: [-20e-3, 20e-3],
        thickness,
        z: [1e-3, settings.depth_end],
        density,
        seed: settings.seed,
    };
    block.fill(phantom, Layers::Anatomy, &|| ())?;
    let brighter = (DENSITY / density).sqrt();
    for scatterer in &mut phantom.scatterers[phantom.on_bone..] {
        scatterer.amplitude *= brighter;
    }
    Ok(())
}
