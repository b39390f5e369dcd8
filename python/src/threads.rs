//! Threads of computations.

use std::num::NonZeroUsize;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::{self, available_parallelism};
use std::time::Duration;

use bonebeam_drive::threads::{check, pool};
use pyo3::exceptions::{PyOverflowError, PyValueError};
use pyo3::prelude::*;
use rayon::ThreadPool;

use crate::error::refused;

/// Number of processes that share the processors.
static PROCESSES: AtomicUsize = AtomicUsize::new(1);

/// A number of threads.
pub struct Threads(NonZeroUsize);

impl<'a, 'py> FromPyObject<'a, 'py> for Threads {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        object.extract().map(Threads).map_err(|error: PyErr| {
            let py = object.py();
            let number = error.is_instance_of::<PyValueError>(py)
                || error.is_instance_of::<PyOverflowError>(py);
            match number {
                true => PyValueError::new_err(format!(
                    "`threads` is {object:?}; expected a number of at least 1"
                )),
                false => error,
            }
        })
    }
}

/// Runs `work` on a pool's threads until it ends, or a signal such as Ctrl-C.
///
/// `work` calls its argument now and then, which ends it.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    pool: &ThreadPool,
    work: impl FnOnce(&(dyn Fn(f64) + Sync)) -> T + Send,
) -> PyResult<T> {
    let interrupted = AtomicBool::new(false);
    let progress = |_| {
        if interrupted.load(Ordering::Relaxed) {
            // Without a message: the signal's exception has it.
            resume_unwind(Box::new(()));
        }
    };
    thread::scope(|scope| {
        let worker = scope.spawn(|| pool.install(|| work(&progress)));
        while !worker.is_finished() {
            py.detach(|| thread::sleep(POLL));
            if let Err(signal) = py.check_signals() {
                interrupted.store(true, Ordering::Relaxed);
                let _ = py.detach(|| worker.join());
                return Err(signal);
            }
        }
        Ok(worker.join().unwrap_or_else(|panic| resume_unwind(panic)))
    })
}

/// Time between two looks for a signal.
const POLL: Duration = Duration::from_millis(5);

/// A pool of `count` threads; by default one for each processor of this process.
///
/// The threads belong to one call and end with it, so a process that is forked later lacks none.
pub fn threads(count: Option<Threads>) -> PyResult<ThreadPool> {
    let count = match count {
        Some(Threads(count)) => {
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
