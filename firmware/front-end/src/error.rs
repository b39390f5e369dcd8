//! Errors of the parts.

use embedded_hal::{digital, spi};

/// Reason why the configuration of a part failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Error {
    /// The SPI device refused a frame.
    #[error("the SPI device refused a frame: {0}")]
    Spi(spi::ErrorKind),
    /// A pin could not be set.
    #[error("a pin could not be set: {0}")]
    Pin(digital::ErrorKind),
    /// A register does not hold the value that was written.
    ///
    /// Causes: a broken line, another part, a part without power or in reset.
    #[error("register {register} reads {read:#06x}, {written:#06x} was written")]
    ReadBack {
        /// The register.
        register: u16,
        /// The value that was written.
        written: u32,
        /// The value that was read.
        read: u32,
    },
    /// A word of the demodulator's memories does not hold the value that was written.
    #[error("word {index} behind register {register:#04x} does not read as it was written")]
    Memory {
        /// The register of the memory.
        register: u8,
        /// The word.
        index: u8,
    },
    /// The part has no demodulator.
    #[error("the part has no demodulator")]
    NoDemodulator,
    /// A number is beyond the part's range.
    #[error("{name} is {value}, expected {expected}")]
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
