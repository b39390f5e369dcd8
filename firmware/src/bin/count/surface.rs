//! The bone surface of grey levels, line by line.

use bonebeam::prelude::stages::*;
use bonebeam::surface::{Levels, Parameters, Settings, Survey, Tracker};
use firmware::arrays;
use static_cell::ConstStaticCell;

use crate::counter::Counter;
use crate::report;

const SAMPLES: usize = 1024;
const LINES: usize = 20;

/// Lines of 40 mm at 20 MHz; a point is decided nine lines later.
const PARAMETERS: Parameters = Parameters {
    samples: Axis::new(3e-3, 0.0385e-3, SAMPLES),
    spacing: 0.3e-3,
    settings: Settings::DEFAULT,
    latency: 9,
};
/// The same by the learnt model.
const LEARNT: Parameters = Parameters {
    settings: Settings::LEARNT,
    ..PARAMETERS
};
const NEED: Need = valid!(PARAMETERS.need()).or(valid!(LEARNT.need()));

/// Parameters, and the bounds on the instructions per sample (see `beamform.rs`).
const CASES: [(&str, Parameters, u32); 2] =
    [("surface", PARAMETERS, 62), ("surface-learnt", LEARNT, 120)];
const SURVEY_BOUND: u32 = 22;

arrays! {
    /// The memory of the cases.
    struct Workspaces {
        memory: Memory<{ NEED.real }, 0> = Memory::new(),
        line: [u8; SAMPLES] = [0; _],
    }
}
static WORKSPACES: ConstStaticCell<Workspaces> = ConstStaticCell::new(Workspaces::new());

/// Counts scores and path together, and the frame's levels.
///
/// The data are noise with a sloping bone.
pub fn run(counter: &mut Counter) -> Result<bool, Error> {
    let Workspaces { memory, line } = WORKSPACES.take();
    let detector = Detector::new(PARAMETERS)?;
    let mut state = 34u32;
    let mut next = |line: &mut [u8; SAMPLES], bone: usize| {
        for (sample, grey) in line.iter_mut().enumerate() {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = state >> 24;
            *grey = match sample {
                _ if sample >= bone + 8 => noise / 6,
                _ if sample >= bone => 150 + noise / 4,
                _ => 40 + noise / 2,
            } as u8;
        }
    };
    next(line, 500);
    let mut survey = Survey::new(&detector, memory.scratch())?;
    let cost = counter.cost(|| survey.line(line))?;
    let mut within = report("surface-levels", SAMPLES, SAMPLES, &cost, 0, SURVEY_BOUND);
    let levels: Levels = survey.levels();
    for (name, parameters, bound) in CASES {
        let detector = Detector::new(parameters)?;
        let mut tracker = Tracker::new(&detector, memory.scratch())?;
        // The ring is full before the last line.
        for k in 0..LINES {
            next(line, 500 + 3 * k);
            tracker.line(line, levels)?;
        }
        next(line, 500 + 3 * LINES);
        let mut found = Ok(None);
        let cost = counter.count(|| found = tracker.line(line, levels));
        within &= found?.flatten().is_some();
        let bytes = size_of::<f32>() * parameters.need()?.real;
        within &= report(name, SAMPLES, SAMPLES, &cost, bytes, bound);
    }
    Ok(within)
}
