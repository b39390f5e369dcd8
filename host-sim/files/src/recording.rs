//! A recording of any format in memory.

use std::borrow::Cow;
use std::io::{Cursor, Seek, Write};
use std::ops::Range;
use std::path::Path;

use ndarray::{Array3, Array4, Axis};
use num_complex::Complex;

use super::atomic::Outputs;
use super::{AlignedData, ChannelData, FrameSamples, LineFrames, Samples, SharedHash};
use super::{hash, npz, npz_writer};
use crate::memory::product;
use crate::{Error, Result};

/// A recording, of the kind that its keys show.
#[derive(Clone, Debug, PartialEq)]
pub enum Recording {
    /// Channel data as recorded (`rf` or `iq`).
    Channel(ChannelData),
    /// Aligned data (`x`), already delayed.
    Aligned(AlignedData),
    /// Lines (`z`), already beamformed.
    Lines(LineFrames),
}

impl Recording {
    /// A hash of the samples of a frame that exists.
    pub fn frame_hash(&self, frame: usize) -> u128 {
        match self {
            Recording::Channel(data) => match data.samples.frame(frame) {
                Some(FrameSamples::Rf(rf)) => hash::of_array(&rf),
                Some(FrameSamples::Counts(counts)) => hash::of_array(&counts),
                Some(FrameSamples::Iq { iq, .. }) => hash::of_array(&iq),
                Some(FrameSamples::Stored(_)) | None => 0,
            },
            Recording::Aligned(data) => hash::of_array(&data.x.index_axis(Axis(0), frame)),
            Recording::Lines(lines) => hash::of_array(&lines.z.index_axis(Axis(0), frame)),
        }
    }

    /// Reads some frames of a `.npz` archive of any kind, and the number of all.
    ///
    /// Lines are read whole.
    ///
    /// The frames are read into the memory of `spare`, a recording that is no longer needed. Samples stored as i16 stay
    /// i16. Bytes of samples that are stored uncompressed are passed to `hash`, the hash of this file.
    ///
    /// # Errors
    /// The file cannot be opened, has keys of several kinds or of none, or is not valid.
    pub fn read_npz(
        path: &Path,
        frames: Range<usize>,
        spare: Option<Self>,
        hash: Option<SharedHash>,
    ) -> Result<(Self, usize)> {
        let spare = spare.map(Self::into_spare).unwrap_or_default();
        let file = npz::Reader::open(path)?.with_spare(spare);
        Self::of_npz(&mut file.with_hash(hash), frames)
    }

    /// As [`Recording::read_npz`], from an open archive.
    ///
    /// # Errors
    /// As [`Recording::read_npz`].
    pub fn of_npz(file: &mut npz::Reader, frames: Range<usize>) -> Result<(Self, usize)> {
        match (file.has("rf") || file.has("iq"), file.has("x")) {
            (true, false) => {
                let (data, frames) = ChannelData::from_npz(file, frames)?;
                Ok((Recording::Channel(data), frames))
            }
            (false, true) => {
                let (data, frames) = AlignedData::from_npz(file, frames)?;
                Ok((Recording::Aligned(data), frames))
            }
            (true, true) => Err(file.error(
                "holds both `rf` or `iq` (channel data) and `x` (aligned data); expected one of them",
            )),
            (false, false) if file.has("z") && file.has("beam_x") => {
                let lines = LineFrames::from_npz(file)?;
                let frames = lines.z.dim().0;
                Ok((Recording::Lines(lines), frames))
            }
            (false, false) => Err(file.error(
                "holds neither `rf` or `iq` (channel data) nor `x` (aligned data), and no lines (`z` and `beam_x`, or `lines`)",
            )),
        }
    }

    /// Stages a recording of `count` frames as a `.npz` archive.
    ///
    /// The frames are those of `parts`, in order; all else is that of this recording. Each part is a recording and
    /// the range of its frames.
    ///
    /// # Errors
    /// Errors of a part, data that are not valid, or a file that cannot be written.
    pub fn add_npz_to<'a>(
        &self,
        count: usize,
        parts: impl Iterator<Item = Result<(Cow<'a, Recording>, Range<usize>)>>,
        path: &Path,
        outputs: &mut Outputs,
    ) -> Result<()> {
        outputs.add(path, |sink| self.write_npz(count, parts, sink))
    }

    fn write_npz<'a, W: Write + Seek>(
        &self,
        count: usize,
        parts: impl Iterator<Item = Result<(Cow<'a, Recording>, Range<usize>)>>,
        sink: W,
    ) -> std::result::Result<(), Box<dyn std::error::Error>> {
        let frame = self.bytes() / self.frames().max(1);
        let mut npz = npz_writer::Writer::new(sink, product(&[frame, count]));
        match self {
            Recording::Channel(data) => data.samples.begin_npz(count, &mut npz)?,
            Recording::Aligned(data) => data.begin_npz(count, &mut npz)?,
            Recording::Lines(lines) => lines.begin_npz(count, &mut npz)?,
        }
        for part in parts {
            let (recording, own) = part?;
            match recording.as_ref() {
                Recording::Channel(data) => data.samples.append_npz(own, &mut npz)?,
                Recording::Aligned(data) => data.append_npz(own, &mut npz)?,
                Recording::Lines(lines) => npz.append(&lines.z.slice_axis(Axis(0), own.into()))?,
            }
        }
        match self {
            Recording::Channel(data) => Ok(data.finish_npz(npz)?),
            Recording::Aligned(data) => Ok(data.finish_npz(npz)?),
            Recording::Lines(lines) => Ok(lines.finish_npz(npz)?),
        }
    }

    /// The bytes of a `.npz` archive of all frames.
    ///
    /// # Errors
    /// Data that are not valid.
    pub fn npz(&self) -> Result<Vec<u8>> {
        let mut bytes = Cursor::new(Vec::new());
        let all = Ok((Cow::Borrowed(self), 0..self.frames()));
        let written = self.write_npz(self.frames(), std::iter::once(all), &mut bytes);
        written.map_err(|e| Error::Data(format!("the recording cannot be written: {e}")))?;
        Ok(bytes.into_inner())
    }

    fn into_spare(self) -> npz::Spare {
        let mut spare = npz::Spare::default();
        match self {
            Recording::Channel(data) => data.samples.leave(&mut spare),
            Recording::Aligned(data) => spare.complex = data.x.into_raw_vec_and_offset().0,
            Recording::Lines(_) => {}
        }
        spare
    }

    /// The recording with [`Samples::into_float`].
    pub fn into_float(self) -> Self {
        match self {
            Recording::Channel(data) => Recording::Channel(ChannelData {
                samples: data.samples.into_float(),
                ..data
            }),
            other => other,
        }
    }

    /// A copy without frames, with the data that all frames share.
    pub fn shared(&mut self) -> Self {
        match self {
            Recording::Channel(data) => {
                let none = match data.samples.frame(0) {
                    Some(frame) => frame.none(),
                    None => data.samples.clone(),
                };
                let samples = std::mem::replace(&mut data.samples, none);
                let shared = data.clone();
                data.samples = samples;
                Recording::Channel(shared)
            }
            Recording::Aligned(data) => {
                let (_, beams, samples, elements) = data.x.dim();
                Recording::Aligned(AlignedData {
                    x: Array4::default((0, beams, samples, elements)),
                    beam_x: data.beam_x.clone(),
                    ..*data
                })
            }
            Recording::Lines(lines) => {
                let (_, beams, samples) = lines.z.dim();
                Recording::Lines(lines.with_samples(Array3::default((0, beams, samples))))
            }
        }
    }

    /// Number of frames.
    pub fn frames(&self) -> usize {
        match self {
            Recording::Channel(data) => data.samples.frames(),
            Recording::Aligned(data) => data.x.dim().0,
            Recording::Lines(lines) => lines.z.dim().0,
        }
    }

    /// Only some of the frames.
    ///
    /// # Panics
    /// If a frame does not exist.
    pub fn into_frames(mut self, frames: Range<usize>) -> Self {
        if frames != (0..self.frames()) {
            match &mut self {
                Recording::Channel(data) => data.samples.keep(frames),
                Recording::Aligned(data) => {
                    data.x = data.x.slice_axis(Axis(0), frames.into()).to_owned();
                }
                Recording::Lines(lines) => {
                    lines.z = lines.z.slice_axis(Axis(0), frames.into()).to_owned();
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
            Recording::Lines(lines) => lines.z.len() * size_of::<Complex<f32>>(),
        }
    }
}

impl ChannelData {
    /// The recording of some transmits.
    ///
    /// # Panics
    /// If a transmit does not exist, or is in a file that cannot be read.
    #[must_use]
    pub fn only(&self, transmits: &[usize]) -> Self {
        let samples = match &self.samples {
            Samples::Rf(rf) => Samples::Rf(rf.select(Axis(1), transmits)),
            Samples::Counts(counts) => Samples::Counts(counts.select(Axis(1), transmits)),
            Samples::Iq { iq, f_demod } => Samples::Iq {
                iq: iq.select(Axis(1), transmits),
                f_demod: *f_demod,
            },
            Samples::Stored(stored) => {
                let read = stored.read(transmits, &mut npz::Spare::default());
                read.expect("the file is as it was when it was opened")
            }
        };
        Self {
            samples,
            t0: transmits.iter().map(|&k| self.t0[k]).collect(),
            element_x: self.element_x.clone(),
            element_z: self.element_z.clone(),
            element_angle: self.element_angle.clone(),
            transmits: self.transmits.only(transmits),
            ..*self
        }
    }
}
