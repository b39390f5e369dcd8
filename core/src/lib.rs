//! **bonebeam**: from ultrasound channel data to bone surfaces, in fixed memory.
//!
//! The flow is the order of the modules: [`channel`] (recorded data → delayed analytic samples) →
//! [`covariance`] → [`linalg`] (factorisation, eigenvectors) → [`beamform`] (weights, one line) →
//! [`image`] (decibels, isotropic pixels) → [`phase_symmetry`] (the ridge filter).
//!
//! Every kernel is `no_std`, allocates nothing, never panics and returns the same bits on every
//! target: `+ − × ÷ √` in a fixed order, `libm` by path for everything else.

#![no_std]

pub mod beamform;
pub mod channel;
pub mod covariance;
mod error;
pub mod image;
pub mod lanes;
pub mod linalg;
pub mod phase_symmetry;

pub use error::Error;
pub use num_complex::Complex;

/// The README's code must compile.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
