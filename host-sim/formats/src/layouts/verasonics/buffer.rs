//! Samples of a receive buffer.

use std::ops::Range;

use ndarray::{Array2, Array4, Axis};

use super::{Acquisition, Workspace};
use crate::receivers::NONE;
use crate::values::Values;
use bonebeam_files::Result;
use bonebeam_files::memory::{self, product};

impl Workspace<'_> {
    /// Samples of the acquisitions, and the number of frames in the buffer.
    pub(super) fn samples(
        &mut self,
        rows: &[Range<usize>],
        elements: usize,
        (number, frames): (usize, Range<usize>),
    ) -> Result<(Array4<f32>, usize)> {
        let buffers = self.entries("RcvData");
        if buffers.is_empty() {
            let without = "is a Verasonics workspace without `RcvData`, its samples; save them in it, or name them by \
                           --variable rf=NAME with their keys";
            return self.refuse(without.into());
        }
        let Some(buffer) = buffers.get(number.wrapping_sub(1)) else {
            return self.refuse(format!(
                "has {} buffers in `RcvData`; `Receive.bufnum` is {number}",
                buffers.len()
            ));
        };
        let in_parts = self
            .source
            .shape_for_parts(buffer)?
            .filter(|shape| shape.len() == 3);
        let held = self
            .source
            .sides(buffer)
            .and_then(|sides| sides.get(2).copied())
            .unwrap_or(1);
        let oldest = self.oldest(number, held)?;
        let mut parts = Vec::new();
        for frames in match in_parts {
            Some(_) => in_memory(frames, oldest, held),
            None => std::iter::once(0..held).collect(),
        } {
            let part = in_parts.is_some().then_some((2, frames));
            match self.source.samples(buffer, part)? {
                Values::Real(data) => parts.push(data),
                Values::Complex(_) => {
                    return self.refuse("`RcvData` is complex; expected RF".into());
                }
            }
        }
        let views: Vec<_> = parts.iter().map(|part| part.view()).collect();
        let axis = Axis(
            views
                .first()
                .map_or(0, |view| view.ndim().min(3).saturating_sub(1)),
        );
        let data = ndarray::concatenate(axis, &views)
            .map_err(|e| self.source.error(format!("`RcvData`: {e}")))?;
        let there = data.shape().to_vec();
        let last = rows.iter().map(|rows| rows.end).max().unwrap_or(0);
        if !(2..=3).contains(&there.len()) || there[0] < last {
            return self.refuse(format!(
                "`RcvData` has shape {there:?}; expected [at least {last} rows, channel, frame]"
            ));
        }
        let channels = self.channels(elements, there[1])?;
        let shape = (
            there.get(2).copied().unwrap_or(1),
            rows.len(),
            elements,
            rows.first().map_or(0, ExactSizeIterator::len),
        );
        // Acquisitions may have rows in common.
        let bytes = product(&[shape.0, shape.1, shape.2, shape.3, size_of::<f32>()]);
        memory::check(bytes, "the samples").map_err(|e| self.source.error(e.to_string()))?;
        let rf = Array4::from_shape_fn(shape, |(frame, transmit, m, n)| {
            let (row, channel) = (rows[transmit].start + n, channels[m]);
            let frame = match in_parts {
                Some(_) => frame,
                None => (frame + oldest) % held,
            };
            match data.ndim() {
                2 => data[[row, channel]],
                _ => data[[row, channel, frame]],
            }
        });
        Ok((rf, held))
    }

    /// The channel of each element, `[acquisition, element]`, if `Receive.Apod` leaves some out.
    pub(super) fn receivers(
        &mut self,
        all: &[Acquisition],
        elements: usize,
    ) -> Result<Option<Array2<usize>>> {
        let names = self.entries("Receive.Apod");
        let mut channels = Array2::from_shape_fn((all.len(), elements), |(_, m)| m);
        let mut is_weighted = false;
        for (mut row, one) in channels.outer_iter_mut().zip(all) {
            let Some(name) = names.get(one.receive) else {
                return Ok(None);
            };
            let weights = self.source.vector(name)?;
            if weights.len() != elements {
                return self.refuse(format!(
                    "`Receive.Apod` has {} numbers; expected one for each of {elements} elements",
                    weights.len()
                ));
            }
            for (channel, &weight) in row.iter_mut().zip(&weights) {
                is_weighted |= weight != 0.0 && weight != 1.0;
                if weight == 0.0 {
                    *channel = NONE;
                }
            }
        }
        if is_weighted {
            let why =
                "the samples keep the weights of Receive.Apod, some of which are neither 0 nor 1";
            self.assumed.push(why.into());
        }
        Ok(channels
            .iter()
            .any(|&channel| channel == NONE)
            .then_some(channels))
    }

    /// Periods of the carrier from one pair of samples to the next.
    ///
    /// `None` if every sample was kept.
    pub(super) fn periods(&self) -> Result<Option<usize>> {
        let modes = self.entries("Receive.sampleMode");
        let Some(mode) = modes.first() else {
            return Ok(None);
        };
        match self.source.text(mode)?.as_str() {
            "NS200BW" => Ok(None),
            "BS100BW" => Ok(Some(1)),
            "BS50BW" => Ok(Some(2)),
            mode => self.refuse(format!(
                "was sampled with `Receive.sampleMode` {mode}, which is not read; expected NS200BW, BS100BW or BS50BW"
            )),
        }
    }

    /// Place of the oldest frame in a buffer, which is a ring: that after the last one written.
    fn oldest(&mut self, number: usize, held: usize) -> Result<usize> {
        let last = self.entries("Resource.RcvBuffer.lastFrame");
        let Some(name) = last.get(number.wrapping_sub(1)) else {
            return Ok(0);
        };
        // The cast saturates.
        let last = self.source.scalar(name)? as usize;
        if last == 0 || last >= held {
            return Ok(0);
        }
        self.assumed.push(format!(
            "frames are in the order of time: the first is {} in memory, after Resource.RcvBuffer.lastFrame",
            last + 1
        ));
        Ok(last)
    }
}

/// Places in memory of some frames of a ring of `held`, of which the first in time is `oldest`.
fn in_memory(frames: Range<usize>, oldest: usize, held: usize) -> Vec<Range<usize>> {
    let (start, end) = (
        frames.start.min(held) + oldest,
        frames.end.min(held) + oldest,
    );
    match (start >= held, end > held) {
        (true, _) => std::iter::once(start - held..end.max(start) - held).collect(),
        (false, true) => vec![start..held, 0..end - held],
        (false, false) => std::iter::once(start..end).collect(),
    }
}
