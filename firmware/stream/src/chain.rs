//! From blocks to a bone map: what the main loop does.

use bonebeam::Error;
use bonebeam::beamform::WorkspaceView;
use bonebeam::covariance::Averaging;
use bonebeam::focus::Record;
use bonebeam::geometry::Transmit;
use bonebeam::pipeline::{Frame, Memory, MemoryView, Pipeline};

use crate::Block;

/// The memory of a [`Chain`], for a `static`. `REAL` and `COMPLEX` are those of the pipeline's sizes,
/// `RECORD` is elements times samples of a block.
pub struct ChainMemory<const REAL: usize, const COMPLEX: usize, const RECORD: usize> {
    frame: Memory<REAL, COMPLEX>,
    record: [f32; RECORD],
}

impl<const REAL: usize, const COMPLEX: usize, const RECORD: usize>
    ChainMemory<REAL, COMPLEX, RECORD>
{
    /// What it takes.
    pub const BYTES: usize = size_of::<Self>();

    /// All zero.
    pub const fn new() -> Self {
        ChainMemory {
            frame: Memory::new(),
            record: [0.0; RECORD],
        }
    }

    /// The slices for [`Chain::new`].
    pub fn view(&mut self) -> (MemoryView<'_>, &mut [f32]) {
        (self.frame.view(), &mut self.record)
    }
}

impl<const REAL: usize, const COMPLEX: usize, const RECORD: usize> Default
    for ChainMemory<REAL, COMPLEX, RECORD>
{
    fn default() -> Self {
        Self::new()
    }
}

/// A pipeline at work on blocks: a line at a time, then image and map.
pub struct Chain<'p, 'm> {
    frame: Frame<'p, 'm>,
    record: &'m mut [f32],
}

impl<'p, 'm> Chain<'p, 'm> {
    /// Frames of `pipeline` in memory of its sizes.
    ///
    /// # Errors
    /// As [`Frame::new`].
    pub fn new(
        pipeline: &'p Pipeline<'p>,
        (frame, record): (MemoryView<'m>, &'m mut [f32]),
    ) -> Result<Self, Error> {
        Ok(Chain {
            frame: Frame::new(pipeline, frame)?,
            record,
        })
    }

    /// A line of a block: focused, beamformed, its envelope kept for the image.
    ///
    /// # Errors
    /// As [`Frame::line`]; [`Error::Length`] where the memory was made for other blocks.
    pub fn line<A: Averaging<f32>, const M: usize, const N: usize>(
        &mut self,
        line: usize,
        transmit: Transmit,
        block: &Block<i16, M, N>,
        workspace: &mut WorkspaceView<'_, A>,
    ) -> Result<(), Error> {
        planar(&block.samples, self.record)?;
        let record = Record::new(self.record, M)?;
        self.frame.line(line, [(transmit, &record)], workspace)?;
        Ok(())
    }

    /// The image of the lines, row-major, 0 to 255.
    ///
    /// # Errors
    /// As [`Frame::image`].
    pub fn image(&mut self) -> Result<&[f32], Error> {
        self.frame.image()
    }

    /// The bone map of the last image, row-major, 0 to below 1.
    ///
    /// # Errors
    /// As [`Frame::bone_map`].
    pub fn map(&mut self) -> Result<&mut [f32], Error> {
        self.frame.bone_map()
    }
}

/// `[sample][element]` of integers to `[element][sample]` of numbers.
fn planar<const M: usize, const N: usize>(
    samples: &[[i16; M]; N],
    record: &mut [f32],
) -> Result<(), Error> {
    if record.len() != M * N {
        return Err(Error::Length {
            name: "record memory",
            actual: record.len(),
            expected: M * N,
        });
    }
    for (element, record) in record.chunks_exact_mut(N.max(1)).enumerate() {
        for (value, row) in record.iter_mut().zip(samples) {
            if let Some(sample) = row.get(element) {
                *value = (*sample).into();
            }
        }
    }
    Ok(())
}
