//! Receivers, which amplify and digitise echoes.

use embedded_hal_async::delay::DelayNs;

/// A front end between transducer and processor: amplifiers, filters, converters.
///
/// [`Afe`](crate::Afe), [`Afe58jd18`](crate::Afe58jd18), [`Ad9276`](crate::ad9276::Ad9276) and two of a kind as a
/// [`Pair`](crate::Pair) implement it. [`align`](crate::align) aligns the lanes of all of them.
#[allow(async_fn_in_trait)]
pub trait Receiver {
    /// Reason why a call failed.
    type Error;
    /// Gains, filter and termination of the part.
    ///
    /// The default is the state after a reset.
    type Settings;
    /// Number of channels.
    const CHANNELS: usize;
    /// Number of bits of a word on a lane.
    const BITS: u32;
    /// Word of [`TestPattern::Sync`], its first bit highest.
    const SYNC: u16;
    /// Whether the receiver has [`TestPattern::Ramp`].
    ///
    /// Otherwise [`TestPattern::Toggle`] replaces it.
    const RAMP: bool;

    /// Resets the part by its pin: every register is at its default then, and the part runs.
    ///
    /// # Errors
    /// The implementation's own.
    async fn reset(&mut self, delay: &mut impl DelayNs) -> Result<(), Self::Error>;

    /// Sets all channels, and reads the registers back. Bits that [`Receiver::Settings`] does not cover stay.
    ///
    /// # Errors
    /// The implementation's own: at least where a register does not read as it was written.
    async fn configure(&mut self, settings: &Self::Settings) -> Result<(), Self::Error>;

    /// Sets the attenuator between the amplifiers: by its voltage, or by a fixed number.
    ///
    /// # Errors
    /// As [`Receiver::configure`], and for a number beyond the part's range.
    async fn attenuate(&mut self, attenuator: Attenuator) -> Result<(), Self::Error>;

    /// Sends a pattern from all channels in place of echoes, or echoes again.
    ///
    /// # Errors
    /// As [`Receiver::configure`].
    async fn test_pattern(&mut self, pattern: TestPattern) -> Result<(), Self::Error>;

    /// Powers the part up or down. Settings stay. Returns when the part is ready.
    ///
    /// # Errors
    /// As [`Receiver::configure`].
    async fn power(&mut self, power: Power, delay: &mut impl DelayNs) -> Result<(), Self::Error>;
}

/// Power of a receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Power {
    /// Full operation.
    On,
    /// Partial power-down for the time between frames.
    ///
    /// References and clock run, so that the part wakes fast.
    Standby,
    /// Complete power-down. Waking takes milliseconds.
    Down,
}

impl Power {
    /// Time until the part is ready after this, ns. Not verified: long beside the extracts.
    pub(crate) fn wake_ns(self) -> u32 {
        match self {
            Power::On => 0,
            Power::Standby => 20_000,
            Power::Down => 5_000_000,
        }
    }
}

/// The attenuator between the two amplifiers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Attenuator {
    /// Attenuation by a converter's voltage, which may follow depth.
    ///
    /// See [`GainCurve`](crate::GainCurve).
    Voltage,
    /// Fixed attenuation by this number of steps of 6 dB: 0 to 7.
    Steps(u8),
}

/// Words that the channels send instead of echoes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TestPattern {
    /// No pattern: echoes.
    Off,
    /// Ones in one half of a word, zeros in the other; shows word boundaries.
    Sync,
    /// Alternating zeros and ones; shows the edges of bits.
    Deskew,
    /// This word, repeated.
    Custom(u16),
    /// All ones.
    Ones,
    /// Alternating words of zeros and words of ones.
    Toggle,
    /// All zeros.
    Zeros,
    /// Words that count up; shows lost ones.
    Ramp,
}

impl TestPattern {
    /// The code, which TI's parts share.
    pub(crate) fn code(self) -> u16 {
        match self {
            TestPattern::Off => 0b000,
            TestPattern::Sync => 0b001,
            TestPattern::Deskew => 0b010,
            TestPattern::Custom(_) => 0b011,
            TestPattern::Ones => 0b100,
            TestPattern::Toggle => 0b101,
            TestPattern::Zeros => 0b110,
            TestPattern::Ramp => 0b111,
        }
    }
}
