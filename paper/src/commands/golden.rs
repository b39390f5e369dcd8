//! `host-sim golden`: vectors for other implementations of the core.

use std::path::PathBuf;

use clap::Args;

use crate::{Error, Result};
use bonebeam_files::terminal::print;
use bonebeam_oracle::golden::{check, stages, write, write_lines};

/// Write golden vectors, or compare those of another implementation with them.
///
/// The vectors are the input, every intermediate result and the outputs of a small scene: as .npy, and as words for
/// Verilog's $readmemh, floats and 16-bit integers. manifest.json has shapes, formats, hashes and the error of the
/// integers. The files are the same on every machine.
///
/// --check compares every file of DIR with the golden one and prints one line per file, with the first word that
/// differs and the largest error. The exit status is then 0 only if all files are equal bit for bit.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Folder to write; it is created
    #[arg(short, long, value_name = "DIR", required_unless_present_any = ["check", "chain"])]
    output: Option<PathBuf>,

    /// Folder to compare with the golden vectors
    #[arg(long, value_name = "DIR", conflicts_with = "output")]
    check: Option<PathBuf>,

    /// Folder that gets the chain.out.hex of its chain.in.hex and chain.lines.hex
    #[arg(long, value_name = "DIR", conflicts_with_all = ["output", "check"])]
    chain: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  host-sim golden -o vectors
  host-sim golden --check mine        # some or all of the files, with the same names";

/// Runs the command.
///
/// # Errors
/// The folder cannot be written or holds no vectors, or [`Error::Data`] if a file differs.
pub fn run(arguments: &Arguments) -> Result<()> {
    if let Some(folder) = &arguments.output {
        let manifest = write(folder, &stages()?)?;
        for entry in &manifest.stages {
            print(&format!(
                "{} {:34} {:?}, 16-bit words to {:.1e}\n",
                entry.hash, entry.name, entry.shape, entry.largest_error
            ))?;
        }
        return Ok(());
    }
    if let Some(folder) = &arguments.chain {
        return write_lines(folder);
    }
    let Some(folder) = &arguments.check else {
        return Ok(());
    };
    let verdicts = check(folder)?;
    for verdict in &verdicts {
        let word = if verdict.same { "same   " } else { "DIFFERS" };
        print(&format!("{word} {}: {}\n", verdict.file, verdict.detail))?;
    }
    match verdicts.iter().filter(|verdict| !verdict.same).count() {
        0 => Ok(()),
        differing => Err(Error::Data(format!(
            "{differing} of {} files differ from the golden vectors",
            verdicts.len()
        ))),
    }
}
