//! Short-lag coherence of the golden snapshots, with a growing aperture.

use bonebeam::Error;
use bonebeam::beamform::{AlignedLine, ShortLagCoherence};
use bonebeam::memory;

use crate::beamform::growing;
use crate::hash;
use crate::snapshots::{ELEMENTS, SAMPLES, SNAPSHOTS};

/// The case.
pub const COHERENCE: ShortLagCoherence = ShortLagCoherence {
    temporal_half_window: 2,
};

/// The memory of the case.
pub struct Memory {
    scratch: memory::Memory<{ COHERENCE.need().real }, 0>,
    coherence: [f32; SAMPLES],
}

impl Memory {
    pub(crate) const fn new() -> Self {
        Memory {
            scratch: memory::Memory::new(),
            coherence: [0.0; SAMPLES],
        }
    }
}

pub(crate) fn run(memory: &mut Memory, report: &mut impl FnMut(&str, u64)) -> Result<(), Error> {
    let Memory { scratch, coherence } = memory;
    let line = AlignedLine::new(&SNAPSHOTS, ELEMENTS)?;
    COHERENCE.line(line, growing()?, scratch.scratch(), coherence)?;
    report("short-lag-coherence", hash::of(coherence.iter().copied()));
    Ok(())
}
