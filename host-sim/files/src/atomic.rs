//! Outputs that appear whole or not at all.
//!
//! A temporary file in the same folder is written and then renamed.

use std::collections::BTreeSet;
use std::error::Error as StdError;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use super::file_error;
use super::temporary_files::{self, Guard};
use crate::{Error, Result};

/// Sink for an output's contents: seekable, as a zip archive needs.
///
/// The first failure is returned; later writes are discarded and succeed. A zip archive tries to complete itself
/// when it is dropped, and if that fails as well, it would print a message on standard error.
pub struct Sink<'a> {
    file: BufWriter<&'a mut File>,
    position: u64,
    failed: bool,
}

impl<'a> Sink<'a> {
    fn new(file: &'a mut File) -> Self {
        Self {
            file: BufWriter::new(file),
            position: 0,
            failed: false,
        }
    }

    fn note<T>(&mut self, outcome: io::Result<T>) -> io::Result<T> {
        if let Err(e) = &outcome {
            self.failed |= e.kind() != io::ErrorKind::Interrupted;
        }
        outcome
    }

    fn finish(&mut self) -> io::Result<()> {
        if self.failed {
            return Err(io::Error::other("an earlier write failed"));
        }
        self.file.flush()
    }
}

impl Write for Sink<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = if self.failed {
            Ok(bytes.len())
        } else {
            self.file.write(bytes)
        };
        let written = self.note(written)?;
        self.position += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        let flushed = if self.failed {
            Ok(())
        } else {
            self.file.flush()
        };
        self.note(flushed)
    }
}

impl Seek for Sink<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let target = match (self.failed, to) {
            (false, to) => self.file.seek(to),
            (true, SeekFrom::Start(target)) => Ok(target),
            (true, SeekFrom::Current(step)) => Ok(self.position.saturating_add_signed(step)),
            (true, SeekFrom::End(_)) => Ok(self.position),
        };
        self.position = self.note(target)?;
        Ok(self.position)
    }
}

/// The outputs of one run.
///
/// They are written under temporary names beside their targets, and appear together at [`Outputs::commit`]. If
/// dropped before, they leave nothing behind.
#[derive(Default)]
pub struct Outputs {
    pending: Vec<Pending>,
}

/// A temporary file beside its target; removed when dropped.
struct Pending {
    file: File,
    /// The temporary path; `None` once the file has its own name.
    temporary: Option<PathBuf>,
    target: PathBuf,
}

impl Drop for Pending {
    fn drop(&mut self) {
        if let Some(temporary) = &self.temporary {
            let mut guard = temporary_files::lock();
            // What cannot be removed stays: there is nobody to tell.
            let _ = fs::remove_file(temporary);
            guard.forget(temporary);
        }
    }
}

impl Outputs {
    /// No outputs yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Writes the contents of `path` to a temporary file beside it.
    ///
    /// # Errors
    /// The folder does not exist or cannot be written, `path` is not a file, the disk is full, or `contents` fails.
    /// The error names the path; nothing is left behind.
    pub fn add<F>(&mut self, path: &Path, contents: F) -> Result<()>
    where
        F: FnOnce(&mut Sink<'_>) -> std::result::Result<(), Box<dyn StdError>>,
    {
        let mut pending = open(path)?;
        let mut sink = Sink::new(&mut pending.file);
        contents(&mut sink)
            .and_then(|()| Ok(sink.finish()?))
            .map_err(|e| match e.downcast::<Error>() {
                // What went wrong was not the writing.
                Ok(error) => *error,
                Err(e) => file_error(path, format!("cannot be written: {e}")),
            })?;
        drop(sink);
        // Some file systems tell of a full disk only here; after the rename it would be too late.
        pending
            .file
            .sync_all()
            .map_err(|e| file_error(path, format!("cannot be written: {e}")))?;
        self.pending.push(pending);
        Ok(())
    }

    /// As [`Outputs::add`], for a library that creates the file itself.
    ///
    /// `contents` receives the temporary path.
    ///
    /// # Errors
    /// As [`Outputs::add`].
    pub fn add_at(
        &mut self,
        path: &Path,
        contents: impl FnOnce(&Path) -> Result<()>,
    ) -> Result<()> {
        let pending = open(path)?;
        let temporary = pending.temporary.as_deref().unwrap_or(path);
        contents(temporary).map_err(|e| match e {
            Error::Data(message) => file_error(path, message),
            other => other,
        })?;
        pending
            .file
            .sync_all()
            .map_err(|e| file_error(path, format!("cannot be written: {e}")))?;
        self.pending.push(pending);
        Ok(())
    }

    /// Gives every pending file its own name.
    ///
    /// # Errors
    /// A rename fails; after a successful [`Outputs::add`] only if the folder was changed in between.
    pub fn commit(mut self) -> Result<()> {
        let _alone = self.lock_folders();
        // A signal waits until all are in their places.
        let mut guard = temporary_files::lock();
        for pending in &mut self.pending {
            if let Some(temporary) = &pending.temporary {
                fs::rename(temporary, &pending.target)
                    .map_err(|e| file_error(&pending.target, format!("cannot be written: {e}")))?;
                guard.forget(temporary);
            }
            // From here on another run may have a file of that name.
            pending.temporary = None;
        }
        Ok(())
    }

    /// Waits until no other run renames its outputs, so that two runs do not mix.
    ///
    /// The locks end when the returned files are dropped. A file system without locks is accepted.
    fn lock_folders(&self) -> Vec<File> {
        // By one name each and in order, so that no run waits for itself or for one that waits for it.
        let targets = self
            .pending
            .iter()
            .map(|pending| folder_of(&pending.target));
        let folders: BTreeSet<PathBuf> = targets.filter_map(|f| fs::canonicalize(f).ok()).collect();
        let open = folders.iter().filter_map(|folder| File::open(folder).ok());
        open.filter(lock).collect()
    }
}

/// Longest wait for a lock.
///
/// Renames take no time, so a run that holds a lock longer has stopped.
const LONGEST_LOCK: Duration = Duration::from_secs(5);

/// Tries to lock the folder for this run.
fn lock(folder: &File) -> bool {
    let begin = Instant::now();
    loop {
        match folder.try_lock() {
            Ok(()) => return true,
            Err(TryLockError::WouldBlock) if begin.elapsed() < LONGEST_LOCK => {
                thread::sleep(Duration::from_millis(2));
            }
            Err(_) => return false,
        }
    }
}

/// The folder of a file.
fn folder_of(target: &Path) -> &Path {
    match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Writes one file whole or not at all.
///
/// # Errors
/// As [`Outputs::add`].
pub fn write<F>(path: &Path, contents: F) -> Result<()>
where
    F: FnOnce(&mut Sink<'_>) -> std::result::Result<(), Box<dyn StdError>>,
{
    let mut outputs = Outputs::new();
    outputs.add(path, contents)?;
    outputs.commit()
}

/// Checks before a long computation that its output can be written.
///
/// # Errors
/// As [`Outputs::add`].
pub fn check_writable(path: &Path) -> Result<()> {
    check_outputs(&[], &[path])
}

/// Checks before a run that its outputs can be written and replace no input.
///
/// No output may replace another one either. Files left in the folders by killed runs are removed.
///
/// # Errors
/// [`Error::Usage`] naming the two paths of the same file; else as [`check_writable`].
pub fn check_outputs(inputs: &[&Path], outputs: &[&Path]) -> Result<()> {
    let mut taken: Vec<(PathBuf, &Path)> = Vec::new();
    let mut folders = BTreeSet::new();
    for input in inputs {
        // A missing input is reported when it is read.
        if let Ok(target) = fs::canonicalize(input) {
            taken.push((target, input));
        }
    }
    for output in outputs {
        let target = &open(output)?.target;
        let folder = folder_of(target);
        if folders.insert(folder.to_path_buf()) {
            temporary_files::remove_leftovers(folder);
        }
        let target = match target.file_name() {
            Some(name) => fs::canonicalize(folder).map_or(target.clone(), |f| f.join(name)),
            None => target.clone(),
        };
        if let Some((_, other)) = taken.iter().find(|(other, _)| *other == target) {
            return Err(Error::Usage(format!(
                "{} would overwrite {}, the same file; give the output another name",
                output.display(),
                other.display()
            )));
        }
        taken.push((target, output));
    }
    Ok(())
}

/// A temporary file beside `path`, and its target (symbolic links followed).
fn open(path: &Path) -> Result<Pending> {
    // A rename would replace a symbolic link or a device; the person meant what it stands for.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    match fs::symlink_metadata(&target) {
        Ok(found) if found.is_symlink() => {
            return Err(file_error(
                path,
                "is a symbolic link to a file that does not exist; remove the link, or create the \
                 file",
            ));
        }
        Ok(found) if !found.is_file() => {
            return Err(file_error(
                path,
                "is not a file, so no output can be written there",
            ));
        }
        // Only now, since a temporary file beside it has a shorter name.
        Err(e) if e.kind() == io::ErrorKind::InvalidFilename => {
            return Err(file_error(
                path,
                "its name is longer than the system allows",
            ));
        }
        _ => {}
    }
    let folder = folder_of(&target);
    if !folder.is_dir() {
        let state = if folder.exists() {
            "is not a folder"
        } else {
            "does not exist"
        };
        return Err(file_error(
            path,
            format!("its folder {} {state}", folder.display()),
        ));
    }
    let mut guard = temporary_files::lock();
    let (file, temporary) = temporary(folder, &mut guard).map_err(|e| {
        let reason = e.kind();
        file_error(
            path,
            format!(
                "its folder {} cannot be written: {reason}",
                folder.display()
            ),
        )
    })?;
    Ok(Pending {
        file,
        temporary: Some(temporary),
        target,
    })
}

/// Creates a locked file in the folder, with the permissions of any new file.
///
/// Its name has the process and a number that no other file of the process has. Names that exist, from a process in
/// another container or a killed one, are left alone.
fn temporary(folder: &Path, guard: &mut Guard) -> io::Result<(File, PathBuf)> {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    loop {
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let path = folder.join(temporary_files::name(number));
        // Before it is made: a program that aborts has it in its list.
        guard.add(&path);
        let new = OpenOptions::new().write(true).create_new(true).open(&path);
        let file = match new {
            Ok(file) => file,
            Err(e) => {
                guard.forget(&path);
                if e.kind() == io::ErrorKind::AlreadyExists {
                    continue;
                }
                return Err(e);
            }
        };
        // A run that starts may have taken it for a leftover before it was locked.
        let taken = matches!(file.try_lock(), Err(TryLockError::WouldBlock));
        if !taken && path.exists() {
            return Ok((file, path));
        }
        guard.forget(&path);
    }
}
