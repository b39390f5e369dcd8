//! Golden vectors for other implementations of the core: inputs, every intermediate and outputs of a small
//! scene, as `.npy` and as words for Verilog's `$readmemh`.
//!
//! The scene has the same bits on every machine (`scene`), and so has all that follows from it
//! ([`stages`]). Each stage is also given as integers, with what that costs (`fixed_point`).

mod check;
mod files;
mod fixed_point;
mod integer;
mod scene;
mod stages;

pub use check::{Verdict, check};
pub use files::{Entry, Manifest, write};
pub use stages::{Stage, Values, stages};
