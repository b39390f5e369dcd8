//! The machine that is measured.

use std::thread::available_parallelism;
use std::time::Duration;

use bonebeam::simd::{InstructionSet, Task, Vector};

use serde::{Deserialize, Serialize};

use super::peak::peak;

/// What a speed depends on, but for who else is using it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// The processor's name for itself.
    pub processor: String,
    /// Threads that can run at once.
    pub threads: usize,
    /// The instruction sets that the core can use here, widest first.
    pub instruction_sets: Vec<String>,
    /// How wide its arithmetic units are, bits, as their speed tells: a wider register is worked on in parts.
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

/// The instruction sets of this processor, the widest first. One lane has its own rows instead: a
/// compiler may make vectors of it where there is nothing else to do, as at the peak.
pub fn vector_sets() -> Vec<InstructionSet> {
    let sets = InstructionSet::available();
    sets.filter(|&set| set != InstructionSet::Scalar).collect()
}

/// A set whose peak is this many times that of the next narrower one has units as wide as its registers.
/// Where they are not, both are equally fast.
const WIDER: f64 = 1.5;
/// For the peak of a set: a few calls of it.
const LOOK: Duration = Duration::from_millis(20);

/// The width of the widest registers that are worked on as a whole.
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

/// How many lanes the registers of an instruction set have.
pub fn lanes(set: InstructionSet) -> usize {
    set.dispatch(Lanes)
}

struct Lanes;

impl Task for Lanes {
    type Output = usize;

    fn run<V: Vector>(self, _: V) -> usize {
        V::LANES
    }
}

/// The processor's name for itself; the architecture where it does not tell.
fn processor() -> String {
    #[cfg(target_arch = "x86_64")]
    if let Some(name) = raw_cpuid::CpuId::new().get_processor_brand_string() {
        return name.as_str().trim().to_owned();
    }
    format!("{} {}", std::env::consts::OS, std::env::consts::ARCH)
}
