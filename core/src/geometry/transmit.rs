//! How a transmit wave travels.

/// How the transmit wave travels. Times count from the moment at which the wave would pass the
/// law's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TransmitLaw {
    /// A focused beam, one line a transmit: z/c on the beam's axis, from z = 0 there. The line
    /// must lie on the axis.
    Focused,
    /// A plane wave: (x sin α + z cos α)/c, from x = 0, z = 0.
    Plane {
        /// The steering angle α, rad; positive sends the wave towards positive x.
        angle: f64,
    },
    /// One transmitting element: the distance from it over c.
    Element {
        /// The element's lateral position, m.
        x: f64,
    },
}

/// One transmit: its wave, and when its record begins.
///
/// ```
/// use bonebeam::geometry::{Transmit, TransmitLaw};
///
/// // A plane wave 5° to the right, recorded from 2 µs on.
/// let steered = Transmit::new(TransmitLaw::Plane { angle: 5f64.to_radians() }, 2e-6);
/// assert_eq!(steered.t0, 2e-6);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Transmit {
    /// How the wave travels.
    pub law: TransmitLaw,
    /// Time of record sample 0 from the moment the wave would pass the law's origin, s.
    pub t0: f64,
}

impl Transmit {
    /// A wave that travels by `law` and whose record begins at `t0` s.
    pub const fn new(law: TransmitLaw, t0: f64) -> Self {
        Transmit { law, t0 }
    }
}
