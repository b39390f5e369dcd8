//! What the core's results are compared with: the same kernels written a second time.
//!
//! [`reference`](mod@reference) has them plainly in f32, to the bit, and in f64 from the equations. [`verify`] compares the
//! core with both. [`golden`] writes vectors of every stage for other implementations. [`surface`] has the yardsticks of
//! the bone surface.

pub mod golden;
pub mod reference;
pub mod surface;
pub mod verify;

pub use bonebeam_files::{Error, Result};
