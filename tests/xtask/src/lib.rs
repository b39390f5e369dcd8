//! The checks of the repository, as a table of steps: what `tests/run` runs.

mod c;
mod counts;
mod documents;
mod firmware;
mod here;
mod packages;
mod python;
mod rust;
mod steps;
mod targets;
mod tools;

pub use documents::evidence;
pub use here::{Here, with_table};
pub use steps::{Group, STEPS, Step};
