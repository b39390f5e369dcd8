//! Threads of computations.

use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::available_parallelism;

use bonebeam_drive::threads::{check, pool};
use pyo3::{PyResult, pyfunction};
use rayon::ThreadPool;

use crate::error::refused;

/// Number of processes that share the processors.
static PROCESSES: AtomicUsize = AtomicUsize::new(1);

/// A pool of `count` threads; by default one for each processor of this process.
///
/// The threads belong to one call and end with it, so a process that is forked later lacks none.
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

/// Number of processors of this process.
#[pyfunction]
pub fn processors() -> usize {
    available_parallelism().map_or(1, NonZeroUsize::get)
}

/// Default number of threads.
#[pyfunction]
pub fn default_threads() -> usize {
    (processors() / PROCESSES.load(Ordering::Relaxed)).max(1)
}

/// Shares the processors with other processes that compute at the same time.
#[pyfunction]
pub fn share_processors(processes: NonZeroUsize) {
    PROCESSES.store(processes.get(), Ordering::Relaxed);
}
