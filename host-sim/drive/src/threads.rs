//! Thread pools of a given size.
//!
//! They make results and times independent of the machine's number of processors.

use std::env;
use std::fmt::Display;
use std::hint::black_box;
use std::num::NonZeroUsize;
use std::ops::RangeInclusive;

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::{Error, Result};

/// Largest number of threads; more only take time to start.
const MAX_THREADS: usize = 256;

/// Smallest stack, bytes: the default of threads; smaller ones are not tested.
const MIN_STACK: usize = 2 << 20;
/// Largest stack, bytes; more is a mistake.
const MAX_STACK: usize = 1 << 30;

/// Checks a number of threads.
///
/// # Errors
/// [`Error::Usage`] with the number and the range.
pub fn check(count: NonZeroUsize) -> Result<()> {
    in_range("--threads", count, 1..=MAX_THREADS, "threads").map(drop)
}

/// Starts the threads of the program.
///
/// Their number is `count`, else `RAYON_NUM_THREADS`, else one per processor. All have started when it returns, so
/// their memory is allocated before other memory.
///
/// # Errors
/// [`Error::Usage`] if the number, or the value of an environment variable, is out of range; [`Error::Data`] if the
/// system gives no more threads.
pub fn start(count: Option<NonZeroUsize>) -> Result<()> {
    let stack = MIN_STACK..=MAX_STACK;
    from_environment("RUST_MIN_STACK", stack, "bytes")?;
    let threads = match count {
        Some(count) => in_range("--threads", count, 1..=MAX_THREADS, "threads").map(Some)?,
        None => from_environment("RAYON_NUM_THREADS", 1..=MAX_THREADS, "threads")?,
    };
    ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .build_global()
        .map_err(|e| cannot_start(threads, &e))?;
    rayon::broadcast(|_| drop(black_box(Box::new(0))));
    Ok(())
}

/// The value of an environment variable, if it is set.
fn from_environment(name: &str, range: RangeInclusive<usize>, of: &str) -> Result<Option<usize>> {
    let value = env::var_os(name);
    let value = value.map(|value| in_range(name, value.to_string_lossy(), range, of));
    value.transpose()
}

fn in_range(
    name: &str,
    value: impl Display,
    range: RangeInclusive<usize>,
    of: &str,
) -> Result<usize> {
    let value = value.to_string();
    let number = value.parse().ok().filter(|number| range.contains(number));
    number.ok_or_else(|| {
        let (least, most) = (range.start(), range.end());
        Error::Usage(format!(
            "{name} is {value}; expected {least} to {most} {of}"
        ))
    })
}

fn cannot_start(count: Option<usize>, error: &dyn Display) -> Error {
    let count = count.map_or("the".into(), |count| count.to_string());
    Error::Data(format!("cannot start {count} threads: {error}"))
}

/// A pool of `count` threads.
///
/// # Errors
/// [`Error::Data`] if the system gives no more threads.
pub fn pool(count: usize) -> Result<ThreadPool> {
    ThreadPoolBuilder::new()
        .num_threads(count)
        .build()
        .map_err(|e| cannot_start(Some(count), &e))
}
