//! Blocks of a file's frames: the next is read while one is in use.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::Builder;

use bonebeam_files::{Recording, Result, SharedHash};

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
    reader: Option<Reader>,
    /// Whether the reader was asked for a block.
    is_asked: bool,
}

/// A thread that reads blocks into memory that is no longer needed.
struct Reader {
    asked: Sender<(Range<usize>, Option<Recording>)>,
    read: Receiver<Result<Held>>,
}

/// A file, and the parameters to read its frames.
pub(crate) struct Source {
    pub(crate) path: PathBuf,
    pub(crate) variables: Variables,
    pub(crate) format: Format,
    /// The hash of the file, if it is an .npz archive.
    pub(crate) hash: Option<SharedHash>,
}

/// Frames in memory.
struct Held {
    recording: Recording,
    /// Indices of the frames in the file.
    frames: Range<usize>,
}

impl Source {
    /// Reads some frames into memory that is no longer needed.
    fn read(&self, frames: Range<usize>, spare: Option<Recording>) -> Result<Held> {
        let start = frames.start;
        let recording = match self.format {
            Format::Npz => {
                let hash = self.hash.clone();
                let mut recording = Recording::read_npz(&self.path, frames, spare, hash)?.0;
                if let Recording::Channel(data) = &mut recording {
                    data.samples.centre();
                }
                recording
            }
            _ => {
                drop(spare);
                crate::read(&self.path, &self.variables, frames)?.recording
            }
        };
        let frames = start..start + recording.frames();
        Ok(Held { recording, frames })
    }
}

impl Reader {
    /// Begins the thread. If there is none, it cannot be asked.
    fn new(source: Arc<Source>) -> Self {
        let (asked, receiver) = channel();
        let (sender, read) = channel();
        let serve = move || {
            for (frames, spare) in receiver {
                if sender.send(source.read(frames, spare)).is_err() {
                    return;
                }
            }
        };
        let _ = Builder::new().spawn(serve);
        Reader { asked, read }
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
            reader: None,
            is_asked: false,
        }
    }

    /// The block from frame `start` on: a recording and the range of the block in it.
    ///
    /// # Errors
    /// As [`RecordingFile::read`](crate::RecordingFile::read).
    pub fn block(&mut self, start: usize) -> Result<(&Recording, Range<usize>)> {
        let block = self.range(start);
        if std::mem::take(&mut self.is_asked)
            && let Some(reader) = &self.reader
            && let Ok(read) = reader.read.recv()
        {
            self.spare = self.held.replace(read?).map(|held| held.recording);
        }
        let held = match self.held.take() {
            Some(held) if held.holds(&block) => held,
            held => self
                .source
                .read(block.clone(), held.map(|held| held.recording))?,
        };
        let next = self.range(block.end);
        if !next.is_empty() && !held.holds(&next) {
            let new = || Reader::new(self.source.clone());
            let reader = self.reader.get_or_insert_with(new);
            // If there is no thread, the block is read when it is needed.
            self.is_asked = reader.asked.send((next, self.spare.take())).is_ok();
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
