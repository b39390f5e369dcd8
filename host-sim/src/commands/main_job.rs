//! `host-sim` alone: the main job.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use clap::Args;

use super::progress_bar;
use crate::config::read_toml;
use crate::experiments::{self, Parameters};
use crate::files::atomic::{Outputs, check_writable};
use crate::files::leftovers;
use crate::report::{self, Report};
use crate::terminal::print;
use crate::{Error, Result};

/// Arguments of the main job.
#[derive(Debug, Args)]
pub struct Arguments {
    /// A coarser main job in a few seconds
    #[arg(long)]
    quick: bool,

    /// The folder for the main job's report, pictures and configuration [default: out]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// A closed surface in mm, +x towards the front and +z towards the head, in place of the
    /// main job's built-in vertebra
    #[arg(long, value_name = "FILE.ply")]
    mesh: Option<PathBuf>,

    /// Height of the main job's slice through the vertebra, m [default: -0.004]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    slice: Option<f64>,

    /// TOML file with the main job's parameters, such as the one in its folder
    #[arg(long, value_name = "FILE.toml", conflicts_with = "quick")]
    config: Option<PathBuf>,
}

impl Arguments {
    /// The main job's arguments before a command would have no effect, which is a mistake.
    ///
    /// # Errors
    /// One of them was given.
    pub fn refuse(&self) -> Result<()> {
        let given = [
            ("--quick", self.quick),
            ("--out", self.out.is_some()),
            ("--mesh", self.mesh.is_some()),
            ("--slice", self.slice.is_some()),
            ("--config", self.config.is_some()),
        ];
        match given.iter().find(|(_, given)| *given) {
            None => Ok(()),
            Some((flag, _)) => Err(Error::Usage(format!(
                "{flag} before a command belongs to the main job, which runs without a command"
            ))),
        }
    }
}

/// Runs the main job, prints its tables and writes its folder.
///
/// # Errors
/// A parameter out of range, a folder that cannot be written, or a check that fails.
pub fn run(arguments: &Arguments) -> Result<()> {
    let mut parameters = match &arguments.config {
        Some(path) => read_toml(path)?,
        None if arguments.quick => Parameters::quick(),
        None => Parameters::default(),
    };
    if let Some(mesh) = &arguments.mesh {
        parameters.vertebra.mesh = Some(mesh.clone());
    }
    parameters.vertebra.slice = arguments.slice.unwrap_or(parameters.vertebra.slice);
    parameters.validate()?;
    let folder = arguments.out.as_deref().unwrap_or(Path::new("out"));
    let created = prepare(folder)?;
    let result = compute_and_write(&parameters, folder);
    if result.is_err() {
        // Nothing partial stays; a folder that is not empty is somebody else's.
        for folder in created {
            let _ = fs::remove_dir(folder);
        }
    }
    result
}

/// Makes sure before the computation that the folder can be written; tells which folders are new, the
/// innermost first.
fn prepare(folder: &Path) -> Result<Vec<&Path>> {
    let new = |path: &&Path| !path.as_os_str().is_empty() && !path.exists();
    let created: Vec<&Path> = folder.ancestors().take_while(new).collect();
    let mut turn = leftovers::turn();
    for folder in created.iter().rev() {
        turn.add_folder(folder);
    }
    drop(turn);
    fs::create_dir_all(folder).map_err(|e| Error::File {
        path: folder.to_path_buf(),
        message: format!("the folder cannot be made: {}", e.kind()),
    })?;
    check_writable(&folder.join(report::DATA))?;
    Ok(created)
}

fn compute_and_write(parameters: &Parameters, folder: &Path) -> Result<()> {
    let bar = progress_bar("", 1000);
    let step = Mutex::new(String::new());
    let outcome = experiments::run(parameters, &|what, done| {
        // A thread that panicked has ended the run anyway.
        if let Ok(mut step) = step.lock()
            && *step != what
        {
            *step = what.to_owned();
            bar.set_message(what.to_owned());
        }
        bar.set_position((1000.0 * done) as u64);
    })?;
    bar.finish_and_clear();

    let report = Report::new(parameters, &outcome);
    let mut outputs = Outputs::new();
    let names = report.stage(folder, &mut outputs)?;
    outputs.commit()?;
    let mut text = format!(
        "{}\n{} files in {}:\n",
        report.text(),
        names.len(),
        folder.display()
    );
    for name in names.iter().rev().take(3).rev() {
        text += &format!("  {}\n", folder.join(name).display());
    }
    print(&text)?;
    if report.checks_passed() {
        Ok(())
    } else {
        Err(Error::Data(
            "the core differs from its references; see the last table".into(),
        ))
    }
}
