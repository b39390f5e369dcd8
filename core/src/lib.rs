//! **bonebeam**: from ultrasound channel data to bone surfaces, in fixed memory.
//!
//! An application uses the names at the crate's root: [`Parameters`] describe a scan, its beamformer and its image; a
//! [`Pipeline`] is the plan that follows from them; a [`Frame`] is a plan at work in a [`Memory`], on one [`Record`] a
//! transmit. The [`prelude`] has these names and the types of their fields. The modules are for toolmakers: each stage
//! by itself, memory of sizes known at run time, vectors of several lanes.
//!
//! The flow: [`delay`] (recorded data → aligned analytic samples) → [`beamform`] (one line, by way
//! of [`covariance`], its factorisation and eigenvectors) → [`image`] (decibels, isotropic pixels) →
//! [`phase_symmetry`] (the ridge filter) and [`surface`] (a depth of the bone, or none, in each line).
//!
//! Kernels are written over [`simd`] vectors, one independent output a lane. Every kernel is `no_std`,
//! allocates nothing, never panics and returns the same bits on every target: `+ − × ÷ √` in a fixed
//! order, `libm` by path for everything else.
//!
//! That they never panic, the linker shows for one lane, optimised: no call of a panic is left. Vectors of
//! several lanes are tested.
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
mod complex_vector;
pub mod covariance;
pub mod delay;
mod error;
#[cfg(feature = "defmt")]
mod formats;
pub mod geometry;
pub mod image;
mod instructions;
mod kaiser;
mod linalg;
mod magnitude;
pub mod memory;
pub mod phase_symmetry;
pub mod pipeline;
mod self_test;
pub mod simd;
mod sine;
pub mod surface;

pub use delay::Record;
pub use error::Error;
pub use memory::Memory;
pub use num_complex::Complex;
pub use pipeline::{Frame, Parameters, Pipeline};
pub use self_test::self_test;

/// All names that an application needs, from channel data to bone maps.
///
/// `use bonebeam::prelude::*;`
pub mod prelude {
    pub use crate::beamform::{self, Method};
    pub use crate::covariance::Covariance;
    pub use crate::delay::{IqInterpolation, IqLayout, IqRecord, IqSamples};
    pub use crate::geometry::{Array, Axis, Depth, Lines, ScanParameters, Transmit, TransmitLaw};
    pub use crate::memory::{Need, Scratch};
    pub use crate::pipeline::{DepthGate, IqInput};
    pub use crate::{Complex, Error, Frame, Memory, Parameters, Pipeline, Record};
}

/// The code of the package's README must run.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
