//! Temporary files of a run whose outputs are not complete yet.
//!
//! They are removed if a signal ends the run, or at the start of a later run.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{self, OpenOptions};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Lock for making, renaming or removing a temporary file: see [`lock`].
static TURN: Mutex<()> = Mutex::new(());

/// Files and folders to remove.
///
/// The lists have a lock of their own, which is held only briefly. A thread that aborts while it holds [`TURN`] never
/// releases [`TURN`].
static LISTS: Mutex<Lists> = Mutex::new(Lists {
    files: BTreeSet::new(),
    folders: Vec::new(),
});

struct Lists {
    files: BTreeSet<PathBuf>,
    folders: Vec<PathBuf>,
}

/// The right to make, rename and remove temporary files.
pub struct Guard {
    _alone: MutexGuard<'static, ()>,
}

/// Waits for the turn; a signal waits until it is dropped.
pub fn lock() -> Guard {
    // A thread that panicked with the lock has left the lists whole.
    let _alone = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    Guard { _alone }
}

/// As [`lock`], but waits at most half a second.
///
/// A thread that aborts keeps the lock.
#[cfg(all(feature = "signals", unix))]
pub(crate) fn lock_soon() -> Option<Guard> {
    for _ in 0..500 {
        if let Ok(_alone) = TURN.try_lock() {
            return Some(Guard { _alone });
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    None
}

fn lists() -> MutexGuard<'static, Lists> {
    LISTS.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Guard {
    /// Adds a temporary file that is about to be made.
    pub fn add(&mut self, file: &Path) {
        let file = file.to_path_buf();
        lists().files.insert(file);
    }

    /// Forgets a file that is gone, that is an output now, or that was not made.
    pub fn forget(&mut self, file: &Path) {
        lists().files.remove(file);
    }

    /// Adds a new folder, to be removed if it stays empty.
    pub fn add_folder(&mut self, folder: &Path) {
        let folder = folder.to_path_buf();
        lists().folders.push(folder);
    }
}

/// Removes all files and empty folders of the lists.
#[cfg(all(feature = "signals", unix))]
pub(crate) fn remove_all() {
    let lists = lists();
    for file in &lists.files {
        let _ = fs::remove_file(file);
    }
    // The innermost first; one that is not empty is somebody else's by now.
    for folder in lists.folders.iter().rev() {
        let _ = fs::remove_dir(folder);
    }
}

/// Removes unlocked temporary files that earlier runs left in a folder.
///
/// A run keeps its files locked until they have their own names, so files of a run on another machine, on a shared
/// disk, stay.
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

/// Beginning of the names of temporary files.
const PREFIX: &str = ".host-sim-";

/// Whether it is a [`name`] of any process.
fn is_temporary(name: &OsStr) -> bool {
    let numbers = name.to_str().and_then(|name| name.strip_prefix(PREFIX));
    let numbers = numbers.and_then(|numbers| numbers.split_once('-'));
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    numbers.is_some_and(|(process, number)| digits(process) && digits(number))
}
