//! The probe of an application.

use bonebeam::Error;
use bonebeam::beamform::Sizes;
use bonebeam::delay::Stage;
use bonebeam::geometry::Transmit;
use bonebeam::memory::Need;
use bonebeam::pipeline::{Parameters, Pipeline};

/// A probe with its scan, known at compile time.
///
/// [`scan::Reference`](crate::scan::Reference) is an example for I/Q.
pub trait Probe {
    /// The delay stage: `IqDelay` for I/Q, `&Delay` for RF by a constant in flash.
    type Stage: Stage;
    /// Parameters of scan, beamformer and image.
    const PARAMETERS: Parameters<'static>;
    /// Memory of a frame.
    ///
    /// `Parameters::need` of [`Probe::PARAMETERS`].
    const NEED: Need;
    /// Transmit of every beam.
    const TRANSMIT: Transmit<'static>;
    /// Shapes of the beamformer. Constants shorten its loops.
    const SIZES: Sizes = Self::PARAMETERS
        .beamformer
        .sizes(Self::PARAMETERS.scan.array.elements());
    /// Number of lines of a frame.
    const LINES: usize = Self::PARAMETERS.scan.lines.count();

    /// Makes the plan, with the tables of the parameters.
    ///
    /// Once a program; plans of several probes can exist together.
    ///
    /// # Errors
    /// Those of [`Pipeline`], for parameters that are not valid.
    fn plan() -> Result<Plan<Self>, Error>;
}

/// Plan of a probe.
pub type Plan<P> = Pipeline<'static, <P as Probe>::Stage>;
