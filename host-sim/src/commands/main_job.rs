//! `host-sim` without a command: the main job.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;

use super::{about, read_document, view};
use crate::progress::Progress;
use crate::provenance::PROGRAM;
use crate::{Error, Result};
use bonebeam_drive::check::References;
use bonebeam_files::atomic::{Outputs, check_writable};
use bonebeam_files::temporary_files;
use bonebeam_files::terminal::{one_line, print};
use bonebeam_report::experiments::{Job, MAIN_JOB, Overrides};
use bonebeam_report::page::{self, Page, Report};

/// Arguments of the main job.
#[derive(Debug, Args)]
pub struct Arguments {
    /// A coarser main job that takes a few seconds
    #[arg(long)]
    quick: bool,

    /// Folder for the main job's report, pictures and configuration [default: out]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Also compare the results with the references, by the program bonebeam-paper
    #[arg(long)]
    pub references: bool,

    #[command(flatten)]
    overrides: Overrides,

    /// Rewrite the tables of the main job in this document, such as docs/results.md
    ///
    /// They are between its comments `<!-- NAME -->` and `<!-- end of NAME -->`, for `point` and `vertebra`.
    #[arg(long, value_name = "FILE.md")]
    docs: Option<PathBuf>,

    /// TOML file with the main job's parameters, such as the one in its folder
    #[arg(long, value_name = "FILE.toml", conflicts_with = "quick")]
    config: Option<PathBuf>,
}

impl Arguments {
    /// Refuses flags of the main job before a command, where they have no effect.
    ///
    /// # Errors
    /// One of them was given.
    pub fn refuse(&self) -> Result<()> {
        let own = [
            ("--quick", self.quick),
            ("--out", self.out.is_some()),
            ("--references", self.references),
            ("--docs", self.docs.is_some()),
            ("--config", self.config.is_some()),
        ];
        let mut all = own.into_iter().chain(self.overrides.given());
        match all.find(|(_, given)| *given) {
            None => Ok(()),
            Some((flag, _)) => Err(Error::Usage(format!(
                "{flag} is a flag of the main job, which runs without a command"
            ))),
        }
    }
}

/// Runs the main job, prints its tables and writes its folder.
///
/// Results are compared with `references` if there are some.
///
/// # Errors
/// A parameter out of range, a folder that cannot be written, or a check that fails.
pub fn run(arguments: &Arguments, references: Option<&'static References>) -> Result<()> {
    let mut job = match &arguments.config {
        Some(path) => Job::read(MAIN_JOB, path)?,
        None if arguments.quick => Job::quick(MAIN_JOB),
        None => Job::full(MAIN_JOB),
    };
    job.apply(&arguments.overrides);
    job.validate()?;
    job.compare_with(references);
    let folder = arguments.out.as_deref().unwrap_or(Path::new("out"));
    let bar = Progress::new("", 1000);
    let docs = arguments.docs.as_deref();
    run_in(&job, folder, (&Page::MAIN_JOB, bar), docs)
}

/// Runs a job, prints its tables and writes its folder.
///
/// # Errors
/// A folder that cannot be written, or a check that fails.
pub fn run_in(
    job: &Job,
    folder: &Path,
    shown: (&Page, Progress),
    docs: Option<&Path>,
) -> Result<()> {
    let created = prepare(folder)?;
    let result = compute_and_write(job, folder, shown, docs);
    if result.is_err() {
        // Nothing partial stays; a folder that is not empty is somebody else's.
        for folder in created {
            let _ = fs::remove_dir(folder);
        }
    }
    result
}

/// Checks that the folder can be written; returns new folders, innermost first.
///
/// # Errors
/// A folder that cannot be created or written.
pub fn prepare(folder: &Path) -> Result<Vec<&Path>> {
    let new = |path: &&Path| !path.as_os_str().is_empty() && !path.exists();
    let created: Vec<&Path> = folder.ancestors().take_while(new).collect();
    let mut guard = temporary_files::lock();
    for folder in created.iter().rev() {
        guard.add_folder(folder);
    }
    drop(guard);
    fs::create_dir_all(folder).map_err(|e| Error::File {
        path: folder.to_path_buf(),
        message: format!("the folder cannot be created: {}", e.kind()),
    })?;
    check_writable(&folder.join(page::DATA))?;
    Ok(created)
}

fn compute_and_write(
    job: &Job,
    folder: &Path,
    (page, bar): (&Page, Progress),
    docs: Option<&Path>,
) -> Result<()> {
    let document = docs.map(read_document).transpose()?;
    let outcomes = job.run(&|what, done| bar.set_step(what, done))?;
    bar.clear();

    let mut report = Report::new(job, &outcomes, page)?;
    report.live = view::of_vertebra()?;
    let mut outputs = Outputs::new();
    let names = report.add_to(folder, &mut outputs)?;
    if let (Some(path), Some(document)) = (docs, document) {
        let head = format!("Version {PROGRAM}.");
        let text = report.rewrite(&document, &head);
        let text = text.map_err(|e| about(path, e))?;
        outputs.add(path, |sink| Ok(sink.write_all(text.as_bytes())?))?;
    }
    outputs.commit()?;
    let mut text = format!(
        "{}\n{} files in {}:\n",
        report.text(),
        names.len(),
        one_line(&folder.display().to_string())
    );
    for name in names.iter().rev().take(3).rev() {
        let path = folder.join(name);
        text += &format!("  {}\n", one_line(&path.display().to_string()));
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
