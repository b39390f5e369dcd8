//! Two receivers used as one.

use embedded_hal::digital::{Error as _, ErrorKind, OutputPin};
use embedded_hal_async::delay::DelayNs;

use crate::{Attenuator, Power, Receiver, TestPattern};

/// Time that the synchronisation line is high, ns. Not verified; long beside a sample.
const SYNC_NS: u32 = 1_000;

/// Two parts as one receiver: two AFE5809 serve 16 elements.
///
/// The first part has channels 0 to `A::CHANNELS − 1`, the second the others. Both get the same settings, the first
/// part first. `SYNC` drives one line to both parts (TX_SYNC_IN of the AFE5809): a pulse after each change starts
/// their demodulators and patterns at the same sample. Board or FPGA must align the line's edges with the parts'
/// clock.
#[derive(Clone, Debug)]
pub struct Pair<A, B, SYNC, DELAY> {
    first: A,
    second: B,
    sync: SYNC,
    delay: DELAY,
}

/// Error of one part of a [`Pair`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PairError<E> {
    /// Error of the first part. The second did not change.
    #[error("first part: {0}")]
    First(E),
    /// Error of the second part. The first has changed: reset the pair.
    #[error("second part: {0}")]
    Second(E),
    /// The synchronisation line could not be set.
    #[error("the synchronisation line could not be set: {0}")]
    Sync(ErrorKind),
}

impl<A, B, SYNC, DELAY> Pair<A, B, SYNC, DELAY>
where
    A: Receiver,
    B: Receiver<Error = A::Error, Settings = A::Settings>,
    SYNC: OutputPin,
    DELAY: DelayNs,
{
    /// Pairs two receivers with a common synchronisation line. Nothing is sent yet.
    ///
    /// If both share a reset line, the second part's pin is [`NoPin`](crate::NoPin).
    pub fn new(first: A, second: B, sync: SYNC, delay: DELAY) -> Self {
        const {
            assert!(A::BITS == B::BITS && A::SYNC == B::SYNC);
        }
        Pair {
            first,
            second,
            sync,
            delay,
        }
    }

    /// Both parts, for calls outside [`Receiver`].
    ///
    /// Call [`Pair::synchronise`] afterwards.
    pub fn parts(&mut self) -> (&mut A, &mut B) {
        (&mut self.first, &mut self.second)
    }

    /// Returns the parts, the line and the delay.
    pub fn release(self) -> (A, B, SYNC, DELAY) {
        (self.first, self.second, self.sync, self.delay)
    }

    /// Sends a pulse to both parts.
    ///
    /// # Errors
    /// [`PairError::Sync`].
    pub async fn synchronise(&mut self) -> Result<(), PairError<A::Error>> {
        let sync = |error: SYNC::Error| PairError::Sync(error.kind());
        self.sync.set_high().map_err(sync)?;
        self.delay.delay_ns(SYNC_NS).await;
        self.sync.set_low().map_err(sync)
    }
}

/// A call of the first part, then of the second.
macro_rules! both {
    ($pair:ident.$call:ident($($argument:expr),*)) => {{
        let (first, second) = $pair.parts();
        first.$call($($argument),*).await.map_err(PairError::First)?;
        second.$call($($argument),*).await.map_err(PairError::Second)
    }};
}

impl<A, B, SYNC, DELAY> Receiver for Pair<A, B, SYNC, DELAY>
where
    A: Receiver,
    B: Receiver<Error = A::Error, Settings = A::Settings>,
    SYNC: OutputPin,
    DELAY: DelayNs,
{
    type Error = PairError<A::Error>;
    type Settings = A::Settings;
    const CHANNELS: usize = A::CHANNELS + B::CHANNELS;
    const BITS: u32 = A::BITS;
    const SYNC: u16 = A::SYNC;
    const RAMP: bool = A::RAMP && B::RAMP;

    async fn reset(&mut self, delay: &mut impl DelayNs) -> Result<(), Self::Error> {
        both!(self.reset(delay))?;
        self.synchronise().await
    }

    async fn configure(&mut self, settings: &A::Settings) -> Result<(), Self::Error> {
        both!(self.configure(settings))?;
        self.synchronise().await
    }

    async fn attenuate(&mut self, attenuator: Attenuator) -> Result<(), Self::Error> {
        both!(self.attenuate(attenuator))
    }

    async fn test_pattern(&mut self, pattern: TestPattern) -> Result<(), Self::Error> {
        both!(self.test_pattern(pattern))?;
        self.synchronise().await
    }

    async fn power(&mut self, power: Power, delay: &mut impl DelayNs) -> Result<(), Self::Error> {
        both!(self.power(power, delay))?;
        self.synchronise().await
    }
}
