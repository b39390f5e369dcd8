//! Runs the core's stages over whole frames, on all threads and the widest vectors.

pub mod beamform;
mod beams;
pub mod check;
pub mod coherence;
pub mod config;
pub mod delay;
pub mod frame;
pub mod image;
mod lens;
mod limits;
pub mod methods;
pub mod phase_symmetry;
pub mod pipeline;
pub mod policy;
mod records;
mod short_lag;
mod sub_lines;
pub mod surface;
pub mod threads;

pub use bonebeam_files::{Error, Result};
pub use bonebeam_kernels::source;
