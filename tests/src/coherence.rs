//! Coherence of the golden snapshots, with a growing aperture: short-lag, and at trial speeds.

use bonebeam::beamform::SpeedTrials;
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
    // Shorter blocks are more, so that the second trial is the peak.
    let mut trials = SpeedTrials::<3>::new(1500.0, 40.0)?;
    for (trial, block) in [4, 1, 7].into_iter().enumerate() {
        trials.add(trial, trial, line, growing()?, block)?;
        trials.add(5, trial, line, |_| Active::new(2, 12), block)?;
    }
    let found = trials.estimate().map_or(0.0, |found| found.speed);
    let numbers = [0, 1, 2].map(|trial| trials.coherence(trial));
    let numbers = numbers.into_iter().chain([found]);
    report("speed-trials", hash::of(numbers.map(|x| x as f32)));
    Ok(())
}
