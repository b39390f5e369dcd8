//! A recording of any format in memory.

use std::ops::Range;

use ndarray::Axis;
use num_complex::Complex;

use super::{AlignedData, ChannelData};

/// A recording, of a kind that its keys tell.
#[derive(Clone, Debug, PartialEq)]
pub enum Recording {
    /// Channel data as recorded (`rf` or `iq`).
    Channel(ChannelData),
    /// Aligned data (`x`): no delaying is left to do.
    Aligned(AlignedData),
}

impl Recording {
    /// How many frames there are.
    pub fn frames(&self) -> usize {
        match self {
            Recording::Channel(data) => data.samples.frames(),
            Recording::Aligned(data) => data.x.dim().0,
        }
    }

    /// Some of the frames alone.
    ///
    /// # Panics
    /// Frames that there are not.
    pub fn into_frames(mut self, frames: Range<usize>) -> Self {
        if frames != (0..self.frames()) {
            match &mut self {
                Recording::Channel(data) => data.samples.keep(frames),
                Recording::Aligned(data) => {
                    data.x = data.x.slice_axis(Axis(0), frames.into()).to_owned();
                }
            }
        }
        self
    }

    /// The size of the samples, bytes.
    pub fn bytes(&self) -> usize {
        match self {
            Recording::Channel(data) => data.samples.bytes(),
            Recording::Aligned(data) => data.x.len() * size_of::<Complex<f32>>(),
        }
    }
}
