//! `host-sim bench` in a build without the feature `bench`: how to get it.

use std::ffi::OsString;

use clap::Args;

use crate::{Error, Result};

/// Measure the core's speed; needs a build with the feature `bench`.
///
/// The benchmark compares the core with other libraries, which take as long to compile as everything else. An
/// ordinary build leaves them out. To run it: cargo run --release --features bench -- bench
#[derive(Debug, Args)]
#[command(disable_help_flag = true)]
pub struct Arguments {
    /// Arguments of the benchmark
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    _all: Vec<OsString>,
}

/// Refuses to run, with the command that builds the benchmark.
///
/// # Errors
/// Always [`Error::Usage`].
pub fn run(_: &Arguments) -> Result<()> {
    Err(Error::Usage(
        "bench is not in this build; run cargo run --release --features bench -- bench".to_owned(),
    ))
}
