//! The command line of the program.

mod golden;
mod paper;
mod tune;
mod verify;

use std::num::NonZeroUsize;
use std::process::ExitCode;

use crate::page::print::register_font;
use bonebeam_oracle::verify::REFERENCES;
use clap::{Parser, Subcommand};
use host_sim::commands::main_job;
use host_sim::provenance::PROGRAM;
use host_sim::{run_as, start};

/// The paper's experiments, the search for parameters, and the core beside its references.
///
/// `host-sim` runs this program for the commands below. Without a command it runs the main job, and compares its results
/// with the references.
#[derive(Debug, Parser)]
#[command(name = "host-sim", version = PROGRAM, arg_required_else_help = false)]
struct Cli {
    /// Number of threads; results do not depend on it [default: all processors]
    #[arg(long, global = true, value_name = "N")]
    threads: Option<NonZeroUsize>,

    #[command(flatten)]
    main_job: main_job::Arguments,

    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    Paper(paper::Arguments),
    Tune(tune::Arguments),
    Verify(verify::Arguments),
    Golden(golden::Arguments),
}

/// Runs the program on the process's arguments.
pub fn run() -> ExitCode {
    run_as(|cli: Cli| {
        if cli.command.is_some() {
            cli.main_job.refuse()?;
        }
        start(cli.threads)?;
        register_font()?;
        match cli.command {
            None => main_job::run(&cli.main_job, Some(&REFERENCES)),
            Some(Command::Paper(arguments)) => paper::run(&arguments),
            Some(Command::Tune(arguments)) => tune::run(&arguments),
            Some(Command::Verify(arguments)) => verify::run(arguments),
            Some(Command::Golden(arguments)) => golden::run(&arguments),
        }
    })
}
