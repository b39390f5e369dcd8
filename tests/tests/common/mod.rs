//! Shared code of the test files.

pub mod delays;
pub mod frames;
pub mod lines;
pub mod refused;
pub mod tolerances;

/// What most of the tests use.
pub mod kit {
    pub use super::lines::{
        COVARIANCES, Gaussian, Line, METHODS, core_weights, stacked, variants, widen,
    };
    pub use super::refused::{assert_refused, name, refused};
    pub use super::{assert_same_bits, changed, tolerances};
    pub use bonebeam::prelude::stages::*;
    pub use bonebeam_drive::config::Beamform;
    pub use bonebeam_drive::delay::DelayStage;
    pub use bonebeam_drive::methods::MethodName;
    pub use bonebeam_files::{BeamformedLines, ChannelData, Transmits};
    pub use bonebeam_oracle::reference;
    pub use bonebeam_oracle::reference::f64::beamform::Sample;
    pub use bonebeam_tests::kernel::bits;
    pub use ndarray::{Array2, Array3};
    pub use rand::rngs::ChaCha8Rng;
    pub use rand::{RngExt, SeedableRng};
    pub use std::f64::consts::{PI, TAU};
    pub use std::fs;
    pub use std::path::{Path, PathBuf};
}

use bonebeam::Complex;

/// Asserts equal bits, so that 0 and −0 differ.
pub fn assert_same_bits(left: &[Complex<f32>], right: &[Complex<f32>], what: &str) {
    let [left, right] = [left, right].map(bonebeam_tests::kernel::bits);
    let at = left.iter().zip(&right).position(|(a, b)| a != b);
    assert!(
        at.is_none() && left.len() == right.len(),
        "{what}: other bits at {at:?}"
    );
}

/// A value with something changed.
pub fn changed<T>(mut value: T, change: impl FnOnce(&mut T)) -> T {
    change(&mut value);
    value
}
