//! `host-sim verify`: checks every kernel of the core against its references.

use clap::Args;

use crate::{Error, Result};
use bonebeam_files::terminal::print;
use bonebeam_oracle::verify::kernels::verify;
use host_sim::progress::Progress;

/// Check the core bit for bit on this machine.
///
/// Every kernel runs on a small synthetic recording. The result is compared with the f32 reference (equal bits),
/// with the f64 reference (within the bounds of docs/numerics.md), and with the kernel itself on one lane, on 1 and
/// 7 threads, and in strips of several heights.
///
/// Each check is one line: ok or WRONG, the hash of the result's bits, the name, and the comparison. The hashes are
/// the same on every machine. The exit status is 0 only if all checks hold.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {}

const EXAMPLES: &str = "\
Examples:
  host-sim verify
  host-sim verify > here.txt     # to compare with another machine";

/// Runs the command.
///
/// # Errors
/// [`Error::Data`] if a check does not hold.
pub fn run(_: Arguments) -> Result<()> {
    let bar = Progress::new("verifying", 0);
    let verdicts = verify(|done| bar.set(done as u64, done as u64))?;
    bar.clear();
    for verdict in &verdicts {
        let word = if verdict.holds { "ok   " } else { "WRONG" };
        let hash = verdict.hash.map(|hash| format!("{hash:016x}"));
        let hash = hash.unwrap_or_default();
        print(&format!(
            "{word} {hash:16} {}: {}\n",
            verdict.name, verdict.detail
        ))?;
    }
    let wrong = verdicts.iter().filter(|verdict| !verdict.holds).count();
    print(&format!(
        "{} checks hold, {wrong} do not\n",
        verdicts.len() - wrong
    ))?;
    match wrong {
        0 => Ok(()),
        _ => Err(Error::Data(format!("{wrong} checks do not hold"))),
    }
}
