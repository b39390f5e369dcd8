//! The command line of the program.

mod paper;
mod tune;

use std::num::NonZeroUsize;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use host_sim::provenance::PROGRAM;
use host_sim::{run_as, start};

/// The paper's experiments, and the search for parameters.
///
/// `host-sim paper` and `host-sim tune` run this program.
#[derive(Debug, Parser)]
#[command(name = "host-sim", version = PROGRAM)]
struct Cli {
    /// Number of threads; results do not depend on it [default: all processors]
    #[arg(long, global = true, value_name = "N")]
    threads: Option<NonZeroUsize>,

    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Paper(paper::Arguments),
    Tune(tune::Arguments),
}

/// Runs the program on the process's arguments.
pub fn run() -> ExitCode {
    run_as(|cli: Cli| {
        start(cli.threads)?;
        match cli.command {
            Command::Paper(arguments) => paper::run(&arguments),
            Command::Tune(arguments) => tune::run(&arguments),
        }
    })
}
