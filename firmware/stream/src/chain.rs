//! From blocks to a bone map: what the main loop does, for the scan of [`scan`](crate::scan).

use bonebeam::Error;
use bonebeam::beamform::Sizes;
use bonebeam::covariance::Covariance;
use bonebeam::delay::{IqDelay, IqLayout, IqRecord, IqSamples};
use bonebeam::memory::{Memory, Need};
use bonebeam::pipeline::{Frame, Pipeline};

use crate::scan::{ELEMENTS, INPUT, PARAMETERS, ScanBlock, TRANSMIT};

/// The plan: what follows from the parameters once and for all.
pub type Plan = Pipeline<'static, IqDelay>;

/// The scan's plan.
///
/// # Errors
/// None: the parameters of [`scan`](crate::scan) are valid.
pub fn plan() -> Result<Plan, Error> {
    Pipeline::of_iq(PARAMETERS, INPUT)
}

const NEED: Need = match PARAMETERS.need_of_iq(Covariance::ForwardBackward) {
    Ok(need) => need,
    Err(_) => panic!("the scan is not valid"),
};

/// The beamformer's shapes. They are constants, which makes its loops shorter.
const SIZES: Sizes = PARAMETERS.beamformer.sizes(ELEMENTS);

/// The memory of a [`Chain`], for a `static`.
pub type ChainMemory = Memory<{ NEED.real }, { NEED.complex }>;

/// A plan at work on blocks: a line at a time, then image and map.
pub struct Chain<'m> {
    frame: Frame<'m, 'm, IqDelay>,
}

impl<'m> Chain<'m> {
    /// A chain that has seen no block.
    ///
    /// # Errors
    /// [`Error::Length`] for a plan of other sizes than the scan's. Another beamformer of the scan's
    /// subaperture and time window, another reading and a depth gate change none.
    pub fn new(plan: &'m Plan, memory: &'m mut ChainMemory) -> Result<Self, Error> {
        Ok(Chain {
            frame: Frame::new(plan, memory.scratch())?,
        })
    }

    /// Focuses and beamforms a line's block, and keeps its envelope for the image.
    ///
    /// # Errors
    /// [`Error::Capacity`] for a line that the scan does not have.
    pub fn line(&mut self, line: usize, block: &ScanBlock) -> Result<(), Error> {
        let samples = IqSamples::Counts(block.samples.as_flattened(), 1.0);
        let record = IqRecord::new(samples, IqLayout::Interleaved, ELEMENTS)?;
        let transmits = [(TRANSMIT, &record)];
        self.frame.line_by(SIZES, line, transmits).map(drop)
    }

    /// The image of the lines, row-major, 0 to 255.
    ///
    /// # Errors
    /// None: lines are finite.
    pub fn image(&mut self) -> Result<&[f32], Error> {
        self.frame.image()
    }

    /// The bone map of the last image, row-major, 0 to below 1.
    ///
    /// # Errors
    /// None: images are finite.
    pub fn map(&mut self) -> Result<&[f32], Error> {
        Ok(self.frame.bone_map()?)
    }
}
