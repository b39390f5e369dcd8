//! What sends.

/// A transmit board: it holds profiles of delays, and fires one of them at a trigger.
///
/// Modelled on parts such as TI's TX7332 (32 channels, 16 profiles of delays in clock cycles), whose
/// registers are no matter of this crate.
pub trait Pulser {
    /// Why a call failed.
    type Error;
    /// Channels that fire together.
    const CHANNELS: usize;
    /// Profiles that it holds.
    const PROFILES: u8;
    /// The longest delay, in clock cycles.
    const LONGEST: u16;

    /// The clock that delays are counted in, Hz.
    fn clock(&self) -> f64;

    /// Writes a profile: each channel's delay after the trigger in clock cycles, or `None` where it is to
    /// be silent.
    ///
    /// # Errors
    /// The implementation's own: at least where there are more channels, profiles or cycles than it has.
    fn load(&mut self, profile: u8, delays: &[Option<u16>]) -> Result<(), Self::Error>;

    /// Fires with this profile at the next trigger, and at those that follow.
    ///
    /// # Errors
    /// The implementation's own: at least for a profile that was never loaded.
    fn select(&mut self, profile: u8) -> Result<(), Self::Error>;
}

/// Why a [`MockPulser`] refused a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MockPulserError {
    /// There is no such profile.
    Profile(u8),
    /// There are so many delays, not one for each channel.
    Channels(usize),
    /// This channel's delay is too long.
    Delay {
        /// The channel.
        channel: usize,
        /// The delay, clock cycles.
        cycles: u16,
    },
    /// The profile was never loaded.
    NotLoaded(u8),
    /// The call that was to fail: [`MockPulser::fail_next`].
    Asked,
}

/// A [`Pulser`] of `N` channels and four profiles without hardware: it keeps what it is told, and refuses
/// what a board would refuse.
#[derive(Clone, Debug, PartialEq)]
pub struct MockPulser<const N: usize> {
    clock: f64,
    profiles: [Option<[Option<u16>; N]>; 4],
    selected: Option<u8>,
    fail: bool,
}

impl<const N: usize> MockPulser<N> {
    /// A board that knows no profile, with this clock, Hz.
    pub const fn new(clock: f64) -> Self {
        MockPulser {
            clock,
            profiles: [None; 4],
            selected: None,
            fail: false,
        }
    }

    /// The next call fails, and changes nothing.
    pub fn fail_next(&mut self) {
        self.fail = true;
    }

    /// What the next trigger would send: each channel's delay. `None` where no profile is selected.
    pub fn sends(&self) -> Option<&[Option<u16>; N]> {
        self.profiles[usize::from(self.selected?)].as_ref()
    }

    fn call(&mut self) -> Result<(), MockPulserError> {
        if core::mem::take(&mut self.fail) {
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

    fn load(&mut self, profile: u8, delays: &[Option<u16>]) -> Result<(), MockPulserError> {
        self.call()?;
        let Ok(delays) = <[Option<u16>; N]>::try_from(delays) else {
            return Err(MockPulserError::Channels(delays.len()));
        };
        for (channel, delay) in delays.iter().enumerate() {
            match *delay {
                Some(cycles) if cycles > Self::LONGEST => {
                    return Err(MockPulserError::Delay { channel, cycles });
                }
                _ => {}
            }
        }
        match self.profiles.get_mut(usize::from(profile)) {
            Some(slot) => *slot = Some(delays),
            None => return Err(MockPulserError::Profile(profile)),
        }
        Ok(())
    }

    fn select(&mut self, profile: u8) -> Result<(), MockPulserError> {
        self.call()?;
        match self.profiles.get(usize::from(profile)) {
            Some(Some(_)) => {
                self.selected = Some(profile);
                Ok(())
            }
            Some(None) => Err(MockPulserError::NotLoaded(profile)),
            None => Err(MockPulserError::Profile(profile)),
        }
    }
}
