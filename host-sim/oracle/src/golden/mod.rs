//! Golden vectors for other implementations of the core.
//!
//! They are inputs, every intermediate value and outputs of a small scene, as `.npy` and as words for Verilog's
//! `$readmemh`. The scene (`scene`) and all values computed from it ([`stages`]) have the same bits on every machine. Each
//! stage is also given as integers, with their errors (`fixed_point`).

mod adaptive;
mod chain;
mod check;
mod files;
mod fixed_point;
mod integer;
mod scene;
mod solver;
mod stages;

pub use chain::write_lines;
pub use check::{Verdict, check};
pub use files::{Entry, Manifest, write};
pub use stages::{Stage, Values, stages};
