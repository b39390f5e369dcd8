//! Mock of a pulser by its trait.

use core::cell::Cell;

use crate::{Checked, Pulser, Waveform};

/// Mock of a pulser with `N` channels and four profiles.
///
/// It keeps its profiles, and refuses calls that a board would refuse.
#[derive(Clone, Debug)]
pub struct MockPulser<const N: usize> {
    clock: f64,
    profiles: [Option<MockProfile<N>>; 4],
    selected: Option<u8>,
    fail: Cell<bool>,
}

/// A profile of a [`MockPulser`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MockProfile<const N: usize> {
    /// Each channel's delay, clock cycles.
    pub delays: [Option<u16>; N],
    /// The waveform.
    pub waveform: Waveform,
    /// The PRF, Hz.
    pub prf: f64,
}

/// Reason why a [`MockPulser`] refused a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{self:?}")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MockPulserError {
    /// There is no such profile.
    Profile(u8),
    /// The number of delays differs from the number of channels.
    Channels(usize),
    /// A channel's delay is too long.
    Delay {
        /// The channel.
        channel: usize,
        /// The delay, clock cycles.
        cycles: u16,
    },
    /// The profile was never loaded.
    NotLoaded(u8),
    /// A failure requested by [`MockPulser::fail_next`].
    Asked,
}

impl<const N: usize> MockPulser<N> {
    /// A board without profiles, with a clock of `clock` Hz.
    pub const fn new(clock: f64) -> Self {
        MockPulser {
            clock,
            profiles: [None; 4],
            selected: None,
            fail: Cell::new(false),
        }
    }

    /// Makes the next call fail, without changes.
    pub fn fail_next(&self) {
        self.fail.set(true);
    }

    /// Profile of the next trigger; `None` if none is selected.
    pub fn sends(&self) -> Option<&MockProfile<N>> {
        self.profiles[usize::from(self.selected?)].as_ref()
    }

    fn call(&mut self) -> Result<(), MockPulserError> {
        if self.fail.take() {
            return Err(MockPulserError::Asked);
        }
        Ok(())
    }
}

impl<const N: usize> Pulser for MockPulser<N> {
    type Error = MockPulserError;
    const CHANNELS: usize = N;
    const PROFILES: u8 = 4;
    const LONGEST: u16 = 8191;

    fn clock(&self) -> f64 {
        self.clock
    }

    async fn load(&mut self, index: u8, profile: Checked<'_>) -> Result<(), MockPulserError> {
        self.call()?;
        let profile = profile.profile();
        let Ok(delays) = <[Option<u16>; N]>::try_from(profile.delays) else {
            return Err(MockPulserError::Channels(profile.delays.len()));
        };
        for (channel, delay) in delays.iter().enumerate() {
            match *delay {
                Some(cycles) if cycles > Self::LONGEST => {
                    return Err(MockPulserError::Delay { channel, cycles });
                }
                _ => {}
            }
        }
        match self.profiles.get_mut(usize::from(index)) {
            Some(slot) => {
                *slot = Some(MockProfile {
                    delays,
                    waveform: profile.waveform,
                    prf: profile.prf,
                });
                Ok(())
            }
            None => Err(MockPulserError::Profile(index)),
        }
    }

    async fn select(&mut self, index: u8) -> Result<(), MockPulserError> {
        self.call()?;
        match self.profiles.get(usize::from(index)) {
            Some(Some(_)) => {
                self.selected = Some(index);
                Ok(())
            }
            Some(None) => Err(MockPulserError::NotLoaded(index)),
            None => Err(MockPulserError::Profile(index)),
        }
    }

    async fn stop(&mut self) -> Result<(), MockPulserError> {
        self.call()?;
        self.selected = None;
        Ok(())
    }
}
