//! The threads that compute.

use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::available_parallelism;

use bonebeam_drive::threads::{check, pool};
use pyo3::{PyResult, pyfunction};
use rayon::ThreadPool;

use crate::error::refused;

/// How many processes share the processors.
static PROCESSES: AtomicUsize = AtomicUsize::new(1);

/// So many threads; without a number, as many as there are processors for this process.
///
/// They are this call's own and end with it: a process that is forked later finds none that it lacks.
pub fn threads(count: Option<NonZeroUsize>) -> PyResult<ThreadPool> {
    let count = match count {
        Some(count) => {
            check(count).map_err(refused)?;
            count.get()
        }
        None => default_threads(),
    };
    pool(count).map_err(refused)
}

/// How many processors there are for this process.
#[pyfunction]
pub fn processors() -> usize {
    available_parallelism().map_or(1, NonZeroUsize::get)
}

/// How many threads compute where no number is given.
#[pyfunction]
pub fn default_threads() -> usize {
    (processors() / PROCESSES.load(Ordering::Relaxed)).max(1)
}

/// This process is one of so many that compute at a time.
#[pyfunction]
pub fn share_processors(processes: NonZeroUsize) {
    PROCESSES.store(processes.get(), Ordering::Relaxed);
}
