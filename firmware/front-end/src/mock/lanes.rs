//! Mock of the lanes between receivers and an FPGA.

use core::convert::Infallible;

use embedded_hal::digital::{self, OutputPin};

use super::words::MockWords;
use super::{MockAfe, PinResult};
use crate::Deserialiser;

/// Mock of a synchronisation line to several parts.
///
/// A rising edge starts their ramps together.
#[derive(Clone, Debug)]
pub struct MockSync<'a>(pub &'a [MockAfe]);

impl digital::ErrorType for MockSync<'_> {
    type Error = Infallible;
}

impl OutputPin for MockSync<'_> {
    fn set_low(&mut self) -> PinResult {
        Ok(())
    }

    fn set_high(&mut self) -> PinResult {
        for part in self.0 {
            part.start(0);
        }
        Ok(())
    }
}

/// A lane: its readable taps, and the first bit of its words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MockLane {
    /// The first good tap.
    pub first: u16,
    /// The first bad tap after it.
    pub end: u16,
    /// Number of bits by which words must be shifted.
    pub offset: u32,
    /// The tap in use.
    pub tap: u16,
}

/// Mock deserialiser of `N` lanes, the same number from each part.
#[derive(Clone, Debug)]
pub struct MockLanes<'a, P, const N: usize> {
    parts: &'a [P],
    /// The lanes.
    pub lanes: [MockLane; N],
    time: u16,
    noise: u32,
}

impl<'a, P: MockWords, const N: usize> MockLanes<'a, P, N> {
    /// Lanes of these parts. Ramps of different parts start at different words.
    pub fn new(parts: &'a [P], lanes: [MockLane; N]) -> Self {
        for (part, phase) in parts.iter().zip(1..) {
            part.start(phase);
        }
        MockLanes {
            parts,
            lanes,
            time: 0,
            noise: 1,
        }
    }
}

impl<P: MockWords, const N: usize> Deserialiser for MockLanes<'_, P, N> {
    /// Index of a lane that does not exist.
    type Error = usize;
    const TAPS: u16 = 32;

    async fn delay(&mut self, channel: usize, tap: u16) -> Result<(), usize> {
        self.lanes.get_mut(channel).ok_or(channel)?.tap = tap;
        Ok(())
    }

    async fn slip(&mut self, channel: usize) -> Result<(), usize> {
        let lane = self.lanes.get_mut(channel).ok_or(channel)?;
        lane.offset = (lane.offset + P::BITS - 1) % P::BITS;
        Ok(())
    }

    async fn capture(&mut self) -> Result<(), usize> {
        self.time = self.time.wrapping_add(100);
        Ok(())
    }

    async fn words(&mut self, channel: usize, words: &mut [u16]) -> Result<(), usize> {
        let lane = *self.lanes.get(channel).ok_or(channel)?;
        let part = self.parts.get(channel * self.parts.len() / N);
        let part = part.ok_or(channel)?;
        let mask = ((1u32 << P::BITS) - 1) as u16;
        for (word, time) in words.iter_mut().zip(self.time..) {
            // Echoes are noise.
            self.noise = self
                .noise
                .wrapping_mul(1_664_525)
                .wrapping_add(1_013_904_223);
            let noise = (self.noise >> 16) as u16 & mask;
            let sent = |time| u32::from(part.word(time).unwrap_or(noise));
            let two = sent(time) << P::BITS | sent(time.wrapping_add(1));
            let good = (lane.first..lane.end).contains(&lane.tap);
            *word = (two >> (P::BITS - lane.offset)) as u16 & mask ^ if good { 0 } else { noise };
        }
        Ok(())
    }
}
