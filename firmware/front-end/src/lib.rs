//! What stands between transducer and processor: the front end that amplifies, digitises and
//! demodulates echoes, and the pulser that sends.
//!
//! [`Afe`] drives TI's AFE5808A and AFE5809 over an embedded-hal SPI device and a reset pin.
//! [`Pulser`] is what a transmit board must be able to do, [`MockPulser`] one without hardware, and
//! [`Firing`] works out the delays for it.
//!
//! No part was at hand. What the code knows of the AFE is marked, register by register, in
//! [`registers`]: what public sources confirm, and what the integrator has to check against the data
//! sheet first.

#![no_std]

#[cfg(test)]
extern crate std;

mod afe;
mod demodulator;
mod error;
mod firing;
mod pulser;
pub mod registers;
mod settings;

pub use afe::Afe;
pub use demodulator::{Demodulator, frequency_word};
pub use error::Error;
pub use firing::{Firing, OutOfRange};
pub use pulser::{MockPulser, MockPulserError, Pulser};
pub use settings::{Gain, LnaGain, LowPass, Part, PgaGain, Settings, TestPattern};
