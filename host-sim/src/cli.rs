//! The command line: arguments, dispatch and exit status.

use std::ffi::OsString;
use std::fs;
use std::num::NonZeroUsize;
use std::panic::resume_unwind;
use std::process::ExitCode;
use std::thread;

use clap::{CommandFactory, Parser, Subcommand};

use crate::arguments;
#[cfg(feature = "bench")]
use crate::commands::bench;
#[cfg(not(feature = "bench"))]
use crate::commands::bench_left_out as bench;
use crate::commands::{
    beamform, check, completions, convert, elsewhere, info, main_job, phase_symmetry, register,
    serve, simulate, surface, sweep, view,
};
use crate::provenance::PROGRAM;
use crate::{Error, Result};
use bonebeam_drive::threads;
use bonebeam_files::terminal::{complain, print};

/// Simulates and beamforms ultrasound channel data and finds bone surfaces in them.
///
/// Without a command it runs the main job: it simulates a point and a vertebra, beamforms both, makes and measures
/// the images, and writes a report. With --references it also checks the core against its references.
///
/// Lengths are in metres, times in seconds, frequencies in hertz. An error is one line. The exit status is 2 if the
/// command line or the configuration is wrong, and 1 for wrong data.
#[derive(Debug, Parser)]
#[command(name = "host-sim", version = PROGRAM, after_help = EXAMPLES, arg_required_else_help = false)]
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
    Simulate(Box<simulate::Arguments>),
    Beamform(Box<beamform::Arguments>),
    PhaseSymmetry(phase_symmetry::Arguments),
    Surface(Box<surface::Arguments>),
    Sweep(Box<sweep::Arguments>),
    Register(Box<register::Arguments>),
    Serve(Box<serve::Arguments>),
    /// Tune beamformer, image and bone-surface detector together, on simulated bones
    Tune(elsewhere::Arguments),
    Info(Box<info::Arguments>),
    Check(check::Arguments),
    Convert(convert::Arguments),
    View(view::Arguments),
    /// Check the core bit for bit on this machine
    Verify(elsewhere::Arguments),
    /// Write golden vectors, or compare those of another implementation with them
    Golden(elsewhere::Arguments),
    /// Reproduce the paper: its figures, its tables and its claims
    Paper(elsewhere::Arguments),
    Completions(completions::Arguments),
    Bench(bench::Arguments),
}

const EXAMPLES: &str = "\
Examples:
  host-sim --quick
  host-sim --out report
  host-sim --mesh vertebra.ply --slice -0.002 --out mesh
  host-sim verify
  host-sim golden -o vectors
  host-sim paper --figure 2
  host-sim bench --quick
  host-sim simulate vertebra -o channels.npz
  host-sim beamform channels.npz --method esmv-rank1 -o lines.npz --image lines.png
  host-sim phase-symmetry lines.png --pad --scales 2^-7,2^-8,2^-9 --threshold 15 -o ps.npy \\
      --image ps.png
  host-sim surface channels.npz -o surface.csv --image surface.png
  host-sim surface scan.png --pixel-size 0.0001 -o surface.csv --image surface.png
  host-sim sweep sweep.igs.mha --calibration PlusConfiguration.xml -o bone.ply --image views.png
  host-sim register bone.ply ct.stl -o registered.ply --image residuals.png
  host-sim serve --calibration PlusConfiguration.xml
  host-sim tune -o tuned
  host-sim info recording.hdf5
  host-sim check recording.hdf5
  host-sim convert recording.uff -o recording.npz
  host-sim view recording.hdf5 -o page.html
  host-sim beamform --help";

/// Runs the program on the process's arguments.
pub fn run() -> ExitCode {
    run_as(dispatch)
}

/// Runs the program within another process; returns its exit status.
///
/// The first argument is the program's name.
pub fn run_within(own: Vec<OsString>) -> u8 {
    arguments::set(own);
    status_of(dispatch)
}

/// Bytes of stack that are enough for every command.
const STACK: usize = 1 << 20;

/// Whether the process has less stack, as far as the system tells.
fn has_little_stack() -> bool {
    let limits = fs::read_to_string("/proc/self/limits").unwrap_or_default();
    let stack = limits
        .lines()
        .find_map(|line| line.strip_prefix("Max stack size"));
    let bytes = stack.and_then(|limits| limits.split_whitespace().next()?.parse().ok());
    bytes.is_some_and(|bytes: usize| bytes < STACK)
}

/// Runs `work` on the parsed arguments of the process; an error is one line.
pub fn run_as<C: Parser>(work: impl FnOnce(C) -> Result<()> + Send) -> ExitCode {
    ExitCode::from(status_of(work))
}

fn status_of<C: Parser>(work: impl FnOnce(C) -> Result<()> + Send) -> u8 {
    if !has_little_stack() {
        return parse_and_run(work);
    }
    thread::scope(|scope| {
        let main = thread::Builder::new().stack_size(STACK);
        match main.spawn_scoped(scope, || parse_and_run(work)) {
            Ok(main) => main.join().unwrap_or_else(|panic| resume_unwind(panic)),
            Err(e) => finish(Err(Error::Data(format!("cannot start a thread: {e}")))),
        }
    })
}

fn parse_and_run<C: Parser>(work: impl FnOnce(C) -> Result<()>) -> u8 {
    let cli = match C::try_parse_from(arguments::all()) {
        Ok(cli) => cli,
        Err(e) if !e.use_stderr() => {
            // Help and version are not errors.
            return finish(print(&e.render().to_string()));
        }
        Err(e) => return finish(Err(Error::Usage(one_line(&e)))),
    };
    finish(work(cli))
}

/// Handles signals and starts the threads.
///
/// # Errors
/// As [`threads::start`].
pub fn start(count: Option<NonZeroUsize>) -> Result<()> {
    #[cfg(unix)]
    bonebeam_files::signals::handle()?;
    threads::start(count)
}

fn dispatch(cli: Cli) -> Result<()> {
    if cli.command.is_some() {
        cli.main_job.refuse()?;
    }
    let elsewhere = match &cli.command {
        None => cli.main_job.references.then_some("--references"),
        Some(Command::Tune(_)) => Some("tune"),
        Some(Command::Paper(_)) => Some("paper"),
        Some(Command::Verify(_)) => Some("verify"),
        Some(Command::Golden(_)) => Some("golden"),
        _ => None,
    };
    if let Some(what) = elsewhere {
        return elsewhere::run(what);
    }
    start(cli.threads)?;
    match cli.command {
        None => main_job::run(&cli.main_job, None),
        Some(Command::Beamform(arguments)) => beamform::run(*arguments),
        Some(Command::PhaseSymmetry(arguments)) => phase_symmetry::run(arguments),
        Some(Command::Surface(arguments)) => surface::run(*arguments),
        Some(Command::Sweep(arguments)) => sweep::run(*arguments),
        Some(Command::Register(arguments)) => register::run(&arguments),
        Some(Command::Serve(arguments)) => serve::run(*arguments),
        Some(Command::Tune(_) | Command::Paper(_) | Command::Verify(_) | Command::Golden(_)) => {
            Ok(())
        }
        Some(Command::Simulate(arguments)) => simulate::run(*arguments),
        Some(Command::Info(arguments)) => info::run(*arguments),
        Some(Command::Check(arguments)) => check::run(&arguments),
        Some(Command::Convert(arguments)) => convert::run(arguments),
        Some(Command::View(arguments)) => view::run(&arguments),
        Some(Command::Completions(arguments)) => completions::run(&arguments, Cli::command()),
        Some(Command::Bench(arguments)) => bench::run(&arguments),
    }
}

fn finish(outcome: Result<()>) -> u8 {
    match outcome {
        Ok(()) => 0,
        Err(error) => {
            complain(&error);
            error.exit_status()
        }
    }
}

/// The message of a command-line error, without the usage text after it.
fn one_line(error: &clap::Error) -> String {
    let text = error.render().to_string();
    let lines = text.lines().map(str::trim);
    let reported = lines.take_while(|l| !l.starts_with("Usage:") && !l.starts_with("For more"));
    let words: Vec<&str> = reported.filter(|l| !l.is_empty()).collect();
    let message = words.join(" ");
    message
        .strip_prefix("error: ")
        .unwrap_or(&message)
        .to_owned()
}
