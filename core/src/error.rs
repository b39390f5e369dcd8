//! The one error type of the crate.

use core::fmt;

/// Reason for refusing a call.
///
/// Nothing was computed and no output was written, unless the function's documentation says otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Error {
    /// A parameter is outside its range.
    Parameter {
        /// The parameter's name, as in the documentation.
        name: &'static str,
        /// The value that was given.
        value: f64,
        /// The accepted values, in words.
        expected: &'static str,
    },
    /// A slice's length differs from the length that the shapes require.
    Length {
        /// Contents of the slice.
        name: &'static str,
        /// Its length.
        actual: usize,
        /// The required length.
        expected: usize,
    },
    /// A size exceeds the capacity that was compiled in.
    Capacity {
        /// The size's name.
        name: &'static str,
        /// The requested size.
        actual: usize,
        /// The largest that fits.
        capacity: usize,
    },
    /// An input sample is NaN or infinite.
    NonFinite {
        /// Contents of the slice.
        name: &'static str,
        /// Index of the sample in the flat slice.
        index: usize,
    },
    /// External memory could not be read or written.
    Memory,
}

/// The value of a constant, or a compiler's error that says why it is not valid.
///
/// ```
/// use bonebeam::prelude::*;
///
/// const NEED: Need = valid!(Parameters::EXAMPLE.need(Input::Rf, 1));
/// static MEMORY: Memory<{ NEED.real }, { NEED.complex }> = Memory::new();
/// ```
#[macro_export]
macro_rules! valid {
    ($value:expr) => {
        match $value {
            Ok(value) => value,
            Err(error) => panic!("{}", $crate::Error::words(&error).as_str()),
        }
    };
}

impl Error {
    /// A parameter outside its range.
    pub(crate) const fn parameter(name: &'static str, value: f64, expected: &'static str) -> Self {
        Error::Parameter {
            name,
            value,
            expected,
        }
    }

    /// A slice of another length than expected.
    pub(crate) const fn length(name: &'static str, actual: usize, expected: usize) -> Self {
        Error::Length {
            name,
            actual,
            expected,
        }
    }

    /// A size above the capacity.
    pub(crate) const fn capacity(name: &'static str, actual: usize, capacity: usize) -> Self {
        Error::Capacity {
            name,
            actual,
            capacity,
        }
    }

    /// Name and accepted values, for a `const` that cannot format a number.
    ///
    /// ```compile_fail
    /// use bonebeam::prelude::*;
    ///
    /// // error: evaluation panicked: block: expected at least 1
    /// const NEED: Need = valid!((Parameters { block: 0, ..Parameters::EXAMPLE }).need(Input::Rf, 1));
    /// static MEMORY: [f32; NEED.real] = [0.0; NEED.real];
    /// ```
    pub const fn words(&self) -> Words {
        match *self {
            Error::Parameter { name, expected, .. } => Words::of([name, ": expected ", expected]),
            Error::Length { name, .. } => Words::of([name, ": another length", ""]),
            Error::Capacity { name, .. } => Words::of([name, ": too large", ""]),
            Error::NonFinite { name, .. } => Words::of([name, ": not finite", ""]),
            Error::Memory => Words::of(["external memory", "", ""]),
        }
    }

    /// Number of the kind of error, for interfaces without types.
    ///
    /// It is never 0, and keeps its meaning in later versions.
    ///
    /// ```
    /// use bonebeam::Error;
    ///
    /// assert_eq!(Error::Memory.code(), 5);
    /// ```
    pub const fn code(&self) -> u8 {
        match self {
            Error::Parameter { .. } => 1,
            Error::Length { .. } => 2,
            Error::Capacity { .. } => 3,
            Error::NonFinite { .. } => 4,
            Error::Memory => 5,
        }
    }
}

/// A short text in fixed memory: [`Error::words`].
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Words {
    bytes: [u8; 160],
    length: usize,
}

impl Words {
    const fn of([before, between, after]: [&str; 3]) -> Self {
        let words = Words {
            bytes: [0; 160],
            length: 0,
        };
        words.and(before).and(between).and(after)
    }

    #[inline(never)]
    const fn and(mut self, text: &str) -> Self {
        let mut rest = text.as_bytes();
        while let [first, after @ ..] = rest
            && self.length < self.bytes.len()
        {
            self.bytes[self.length] = *first;
            self.length += 1;
            rest = after;
        }
        self
    }

    /// The text.
    pub const fn as_str(&self) -> &str {
        let text = match self.bytes.split_at_checked(self.length) {
            Some((text, _)) => text,
            None => &[],
        };
        match core::str::from_utf8(text) {
            Ok(text) => text,
            Err(_) => "",
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Error::Parameter {
                name,
                value,
                expected,
            } => {
                write!(f, "{name} is {value}, expected {expected}")
            }
            Error::Length {
                name,
                actual,
                expected,
            } => {
                write!(f, "{name} has length {actual}, expected {expected}")
            }
            Error::Capacity {
                name,
                actual,
                capacity,
            } => {
                write!(f, "{name} is {actual}, more than the capacity {capacity}")
            }
            Error::NonFinite { name, index } => {
                write!(f, "{name} holds a NaN or infinite value at index {index}")
            }
            Error::Memory => write!(f, "external memory could not be read or written"),
        }
    }
}

impl core::error::Error for Error {}

/// The operator `?` for a `const fn`, which does not have it.
macro_rules! attempt {
    ($result:expr) => {
        match $result {
            Ok(value) => value,
            Err(error) => return Err(error),
        }
    };
}
pub(crate) use attempt;

/// Refuses a slice whose length is not the one that the shapes require.
pub(crate) const fn check_length(
    name: &'static str,
    actual: usize,
    expected: usize,
) -> Result<(), Error> {
    if actual == expected {
        Ok(())
    } else {
        Err(Error::length(name, actual, expected))
    }
}

/// Refuses a number that is not positive and finite.
#[cfg_attr(not(feature = "constants"), inline(never))]
pub(crate) const fn positive(name: &'static str, value: f64) -> Result<(), Error> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(Error::parameter(name, value, "a positive, finite number"))
}

/// Refuses a NaN and an infinity.
pub(crate) const fn finite(name: &'static str, value: f64) -> Result<(), Error> {
    if value.is_finite() {
        return Ok(());
    }
    Err(Error::parameter(name, value, "a finite number"))
}

/// Refuses a negative number, a NaN and an infinity.
pub(crate) const fn not_negative(name: &'static str, value: f32) -> Result<(), Error> {
    if value >= 0.0 && value.is_finite() {
        return Ok(());
    }
    let expected = "a finite number of at least 0";
    Err(Error::parameter(name, value as f64, expected))
}

/// Refuses 0.
pub(crate) const fn at_least_one(name: &'static str, value: usize) -> Result<(), Error> {
    if value == 0 {
        return Err(none(name));
    }
    Ok(())
}

/// The refusal of 0.
pub(crate) const fn none(name: &'static str) -> Error {
    Error::parameter(name, 0.0, "at least 1")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Written out, since other programs know them.
    #[test]
    fn codes_stay() {
        let (name, expected) = ("", "");
        let parameter = Error::parameter(name, 0.0, expected);
        let length = Error::length(name, 0, 1);
        let capacity = Error::capacity(name, 1, 0);
        let non_finite = Error::NonFinite { name, index: 0 };
        let all = [parameter, length, capacity, non_finite, Error::Memory];
        assert_eq!(all.map(|error| error.code()), [1, 2, 3, 4, 5]);
    }
}
