//! The tests of the program `bonebeam-paper`, linked into one program.

mod golden;
#[cfg(unix)]
mod inputs;
mod killed;
#[path = "../../host-sim/tests/common/pages.rs"]
mod pages;
mod paper;
mod registration;
mod tune;
