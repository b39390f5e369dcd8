//! Times on a machine that others use too: the fastest of many, taken in turn.

use std::time::{Duration, Instant};

/// Fewest rounds, whatever the budget: the first warms the caches, one alone could be disturbed.
const FEWEST: usize = 3;

/// What is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// The time that this thread computes, without that in which others have its processor: for
    /// work that this thread does alone.
    Thread,
    /// The time that passes: for work on several threads.
    Wall,
}

/// How long each of `contestants` takes, s: the fastest of at least three calls, one of each in
/// turn, until `budget` is used up. Taken in turn, a disturbance or a change of the clock rate meets
/// all alike.
pub fn side_by_side<const N: usize>(
    clock: Clock,
    budget: Duration,
    mut contestants: [&mut dyn FnMut(); N],
) -> [f64; N] {
    let begin = Instant::now();
    let mut fastest = [f64::INFINITY; N];
    let mut rounds = 0;
    while rounds < FEWEST || begin.elapsed() < budget {
        for (contestant, fastest) in contestants.iter_mut().zip(&mut fastest) {
            let start = clock.now(begin);
            contestant();
            let seconds = (clock.now(begin) - start).as_secs_f64();
            if seconds < *fastest {
                *fastest = seconds;
            }
        }
        rounds += 1;
    }
    fastest
}

/// [`side_by_side`] for one alone.
pub fn fastest(clock: Clock, budget: Duration, mut work: impl FnMut()) -> f64 {
    let [seconds] = side_by_side(clock, budget, [&mut work]);
    seconds
}

impl Clock {
    #[cfg(unix)]
    fn now(self, begin: Instant) -> Duration {
        use rustix::time::{ClockId, clock_gettime};
        match self {
            Clock::Thread => clock_gettime(ClockId::ThreadCPUTime)
                .try_into()
                .unwrap_or_else(|_| begin.elapsed()),
            Clock::Wall => begin.elapsed(),
        }
    }

    #[cfg(not(unix))]
    fn now(self, begin: Instant) -> Duration {
        begin.elapsed()
    }
}
