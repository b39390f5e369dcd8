//! Times on a machine that others use too: the fastest of many, taken in turn.
//!
//! It is the time that passes. A thread's own processor time would leave out the others', but on a
//! virtual machine it runs too slowly at times, and the fastest of many finds those times. So calls
//! are kept to a few milliseconds, which others leave undisturbed often enough.

use std::time::{Duration, Instant};

/// Fewest rounds, whatever the budget: the first warms the caches, one alone could be disturbed.
const FEWEST: usize = 3;

/// How long each of `contestants` takes, s: the fastest of at least three calls, one of each in
/// turn, until `budget` is used up. Taken in turn, a disturbance or a change of the clock rate meets
/// all alike.
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

/// [`side_by_side`] for one alone.
pub fn fastest(budget: Duration, mut work: impl FnMut()) -> f64 {
    let [seconds] = side_by_side(budget, [&mut work]);
    seconds
}
