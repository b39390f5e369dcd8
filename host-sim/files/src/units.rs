//! Values in a wrong unit.
//!
//! They are refused if they are impossible; the message names the probable unit.

use crate::terminal::digits;

/// A quantity: its unit, its accepted range, its usual range, its other units.
///
/// The other units are those in which the quantity is often given by mistake.
pub struct Quantity {
    unit: &'static str,
    accepted: [f64; 2],
    usual: [f64; 2],
    others: &'static [(&'static str, f64)],
}

/// Sampling rates and centre frequencies.
pub const RATE: Quantity = Quantity {
    unit: "Hz",
    accepted: [10e3, 10e9],
    usual: [50e3, 2e9],
    others: &[("MHz", 1e6), ("kHz", 1e3), ("GHz", 1e9)],
};

/// Speeds of sound.
pub const SPEED: Quantity = Quantity {
    unit: "m/s",
    accepted: [100.0, 20e3],
    usual: [300.0, 7e3],
    others: &[("km/s", 1e3), ("cm/s", 1e-2), ("mm/s", 1e-3)],
};

/// The distance between neighbouring elements.
pub const PITCH: Quantity = Quantity {
    unit: "m",
    accepted: [1e-6, 10e-3],
    usual: [50e-6, 3e-3],
    others: LENGTH_UNITS,
};

/// Depths, and positions of beams beside the array.
pub const LENGTH: Quantity = Quantity {
    unit: "m",
    accepted: [0.0, 10.0],
    usual: [1e-3, 0.3],
    others: LENGTH_UNITS,
};

const LENGTH_UNITS: &[(&str, f64)] = &[("mm", 1e-3), ("cm", 1e-2), ("µm", 1e-6)];

impl Quantity {
    /// Checks a value; the message names the range and the probable unit.
    pub fn check(&self, what: &str, value: f64) -> Result<(), String> {
        let [least, most] = self.accepted;
        let size = value.abs();
        if size >= least && size <= most {
            return Ok(());
        }
        let unit = self.unit;
        let hint = self.hint(value);
        Err(format!(
            "{what} is {} {unit}; expected {least} to {most} {unit}{hint}",
            digits(value)
        ))
    }

    /// The unit that an unusual value probably has, to append to a message.
    ///
    /// Empty if no unit would make it usual.
    pub fn hint(&self, value: f64) -> String {
        let [least, most] = self.usual;
        let usual = |scale: f64| (least..=most).contains(&(value.abs() * scale));
        match self.others.iter().find(|(_, scale)| usual(*scale)) {
            Some((other, _)) => format!("; it is probably in {other}"),
            None => String::new(),
        }
    }
}

/// Checks that record starts, in seconds, are at depths that sound reaches.
pub fn check_starts(t0: &[f64], c: f64) -> Result<(), String> {
    let [_, deepest] = LENGTH.accepted;
    let depth = |t0: f64| c * t0 / 2.0;
    match t0.iter().position(|&t0| depth(t0).abs() > deepest) {
        None => Ok(()),
        Some(transmit) => Err(format!(
            "`t0` is {} at transmit {transmit}, the time of a depth of {:.0} m; expected seconds, at \
             most {deepest} m either way; it is probably in µs or counted in samples",
            digits(t0[transmit]),
            depth(t0[transmit])
        )),
    }
}

/// Checks the number of values that describe an axis of the samples.
///
/// If the number is that of another axis, the axes are probably in another order. Messages give the samples' key,
/// shape and names of axes.
pub fn check_axis(
    key: &str,
    count: usize,
    (samples, shape, axes): (&str, &[usize], &[&str]),
    axis: usize,
    of: &str,
) -> Result<(), String> {
    const PLACES: [&str; 4] = ["first", "second", "third", "fourth"];
    if count == shape[axis] {
        return Ok(());
    }
    let message = format!(
        "`{key}` has length {count}; expected {}, one for each {of}",
        shape[axis]
    );
    match shape.iter().position(|&side| side == count) {
        None => Err(message),
        Some(other) => Err(format!(
            "{message}: `{samples}` has shape {shape:?}, and its {} axis is that long, not the {}; its axes \
             are probably swapped, expected [{}]",
            PLACES[other],
            PLACES[axis],
            axes.join(", ")
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_that_is_probably_meant_is_named() {
        for (quantity, value, unit) in [
            (RATE, 40.0, "MHz"),
            (RATE, 5000.0, "kHz"),
            (SPEED, 1.54, "km/s"),
            (SPEED, 154_000.0, "cm/s"),
            (SPEED, 1.54e6, "mm/s"),
            (PITCH, 0.3, "mm"),
            (PITCH, 0.03, "cm"),
            (PITCH, 300.0, "µm"),
            (LENGTH, 15.0, "mm"),
        ] {
            let message = quantity.check("`key`", value).unwrap_err();
            assert!(
                message.ends_with(&format!("probably in {unit}")),
                "{message}"
            );
        }
        for (quantity, value) in [(RATE, 5e6), (SPEED, 1540.0), (PITCH, 0.3e-3), (LENGTH, 0.0)] {
            assert_eq!(quantity.check("`key`", value), Ok(()));
        }
        for value in [f64::NAN, f64::INFINITY, 0.0] {
            let message = SPEED.check("`c`", value).unwrap_err();
            assert!(!message.contains("probably"), "{message}");
        }
    }

    #[test]
    fn axes_in_another_order_are_reported() {
        let check = |count, shape: [usize; 3]| {
            let axes = ["transmit", "element", "sample"];
            check_axis("element_x", count, ("rf", &shape, &axes), 1, "element")
        };
        assert_eq!(check(4, [2, 4, 64]), Ok(()));
        let message = check(4, [2, 64, 4]).unwrap_err();
        assert!(
            message.contains("third axis") && message.contains("swapped"),
            "{message}"
        );
        let message = check(5, [2, 64, 4]).unwrap_err();
        assert!(!message.contains("swapped"), "{message}");
    }
}
