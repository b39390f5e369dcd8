//! Short-lag coherence of the golden snapshots, with a growing aperture.

use bonebeam::memory;
use bonebeam::prelude::stages::*;

use crate::beamform::growing;
use crate::snapshots::{ELEMENTS, SAMPLES, SNAPSHOTS};
use crate::{arrays, hash};

/// The case.
pub const COHERENCE: ShortLagCoherence = ShortLagCoherence {
    temporal_half_window: 2,
};

arrays! {
    /// The memory of the case.
    pub struct Memory {
        scratch: memory::Memory<{ COHERENCE.need().real }, 0> = memory::Memory::new(),
        coherence: [f32; SAMPLES] = [0.0; _],
    }
}

pub(crate) fn run(memory: &mut Memory, report: &mut impl FnMut(&str, u64)) -> Result<(), Error> {
    let Memory { scratch, coherence } = memory;
    let line = AlignedLine::new(&SNAPSHOTS, ELEMENTS)?;
    COHERENCE.line(line, growing()?, scratch.scratch(), coherence)?;
    report("short-lag-coherence", hash::of(coherence.iter().copied()));
    Ok(())
}
