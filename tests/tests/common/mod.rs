//! What the test files share.

pub mod lines;
pub mod tolerances;
