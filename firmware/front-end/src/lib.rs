//! Drivers of an ultrasound front end: receivers and pulsers.
//!
//! Receivers amplify, digitise and demodulate echoes.
//!
//! | | trait | parts |
//! |---|---|---|
//! | receivers | [`Receiver`] | [`Afe`] (TI's AFE5808A and AFE5809), [`Afe58jd18`], [`ad9276::Ad9276`], two of a kind as a [`Pair`] |
//! | lanes of a receiver | [`Deserialiser`], the FPGA's end | [`align`] finds bits and words |
//! | gain over depth | [`Vcat`], a converter | [`GainCurve`] makes its codes |
//! | pulsers | [`Pulser`], behind the limits of [`Limited`] | [`tx7332::Tx7332`] |
//!
//! [`Firing`] computes a transmit's delays. [`mock`] simulates all parts without hardware.
//!
//! The drivers are async, over `embedded-hal-async`. [`Blocking`] and [`block`] run them over `embedded-hal`.
//!
//! No part was available. [`registers`], [`ad9276`] and [`tx7332`] list the facts that public sources confirm, and
//! the facts that the integrator must first check against the data sheet.

#![no_std]

#[cfg(test)]
extern crate std;

pub mod ad9276;
mod afe;
mod afe58jd18;
mod alignment;
mod blocking;
mod demodulator;
mod error;
mod firing;
mod frames;
pub mod mock;
mod pair;
mod pulser;
mod receiver;
pub mod registers;
mod settings;
mod tgc;
pub mod tx7332;

pub use afe::{Afe, NoPin};
pub use afe58jd18::Afe58jd18;
pub use alignment::{AlignError, Deserialiser, Lane, align};
pub use blocking::{Blocking, block};
pub use demodulator::{Demodulator, frequency_word};
pub use error::Error;
pub use firing::{Firing, OutOfRange};
pub use pair::{Pair, PairError};
pub use pulser::{
    Checked, Limit, LimitError, Limited, LimitedError, Limits, Profile, Pulser, Waveform,
};
pub use receiver::{Attenuator, Power, Receiver, TestPattern};
pub use settings::{Gain, Jd18LowPass, LnaGain, LowPass, PgaGain, Settings, Termination};
pub use tgc::{GainCurve, Vcat, VcatRange};
