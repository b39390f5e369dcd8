//! Delays of a transmit, in a pulser's clock cycles.

use core::fmt;

/// A transmit's delays, and the time between its trigger and the moment that the beamformer counts from.
///
/// Elements lie at depth 0 and look down, as the beamformer's do.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Firing<const N: usize> {
    /// Each element's delay after the trigger, clock cycles. The first to fire has 0.
    pub cycles: [u16; N],
    /// When the wave passes the origin of its law, s after the trigger. A record whose first sample is
    /// taken `t` after the trigger has `t0` = `t` − `origin`.
    pub origin: f64,
}

/// Delays that the pulser does not have: longer than its longest, or not finite.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OutOfRange {
    /// The element.
    pub element: usize,
    /// The delay asked for, clock cycles.
    pub cycles: f64,
    /// The longest that the pulser has.
    pub longest: u16,
}

impl fmt::Display for OutOfRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let OutOfRange {
            element,
            cycles,
            longest,
        } = self;
        write!(
            f,
            "the delay of element {element} is {cycles} cycles, expected at most {longest}"
        )
    }
}

impl core::error::Error for OutOfRange {}

impl<const N: usize> Firing<N> {
    /// A plane wave by `angle` rad, positive towards positive x, from elements at `x` m. Its law's origin is
    /// x = 0, z = 0. `clock` in Hz, `sound_speed` in m/s.
    ///
    /// # Errors
    /// [`OutOfRange`] for the first element whose delay is longer than `longest` cycles.
    pub fn plane(
        x: &[f64; N],
        angle: f64,
        sound_speed: f64,
        clock: f64,
        longest: u16,
    ) -> Result<Self, OutOfRange> {
        let slope = libm::sin(angle) / sound_speed;
        Self::of(x.map(|x| x * slope), 0.0, clock, longest)
    }

    /// A wave focused at `focus` = (x, z) m. Its law's origin is x = focus.0, z = 0: that of a beam along
    /// its axis.
    ///
    /// # Errors
    /// As [`Firing::plane`].
    pub fn focused(
        x: &[f64; N],
        focus: (f64, f64),
        sound_speed: f64,
        clock: f64,
        longest: u16,
    ) -> Result<Self, OutOfRange> {
        let early = x.map(|x| -libm::hypot(x - focus.0, focus.1) / sound_speed);
        Self::of(early, -focus.1 / sound_speed, clock, longest)
    }

    /// Delays `times`, s, from the first of them on, where the wave passes its origin at `origin`.
    fn of(times: [f64; N], origin: f64, clock: f64, longest: u16) -> Result<Self, OutOfRange> {
        let first = times
            .iter()
            .fold(f64::INFINITY, |a, &b| if b < a { b } else { a });
        let mut cycles = [0; N];
        for (element, (cycles, time)) in cycles.iter_mut().zip(times).enumerate() {
            let exact = libm::round((time - first) * clock);
            if !(exact >= 0.0 && exact <= longest.into()) {
                return Err(OutOfRange {
                    element,
                    cycles: exact,
                    longest,
                });
            }
            *cycles = exact as u16;
        }
        Ok(Firing {
            cycles,
            origin: origin - first,
        })
    }

    /// The delays as a [`Profile`](crate::Profile) has them, all channels firing.
    pub fn all(&self) -> [Option<u16>; N] {
        self.cycles.map(Some)
    }
}
