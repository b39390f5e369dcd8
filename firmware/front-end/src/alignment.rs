//! Bit and word alignment of a receiver's lanes.

use crate::{Receiver, TestPattern};

/// The receiving end of a receiver's lanes, in an FPGA.
///
/// A channel has a delay line of [`Deserialiser::TAPS`] taps, which span at least a bit, and a shift of words by
/// bits.
#[allow(async_fn_in_trait)]
pub trait Deserialiser {
    /// Reason why a call failed.
    type Error;
    /// Number of taps of a channel's delay line.
    const TAPS: u16;

    /// Sets a channel's delay.
    ///
    /// # Errors
    /// The implementation's own.
    async fn delay(&mut self, channel: usize, tap: u16) -> Result<(), Self::Error>;

    /// Moves a channel's words by one bit.
    ///
    /// # Errors
    /// The implementation's own.
    async fn slip(&mut self, channel: usize) -> Result<(), Self::Error>;

    /// Fills `words` with consecutive words of a channel, its first bit highest. Calls for several channels
    /// after one [`Deserialiser::capture`] return words of the same time.
    ///
    /// # Errors
    /// The implementation's own.
    async fn words(&mut self, channel: usize, words: &mut [u16]) -> Result<(), Self::Error>;

    /// Captures words of all channels at once.
    ///
    /// # Errors
    /// The implementation's own.
    async fn capture(&mut self) -> Result<(), Self::Error>;
}

/// Alignment of a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Lane {
    /// The chosen tap, in the middle of the widest range of good taps.
    pub tap: u16,
    /// Number of good taps in that range.
    ///
    /// A small number is a warning of a noisy or badly terminated line.
    pub window: u16,
    /// Number of bits by which words were shifted.
    pub slips: u8,
}

/// Reason why lanes could not be aligned.
///
/// `R` and `D` are the errors of receiver and deserialiser.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum AlignError<R, D> {
    /// Error of the receiver.
    #[error("receiver: {0:?}")]
    Receiver(R),
    /// Error of the deserialiser.
    #[error("deserialiser: {0:?}")]
    Deserialiser(D),
    /// A channel has fewer good taps than required.
    #[error("channel {channel} has only {window} good taps in a row")]
    NoEye {
        /// The channel.
        channel: usize,
        /// Its good taps in a row.
        window: u16,
    },
    /// No shift of a channel's words shows the synchronisation pattern.
    #[error("channel {channel} never shows the synchronisation pattern, {word:#06x} at last")]
    NoFrame {
        /// The channel.
        channel: usize,
        /// The word that came last.
        word: u16,
    },
    /// A ramp or toggle pattern has a wrong word.
    ///
    /// The word is not the next of its channel, or differs from channel 0's.
    #[error("the ramp of channel {channel} is {got:#06x}, expected {expected:#06x}")]
    Ramp {
        /// The channel.
        channel: usize,
        /// The word that was due.
        expected: u16,
        /// The word that came.
        got: u16,
    },
}

/// Words that are looked at for each tap, and of each ramp.
const WORDS: usize = 64;

/// Aligns all channels and returns their alignment.
///
/// `N` is at most the number of the receiver's channels.
///
/// 1. Deskew pattern: each channel's delay is set to the middle of its widest range of taps at which all words
///    alternate zeros and ones. At least `least` taps are needed.
/// 2. Synchronisation pattern: words are shifted until they are [`Receiver::SYNC`].
/// 3. Ramp: words must count up by one, equally in all channels. For a part without a ramp, words of zeros and of
///    ones must alternate.
///
/// The receiver sends echoes again afterwards, also after an error.
///
/// # Errors
/// The first error found.
pub async fn align<R: Receiver, D: Deserialiser, const N: usize>(
    receiver: &mut R,
    lanes: &mut D,
    least: u16,
) -> Result<[Lane; N], AlignError<R::Error, D::Error>> {
    const {
        assert!(N <= R::CHANNELS && R::BITS <= 16);
    }
    let aligned = steps(receiver, lanes, least).await;
    let echoes = receiver.test_pattern(TestPattern::Off).await;
    let aligned = aligned?;
    echoes.map_err(AlignError::Receiver)?;
    Ok(aligned)
}

async fn steps<R: Receiver, D: Deserialiser, const N: usize>(
    receiver: &mut R,
    lanes: &mut D,
    least: u16,
) -> Result<[Lane; N], AlignError<R::Error, D::Error>> {
    let mut aligned = [Lane::default(); N];
    let pattern = TestPattern::Deskew;
    receiver
        .test_pattern(pattern)
        .await
        .map_err(AlignError::Receiver)?;
    for (channel, lane) in aligned.iter_mut().enumerate() {
        *lane = eye(lanes, channel, R::BITS)
            .await
            .map_err(AlignError::Deserialiser)?;
        if lane.window < least || lane.window == 0 {
            return Err(AlignError::NoEye {
                channel,
                window: lane.window,
            });
        }
        lanes
            .delay(channel, lane.tap)
            .await
            .map_err(AlignError::Deserialiser)?;
    }

    let pattern = TestPattern::Sync;
    receiver
        .test_pattern(pattern)
        .await
        .map_err(AlignError::Receiver)?;
    for (channel, lane) in aligned.iter_mut().enumerate() {
        match frame(lanes, channel, R::BITS, R::SYNC).await {
            Ok(Ok(slips)) => lane.slips = slips,
            Ok(Err(word)) => return Err(AlignError::NoFrame { channel, word }),
            Err(error) => return Err(AlignError::Deserialiser(error)),
        }
    }

    let pattern = match R::RAMP {
        true => TestPattern::Ramp,
        false => TestPattern::Toggle,
    };
    receiver
        .test_pattern(pattern)
        .await
        .map_err(AlignError::Receiver)?;
    ramp::<R, D>(lanes, N).await?;
    Ok(aligned)
}

/// The widest range of taps with zeros and ones in turn, and its middle.
async fn eye<D: Deserialiser>(lanes: &mut D, channel: usize, bits: u32) -> Result<Lane, D::Error> {
    let mask = mask(bits);
    let (one, other) = (0x5555 & mask, 0xAAAA & mask);
    let mut best = Lane::default();
    let mut run = 0;
    for tap in 0..D::TAPS {
        lanes.delay(channel, tap).await?;
        lanes.capture().await?;
        let mut words = [0; WORDS];
        lanes.words(channel, &mut words).await?;
        let first = words.first().copied().unwrap_or_default();
        let good = (first == one || first == other) && words.iter().all(|&word| word == first);
        run = if good { run + 1 } else { 0 };
        if run > best.window {
            best.window = run;
            best.tap = tap - run / 2;
        }
    }
    Ok(best)
}

/// Bits by which words are moved until they are `sync`, or the last word.
async fn frame<D: Deserialiser>(
    lanes: &mut D,
    channel: usize,
    bits: u32,
    sync: u16,
) -> Result<Result<u8, u16>, D::Error> {
    let mut last = 0;
    for slips in 0..bits as u8 {
        lanes.capture().await?;
        let mut words = [0; WORDS];
        lanes.words(channel, &mut words).await?;
        if words.iter().all(|&word| word == sync) {
            return Ok(Ok(slips));
        }
        last = words.last().copied().unwrap_or_default();
        lanes.slip(channel).await?;
    }
    Ok(Err(last))
}

/// Whether words of all channels follow each other, alike. Words in turn are zeros or ones.
async fn ramp<R: Receiver, D: Deserialiser>(
    lanes: &mut D,
    channels: usize,
) -> Result<(), AlignError<R::Error, D::Error>> {
    lanes.capture().await.map_err(AlignError::Deserialiser)?;
    let mut start = None;
    for channel in 0..channels {
        let mut words = [0; WORDS];
        lanes
            .words(channel, &mut words)
            .await
            .map_err(AlignError::Deserialiser)?;
        let mut expected = *start.get_or_insert(words[0]);
        for got in words {
            if got != expected {
                return Err(AlignError::Ramp {
                    channel,
                    expected,
                    got,
                });
            }
            expected = match R::RAMP {
                true => expected.wrapping_add(1) & mask(R::BITS),
                false => !expected & mask(R::BITS),
            };
        }
    }
    Ok(())
}

/// The lowest `bits` bits.
fn mask(bits: u32) -> u16 {
    ((1u32 << bits) - 1) as u16
}
