//! Working memory of the stages, and of beamformers with either covariance.

use crate::memory::{Bytes, bytes_of, sum};
use crate::status::Status;
use crate::vectors::{V, zero};
use bonebeam::beamform::{self, Sizes};
#[cfg(feature = "forward")]
use bonebeam::covariance::Forward;
use bonebeam::covariance::{Covariance, ForwardBackward};
use bonebeam::memory::{Need, Scratch};

/// A workspace in the caller's bytes.
pub(crate) enum Workspace {
    #[cfg(feature = "forward")]
    Forward(beamform::Workspace<'static, Forward, V>),
    ForwardBackward(beamform::Workspace<'static, ForwardBackward, V>),
}

/// Evaluates an expression of the view in a workspace.
macro_rules! with_view {
    ($workspace:expr, $view:ident => $work:expr) => {
        match $workspace {
            #[cfg(feature = "forward")]
            $crate::workspace::Workspace::Forward($view) => $work,
            $crate::workspace::Workspace::ForwardBackward($view) => $work,
        }
    };
}
pub(crate) use with_view;

impl Workspace {
    /// A workspace in `bytes`. Refuses a covariance that is not compiled in.
    pub(crate) fn new(
        bytes: &mut Bytes,
        sizes: Sizes,
        covariance: Covariance,
    ) -> Result<Self, Status> {
        let need = sizes.need(covariance);
        let scratch = Scratch {
            real: bytes.fill(need.real, zero())?,
            complex: bytes.fill(need.complex, bonebeam::Complex::new(zero(), zero()))?,
        };
        match covariance {
            #[cfg(feature = "forward")]
            Covariance::Forward => Ok(Workspace::Forward(beamform::Workspace::new(
                zero(),
                sizes,
                scratch,
            )?)),
            #[cfg(not(feature = "forward"))]
            Covariance::Forward => Err(Status::Parameter),
            Covariance::ForwardBackward => Ok(Workspace::ForwardBackward(
                beamform::Workspace::new(zero(), sizes, scratch)?,
            )),
        }
    }
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
pub(crate) fn scratch(bytes: &mut Bytes, need: Need) -> Result<Scratch<'static>, Status> {
    Ok(Scratch {
        real: bytes.fill(need.real, 0.0)?,
        complex: bytes.fill(need.complex, bonebeam::Complex::ZERO)?,
    })
}
