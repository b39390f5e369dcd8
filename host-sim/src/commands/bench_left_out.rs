//! `host-sim bench` in a build without the feature `bench`: how to get it.

use std::ffi::OsString;

use clap::Args;

use crate::{Error, Result};

/// Measure the core's speed; needs a build with the feature `bench`.
///
/// The benchmark compares the core with other libraries, which take as long to compile as all the
/// rest. So they are left out of an ordinary build: cargo run --release --features bench -- bench
#[derive(Debug, Args)]
#[command(disable_help_flag = true)]
pub struct Arguments {
    /// What the benchmark would be asked
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    _all: Vec<OsString>,
}

/// Tells how to build the benchmark.
///
/// # Errors
/// Always [`Error::Usage`].
pub fn run(_: &Arguments) -> Result<()> {
    Err(Error::Usage(
        "bench is not in this build; run cargo run --release --features bench -- bench".to_owned(),
    ))
}
