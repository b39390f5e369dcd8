//! Times on a shared machine: the fastest of many calls, taken in turn.
//!
//! Times are wall-clock times. CPU time of the thread would exclude other processes, but on a virtual machine its clock
//! is sometimes slow, and the fastest of many calls would select those times. Calls take a few milliseconds, which
//! are undisturbed often enough.

use std::time::{Duration, Instant};

/// Minimum number of rounds, whatever the budget.
///
/// The first round warms the caches, and a single one could be disturbed.
const FEWEST: usize = 3;

/// Times each of `contestants`, s: the fastest of at least three calls.
///
/// They are called in turn until `budget` is used up, so that a disturbance or a change of the clock rate affects all
/// equally.
pub fn side_by_side<const N: usize>(
    budget: Duration,
    mut contestants: [&mut dyn FnMut(); N],
) -> [f64; N] {
    let begin = Instant::now();
    let mut fastest = [f64::INFINITY; N];
    let mut rounds = 0;
    while rounds < FEWEST || begin.elapsed() < budget {
        for (contestant, fastest) in contestants.iter_mut().zip(&mut fastest) {
            let start = Instant::now();
            contestant();
            let seconds = start.elapsed().as_secs_f64();
            if seconds < *fastest {
                *fastest = seconds;
            }
        }
        rounds += 1;
    }
    fastest
}

/// [`side_by_side`] for a single contestant.
pub fn fastest(budget: Duration, mut work: impl FnMut()) -> f64 {
    let [seconds] = side_by_side(budget, [&mut work]);
    seconds
}
