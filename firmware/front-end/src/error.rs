//! Why a front end could not be set.

use core::fmt;

/// Why the front end is not as it was asked to be. `S` and `P` are the errors of the SPI device and of
/// the reset pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Error<S, P> {
    /// The SPI device refused a frame.
    Spi(S),
    /// The reset pin could not be set.
    Reset(P),
    /// A register does not hold what was written: a broken line, another part, a part without power or
    /// in reset.
    ReadBack {
        /// The register.
        register: u8,
        /// What was written.
        written: u16,
        /// What was read.
        read: u16,
    },
    /// The part has no demodulator.
    NoDemodulator,
    /// A number is beyond what the part takes.
    Range {
        /// What it is.
        name: &'static str,
        /// The number.
        value: i32,
        /// What would be right.
        expected: &'static str,
    },
}

impl<S: fmt::Debug, P: fmt::Debug> fmt::Display for Error<S, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Spi(error) => write!(f, "the SPI device refused a frame: {error:?}"),
            Error::Reset(error) => write!(f, "the reset pin could not be set: {error:?}"),
            Error::ReadBack {
                register,
                written,
                read,
            } => write!(
                f,
                "register {register} reads {read:#06x}, {written:#06x} was written"
            ),
            Error::NoDemodulator => write!(f, "the part has no demodulator"),
            Error::Range {
                name,
                value,
                expected,
            } => write!(f, "{name} is {value}, expected {expected}"),
        }
    }
}

impl<S: fmt::Debug, P: fmt::Debug> core::error::Error for Error<S, P> {}
