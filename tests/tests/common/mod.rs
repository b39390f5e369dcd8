//! Shared code of the test files.

pub mod frames;
pub mod lines;
pub mod refused;
pub mod tolerances;
