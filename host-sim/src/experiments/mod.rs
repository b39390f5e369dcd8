//! The main job: both phantoms, every method, every check, one result.

mod frame;
mod methods;
mod parameters;
mod picture;
mod point;
mod vertebra;
mod view;

pub use methods::{BEAMFORMERS, Beamformer};
pub use parameters::{Checks, Parameters, Point, Receive, Sampling, Vertebra};
pub use picture::{Pair, Picture};
pub use point::{PointMeasure, PointResult, SamplingResult};
pub use vertebra::{ByImage, ImageLine, Surface, VertebraMeasure, VertebraResult};

use serde::Serialize;

use crate::Result;
use crate::validate::Check;

/// Everything that the main job finds.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    /// The point scatterer.
    pub point: PointResult,
    /// The vertebra.
    pub vertebra: VertebraResult,
    /// The core against its references.
    pub checks: Vec<Check>,
}

/// Runs the main job. `progress` hears, from any thread, what is being done and the fraction of it
/// that is done. The outcome does not depend on the number of threads.
///
/// # Errors
/// Parameters that are out of range or do not fit together.
pub fn run(parameters: &Parameters, progress: &(dyn Fn(&str, f64) + Sync)) -> Result<Outcome> {
    parameters.validate()?;
    // First, since a mesh may turn out not to be one.
    let bone = vertebra::phantom(&parameters.vertebra)?;
    let (point, mut checks) = point::run(parameters, progress)?;
    let (vertebra, found) = vertebra::run(parameters, &bone, progress)?;
    checks.extend(found);
    Ok(Outcome {
        point,
        vertebra,
        checks,
    })
}
