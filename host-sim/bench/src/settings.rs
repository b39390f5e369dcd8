//! The parts of the benchmark, and settings of the measurements.

use std::fmt;
use std::time::Duration;

use bonebeam::simd::InstructionSet;
use clap::ValueEnum;

use super::machine::{lanes, unit_bits, vector_sets};
use crate::{Error, Result};

/// The parts of the benchmark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Section {
    /// Peak rate of one core with each instruction set
    Peak,
    /// Beamformers against naive faer
    Beamformers,
    /// The beamformer's share of the peak
    Fraction,
    /// A time window of 21 samples against none
    TimeWindow,
    /// Several directions of a line against one
    SubLines,
    /// Simulated frames, and depths beyond the full aperture
    Simulated,
    /// Frames per second
    Frames,
    /// The delay stage against the beamformer
    Delay,
    /// Phase symmetry against naive rustfft, and scipy if it is installed
    PhaseSymmetry,
    /// A frame against USTB, zea and ultraspy, if Python has them
    Peers,
}

impl fmt::Display for Section {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = self.to_possible_value();
        f.write_str(value.as_ref().map_or("", |value| value.get_name()))
    }
}

/// Samples of a line whose ends have little effect: half a line of 40 mm.
pub const LINE: usize = 512;

/// Settings of the measurements.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Whether this is a quick run.
    pub quick: bool,
    /// Instruction set of the core's lanes.
    pub instruction_set: InstructionSet,
    /// Instruction sets whose peak is measured.
    pub instruction_sets: Vec<InstructionSet>,
    /// Time for one row.
    pub budget: Duration,
    /// Samples of a line in the comparison with faer.
    pub samples: usize,
    /// Width of the processor's arithmetic units, bits.
    pub unit_bits: Option<usize>,
}

impl Settings {
    /// Settings for this machine, with all its instruction sets or `forced` alone.
    ///
    /// # Errors
    /// [`Error::Usage`] if the processor does not have `forced`.
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
            unit_bits: unit_bits(),
        })
    }
}

impl Settings {
    /// Whether the core's lanes are processed 512 bits at a time.
    pub fn is_wide(&self) -> bool {
        self.unit_bits == Some(512) && lanes(self.instruction_set) == 16
    }
}
