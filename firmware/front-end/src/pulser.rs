//! Pulsers, and limits that hold for every transmit.

use core::fmt;

/// The signal of each element.
///
/// Half cycles of alternating sign. A pulser of two levels drives a whole half cycle. A pulser of three levels
/// drives a part of it, and ground for the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Waveform {
    /// Frequency, Hz.
    pub frequency: f64,
    /// Number of half cycles.
    pub half_cycles: u8,
    /// Whether the first half cycle is positive.
    pub positive_first: bool,
    /// Driven part of a half cycle: above 0, at most 1 (two levels).
    ///
    /// At 2/3 the third harmonic is smallest.
    pub driven: f64,
    /// Voltage of both rails against ground, V.
    pub volts: f64,
    /// Damping: time that the element is driven to ground afterwards, s.
    pub damping: f64,
}

impl Waveform {
    /// Time that an element is driven away from ground, s.
    pub fn driven_time(&self) -> f64 {
        f64::from(self.half_cycles) / 2.0 / self.frequency * self.driven
    }

    /// Time from the first edge to the end of damping, s.
    pub fn duration(&self) -> f64 {
        f64::from(self.half_cycles) / 2.0 / self.frequency + self.damping
    }
}

/// A transmit as a pulser stores it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Profile<'a> {
    /// The signal of each element that fires.
    pub waveform: Waveform,
    /// Delay of each channel after the trigger, clock cycles; `None` if silent.
    ///
    /// Apodization is on or off, since all channels share rails and waveform.
    pub delays: &'a [Option<u16>],
    /// Time from the end of the waveform to the opening of the receive switches, s.
    ///
    /// The transmit/receive switches then pass echoes.
    pub receive_after: f64,
    /// Transmits per second while this profile is selected, Hz.
    pub prf: f64,
}

/// A profile within the limits. Only [`Limited`] makes one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checked<'a> {
    profile: Profile<'a>,
}

impl<'a> Checked<'a> {
    /// The profile.
    pub fn profile(&self) -> &Profile<'a> {
        &self.profile
    }
}

/// A transmit board that holds profiles, and fires one of them at each trigger.
///
/// Firmware calls it through [`Limited`], which alone can make the argument of [`Pulser::load`].
#[allow(async_fn_in_trait)]
pub trait Pulser {
    /// Reason why a call failed.
    type Error;
    /// Number of channels that fire together.
    const CHANNELS: usize;
    /// Number of stored profiles.
    const PROFILES: u8;
    /// The longest delay, clock cycles.
    const LONGEST: u16;

    /// Clock of the delays, Hz.
    fn clock(&self) -> f64;

    /// Writes a profile.
    ///
    /// # Errors
    /// The implementation's own: at least for a profile, a number of channels, a delay or a waveform that it
    /// does not have.
    async fn load(&mut self, index: u8, profile: Checked<'_>) -> Result<(), Self::Error>;

    /// Fires with this profile, its voltage and its PRF from now on.
    ///
    /// # Errors
    /// The implementation's own: at least for a profile that was never loaded.
    async fn select(&mut self, index: u8) -> Result<(), Self::Error>;

    /// Stops firing, and takes the voltage away.
    ///
    /// # Errors
    /// The implementation's own.
    async fn stop(&mut self) -> Result<(), Self::Error>;
}

/// Limits of a device, fixed once for a probe.
///
/// They are electrical. IEC 60601-2-37 limits the output at the patient: acoustic output, shown as thermal and
/// mechanical index, and the temperature of the probe's surface. The maker measures both at these limits, and
/// chooses limits that meet the standard.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits {
    /// Maximum voltage of a rail, V.
    pub volts: f64,
    /// Maximum driven part of the time: driven time times PRF.
    pub duty: f64,
    /// Maximum electrical energy of a transmit, J.
    ///
    /// Firing channels times `volts²/load` times driven time.
    pub energy: f64,
    /// Maximum PRF, Hz.
    pub prf: f64,
    /// Resistance of an element at its centre frequency for the energy, Ω.
    pub load: f64,
}

/// The limit that a profile exceeds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Limit {
    /// Voltage, V.
    Volts,
    /// Driven part of the time.
    Duty,
    /// Energy of a transmit, J.
    Energy,
    /// PRF, Hz.
    Prf,
    /// Time from a trigger to received echoes, s.
    ///
    /// At most the time to the next trigger.
    Period,
    /// A number that is negative, not finite, or 0 where it must not be.
    Value,
}

/// A profile beyond a limit. Nothing was sent.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LimitError {
    /// The limit.
    pub limit: Limit,
    /// The profile's value.
    pub value: f64,
    /// The allowed maximum.
    pub most: f64,
}

impl fmt::Display for LimitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let LimitError { limit, value, most } = self;
        let (name, unit) = match limit {
            Limit::Volts => ("voltage", " V"),
            Limit::Duty => ("duty", ""),
            Limit::Energy => ("energy of a transmit", " J"),
            Limit::Prf => ("PRF", " Hz"),
            Limit::Period => ("time of a transmit", " s"),
            Limit::Value => return write!(f, "{value} is no number of a transmit"),
        };
        write!(
            f,
            "the {name} is {value}{unit}, expected at most {most}{unit}"
        )
    }
}

impl core::error::Error for LimitError {}

impl Limits {
    /// Checks a profile for a pulser of this clock, Hz.
    fn check(&self, profile: &Profile<'_>, clock: f64) -> Result<(), LimitError> {
        let Profile {
            waveform,
            delays,
            receive_after,
            prf,
        } = *profile;
        within([waveform.frequency, waveform.driven, prf], |x| x > 0.0)?;
        within([waveform.volts, waveform.damping, receive_after], |x| {
            x >= 0.0
        })?;
        if waveform.driven > 1.0 {
            return Err(no_value(waveform.driven));
        }
        let firing = delays.iter().flatten().count() as f64;
        let power = waveform.volts * waveform.volts / self.load;
        let longest = delays.iter().flatten().fold(0, |a, &b| a.max(b));
        let time = f64::from(longest) / clock + waveform.duration() + receive_after;
        for (limit, value, most) in [
            (Limit::Volts, waveform.volts, self.volts),
            (Limit::Prf, prf, self.prf),
            (Limit::Duty, waveform.driven_time() * prf, self.duty),
            (
                Limit::Energy,
                firing * power * waveform.driven_time(),
                self.energy,
            ),
            (Limit::Period, time, 1.0 / prf),
        ] {
            // A value that is not finite is beyond every limit.
            let is_within = value <= most;
            if !is_within {
                return Err(LimitError { limit, value, most });
            }
        }
        Ok(())
    }
}

fn no_value(value: f64) -> LimitError {
    LimitError {
        limit: Limit::Value,
        value,
        most: 0.0,
    }
}

/// Refuses a value that is not finite, or not within `range`.
fn within<const N: usize>(values: [f64; N], range: impl Fn(f64) -> bool) -> Result<(), LimitError> {
    match values.into_iter().find(|&x| !(range(x) && x.is_finite())) {
        Some(value) => Err(no_value(value)),
        None => Ok(()),
    }
}

/// Reason why [`Limited`] refused a call.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LimitedError<E> {
    /// The profile exceeds a limit.
    #[error("{0}")]
    Limit(LimitError),
    /// Error of the pulser.
    #[error("{0}")]
    Pulser(E),
}

/// A pulser within limits.
///
/// It owns the pulser, and the limits cannot be changed. No profile beyond them reaches the pulser.
#[derive(Clone, Debug)]
pub struct Limited<P> {
    pulser: P,
    limits: Limits,
}

impl<P: Pulser> Limited<P> {
    /// Limits `pulser` by `limits`.
    ///
    /// # Errors
    /// [`LimitError`] for a limit that is not finite and above 0, or a duty above 1.
    pub fn new(pulser: P, limits: Limits) -> Result<Self, LimitError> {
        let Limits {
            volts,
            duty,
            energy,
            prf,
            load,
        } = limits;
        within([volts, duty, energy, prf, load, pulser.clock()], |x| {
            x > 0.0
        })?;
        if duty > 1.0 {
            return Err(no_value(duty));
        }
        Ok(Limited { pulser, limits })
    }

    /// The pulser, for inspection.
    pub fn pulser(&self) -> &P {
        &self.pulser
    }

    /// The limits.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Writes a profile, if it is within the limits.
    ///
    /// # Errors
    /// [`LimitedError::Limit`], with nothing sent; [`LimitedError::Pulser`].
    pub async fn load(
        &mut self,
        index: u8,
        profile: &Profile<'_>,
    ) -> Result<(), LimitedError<P::Error>> {
        self.limits
            .check(profile, self.pulser.clock())
            .map_err(LimitedError::Limit)?;
        let checked = Checked { profile: *profile };
        self.pulser
            .load(index, checked)
            .await
            .map_err(LimitedError::Pulser)
    }

    /// Fires with this profile from now on.
    ///
    /// # Errors
    /// The pulser's error.
    pub async fn select(&mut self, index: u8) -> Result<(), P::Error> {
        self.pulser.select(index).await
    }

    /// Stops firing, and switches the voltage off.
    ///
    /// # Errors
    /// The pulser's error.
    pub async fn stop(&mut self) -> Result<(), P::Error> {
        self.pulser.stop().await
    }
}
