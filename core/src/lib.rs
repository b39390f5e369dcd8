//! **bonebeam**: from ultrasound channel data to bone surfaces, in fixed memory.
//!
//! The flow: [`focus`] (recorded data → aligned analytic samples) → [`beamform`] (one line, by way
//! of [`covariance`], its factorisation and eigenvectors) → [`image`] (decibels, isotropic pixels) →
//! [`phase_symmetry`] (the ridge filter).
//!
//! Kernels are written over [`simd`] vectors, one independent output a lane. Every kernel is `no_std`,
//! allocates nothing, never panics and returns the same bits on every target: `+ − × ÷ √` in a fixed
//! order, `libm` by path for everything else.
//!
//! That they never panic, the linker shows of all but the filters of [`phase_symmetry`], for one lane,
//! optimised: no call of a panic is left. Those filters, and vectors of several lanes, are tested.
//! An overflow that the debug profile would tell of is tested, too.

#![no_std]

#[cfg(test)]
extern crate std;

/// How far apart the cases are that a test tries: 1, or `sparse` under Miri, which takes thousands of times as
/// long for each.
#[cfg(test)]
const fn step(sparse: usize) -> usize {
    if cfg!(miri) { sparse } else { 1 }
}

pub mod beamform;
pub mod covariance;
pub mod delay;
mod error;
#[cfg(feature = "defmt")]
mod formats;
pub mod geometry;
pub mod image;
mod instructions;
mod linalg;
mod magnitude;
pub mod phase_symmetry;
pub mod pipeline;
pub mod simd;

pub use error::Error;
pub use num_complex::Complex;

/// The code of the package's README must run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
