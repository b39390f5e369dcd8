//! Simulated parts for tests of drivers and firmware.
//!
//! They hold the parts' registers, answer as the parts do, and refuse frames that a part would ignore.

mod ad9276;
mod afe;
mod lanes;
mod pulser;
mod tx7332;
mod words;

pub use ad9276::{AdRefused, MockAd9276};
pub use afe::{MockAfe, MockPart, MockPin, MockSpi, Refused};
pub use lanes::{MockLane, MockLanes, MockSync};
pub use pulser::{MockProfile, MockPulser, MockPulserError};
pub use tx7332::{BoardFailed, MockBoard, MockTx7332, TxRefused};
pub use words::MockWords;

use core::cell::Cell;
use core::convert::Infallible;

/// A delay that does not wait, and sums the requested times, ns.
#[derive(Clone, Debug, Default)]
pub struct MockDelay {
    /// The sum, ns.
    pub ns: u64,
}

impl embedded_hal::delay::DelayNs for MockDelay {
    fn delay_ns(&mut self, ns: u32) {
        self.ns += u64::from(ns);
    }
}

/// Levels of a pin that never fails.
type PinResult = Result<(), Infallible>;

/// The first error of some outcomes.
#[derive(Debug)]
struct First<E: Copy>(Cell<Option<E>>);

impl<E: Copy> First<E> {
    const fn none() -> Self {
        First(Cell::new(None))
    }

    /// Returns an outcome, whose error is kept if it is the first.
    fn of(&self, outcome: Result<(), E>) -> Result<(), E> {
        self.0.set(self.0.get().or(outcome.err()));
        outcome
    }
}
