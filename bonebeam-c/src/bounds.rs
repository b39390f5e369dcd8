//! Accepted values in SI units: those of the command and of files.

use crate::status::Refused;
use core::f64::consts::FRAC_PI_2;

/// Least and greatest magnitude, and both in words. The core checks signs.
pub(crate) struct Bound([f64; 2], &'static str);

pub(crate) const SPEED: Bound = Bound([100.0, 20e3], "100 to 20000 m/s");
pub(crate) const RATE: Bound = Bound([10e3, 10e9], "1e4 to 1e10 Hz");
pub(crate) const OUTPUT_RATE: Bound = Bound([1e3, 10e9], "1e3 to 1e10 Hz");
pub(crate) const FREQUENCY: Bound = Bound([0.0, 10e9], "at most 1e10 Hz");
pub(crate) const PITCH: Bound = Bound([1e-6, 10e-3], "1e-6 to 0.01 m");
pub(crate) const SPACING: Bound = Bound([1e-6, 1.0], "1e-6 to 1 m");
pub(crate) const RADIUS: Bound = Bound([1e-3, 10.0], "0.001 to 10 m");
pub(crate) const LENGTH: Bound = Bound([0.0, 10.0], "at most 10 m");
pub(crate) const ANGLE: Bound = Bound([0.0, FRAC_PI_2], "-pi/2 to pi/2 rad");
pub(crate) const F_NUMBER: Bound = Bound([1e-3, 1e6], "0.001 to 1e6");
pub(crate) const FIRING: Bound = Bound([0.0, 1e-3], "at most 0.001 s");
pub(crate) const RANGE: Bound = Bound([0.1, 1000.0], "0.1 to 1000 dB");
pub(crate) const THRESHOLD: Bound = Bound([0.0, 1e12], "at most 1e12");

impl Bound {
    pub(crate) fn check(&self, name: &'static str, value: f64) -> Result<(), Refused> {
        let Bound([least, most], expected) = self;
        match (*least..=*most).contains(&value.abs()) {
            true => Ok(()),
            false => Err(Refused::field(name, value, expected)),
        }
    }
}

/// Refuses a two-way time at which sound of speed `c` is more than 10 m away.
pub(crate) fn check_time(name: &'static str, time: f64, c: f64) -> Result<(), Refused> {
    match LENGTH.check(name, c * time / 2.0) {
        Ok(()) => Ok(()),
        Err(_) => Err(Refused::field(name, time, "the time of at most 10 m")),
    }
}
