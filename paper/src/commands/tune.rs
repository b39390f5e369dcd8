//! `host-sim tune`: tunes beamformer, image and bone-surface detector together.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use crate::Result;
use crate::experiments::tune::{Sections, Shown, Tune};
use crate::experiments::{Common, Context};
use bonebeam_drive::methods::MethodName;
use bonebeam_files::atomic::Outputs;
use bonebeam_files::section::Value;
use bonebeam_files::terminal::{one_line, print};
use host_sim::commands::main_job::prepare;
use host_sim::commands::{ConfigArgument, about, load_config, read_document};
use host_sim::progress::Progress;
use host_sim::provenance::PROGRAM;

/// Tune beamformer, image and bone-surface detector together, on simulated bones.
///
/// Each method is tuned alone, and the largest score wins. The score is the mean of F1 over random vertebrae under
/// layers of tissue, clean and disturbed by aberration, clutter and noise. The result is judged on other bones,
/// beside DAS with the detector's defaults and DAS with only the detector tuned. The latter can also win, if das is
/// one of the methods.
///
/// The folder holds tuned.toml, a configuration that every command takes by --config; report.json with every
/// number; and evaluations.csv. An interrupted run resumes from .kept in the folder and writes the same bytes.
/// Lines have the depth step of --preset live.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Folder for the configuration, the report and the evaluations
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,

    /// Beamformers to tune [default: das,mv,esmv-rank1; with --quick das,mv]
    #[arg(long, value_name = "METHOD,…", value_delimiter = ',', value_parser = methods())]
    methods: Vec<MethodName>,

    /// Number of bones to tune on, and of others to judge on [default: 6; with --quick 2]
    #[arg(long, value_name = "N")]
    bones: Option<u64>,

    /// Evaluations per method [default: 240; with --quick 24]
    ///
    /// The detector alone gets eight times as many.
    #[arg(long, value_name = "N")]
    evaluations: Option<usize>,

    /// Seed of the search and of the bones [default: 1]
    #[arg(long, value_name = "N")]
    seed: Option<u64>,

    /// Few, coarse scenes, for a first look
    #[arg(long)]
    quick: bool,

    /// Rewrite the tables of this document between `<!-- tune -->` and `<!-- end of tune -->`
    #[arg(long, value_name = "FILE.md")]
    docs: Option<PathBuf>,

    #[command(flatten)]
    config: ConfigArgument,
}

/// The names of the beamformers.
fn methods() -> impl TypedValueParser<Value = MethodName> {
    let names = MethodName::choices().into_iter();
    let values = names.map(|[name, help]| PossibleValue::new(name).help(help));
    PossibleValuesParser::new(values).try_map(|name| MethodName::read(&name))
}

const EXAMPLES: &str = "\
The file of --config sets the scanner ([simulate.scanner]), the start of the search, and all that is not tuned.

Examples:
  host-sim tune -o tuned
  host-sim tune --quick -o look
  host-sim tune --methods das --bones 12 --evaluations 1000 --seed 2 -o tuned
  host-sim tune --config scanner.toml -o tuned
  host-sim surface channels.npz --config tuned/tuned.toml -o surface.csv";

/// Folder in the outputs for recordings and scores until the run is done.
const KEPT: &str = ".kept";

/// Runs the command.
///
/// # Errors
/// A parameter out of range, or a folder that cannot be written.
pub fn run(arguments: &Arguments) -> Result<()> {
    let mut tune = Tune::new(arguments.quick);
    if arguments.config.path.is_some() {
        let config = load_config(arguments.config.path.as_deref())?;
        config.validate()?;
        tune.sections = Sections {
            beamform: config.beamform,
            image: config.image,
            surface: config.surface,
        };
        if let Some(scanner) = config.simulate.scanner {
            tune.scenes.scanner = scanner;
        }
    }
    if !arguments.methods.is_empty() {
        tune.methods.clone_from(&arguments.methods);
    }
    tune.bones = arguments.bones.unwrap_or(tune.bones);
    tune.evaluations = arguments.evaluations.unwrap_or(tune.evaluations);
    tune.seed = arguments.seed.unwrap_or(tune.seed);
    tune.validate()?;
    let document = arguments.docs.as_deref().map(read_document).transpose()?;

    let folder = &arguments.output;
    let created = prepare(folder)?;
    let result = tuned(&tune, folder).and_then(|shown| {
        let docs = arguments.docs.as_deref().zip(document.as_deref());
        write(&shown, folder, docs)
    });
    if result.is_err() {
        // Nothing partial stays; a folder that is not empty is kept for the next run.
        for folder in created {
            let _ = fs::remove_dir(folder);
        }
        return result;
    }
    // The outputs are there. What cannot be removed is taken by the next run.
    let _ = fs::remove_dir_all(folder.join(KEPT));
    Ok(())
}

fn tuned(tune: &Tune, folder: &Path) -> Result<Shown> {
    let bar = Progress::of_steps(1000);
    let kept = folder.join(KEPT);
    let shown = tune.run(&Context {
        common: &Common::default(),
        kept: Some(&kept),
        merged: &[],
        references: None,
        progress: &|what, done| bar.set_step(what, done),
    })?;
    bar.clear();
    Ok(shown)
}

fn write(shown: &Shown, folder: &Path, docs: Option<(&Path, &str)>) -> Result<()> {
    let mut outputs = Outputs::new();
    let mut add =
        |path: &Path, text: &str| outputs.add(path, |sink| Ok(sink.write_all(text.as_bytes())?));
    let head = format!("# host-sim {PROGRAM}: tune\n\n");
    add(&folder.join("tuned.toml"), &(head + &shown.configuration))?;
    add(
        &folder.join("report.json"),
        &format!("{:#}\n", shown.report),
    )?;
    add(&folder.join("evaluations.csv"), &shown.evaluations)?;
    if let Some((path, document)) = docs {
        let text = shown.rewrite(document, &format!("Version {PROGRAM}."));
        add(path, &text.map_err(|e| about(path, e))?)?;
    }
    outputs.commit()?;
    let best = shown.report["best"].as_str().unwrap_or_default();
    let file = one_line(&folder.join("tuned.toml").display().to_string());
    print(&format!("{}\nthe best, in {file}: {best}\n", shown.text()))
}
