//! Reads recordings from files a few frames at a time.

use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;

use bonebeam_files::atomic::Outputs;
use bonebeam_files::{Recording, Result, Samples, SharedHash};

use crate::blocks::{Blocks, Source};
use crate::export::add_recording;
use crate::hdf5::Store;
use crate::{Export, Format, Found, Variables, zea};

/// Bytes of samples to read at a time; at least one frame.
const AT_A_TIME: usize = 16 << 20;

/// The file of a recording, whose frames are read a few at a time.
///
/// So it may be larger than memory. Formats that are only read whole are in memory.
pub struct RecordingFile {
    source: Source,
    frames: usize,
    /// The first frame, or all.
    first: Recording,
    assumed: Vec<String>,
    unread: Vec<String>,
}

impl RecordingFile {
    /// Reads all but the frames after the first.
    ///
    /// `variables` describe the file's arrays.
    ///
    /// # Errors
    /// As [`crate::read`], and variables that have no effect on that format.
    pub fn open(path: &Path, variables: &Variables) -> Result<Self> {
        Self::open_hashed(path, variables, None)
    }

    /// As [`RecordingFile::open`], with the hash of this file.
    ///
    /// A large frame of focused transmits may then stay in the file.
    ///
    /// Bytes of an .npz archive that is not compressed are passed to the hash when they are read; the hash reads the
    /// others itself.
    ///
    /// # Errors
    /// As [`RecordingFile::open`].
    pub fn open_hashed(
        path: &Path,
        variables: &Variables,
        hash: Option<SharedHash>,
    ) -> Result<Self> {
        let found = crate::read_as_stored(path, variables, 0..1, hash.clone())?;
        Ok(Self {
            source: Source {
                path: path.to_path_buf(),
                variables: variables.clone(),
                format: found.format,
                hash,
            },
            frames: found.frames,
            first: found.recording,
            assumed: found.assumed,
            unread: found.unread,
        })
    }

    /// Format of the file.
    pub fn format(&self) -> Format {
        self.source.format
    }

    /// Assumed values that the file does not give.
    pub fn assumed(&self) -> &[String] {
        &self.assumed
    }

    /// Names of the file's arrays that were not read.
    pub fn unread(&self) -> &[String] {
        &self.unread
    }

    /// The pose of the probe in each frame of a tracked sweep, if the file has poses.
    ///
    /// A position (x, y, z), m, with Euler angles about fixed axes x, y, z, rad, or a quaternion x, y, z, w.
    ///
    /// # Errors
    /// Poses that are not valid.
    pub fn poses(&self) -> Result<Option<Vec<Option<Vec<f64>>>>> {
        let Source {
            path, variables, ..
        } = &self.source;
        match self.format() {
            Format::Zea => zea::poses::read(&Store::open(path, false)?, variables),
            _ => Ok(None),
        }
    }

    /// Number of frames in the file.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// The first frame, or all frames, with the data shared by the frames.
    ///
    /// Samples that an archive stores as i16 are counts.
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
    /// RF is in f32.
    ///
    /// # Errors
    /// As [`RecordingFile::open`].
    pub fn read(&self, frames: Range<usize>) -> Result<(Cow<'_, Recording>, Range<usize>)> {
        if frames.end <= self.first.frames() {
            return Ok((self.first_in_float(), frames));
        }
        let Found { recording, .. } =
            crate::read(&self.source.path, &self.source.variables, frames)?;
        let all = 0..recording.frames();
        Ok((Cow::Owned(recording), all))
    }

    fn first_in_float(&self) -> Cow<'_, Recording> {
        match &self.first {
            Recording::Channel(data) if matches!(data.samples, Samples::Counts(_)) => {
                Cow::Owned(self.first.clone().into_float())
            }
            first => Cow::Borrowed(first),
        }
    }

    /// Replaces the hash of [`RecordingFile::open_hashed`].
    pub fn set_hash(&mut self, hash: Option<SharedHash>) {
        self.source.hash = hash;
    }

    /// Splits into the data that all frames share, and blocks of frames.
    ///
    /// The shared data are a recording without frames. The blocks have `at_a_time` of the given `frames` each.
    pub fn into_blocks(mut self, frames: Range<usize>, at_a_time: usize) -> (Recording, Blocks) {
        let shared = self.first.shared();
        let blocks = Blocks::new(self.source, self.first, frames, at_a_time);
        (shared, blocks)
    }

    /// Stages the recording in a format, a few frames at a time.
    ///
    /// # Errors
    /// Data that are not valid or that the format cannot hold, or a file that cannot be written.
    pub fn add_to(&self, export: Export, path: &Path, outputs: &mut Outputs) -> Result<()> {
        let step = self.frames_at_a_time();
        let parts = (0..self.frames).step_by(step);
        let parts = parts.map(|first| self.read(first..self.frames.min(first + step)));
        let first = self.first_in_float();
        match export {
            Export::Npz => first.add_npz_to(self.frames, parts, path, outputs),
            _ => add_recording(export, (&first, self.frames), parts, path, outputs),
        }
    }
}
