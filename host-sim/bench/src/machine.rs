//! The machine that is measured.

use std::thread::available_parallelism;
use std::time::Duration;

use bonebeam::dispatch;
use bonebeam::prelude::stages::*;

use serde::{Deserialize, Serialize};

use super::peak::peak;

/// Properties of the machine on which speeds depend.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Name of the processor.
    pub processor: String,
    /// Number of threads that can run at once.
    pub threads: usize,
    /// The instruction sets that the core can use here, widest first.
    pub instruction_sets: Vec<String>,
    /// Width of the arithmetic units, bits, as measured by their speed.
    ///
    /// Wider registers are processed in parts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit_bits: Option<usize>,
}

impl Machine {
    /// This machine.
    pub fn here(unit_bits: Option<usize>) -> Self {
        Machine {
            processor: processor(),
            threads: available_parallelism().map_or(1, usize::from),
            instruction_sets: vector_sets()
                .into_iter()
                .map(|set| set.name().to_owned())
                .collect(),
            unit_bits,
        }
    }
}

/// The vector instruction sets of this processor, the widest first.
///
/// One lane has its own rows instead, since a compiler may vectorise it, as it does for the peak.
pub fn vector_sets() -> Vec<InstructionSet> {
    let sets = InstructionSet::available();
    sets.filter(|&set| set != InstructionSet::Scalar).collect()
}

/// Smallest ratio of peaks at which units are as wide as the registers.
///
/// It is the peak of a set over that of the next narrower one. With narrower units, both are equally fast.
const WIDER: f64 = 1.5;
/// Time for the peak of a set: a few calls.
const LOOK: Duration = Duration::from_millis(20);

/// The width of the widest registers that are processed as a whole, bits.
pub fn unit_bits() -> Option<usize> {
    let peaks: Vec<(InstructionSet, f64)> = vector_sets()
        .into_iter()
        .map(|set| (set, peak(set, LOOK)))
        .collect();
    let whole = |pair: &[(InstructionSet, f64)]| pair[0].1 >= WIDER * pair[1].1;
    let widest = peaks.windows(2).find(|pair| whole(pair));
    let (set, _) = widest.map_or_else(|| peaks.last(), |pair| pair.first())?;
    Some(32 * lanes(*set))
}

/// The number of lanes of an instruction set's registers.
pub fn lanes(set: InstructionSet) -> usize {
    dispatch!(set, zero => zero.lanes().len())
}

/// The name of the processor, or its architecture if it has none.
fn processor() -> String {
    #[cfg(target_arch = "x86_64")]
    if let Some(name) = raw_cpuid::CpuId::new().get_processor_brand_string() {
        return name.as_str().trim().to_owned();
    }
    format!("{} {}", std::env::consts::OS, std::env::consts::ARCH)
}
