//! Working memory of the stages, and of beamformers.

use crate::memory::{Bytes, bytes_of, sum};
use crate::status::Refused;
use crate::vectors::{V, zero};
use bonebeam::beamform::{Sizes, Workspace};
use bonebeam::memory::{Need, Scratch};

/// A workspace in the caller's bytes.
pub(crate) fn workspace(bytes: &mut Bytes, sizes: Sizes) -> Result<Workspace<'static, V>, Refused> {
    let need = sizes.need();
    let scratch = Scratch::new(
        bytes.fill(need.real, zero())?,
        bytes.fill(need.complex, bonebeam::Complex::new(zero(), zero()))?,
    );
    Ok(Workspace::new(zero(), sizes, scratch)?)
}

/// Bytes of a [`Workspace`] of this need.
pub(crate) fn workspace_bytes(need: Need) -> usize {
    sum(&[
        bytes_of::<V>(need.real),
        bytes_of::<bonebeam::Complex<V>>(need.complex),
    ])
}

/// Bytes of a stage's memory.
pub(crate) fn need_bytes(need: Need) -> usize {
    sum(&[
        bytes_of::<f32>(need.real),
        bytes_of::<bonebeam::Complex<f32>>(need.complex),
    ])
}

/// The memory of a stage in `bytes`.
pub(crate) fn scratch(bytes: &mut Bytes, need: Need) -> Result<Scratch<'static>, Refused> {
    Ok(Scratch::new(
        bytes.fill(need.real, 0.0)?,
        bytes.fill(need.complex, bonebeam::Complex::ZERO)?,
    ))
}
