//! Blocks of a file's frames: the next is read while one is in use.

use std::ops::Range;
use std::panic::resume_unwind;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread::{Builder, JoinHandle};

use bonebeam_files::{Recording, Result};

use crate::{Format, Variables};

/// Some frames of a file, one block after the other.
///
/// While a block is in use, a thread reads the next one into the memory of the one before. Formats other than .npz
/// take new memory for each block; those that are only read whole are in memory.
pub struct Blocks {
    source: Arc<Source>,
    frames: Range<usize>,
    at_a_time: usize,
    /// The block in use; before the first block, the file's first frame.
    held: Option<Held>,
    /// Memory of the block before it.
    spare: Option<Recording>,
    /// The thread that reads the next block.
    next: Option<JoinHandle<Result<Held>>>,
}

/// What a file's frames are read with.
pub(crate) struct Source {
    pub(crate) path: PathBuf,
    pub(crate) variables: Variables,
    pub(crate) format: Format,
}

/// Frames in memory.
struct Held {
    recording: Recording,
    /// Their indices in the file.
    frames: Range<usize>,
}

impl Source {
    /// Reads some frames into memory that is no longer needed.
    fn read(&self, frames: Range<usize>, spare: Option<Recording>) -> Result<Held> {
        let start = frames.start;
        let recording = match self.format {
            Format::Npz => Recording::read_npz_into(&self.path, frames, spare)?.0,
            _ => {
                drop(spare);
                crate::read(&self.path, &self.variables, frames)?.recording
            }
        };
        let frames = start..start + recording.frames();
        Ok(Held { recording, frames })
    }
}

impl Held {
    fn holds(&self, frames: &Range<usize>) -> bool {
        self.frames.start <= frames.start && frames.end <= self.frames.end
    }
}

impl Blocks {
    /// Blocks of `at_a_time` frames of a file whose first frame, or all, are in memory.
    pub(crate) fn new(
        source: Source,
        first: Recording,
        frames: Range<usize>,
        at_a_time: usize,
    ) -> Self {
        Blocks {
            source: Arc::new(source),
            frames,
            at_a_time,
            held: Some(Held {
                frames: 0..first.frames(),
                recording: first,
            }),
            spare: None,
            next: None,
        }
    }

    /// The block from frame `start` on: a recording and the range of the block in it.
    ///
    /// # Errors
    /// As [`RecordingFile::read`](crate::RecordingFile::read).
    pub fn block(&mut self, start: usize) -> Result<(&Recording, Range<usize>)> {
        let block = self.range(start);
        if let Some(thread) = self.next.take() {
            let read = thread.join().unwrap_or_else(|panic| resume_unwind(panic))?;
            self.spare = self.held.replace(read).map(|held| held.recording);
        }
        let held = match self.held.take() {
            Some(held) if held.holds(&block) => held,
            held => self
                .source
                .read(block.clone(), held.map(|held| held.recording))?,
        };
        let next = self.range(block.end);
        if !next.is_empty() && !held.holds(&next) {
            let (source, spare) = (self.source.clone(), self.spare.take());
            let read = move || source.read(next, spare);
            // If there is no thread, the block is read when it is asked for.
            self.next = Builder::new().spawn(read).ok();
        }
        let held = self.held.insert(held);
        let first = block.start.saturating_sub(held.frames.start);
        let end = held.recording.frames().min(first + block.len());
        Ok((&held.recording, first.min(end)..end))
    }

    fn range(&self, start: usize) -> Range<usize> {
        start..self.frames.end.min(start + self.at_a_time)
    }
}
