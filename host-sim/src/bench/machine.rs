//! The machine that is measured.

use std::thread::available_parallelism;

use serde::{Deserialize, Serialize};

use super::vector_sets;

/// What a speed depends on, but for who else is using it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// The processor's name for itself.
    pub processor: String,
    /// Threads that can run at once.
    pub threads: usize,
    /// The instruction sets that the core can use here, widest first.
    pub instruction_sets: Vec<String>,
}

impl Machine {
    /// This machine.
    pub fn here() -> Self {
        Machine {
            processor: processor(),
            threads: available_parallelism().map_or(1, usize::from),
            instruction_sets: vector_sets()
                .into_iter()
                .map(|set| set.name().to_owned())
                .collect(),
        }
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
