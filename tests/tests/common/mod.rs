//! What the test files share.

pub mod frames;
pub mod lines;
pub mod tolerances;
