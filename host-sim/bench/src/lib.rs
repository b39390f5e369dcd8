//! The benchmark: the core against other implementations, in one run.
//!
//! Speeds are only comparable if measured together on the same machine. Every section times both sides in turn and keeps
//! the fastest of many runs. Its targets are ratios, shares or frame rates.

mod beamformers;
mod core;
mod delay;
mod document;
mod frames;
mod in_vivo;
mod machine;
mod naive;
mod naive_phase_symmetry;
mod operations;
mod peak;
mod peers;
mod phase_symmetry;
mod report;
mod scipy;
mod settings;
mod shares;
mod simulated;
mod snapshots;
mod text;
mod timing;

pub use bonebeam_files::{Error, Result};
pub use document::rewrite;
pub use machine::vector_sets;
pub use report::{Quantity, Report, Row, Table, Target};
pub use settings::{Section, Settings};
pub use text::text;

use machine::Machine;

/// Measures the sections; `program` is the version.
///
/// `progress` is called with the section and its part before each starts.
///
/// # Errors
/// The errors of the core, and results that differ from those of the reference.
pub fn run(
    program: &str,
    settings: &Settings,
    sections: &[Section],
    progress: &mut (dyn FnMut(Section, &str) + Send),
) -> Result<Report> {
    let tables = sections.iter().map(|&section| {
        let mut step = |what: &str| progress(section, what);
        measure(settings, section, &mut step)
    });
    let tables = tables.collect::<Result<Vec<Table>>>()?;
    Ok(Report {
        program: program.to_owned(),
        machine: Machine::here(settings.unit_bits),
        instruction_set: settings.instruction_set.name().to_owned(),
        quick: settings.quick,
        tables,
    })
}

fn measure(
    settings: &Settings,
    section: Section,
    step: &mut (dyn FnMut(&str) + Send),
) -> Result<Table> {
    match section {
        Section::Peak => Ok(shares::peaks(settings, step)),
        Section::Beamformers => beamformers::against_faer(settings, step),
        Section::Fraction => shares::share_of_peak(settings, step),
        Section::TimeWindow => shares::time_window(settings, step),
        Section::SubLines => shares::sub_lines(settings, step),
        Section::Simulated => simulated::simulated(settings, step),
        Section::Frames => frames::frames(settings, step),
        Section::Delay => delay::against_beamforming(settings, step),
        Section::PhaseSymmetry => phase_symmetry::phase_symmetry(settings, step),
        Section::Peers => peers::peers(settings, step),
    }
}
