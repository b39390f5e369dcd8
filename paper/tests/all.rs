//! The tests of the program `bonebeam-paper`, linked into one program.

#[cfg(unix)]
mod inputs;
mod paper;
mod registration;
#[path = "../../host-sim/tests/common/runs.rs"]
mod runs;
mod tune;
