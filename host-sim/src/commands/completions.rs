//! `host-sim completions`: shell completions of the command line.

use clap::{Args, Command};
use clap_complete::{Shell, generate};

use crate::{Error, Result};
use bonebeam_files::terminal::print;

/// Print the completions for a shell.
///
/// Save them where the shell looks for them, or in bash: source <(host-sim completions bash).
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

const EXAMPLES: &str = "\
Examples:
  host-sim completions bash > ~/.local/share/bash-completion/completions/host-sim
  host-sim completions fish > ~/.config/fish/completions/host-sim.fish";

/// Runs the command.
///
/// # Errors
/// The standard output cannot be written.
pub fn run(arguments: &Arguments, mut command: Command) -> Result<()> {
    let mut text = Vec::new();
    let name = command.get_name().to_owned();
    generate(arguments.shell, &mut command, name, &mut text);
    let text = String::from_utf8(text)
        .map_err(|e| Error::Data(format!("the completions are not text: {e}")))?;
    print(&text)
}
