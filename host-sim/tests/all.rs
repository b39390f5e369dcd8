//! The tests of the host program, one module a subject, linked into one program.

mod arrays;
#[cfg(feature = "bench")]
mod bench;
mod commands;
mod common;
mod config;
mod crafted;
mod defaults;
#[cfg(unix)]
mod edges;
mod elsewhere;
mod faults;
mod files;
mod frames;
mod golden_vectors;
mod grid;
mod in_place;
mod main_job;
#[cfg(unix)]
mod refused;
mod register;
mod resumed;
mod serve;
mod surface;
mod sweep;
mod view;

const PROGRAM: &str = env!("CARGO_BIN_EXE_host-sim");
