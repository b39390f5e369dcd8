//! Temporary files of a run whose outputs are not whole yet: removed if a signal ends it, or at the start of a
//! later run.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{self, OpenOptions};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::{Mutex, MutexGuard, PoisonError};

static TEMPORARY_FILES: Mutex<TemporaryFiles> = Mutex::new(TemporaryFiles {
    files: BTreeSet::new(),
    folders: Vec::new(),
});

/// Temporary files, and folders that are new.
pub struct TemporaryFiles {
    files: BTreeSet<PathBuf>,
    folders: Vec<PathBuf>,
}

/// Locks the lists; a signal waits until the guard is dropped.
pub fn lock() -> MutexGuard<'static, TemporaryFiles> {
    // A thread that panicked with the lock has left the lists whole.
    TEMPORARY_FILES
        .lock()
        .unwrap_or_else(PoisonError::into_inner)
}

/// As [`lock`], where nobody has it or gives it back within half a second: the thread that aborts keeps it.
#[cfg(all(feature = "signals", unix))]
pub(crate) fn lock_soon() -> Option<MutexGuard<'static, TemporaryFiles>> {
    for _ in 0..500 {
        if let Ok(files) = TEMPORARY_FILES.try_lock() {
            return Some(files);
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    None
}

impl TemporaryFiles {
    /// A temporary file is there.
    pub fn add(&mut self, file: &Path) {
        self.files.insert(file.to_path_buf());
    }

    /// It is gone, or an output now.
    pub fn forget(&mut self, file: &Path) {
        self.files.remove(file);
    }

    /// A folder is new: to be removed if it stays empty.
    pub fn add_folder(&mut self, folder: &Path) {
        self.folders.push(folder.to_path_buf());
    }

    /// Removes them all.
    #[cfg(all(feature = "signals", unix))]
    pub(crate) fn remove(&mut self) {
        for file in &self.files {
            let _ = fs::remove_file(file);
        }
        // The innermost first; one that is not empty is somebody else's by now.
        for folder in self.folders.iter().rev() {
            let _ = fs::remove_dir(folder);
        }
    }
}

/// Removes the temporary files that earlier runs left in a folder: those that nobody has locked. A run keeps its
/// files locked until they have their own names, so those of a run elsewhere, on a disk that is shared, stay.
pub fn remove_leftovers(folder: &Path) {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    for entry in entries.filter(|entry| is_temporary(&entry.file_name())) {
        let regular = entry.file_type().is_ok_and(|kind| kind.is_file());
        // What cannot be opened, locked or removed stays: it does no harm.
        if regular
            && let Ok(file) = OpenOptions::new().write(true).open(entry.path())
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// The name of a temporary file of this process.
pub fn name(number: u64) -> String {
    format!("{PREFIX}{}-{number}", process::id())
}

/// How names of temporary files begin.
const PREFIX: &str = ".host-sim-";

/// Whether it is a [`name`] of any process.
fn is_temporary(name: &OsStr) -> bool {
    let numbers = name.to_str().and_then(|name| name.strip_prefix(PREFIX));
    let numbers = numbers.and_then(|numbers| numbers.split_once('-'));
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    numbers.is_some_and(|(process, number)| digits(process) && digits(number))
}
