//! The probe of an application.

use bonebeam::beamform::Sizes;
use bonebeam::prelude::stages::*;

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

    /// Makes the pipeline of [`Probe::PARAMETERS`], with its tables.
    ///
    /// # Errors
    /// Those of [`Pipeline`], for parameters that are not valid.
    fn pipeline() -> Result<Pipeline<'static, Self::Stage>, Error>;

    /// Makes the plan.
    ///
    /// Once a program; plans of several probes can exist together.
    ///
    /// # Errors
    /// As [`Probe::pipeline`].
    fn plan() -> Result<Plan<Self>, Error>
    where
        Self: Sized,
    {
        Ok(Plan::of(Self::pipeline()?))
    }
}

/// Plan of a probe. A chain of another probe does not take it.
///
/// ```compile_fail
/// use bonebeam::memory::Memory;
/// use bonebeam_stream::scan::{Reference, Shallow};
/// use bonebeam_stream::{Chain, Probe};
///
/// let plan = Reference::plan().unwrap();
/// let mut memory = Box::new(Memory::<{ Shallow::NEED.real }, { Shallow::NEED.complex }>::new());
/// let chain = Chain::<Shallow, { Shallow::LINES }>::new(&plan, memory.scratch()); // mismatched types
/// ```
pub struct Plan<P: Probe>(Pipeline<'static, P::Stage>);

impl<P: Probe> Plan<P> {
    /// A plan by a pipeline of the probe.
    ///
    /// For instance with a depth gate, or with directions of sub-lines.
    pub const fn of(pipeline: Pipeline<'static, P::Stage>) -> Self {
        Plan(pipeline)
    }

    /// The pipeline.
    pub const fn pipeline(&self) -> &Pipeline<'static, P::Stage> {
        &self.0
    }
}
