//! The tests of the program `bonebeam-paper`, linked into one program.

mod golden;
#[cfg(unix)]
mod inputs;
mod killed;
#[path = "../../host-sim/tests/common/pages.rs"]
mod pages;
mod paper;
mod registration;
#[path = "../../host-sim/tests/common/runs.rs"]
mod runs;
mod tune;

const PROGRAM: &str = env!("CARGO_BIN_EXE_bonebeam-paper");
