//! The benchmark: the core beside other ways of computing the same, in one run.
//!
//! A speed is worth something only beside another one of the same minute on the same machine, so
//! every section times both sides in turn and keeps the fastest of many, and its targets are
//! ratios, shares or rates of frames.

mod beamformers;
mod core;
mod delay;
mod document;
mod frames;
mod machine;
mod naive;
mod naive_phase_symmetry;
mod operations;
mod peak;
mod peers;
mod phase_symmetry;
mod report;
mod scipy;
mod shares;
mod simulated;
mod snapshots;
mod text;
mod timing;

pub use bonebeam_files::{Error, Result};
pub use document::rewrite;
pub use report::{Quantity, Report, Row, Table, Target};
pub use text::text;

use std::fmt;
use std::time::Duration;

use bonebeam::simd::InstructionSet;
use clap::ValueEnum;

use machine::Machine;

/// The parts of the benchmark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Section {
    /// The peak of one core, each instruction set
    Peak,
    /// Beamformers against naive faer
    Beamformers,
    /// The beamformer's share of the peak
    Fraction,
    /// A time window of 21 samples against none
    TimeWindow,
    /// Simulated frames, and depths beyond the full aperture
    Simulated,
    /// Whole frames
    Frames,
    /// The delay stage against the beamformer
    Delay,
    /// Phase symmetry against naive rustfft, and scipy where it is installed
    PhaseSymmetry,
    /// A frame against USTB, zea and ultraspy, where Python has them
    Peers,
}

impl fmt::Display for Section {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = self.to_possible_value();
        f.write_str(value.as_ref().map_or("", |value| value.get_name()))
    }
}

/// Samples of a line where its ends should not count for much: half a line of 40 mm.
const LINE: usize = 512;

/// How to measure.
#[derive(Clone, Debug)]
pub struct Settings {
    /// A short look.
    pub quick: bool,
    /// For the core's lanes.
    pub instruction_set: InstructionSet,
    /// Those whose peak is measured.
    pub instruction_sets: Vec<InstructionSet>,
    /// For one row.
    pub budget: Duration,
    /// Of a line beside faer.
    pub samples: usize,
    /// How wide the processor's arithmetic units are, bits.
    pub unit_bits: Option<usize>,
}

impl Settings {
    /// Settings for this machine: its widest instruction set and the others beside it, or `forced`
    /// alone.
    ///
    /// # Errors
    /// [`Error::Usage`] where the processor does not have `forced`.
    pub fn new(quick: bool, forced: Option<InstructionSet>) -> Result<Self> {
        let available = vector_sets();
        if let Some(set) = forced
            && !available.contains(&set)
        {
            let names: Vec<&str> = available.iter().map(|set| set.name()).collect();
            return Err(Error::Usage(format!(
                "--instruction-set {} cannot be measured here; expected one of {}",
                set.name(),
                names.join(", ")
            )));
        }
        let instruction_sets = forced.map_or(available, |set| vec![set]);
        Ok(Settings {
            quick,
            instruction_set: instruction_sets[0],
            instruction_sets,
            budget: Duration::from_millis(if quick { 20 } else { 800 }),
            samples: if quick { 32 } else { 128 },
            unit_bits: machine::unit_bits(),
        })
    }
}

impl Settings {
    /// Whether the core's lanes are worked on 512 bits at a time.
    fn is_wide(&self) -> bool {
        self.unit_bits == Some(512) && machine::lanes(self.instruction_set) == 16
    }
}

/// The instruction sets of this processor, the widest first. One lane has its own rows instead: a
/// compiler may make vectors of it where there is nothing else to do, as at the peak.
pub fn vector_sets() -> Vec<InstructionSet> {
    let sets = InstructionSet::available();
    sets.filter(|&set| set != InstructionSet::Scalar).collect()
}

/// Measures the sections; `progress` hears which, and what of it, before it begins.
///
/// # Errors
/// What the core refuses, and results that are not those of the yardstick.
pub fn run(
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
        Section::Simulated => simulated::simulated(settings, step),
        Section::Frames => frames::frames(settings, step),
        Section::Delay => delay::against_beamforming(settings, step),
        Section::PhaseSymmetry => phase_symmetry::phase_symmetry(settings, step),
        Section::Peers => peers::peers(settings, step),
    }
}
