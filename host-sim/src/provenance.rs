//! Provenance of a result: the program's version and commit, hashes of the inputs.

use std::fs::{self, Metadata};
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration, SystemTime};

use crate::{Error, Result};
use bonebeam_files::{FileHash, SharedHash, cannot_be_opened, file_error};

/// The program's version.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Commit of the build; `unknown` outside a repository.
pub const COMMIT: &str = env!("HOST_SIM_COMMIT");
/// Version and commit, as `--version` prints them.
pub const PROGRAM: &str = concat!(
    env!("CARGO_PKG_VERSION"),
    ", commit ",
    env!("HOST_SIM_COMMIT")
);
/// Largest file that is hashed if only a part of it was used, bytes.
const PART: u64 = 1 << 30;
/// Longer than the resolution of file times: close changes can have the same time.
const CLOCK: Duration = Duration::from_millis(20);

/// An input file of a result.
pub struct Input {
    /// Path as given.
    pub path: PathBuf,
    /// XXH3-128, as `xxh128sum` prints it; `None` for a large file read in part.
    ///
    /// Of a file, over its bytes. Of a folder, over names and bytes of its files in the order of their names.
    pub xxh128: Option<String>,
}

/// State of a file, or of a folder's files, before they are read.
///
/// Readers of archives and of HDF5 seek in a file, skip parts of it and read others twice, so a file is hashed by
/// itself; only frames of an archive that is not compressed are hashed as they are read. The file must not have
/// changed from the snapshot to the end.
pub struct Snapshot {
    path: PathBuf,
    files: Vec<State>,
}

/// A file's path, its length and the time of its last change.
#[derive(PartialEq)]
struct State {
    path: PathBuf,
    bytes: u64,
    changed: Option<SystemTime>,
}

impl Snapshot {
    /// Records the state of a file, or of the files of a folder.
    ///
    /// # Errors
    /// A file that does not exist, or that is being written.
    pub fn of(path: &Path) -> Result<Self> {
        let snapshot = Snapshot {
            path: path.to_path_buf(),
            files: files_of(path)?,
        };
        let age = |file: &State| file.changed.and_then(|time| time.elapsed().ok());
        if snapshot.files.iter().filter_map(age).any(|age| age < CLOCK) {
            thread::sleep(CLOCK);
            snapshot.check()?;
        }
        Ok(snapshot)
    }

    /// Refuses a file that changed.
    ///
    /// # Errors
    /// A changed length or time of change, or a file added or removed.
    pub fn check(&self) -> Result<()> {
        if files_of(&self.path)? == self.files {
            return Ok(());
        }
        let message = "changed while it was read; run again when no program writes to it";
        Err(file_error(&self.path, message))
    }

    /// Hashes the input after it was read.
    ///
    /// # Errors
    /// A file that changed or that cannot be read.
    pub fn hashed(&self) -> Result<Input> {
        self.input(Some(&mut self.hash()))
    }

    /// Begins to hash the input, behind its reader.
    pub fn hashing(&self) -> Hashing<'_> {
        let (read, receiver) = channel();
        let (hash, bytes) = (SharedHash::new(self.hash()), self.bytes());
        let own = hash.clone();
        let (begun, begin) = channel();
        let follow = move || {
            // Its memory is taken before other memory is asked for.
            let _ = begun.send(());
            for fraction in receiver {
                own.lock().up_to((fraction * bytes as f64) as u64)?;
            }
            Ok(())
        };
        let thread = thread::Builder::new().spawn(follow).ok();
        let _ = begin.recv();
        Hashing {
            snapshot: self,
            hash: Some(hash),
            read,
            thread,
        }
    }

    fn hash(&self) -> FileHash {
        let of_folder = self.files.iter().any(|file| file.path != self.path);
        let files = self.files.iter().map(|file| file.path.clone()).collect();
        FileHash::new(files, of_folder)
    }

    fn bytes(&self) -> u64 {
        self.files.iter().map(|file| file.bytes).sum()
    }

    fn input(&self, hash: Option<&mut FileHash>) -> Result<Input> {
        let xxh128 = hash.map(FileHash::finish).transpose()?;
        self.check()?;
        Ok(Input {
            path: self.path.clone(),
            xxh128: xxh128.map(|hash| format!("{hash:032x}")),
        })
    }
}

/// A hash of an input, in a thread while the input is used.
///
/// It stays behind the reader, whose bytes the system then still has in memory.
pub struct Hashing<'s> {
    snapshot: &'s Snapshot,
    hash: Option<SharedHash>,
    read: Sender<f64>,
    thread: Option<JoinHandle<Result<()>>>,
}

impl Hashing<'_> {
    /// The hash, for a reader that can pass it the bytes that it reads.
    ///
    /// `None` if there is none, or for a folder.
    pub fn shared(&self) -> Option<SharedHash> {
        let is_file = self
            .snapshot
            .files
            .iter()
            .all(|file| file.path == self.snapshot.path);
        self.hash.clone().filter(|_| is_file)
    }

    /// Without a hash from here on if only a part of a large input is used.
    pub fn of_part(&mut self) {
        self.hash.take_if(|_| self.snapshot.bytes() > PART);
    }

    /// Follows the reader to a share of the input.
    pub fn follow(&self, fraction: f64) {
        if self.hash.is_some() {
            // `finish` returns the error of a thread that has ended.
            let _ = self.read.send(fraction);
        }
    }

    /// Hashes the rest.
    ///
    /// # Errors
    /// As [`Snapshot::hashed`].
    pub fn finish(self) -> Result<Input> {
        drop(self.read);
        if let Some(thread) = self.thread {
            thread.join().unwrap_or_else(|panic| resume_unwind(panic))?;
        }
        let mut hash = self.hash.as_ref().map(SharedHash::lock);
        self.snapshot.input(hash.as_deref_mut())
    }
}

/// The file, or the files of a folder by their names.
fn files_of(path: &Path) -> Result<Vec<State>> {
    let state = |path: PathBuf, metadata: &Metadata| State {
        path,
        bytes: metadata.len(),
        changed: metadata.modified().ok(),
    };
    let wrong = |e| unreadable(path, &e);
    let metadata = fs::metadata(path).map_err(wrong)?;
    if !metadata.is_dir() {
        return Ok(vec![state(path.to_path_buf(), &metadata)]);
    }
    let mut files = Vec::new();
    for entry in fs::read_dir(path).map_err(wrong)? {
        let file = entry.map_err(wrong)?.path();
        let metadata = fs::metadata(&file).map_err(wrong)?;
        if metadata.is_file() {
            files.push(state(file, &metadata));
        }
    }
    files.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(files)
}

fn unreadable(path: &Path, error: &std::io::Error) -> Error {
    file_error(path, cannot_be_opened(error))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Within one step of the system's clock, too, at the same length.
    #[test]
    fn a_file_that_changes_after_its_snapshot_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("data");
        for _ in 0..10 {
            fs::write(&path, "before").unwrap();
            let snapshot = Snapshot::of(&path).unwrap();
            assert!(snapshot.check().is_ok());
            fs::write(&path, "behind").unwrap();
            let message = snapshot.hashed().err().unwrap().to_string();
            assert!(message.contains("changed while it was read"), "{message}");
        }
        let snapshot = Snapshot::of(folder.path()).unwrap();
        fs::write(folder.path().join("more"), "").unwrap();
        assert!(snapshot.check().is_err());
    }
}
