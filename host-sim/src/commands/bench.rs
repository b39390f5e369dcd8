//! `host-sim bench`: the core's speed beside other implementations.

use std::path::{Path, PathBuf};

use bonebeam::simd::InstructionSet;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};

use super::{about, read_document};
use crate::Result;
use crate::progress::Progress;
use crate::provenance::PROGRAM;
use bonebeam_bench::{Section, Settings, rewrite, run as measure, text};
use bonebeam_files::atomic::{Outputs, check_outputs};
use bonebeam_files::terminal::print;

/// Measure the core's speed on this machine, beside naive baselines.
///
/// The baselines use faer, rustfft and scipy. Both sides are timed in turn on the same data, with one thread unless
/// stated, after their results have been compared. The fastest of many calls counts, since other programs on the
/// machine slow some calls down.
///
/// Each measurement is one line: the core's time, the baseline's time, the ratio, share or rate, its target, and
/// whether it is met. A slow result is not an error: the exit status is 1 only if results differ. Build with
/// --release.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A short run of a few seconds
    #[arg(long)]
    quick: bool,

    /// Only these sections [default: all]
    #[arg(long, value_name = "SECTION,…", value_delimiter = ',')]
    only: Vec<Section>,

    /// Force one instruction set [default: the widest]
    #[arg(long, value_name = "NAME", value_parser = instruction_sets())]
    instruction_set: Option<InstructionSet>,

    /// Write all figures as JSON
    #[arg(short, long, value_name = "FILE.json")]
    output: Option<PathBuf>,

    /// Rewrite this document's tables, between the two comments of the instruction set
    #[arg(long, value_name = "FILE.md", conflicts_with_all = ["quick", "only"])]
    docs: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  host-sim bench
  host-sim bench --quick
  host-sim bench --only peak,fraction --instruction-set avx2
  host-sim bench -o bench.json
  host-sim bench -o bench.json --docs docs/benchmarks.md
  host-sim bench --instruction-set avx2 --docs docs/benchmarks.md";

/// Parses the name of an instruction set; the help lists all names.
fn instruction_sets() -> impl TypedValueParser<Value = InstructionSet> {
    let names = InstructionSet::ALL.iter().map(|set| set.key());
    PossibleValuesParser::new(names).try_map(|name| name.parse::<InstructionSet>())
}

/// Runs the command.
///
/// # Errors
/// An instruction set that the processor does not have, a file that cannot be written, or results of the two sides
/// that differ.
pub fn run(arguments: &Arguments) -> Result<()> {
    let outputs = [&arguments.output, &arguments.docs];
    let outputs: Vec<&Path> = outputs
        .into_iter()
        .flatten()
        .map(PathBuf::as_path)
        .collect();
    check_outputs(&[], &outputs)?;
    let document = arguments.docs.as_deref().map(read_document).transpose()?;
    let sections = match arguments.only.as_slice() {
        [] => Section::value_variants(),
        some => some,
    };
    let settings = Settings::new(arguments.quick, arguments.instruction_set)?;

    let bar = Progress::new("", 0);
    let report = measure(PROGRAM, &settings, sections, &mut |section, what| {
        bar.set_message(format!("{section}: {what}"));
    })?;
    bar.clear();
    print(&text(&report))?;

    let mut outputs = Outputs::new();
    if let Some(path) = &arguments.output {
        outputs.add(path, |sink| {
            Ok(serde_json::to_writer_pretty(sink, &report)?)
        })?;
    }
    if let (Some(path), Some(document)) = (&arguments.docs, document) {
        let text = rewrite(&document, &report).map_err(|e| about(path, e))?;
        outputs.add(path, |sink| {
            Ok(std::io::Write::write_all(sink, text.as_bytes())?)
        })?;
    }
    outputs.commit()
}
