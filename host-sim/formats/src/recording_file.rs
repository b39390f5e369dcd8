//! Reads recordings from files a few frames at a time.

use std::borrow::Cow;
use std::ops::Range;
use std::path::{Path, PathBuf};

use bonebeam_files::atomic::Outputs;
use bonebeam_files::{Recording, Result};

use crate::export::add_recording;
use crate::{Export, Format, Found, Variables};

/// Bytes of samples to read at a time; at least one frame.
const AT_A_TIME: usize = 16 << 20;

/// The file of a recording, whose frames are read a few at a time.
///
/// So it may be larger than memory. Formats that are only read whole are in memory.
pub struct RecordingFile {
    path: PathBuf,
    variables: Variables,
    format: Format,
    frames: usize,
    /// The first frame, or all.
    first: Recording,
    assumed: Vec<String>,
}

impl RecordingFile {
    /// Reads all but the frames after the first.
    ///
    /// `variables` describe the file's arrays.
    ///
    /// # Errors
    /// As [`crate::read`], and variables that have no effect on that format.
    pub fn open(path: &Path, variables: &Variables) -> Result<Self> {
        let found = crate::read(path, variables, 0..1)?;
        Ok(Self {
            path: path.to_path_buf(),
            variables: variables.clone(),
            format: found.format,
            frames: found.frames,
            first: found.recording,
            assumed: found.assumed,
        })
    }

    /// Format of the file.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Assumed values that the file does not give.
    pub fn assumed(&self) -> &[String] {
        &self.assumed
    }

    /// Number of frames in the file.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// The first frame, or all frames, with the data shared by the frames.
    pub fn first(&self) -> &Recording {
        &self.first
    }

    /// Number of frames to read at a time; at least one.
    pub fn frames_at_a_time(&self) -> usize {
        let frame = self.first.bytes() / self.first.frames().max(1);
        (AT_A_TIME / frame.max(1)).max(1)
    }

    /// Reads some frames; returns a recording and the range of those frames in it.
    ///
    /// # Errors
    /// As [`RecordingFile::open`].
    pub fn read(&self, frames: Range<usize>) -> Result<(Cow<'_, Recording>, Range<usize>)> {
        if frames.end <= self.first.frames() {
            return Ok((Cow::Borrowed(&self.first), frames));
        }
        let Found { recording, .. } = crate::read(&self.path, &self.variables, frames)?;
        let all = 0..recording.frames();
        Ok((Cow::Owned(recording), all))
    }

    /// Reads some frames into the memory of earlier ones in `spare`.
    ///
    /// Not all formats allow that. If so, all frames together need the memory of one.
    ///
    /// # Errors
    /// As [`RecordingFile::read`].
    pub fn read_into<'s>(
        &'s self,
        frames: Range<usize>,
        spare: &'s mut Option<Recording>,
    ) -> Result<(&'s Recording, Range<usize>)> {
        if frames.end <= self.first.frames() {
            return Ok((&self.first, frames));
        }
        let recording = match self.format {
            Format::Npz => Recording::read_npz_into(&self.path, frames, spare.take())?.0,
            _ => crate::read(&self.path, &self.variables, frames)?.recording,
        };
        let all = 0..recording.frames();
        Ok((spare.insert(recording), all))
    }

    /// Stages the recording in a format, a few frames at a time.
    ///
    /// # Errors
    /// Data that are not valid or that the format cannot hold, or a file that cannot be written.
    pub fn add_to(&self, export: Export, path: &Path, outputs: &mut Outputs) -> Result<()> {
        let step = self.frames_at_a_time();
        let parts = (0..self.frames).step_by(step);
        let parts = parts.map(|first| self.read(first..self.frames.min(first + step)));
        match export {
            Export::Npz => self.first.add_npz_to(self.frames, parts, path, outputs),
            _ => add_recording(export, (&self.first, self.frames), parts, path, outputs),
        }
    }
}
