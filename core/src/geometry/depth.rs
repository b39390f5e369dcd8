//! A position along a scan line.

/// A position along a scan line, as a depth or a two-way time.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Depth {
    /// Depth z, m.
    Metres(f64),
    /// Two-way time 2z/c, s.
    Seconds(f64),
}

impl Depth {
    /// Two-way time at `sound_speed` m/s, s.
    ///
    /// ```
    /// use bonebeam::geometry::Depth;
    ///
    /// assert_eq!(Depth::Metres(15.4e-3).seconds(1540.0), 20e-6);
    /// assert_eq!(Depth::Seconds(20e-6).seconds(1540.0), 20e-6);
    /// ```
    pub const fn seconds(self, sound_speed: f64) -> f64 {
        match self {
            Depth::Metres(z) => 2.0 * z / sound_speed,
            Depth::Seconds(t) => t,
        }
    }
}
