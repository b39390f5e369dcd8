//! The threads that compute.

use std::num::NonZeroUsize;
use std::thread::available_parallelism;

use bonebeam_drive::threads::{check, pool};
use pyo3::PyResult;
use rayon::ThreadPool;

use crate::error::refused;

/// So many threads; without a number, as many as there are processors.
///
/// They are this call's own and end with it: a process that is forked later finds none that it lacks.
pub fn threads(count: Option<NonZeroUsize>) -> PyResult<ThreadPool> {
    let count = match count {
        Some(count) => {
            check(count).map_err(refused)?;
            count.get()
        }
        None => available_parallelism().map_or(1, NonZeroUsize::get),
    };
    pool(count).map_err(refused)
}
