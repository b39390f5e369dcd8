//! A frame of 64 lines of 208 samples by MV from I/Q in fixed point, image and map.
//!
//! The program has one shape of the beamformer, as in a scanner.
//!
//! Prints `set-up-live NAME INSTRUCTIONS DIRECTIONS` of `Frame::new` and of the directions of sub-lines, `live NAME LINES IMAGE MAP STEP STACK`, instructions, with
//! the largest step of image and map and the stack in bytes, and `frame NAME READING INSTRUCTIONS` with the map's share.

use bonebeam::prelude::stages::*;
use cortex_m::peripheral::SYST;
use cortex_m_semihosting::hprintln;
use firmware::arrays;
use firmware::load;
use static_cell::ConstStaticCell;
use stream::scan::{BEAMS, ELEMENTS, INPUT, PARAMETERS as STREAM, ScanBlock, TRANSMIT, record};

use crate::CASE;
use crate::counter::{self, Counter, instructions};

/// Samples of a line: those of the scan of `stream` down to 20.5 mm.
const SAMPLES: usize = 208;
/// Lateral width of the lines, m.
const WIDTH: f64 = 12e-3;

/// Contents of a frame, and its bound.
pub struct Case {
    /// The printed name.
    pub name: &'static str,
    /// Number of focused lines.
    pub lines: usize,
    pub sub_lines: usize,
    /// Depth step between computed samples.
    pub depth_step: usize,
    /// Number of frames for each bone map.
    pub map_every: u32,
    /// Maximum number of instructions: at most 3 % above the count of Rust 1.95.
    pub bound: u32,
}

/// Bound on a change of the probe, whose directions are kept.
const SET_UP_BOUND: u32 = 3_000_000;

/// Bound on a step of image or map, between two kicks of a watchdog.
const STEP_BOUND: u32 = 1_000_000;

impl Case {
    const fn parameters(&self) -> Parameters<'static> {
        let rate = STREAM.scan.output_rate;
        let start = match STREAM.scan.start {
            Depth::Seconds(start) => start,
            Depth::Metres(_) => panic!("the scan begins at a time"),
        };
        Parameters {
            scan: ScanParameters {
                lines: Lines::Even(Axis::centred(self.lines, WIDTH / self.lines as f64)),
                end: Depth::Seconds(start + (SAMPLES - 1) as f64 / rate),
                ..STREAM.scan
            },
            beamformer: beamform::Parameters {
                sub_lines: self.sub_lines,
                depth_step: self.depth_step,
                ..STREAM.beamformer
            },
            block: SAMPLES,
            ..STREAM
        }
    }

    const fn need(&self) -> Need {
        valid!(self.parameters().need(Input::Iq, 1))
    }
}

const NEED: Need = CASE.need();
const DIRECTIONS: usize = valid!(CASE.parameters().directions_len());
const GAINS: usize = bonebeam::phase_symmetry::Sizes::new(STREAM.rows, STREAM.columns, 1)
    .gain_tables_len(STREAM.scales.len());

static MEMORY: ConstStaticCell<Workspaces> = ConstStaticCell::new(Workspaces::new());

arrays! {
    /// The memory of the frame.
    struct Workspaces {
        block: ScanBlock = ScanBlock::filled([0; 2]),
        frame: Memory<{ NEED.real }, { NEED.complex }> = Memory::new(),
        gains: [f32; GAINS] = [0.0; _],
        directions: [Complex<f32>; DIRECTIONS] = [Complex::ZERO; _],
    }
}

/// Counts the frame; ends with a failure if it or a step exceeds its bound.
pub fn main() -> ! {
    counter::run("live", |counter| run(counter, MEMORY.take()))
}

fn run(counter: &mut Counter, workspaces: &mut Workspaces) -> Result<bool, Error> {
    let Workspaces {
        block,
        frame,
        gains,
        directions,
    } = workspaces;
    const PARAMETERS: Parameters = CASE.parameters();
    let input = IqInput {
        interpolation: Some(IqInterpolation::LinearFixed),
        ..INPUT
    };
    let plan = Pipeline::of_iq(PARAMETERS, input)?;
    let computed = counter.cost(|| plan.lines().directions(directions).map(drop))?;
    let plan = plan.with_directions(directions)?;
    let mut made = None;
    let set_up = counter.count(|| made = Some(Frame::new(&plan, frame.scratch())));
    let Some(made) = made else {
        return Ok(false);
    };
    let mut frame = made?.with_gain_tables(gains)?;
    let (mut lines, mut stack) = (0, 0);
    for line in 0..CASE.lines {
        load(block, line * BEAMS / CASE.lines);
        let cost = counter.cost(|| {
            let sizes = const { PARAMETERS.beamformer.sizes(ELEMENTS) };
            let transmits = [(TRANSMIT, &record(block)?)];
            frame.line_by(sizes, line, transmits).map(drop)
        })?;
        lines += cost.instructions;
        stack = stack.max(cost.stack);
    }
    let mut steps = Steps::default();
    let image = counter.cost(|| {
        steps.begin();
        frame.image_in_steps(&mut |_| steps.end()).map(drop)
    })?;
    let map = counter.cost(|| {
        steps.begin();
        frame.bone_map_in_steps(&mut |_| steps.end()).map(drop)
    })?;
    let Case {
        name,
        map_every,
        bound,
        ..
    } = CASE;
    stack = stack.max(image.stack).max(map.stack);
    let (image, map) = (image.instructions, map.instructions);
    let whole = lines + image + map / map_every;
    let largest = steps.largest;
    let set_up = set_up.instructions;
    hprintln!("set-up-live {name} {set_up} {}", computed.instructions);
    hprintln!("live {name} {lines} {image} {map} {largest} {stack}");
    hprintln!("frame {name} fixed {whole}");
    Ok(whole <= bound && largest < STEP_BOUND && set_up < SET_UP_BOUND)
}

/// The largest step.
#[derive(Default)]
struct Steps {
    before: u32,
    largest: u32,
}

impl Steps {
    fn begin(&mut self) {
        self.before = SYST::get_current();
    }

    fn end(&mut self) {
        let now = SYST::get_current();
        self.largest = self.largest.max(instructions(self.before, now));
        self.before = now;
    }
}
