//! The beamformers' working memory, for either covariance.

use crate::memory::{Bytes, Zeros, bytes_of, sum};
use crate::status::Status;
use bonebeam::beamform::{Sizes, Slices, WorkspaceView};
#[cfg(feature = "forward")]
use bonebeam::covariance::Forward;
use bonebeam::covariance::{Averaging, Covariance, ForwardBackward};
use bonebeam::simd::ComplexVector;

/// A workspace in the caller's bytes.
pub(crate) enum Workspace {
    #[cfg(feature = "forward")]
    Forward(WorkspaceView<'static, Forward>),
    ForwardBackward(WorkspaceView<'static, ForwardBackward>),
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
    /// Bytes of a workspace.
    pub(crate) fn bytes(sizes: Sizes, covariance: Covariance) -> usize {
        let lengths = sizes.lengths(covariance);
        sum(&[
            bytes_of::<ComplexVector<f32>>(lengths.complex),
            match covariance {
                Covariance::Forward => bytes_of::<ComplexVector<f32>>(lengths.scalars),
                Covariance::ForwardBackward => bytes_of::<f32>(lengths.scalars),
            },
            bytes_of::<f32>(lengths.reals),
        ])
    }

    /// A workspace in `bytes`. Refuses a covariance that is not compiled in.
    pub(crate) fn new(
        bytes: &mut Bytes,
        sizes: Sizes,
        covariance: Covariance,
    ) -> Result<Self, Status> {
        match covariance {
            #[cfg(feature = "forward")]
            Covariance::Forward => Ok(Workspace::Forward(view(bytes, sizes)?)),
            #[cfg(not(feature = "forward"))]
            Covariance::Forward => Err(Status::Parameter),
            Covariance::ForwardBackward => Ok(Workspace::ForwardBackward(view(bytes, sizes)?)),
        }
    }
}

fn view<A: Averaging<f32>>(
    bytes: &mut Bytes,
    sizes: Sizes,
) -> Result<WorkspaceView<'static, A>, Status>
where
    A::Scalar: Zeros,
{
    let lengths = sizes.lengths(A::COVARIANCE);
    let slices = Slices {
        complex: bytes.zeros(lengths.complex)?,
        scalars: bytes.zeros(lengths.scalars)?,
        reals: bytes.zeros(lengths.reals)?,
    };
    Ok(WorkspaceView::new(0.0, sizes, slices)?)
}
