//! The bone surface in a frame of integers.
//!
//! The frame has 24 lines of 384 samples of noise, a bright layer, and bone that slopes, jumps and has a gap.

use bonebeam::memory;
use bonebeam::prelude::stages::*;
use bonebeam::surface::{Parameters, Point, Settings};

use crate::{arrays, hash};

/// Lines of the frame.
pub const LINES: usize = 24;
/// Samples of a line.
pub const SAMPLES: usize = 384;

/// All terms except the contrast, against the tissue alone.
const SETTINGS: Settings = Settings {
    cell: 0.06e-3,
    echo: 0.3e-3,
    onset_weight: 1.25,
    margin: 1.0,
    contrast: Ramp::new(0.0, 0.0, 1.0),
    level: Ramp::new(1.0, 0.02, 0.15),
    rest: Ramp::new(2.0, 0.0, 0.1),
    shadow: Ramp::new(-1.0, 0.3, 0.25),
    shadow_range: 0.15,
    absence: -1.5,
    end: 3.0,
    jump: 6.0,
    slope: 1.6e3,
    confidence: [-0.04, 1.2],
    ..Settings::DEFAULT
};

/// The whole frame in one call.
pub const WHOLE: Parameters = Parameters {
    samples: Axis::new(3e-3, 0.0385e-3, SAMPLES),
    spacing: 0.3e-3,
    settings: Settings {
        depths: [4e-3, f64::INFINITY],
        ..SETTINGS
    },
    latency: LINES - 1,
};
/// Line by line, samples as cells, closer lines.
pub const LATE: Parameters = Parameters {
    samples: Axis::new(0.0, 0.1e-3, SAMPLES),
    spacing: 0.2e-3,
    settings: SETTINGS,
    latency: 5,
};
/// Cells of three samples, with the contrast.
pub const CONTRAST: Parameters = Parameters {
    settings: Settings {
        cell: 0.11e-3,
        contrast: Ramp::new(0.8, 0.1, 0.2),
        ..WHOLE.settings
    },
    ..WHOLE
};
/// Each echo is scored by itself.
pub const MARGIN: Parameters = Parameters {
    settings: Settings {
        margin: 0.1,
        level: Ramp::new(1.0, 0.5, 0.3),
        ..CONTRAST.settings
    },
    ..WHOLE
};
/// Scores of the learnt model.
pub const LEARNT: Parameters = Parameters {
    settings: Settings::LEARNT,
    ..WHOLE
};
/// The cases with their names.
pub const CASES: [(&str, Parameters); 5] = [
    ("surface-frame", WHOLE),
    ("surface-late", LATE),
    ("surface-contrast", CONTRAST),
    ("surface-margin", MARGIN),
    ("surface-learnt", LEARNT),
];

const fn need(parameters: Parameters) -> Need {
    valid!(parameters.need())
}
const NEED: Need = need(WHOLE)
    .or(need(LATE))
    .or(need(CONTRAST))
    .or(need(MARGIN))
    .or(need(LEARNT));

arrays! {
    /// The memory of the cases.
    pub struct Memory {
        scratch: memory::Memory<{ NEED.real }, 0> = memory::Memory::new(),
        frame: [u8; LINES * SAMPLES] = [0; _],
        points: [Option<Point>; LINES] = [None; _],
    }
}

/// Grey levels `[line][sample]`.
pub fn frame(out: &mut [u8; LINES * SAMPLES]) {
    let mut state = 34u32;
    for (line, samples) in out.chunks_exact_mut(SAMPLES).enumerate() {
        let bone = match line {
            9..12 => SAMPLES,
            0..9 => 150 + 3 * line,
            _ => 240 - 2 * line,
        };
        for (sample, grey) in samples.iter_mut().enumerate() {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = state >> 24;
            let level = match sample {
                60..66 => 130 + noise / 3,
                _ if sample >= bone + 6 => noise / 6,
                _ if sample >= bone => 150 + noise / 4,
                _ => 40 + noise / 2,
            };
            *grey = level as u8;
        }
    }
}

/// The hash of a surface: depth and confidence of each point.
///
/// The depth is negative at the start of a piece. A line without a point has 0.
pub fn hash_of(points: &[Option<Point>]) -> u64 {
    let numbers = points.iter().flat_map(|point| match point {
        None => [0.0; 2],
        Some(point) if point.begins => [-point.depth, point.confidence],
        Some(point) => [point.depth, point.confidence],
    });
    hash::of(numbers)
}

pub(crate) fn run(memory: &mut Memory, report: &mut impl FnMut(&str, u64)) -> Result<(), Error> {
    let Memory {
        scratch,
        frame: grey,
        points,
    } = memory;
    frame(grey);
    for (name, parameters) in CASES {
        let detector = Detector::new(parameters)?;
        detector.frame(grey, scratch.scratch(), points)?;
        report(name, hash_of(points));
    }
    Ok(())
}
