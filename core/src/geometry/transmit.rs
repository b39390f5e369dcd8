//! Propagation of transmit waves.

/// Propagation of the transmit wave.
///
/// Times count from the passage of the wave through the law's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum TransmitLaw<'a> {
    /// A focused beam, one line per transmit.
    ///
    /// On the beam's axis the delay is the depth divided by c, from the axis's origin on the array (z = 0 if it goes
    /// straight down). The line must be on the axis.
    Focused,
    /// A plane wave: (x sin α + z cos α)/c, from x = 0, z = 0.
    Plane {
        /// The steering angle α, rad; positive sends the wave towards positive x.
        angle: f64,
    },
    /// One transmitting element; the delay is the distance from it divided by c.
    Element {
        /// The element's lateral position, m.
        x: f64,
        /// Its depth, m.
        z: f64,
    },
    /// A virtual source s; times count from x = 0, z = 0, with z down.
    ///
    /// `s.z ≤ 0`: a wave diverging from s, with the delay (|p − s| − |s|)/c. `s.z > 0`: a wave converging on s, with
    /// the delay (|s| − |p − s|)/c at depths less than s.z and (|s| + |p − s|)/c deeper.
    VirtualSource {
        /// The source's lateral position, m.
        x: f64,
        /// Its depth, m; positive for a focus in front of the array.
        z: f64,
    },
    /// Firing time of each element, s; an element without a finite time is silent.
    ///
    /// The delay is the first arrival from an element, counted from firing time 0. Beyond the focus of a converging
    /// wave, the first arrival is not the wave's centre. Use a virtual source there.
    Delays(&'a [f64]),
}

/// One transmit: its wave, and the beginning of its record.
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
    /// Propagation law of the wave.
    pub law: TransmitLaw<'a>,
    /// Time of record sample 0 after the wave passes the law's origin, s.
    pub t0: f64,
}

impl<'a> Transmit<'a> {
    /// A wave that propagates by `law`, with a record from `t0` s on.
    pub const fn new(law: TransmitLaw<'a>, t0: f64) -> Self {
        Transmit { law, t0 }
    }
}
