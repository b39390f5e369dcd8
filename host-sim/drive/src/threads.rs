//! A number of threads of one's own, where a result or a time must not depend on the machine's.

use std::num::NonZeroUsize;

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::{Error, Result};

/// More threads than any machine needs only take time to start.
const MAX_THREADS: usize = 256;

/// Whether so many threads may be asked for.
///
/// # Errors
/// [`Error::Usage`] with the number and the most.
pub fn check(count: NonZeroUsize) -> Result<()> {
    if count.get() <= MAX_THREADS {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "--threads is {count}; expected at most {MAX_THREADS}"
    )))
}

/// A pool of as many threads.
///
/// # Errors
/// [`Error::Data`] where the system gives no more.
pub fn pool(count: usize) -> Result<ThreadPool> {
    ThreadPoolBuilder::new()
        .num_threads(count)
        .build()
        .map_err(|e| Error::Data(format!("cannot start {count} threads: {e}")))
}
