//! How a transmit wave travels.

/// How the transmit wave travels. Times count from the moment at which the wave would pass the
/// law's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TransmitLaw<'a> {
    /// A focused beam, one line a transmit: the depth over c on the beam's axis, from where the axis
    /// leaves the array (z = 0 where it goes straight down). The line must lie on the axis.
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
        /// Its depth, m.
        z: f64,
    },
    /// A virtual source s, from x = 0, z = 0, with z down. s.z ≤ 0: a wave that diverges from s,
    /// (|p − s| − |s|)/c. s.z > 0: a wave that converges on s, (|s| − |p − s|)/c at depths less than s.z and
    /// (|s| + |p − s|)/c from there on.
    VirtualSource {
        /// The source's lateral position, m.
        x: f64,
        /// Its depth, m; positive for a focus in front of the array.
        z: f64,
    },
    /// When each element fires, s; one whose delay is not finite does not. The wave of the first element that
    /// arrives counts, from the moment of delay 0. Beyond the focus of a wave that converges the first to
    /// arrive is not its middle: there a virtual source says more.
    Delays(&'a [f64]),
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
pub struct Transmit<'a> {
    /// How the wave travels.
    pub law: TransmitLaw<'a>,
    /// Time of record sample 0 from the moment the wave would pass the law's origin, s.
    pub t0: f64,
}

impl<'a> Transmit<'a> {
    /// A wave that travels by `law` and whose record begins at `t0` s.
    pub const fn new(law: TransmitLaw<'a>, t0: f64) -> Self {
        Transmit { law, t0 }
    }
}
