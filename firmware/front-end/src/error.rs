//! Errors of the parts.

use core::fmt;

use embedded_hal::{digital, spi};

/// Reason why the configuration of a part failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Error {
    /// The SPI device refused a frame.
    Spi(spi::ErrorKind),
    /// A pin could not be set.
    Pin(digital::ErrorKind),
    /// A register does not hold the value that was written.
    ///
    /// Causes: a broken line, another part, a part without power or in reset.
    ReadBack {
        /// The register.
        register: u16,
        /// The value that was written.
        written: u32,
        /// The value that was read.
        read: u32,
    },
    /// A word of the demodulator's memories does not hold the value that was written.
    Memory {
        /// The register of the memory.
        register: u8,
        /// The word.
        index: u8,
    },
    /// The part has no demodulator.
    NoDemodulator,
    /// A number is beyond the part's range.
    Range {
        /// Its name.
        name: &'static str,
        /// The number.
        value: i32,
        /// The range.
        expected: &'static str,
    },
}

impl Error {
    pub(crate) fn spi(error: impl spi::Error) -> Self {
        Error::Spi(error.kind())
    }

    pub(crate) fn pin(error: impl digital::Error) -> Self {
        Error::Pin(error.kind())
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Error::Spi(kind) => write!(f, "the SPI device refused a frame: {kind}"),
            Error::Pin(kind) => write!(f, "a pin could not be set: {kind}"),
            Error::ReadBack {
                register,
                written,
                read,
            } => write!(
                f,
                "register {register} reads {read:#06x}, {written:#06x} was written"
            ),
            Error::Memory { register, index } => write!(
                f,
                "word {index} behind register {register:#04x} does not read as it was written"
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

impl core::error::Error for Error {}
