//! What an application says of a probe.

use bonebeam::Error;
use bonebeam::beamform::Sizes;
use bonebeam::delay::Stage;
use bonebeam::geometry::Transmit;
use bonebeam::memory::Need;
use bonebeam::pipeline::{Parameters, Pipeline};

/// A probe with its scan: all that is known when the program is compiled.
///
/// [`scan::Reference`](crate::scan::Reference) is one of I/Q.
pub trait Probe {
    /// The delay stage: `IqDelay` for I/Q, `&Delay` for RF by a constant in flash.
    type Stage: Stage;
    /// The scan, and what becomes of it.
    const PARAMETERS: Parameters<'static>;
    /// Memory of a frame: `Parameters::need` or `Parameters::need_of_iq` of [`Probe::PARAMETERS`].
    const NEED: Need;
    /// Every beam's transmit.
    const TRANSMIT: Transmit<'static>;
    /// The beamformer's shapes. Constants make its loops shorter.
    const SIZES: Sizes = Self::PARAMETERS
        .beamformer
        .sizes(Self::PARAMETERS.scan.array.elements());
    /// Lines of a frame.
    const LINES: usize = Self::PARAMETERS.scan.lines.count();

    /// The plan: tables that follow from the parameters. Made once; plans of several probes can lie side by side.
    ///
    /// # Errors
    /// Those of [`Pipeline`], for parameters that are not valid.
    fn plan() -> Result<Plan<Self>, Error>;
}

/// A probe's plan.
pub type Plan<P> = Pipeline<'static, <P as Probe>::Stage>;
