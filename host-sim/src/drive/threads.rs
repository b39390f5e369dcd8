//! A number of threads of one's own, where a result or a time must not depend on the machine's.

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::{Error, Result};

/// A pool of as many threads.
///
/// # Errors
/// [`Error::Data`] where the system gives no more.
pub(crate) fn pool(count: usize) -> Result<ThreadPool> {
    ThreadPoolBuilder::new()
        .num_threads(count)
        .build()
        .map_err(|e| Error::Data(format!("cannot start {count} threads: {e}")))
}
