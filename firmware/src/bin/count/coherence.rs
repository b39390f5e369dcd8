//! Short-lag coherence of a line, and its coherence at a trial speed, of three sizes.

use bonebeam::beamform::SpeedTrials;
use bonebeam::prelude::stages::*;
use firmware::arrays;
use static_cell::ConstStaticCell;

use crate::counter::Counter;
use crate::input::{ECHO, snapshots};
use crate::report;

const SAMPLES: usize = 128;
const LARGEST: usize = 64;
/// ±0.4 mm at 20 MHz.
const COHERENCE: ShortLagCoherence = ShortLagCoherence {
    temporal_half_window: 10,
};
const LENGTH: usize = COHERENCE.need().real;

/// The bounds on the instructions per sample for `M` = 16, 32 and 64 (see `beamform.rs`).
const BOUNDS: [u32; 3] = [585, 910, 1560];

/// The same of a trial speed.
const SPEED_BOUNDS: [u32; 3] = [200, 400, 800];

arrays! {
    /// The memory of the cases.
    struct Workspaces {
        memory: Memory<LENGTH, 0> = Memory::new(),
        x: [Complex<f32>; SAMPLES * LARGEST] = [Complex::ZERO; _],
        out: [f32; SAMPLES] = [0.0; _],
    }
}
static WORKSPACES: ConstStaticCell<Workspaces> = ConstStaticCell::new(Workspaces::new());

/// Counts whole lines with all elements active; returns whether they stay within their bounds.
pub fn run(counter: &mut Counter) -> Result<bool, Error> {
    let Workspaces { memory, x, out } = WORKSPACES.take();
    let mut within = true;
    for (elements, bound) in [16, 32, LARGEST].into_iter().zip(BOUNDS) {
        let x = &mut x[..SAMPLES * elements];
        snapshots(x, elements, ECHO);
        let line = AlignedLine::new(x, elements)?;
        let all = |_| Active::new(0, elements);
        let cost = counter.cost(|| COHERENCE.line(line, all, memory.scratch(), out))?;
        let bytes = Memory::<LENGTH, 0>::BYTES;
        let name = "short-lag-coherence";
        within &= report(name, elements, SAMPLES, &cost, bytes, bound);
    }
    for (elements, bound) in [16, 32, LARGEST].into_iter().zip(SPEED_BOUNDS) {
        let x = &mut x[..SAMPLES * elements];
        snapshots(x, elements, ECHO);
        let line = AlignedLine::new(x, elements)?;
        let mut trials = SpeedTrials::<5>::new(1460.0, 40.0)?;
        let all = |_| Active::new(0, elements);
        let cost = counter.cost(|| trials.add(0, 2, line, all, 16))?;
        let bytes = size_of::<SpeedTrials<5>>();
        within &= report("speed-trials", elements, SAMPLES, &cost, bytes, bound);
    }
    Ok(within)
}
