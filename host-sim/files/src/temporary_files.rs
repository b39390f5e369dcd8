//! Temporary files of a run whose outputs are not whole yet: removed if a signal ends it.
//!
//! A signal handler may do next to nothing, so a thread waits for SIGINT and SIGTERM instead. It and
//! whoever makes or renames a temporary file take turns by one lock: no file is missed, and outputs
//! that have begun to take their places all do.

use std::collections::BTreeSet;
#[cfg(all(unix, feature = "signals"))]
use std::fs;
use std::path::{Path, PathBuf};
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

    #[cfg(all(feature = "signals", unix))]
    fn remove(&mut self) {
        for file in &self.files {
            let _ = fs::remove_file(file);
        }
        // The innermost first; one that is not empty is somebody else's by now.
        for folder in self.folders.iter().rev() {
            let _ = fs::remove_dir(folder);
        }
    }
}

/// From here on SIGINT and SIGTERM end the program without a trace, with status 130 and 143.
#[cfg(all(feature = "signals", unix))]
pub fn remove_at_signals() {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    // Where the system gives no handler or no thread, a signal ends the program all the same.
    let Ok(mut signals) = Signals::new([SIGINT, SIGTERM]) else {
        return;
    };
    let _ = std::thread::Builder::new().spawn(move || {
        if let Some(signal) = signals.forever().next() {
            let mut temporary_files = lock();
            temporary_files.remove();
            // With the lock in hand: nothing new is made while the program ends.
            std::process::exit(128 + signal);
        }
    });
}

/// There is nothing to catch here.
#[cfg(all(feature = "signals", not(unix)))]
pub fn remove_at_signals() {}
