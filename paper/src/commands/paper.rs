//! `host-sim paper`: the paper's figures, tables and claims.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::experiments::all::PAPER;
use crate::experiments::{ExperimentFilter, Job, Overrides};
use crate::page;
use crate::{Error, Result};
use bonebeam_files::input::{self, cannot_be_opened};
use bonebeam_files::terminal::print;
use bonebeam_oracle::verify::REFERENCES;
use host_sim::commands::{about, main_job};
use host_sim::progress::Progress;

/// Reproduce the paper: its figures, its tables and its claims.
///
/// All data are simulated, so that the truth is known. Only the clutter of the claims, and the clutter and noise of
/// the water bath, are fitted or chosen by results of the paper.
///
/// The folder holds report.html, one file that can be sent; report.json with every number and the configuration
/// with its seeds; a CSV of every table and one of every number; and the pictures as PNG.
///
/// To judge more bones, start several runs with --claims and different seeds, then one with --merge and the
/// report.json of each.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    filter: ExperimentFilter,

    /// A coarse run of some three minutes on two processors
    #[arg(long)]
    quick: bool,

    /// First seed of noise, tissue and clutter, and number of the claims' first bone [default: the configuration's]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,

    /// Only the claims' scenes whose name contains this word; repeatable
    ///
    /// Words: water, tissue, quiet, disturbed, aberration-20-ns, aberration-35-ns, speed-low, speed-high.
    #[arg(long, value_name = "WORD", value_delimiter = ',')]
    only: Vec<String>,

    /// Folder for the report, pictures, tables and configuration [default: out/paper]
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,

    /// Folder for recordings and long results, for later runs with the same parameters
    ///
    /// Without this flag, .kept in the output folder holds them until the run is done; an interrupted run resumes from it.
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,

    /// report.json of another run, to judge its scenes together with this run's; repeatable
    #[arg(long, value_name = "FILE.json")]
    merge: Vec<PathBuf>,

    /// Closed surface of the bone, in mm, +x towards the front and +z towards the head
    ///
    /// It is the bone of Fig. 3 and of the water bath. Every bone of the claims is a pose of it.
    #[arg(long, value_name = "FILE.ply")]
    mesh: Option<PathBuf>,

    /// Rewrite this document's tables, between the comments of each experiment
    ///
    /// The comments are `<!-- NAME -->` and `<!-- end of NAME -->`.
    #[arg(long, value_name = "FILE.md")]
    docs: Option<PathBuf>,

    /// TOML file with parameters, such as the one in the folder of an earlier run
    #[arg(long, value_name = "FILE.toml", conflicts_with = "quick")]
    config: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  host-sim paper
  host-sim paper --quick --threads 1 -o look
  host-sim paper --figure 2 --figure 3
  host-sim paper --experiment dynamic_range
  host-sim paper --claims --seed 13 --only tissue -o more
  host-sim paper --claims --merge more/report.json --merge others/report.json -o all
  host-sim paper --keep recordings --config out/paper/config.toml
  host-sim paper --experiment surface --keep recordings --docs docs/reproduction.md";

/// Runs the command.
///
/// # Errors
/// A figure that does not exist, a parameter out of range, or a folder that cannot be written.
pub fn run(arguments: &Arguments) -> Result<()> {
    let mut job = match &arguments.config {
        Some(path) => Job::read(PAPER, path)?,
        None if arguments.quick => Job::quick(PAPER),
        None => Job::full(PAPER),
    };
    job.select(&arguments.filter, PAPER)?;
    let flags = [
        ("--mesh", arguments.mesh.is_some()),
        ("--only", !arguments.only.is_empty()),
        ("--keep", arguments.keep.is_some()),
        ("--merge", !arguments.merge.is_empty()),
    ];
    job.check_flags(PAPER, &flags)?;
    job.apply(&Overrides {
        mesh: arguments.mesh.clone(),
        slice: None,
        seed: arguments.seed,
        only: arguments.only.clone(),
    });
    for path in &arguments.merge {
        let report = read_report(path)?;
        job.merge(report).map_err(|e| about(path, e))?;
    }
    job.validate()?;
    if arguments.quick {
        print(&format!("Coarse: {}.\n", page::COARSE))?;
    }
    job.compare_with(Some(&REFERENCES));
    let folder = arguments
        .output
        .as_deref()
        .unwrap_or(Path::new("out/paper"));
    let until_done = folder.join(KEPT);
    job.keep_in(arguments.keep.as_deref().unwrap_or(&until_done));
    let bar = Progress::of_steps(1000);
    let docs = arguments.docs.as_deref();
    main_job::run_in(&job, folder, (&page::PAPER, bar), docs)?;
    // The outputs are there. What cannot be removed is overwritten or taken by the next run.
    let _ = fs::remove_dir_all(&until_done);
    Ok(())
}

/// Folder in the outputs for recordings and long results until the run is done.
const KEPT: &str = ".kept";

/// Longest report to read, bytes: a thousand times the usual length.
const MOST: u64 = 100_000_000;

/// Reads another run's report.
fn read_report(path: &Path) -> Result<serde_json::Value> {
    let error = |message: String| Error::File {
        path: path.to_path_buf(),
        message,
    };
    let text = input::read(path, MOST).map_err(|e| error(cannot_be_opened(&e)))?;
    serde_json::from_slice(&text)
        .map_err(|e| error(format!("is not the report.json of a run: {e}")))
}
