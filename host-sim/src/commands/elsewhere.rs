//! Commands of `bonebeam-paper`, which has experiments and references.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Args;

use crate::arguments;
use crate::{Error, Result};

/// The program, beside this one or in a folder of `PATH`.
const PROGRAM: &str = "bonebeam-paper";

/// Arguments, which the program reads.
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

/// Runs the program with the arguments of this one, in its place.
///
/// # Errors
/// [`Error::Usage`] if it is not there, with `what` needs it.
pub fn run(what: &str) -> Result<()> {
    let name = format!("{PROGRAM}{}", env::consts::EXE_SUFFIX);
    let mut program = Command::new(found(&name).ok_or_else(|| missing(what))?);
    program.args(arguments::all().into_iter().skip(1));
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

/// A file beside this program, or in a folder of `PATH`.
pub(super) fn found(name: &str) -> Option<PathBuf> {
    let own = env::current_exe().ok();
    let own = own.as_deref().and_then(Path::parent).map(Path::to_owned);
    let path = env::var_os("PATH").unwrap_or_default();
    let folders = own.into_iter().chain(env::split_paths(&path));
    folders
        .map(|folder| folder.join(name))
        .find(|path| path.is_file())
}

fn missing(what: &str) -> Error {
    Error::Usage(format!(
        "{what} is done by {PROGRAM}, which is not here; build it in the folder paper: cargo build --release"
    ))
}
