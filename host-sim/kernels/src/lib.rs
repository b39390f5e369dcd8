//! The core's kernels as machine code.
//!
//! Their functions are generic over vectors and input. Here each is compiled for every instruction set and
//! chosen at run time, so that `bonebeam-drive` contains logic alone and compiles quickly.

mod compound;
pub mod image;
pub mod memory;
pub mod phase_symmetry;
pub mod source;

pub use bonebeam_files::{Error, Result};
pub use compound::Compounded;
