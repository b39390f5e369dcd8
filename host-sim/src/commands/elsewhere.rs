//! `host-sim paper` and `host-sim tune`: commands of the program `bonebeam-paper`.

use std::env;
use std::ffi::OsString;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Args;

use crate::{Error, Result};

/// The program, beside this one or in a folder of `PATH`.
const PROGRAM: &str = "bonebeam-paper";

/// Arguments, passed on as they are.
#[derive(Debug, Args)]
#[command(disable_help_flag = true)]
pub struct Arguments {
    /// Arguments of the command; `--help` lists them
    #[arg(
        trailing_var_arg = true,
        allow_hyphen_values = true,
        value_name = "ARGUMENTS"
    )]
    rest: Vec<OsString>,
}

/// Runs a command of the program in place of this one.
///
/// # Errors
/// [`Error::Usage`] if the program is not there.
pub fn run(command: &str, threads: Option<NonZeroUsize>, arguments: &Arguments) -> Result<()> {
    let mut program = Command::new(found().ok_or_else(|| missing(command))?);
    program.arg(command).args(&arguments.rest);
    if let Some(threads) = threads {
        program.arg(format!("--threads={threads}"));
    }
    let error = replace(&mut program);
    Err(Error::Data(format!("{PROGRAM} cannot be run: {error}")))
}

/// Ends as the program; returns only if it cannot be run.
#[cfg(unix)]
fn replace(program: &mut Command) -> std::io::Error {
    std::os::unix::process::CommandExt::exec(program)
}

#[cfg(not(unix))]
fn replace(program: &mut Command) -> std::io::Error {
    match program.status() {
        Ok(status) => std::process::exit(status.code().unwrap_or(1)),
        Err(error) => error,
    }
}

fn found() -> Option<PathBuf> {
    let name = format!("{PROGRAM}{}", env::consts::EXE_SUFFIX);
    let own = env::current_exe().ok();
    let own = own.as_deref().and_then(Path::parent).map(Path::to_owned);
    let path = env::var_os("PATH").unwrap_or_default();
    let folders = own.into_iter().chain(env::split_paths(&path));
    folders
        .map(|folder| folder.join(&name))
        .find(|path| path.is_file())
}

fn missing(command: &str) -> Error {
    Error::Usage(format!(
        "{command} is a command of {PROGRAM}, which is not here; build it in the folder paper: cargo build --release"
    ))
}
