//! Delays of a transmit, in a pulser's clock cycles.

/// Delays of a transmit, and the time origin of its law after the trigger.
///
/// Elements are at depth 0 and face down, as in the beamformer.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Firing<const N: usize> {
    /// Delay of each element after the trigger, clock cycles. The first to fire has 0.
    pub cycles: [u16; N],
    /// Time at which the wave passes the origin of its law, s after the trigger.
    ///
    /// A record whose first sample is taken `t` after the trigger has `t0` = `t` − `origin`.
    pub origin: f64,
}

/// Error for delays that are longer than the pulser's longest, or not finite.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the delay of element {element} is {cycles} cycles, expected at most {longest}")]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct OutOfRange {
    /// Index of the element.
    pub element: usize,
    /// The requested delay, clock cycles.
    pub cycles: f64,
    /// The pulser's longest delay, clock cycles.
    pub longest: u16,
}

impl<const N: usize> Firing<N> {
    /// Delays of a plane wave by `angle` rad, positive towards positive x.
    ///
    /// Elements are at `x` m. The law's origin is x = 0, z = 0. `clock` in Hz, `sound_speed` in m/s.
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

    /// Delays of a wave focused at `focus` = (x, z) m.
    ///
    /// The law's origin is x = focus.0, z = 0, as for a beam along its axis.
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

    /// The delays for a [`Profile`](crate::Profile), with all channels firing.
    pub fn all(&self) -> [Option<u16>; N] {
        self.cycles.map(Some)
    }
}
