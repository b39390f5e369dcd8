//! References for the core's results: independent implementations of its kernels.
//!
//! [`reference`](mod@reference) has plain ones in f32, equal to the bit, and ones in f64 from the equations. [`verify`]
//! compares the core with both. [`golden`] writes vectors of every stage for other implementations. [`surface`] has
//! reference detectors of the bone surface.

pub mod golden;
pub mod reference;
pub mod surface;
pub mod verify;

pub use bonebeam_files::{Error, Result};
