//! Counts a frame of the scan of `stream` by several methods and readings of I/Q.
//!
//! Methods run with and without a depth gate. The counts show which configuration is real time; docs/integration.md
//! has the figures.
//!
//! Prints `memory BLOCK CHAIN PLAN` in bytes, `set-up INSTRUCTIONS STACK`, `focus READING MEAN` of a line without a
//! beamformer, `line NAME READING MEAN MOST STACK`, `picture IMAGE MAP STACK`, and `frame NAME READING INSTRUCTIONS`
//! with a map's share; ends with a failure where a line takes more than its bound or less than all set-up, or a frame
//! is slower than real time.

#![no_std]
#![no_main]

#[path = "../count/counter.rs"]
mod counter;

use bonebeam::pipeline::Block;
use bonebeam::prelude::stages::*;
use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use counter::Counter;
use firmware::arrays;
use firmware::load;
use static_cell::ConstStaticCell;
use stream::scan::{
    self, BEAMS, ELEMENTS, INPUT, LENGTH, PARAMETERS, Reference, SCAN, ScanBlock, ScanMemory,
    TRANSMIT,
};
use stream::{Plan, Probe, Stamp};

type Chain<'m> = stream::Chain<'m, Reference, BEAMS>;

static MEMORY: ConstStaticCell<Workspaces> = ConstStaticCell::new(Workspaces::new());

/// Length of the elements' lags.
const LAGS: usize = IqParameters::of(&SCAN, INPUT.demodulation_frequency)
    .need(1)
    .real;

/// Half of the scan's depth, 4.6 to 24.3 mm: the middle, with the surface.
const GATE: DepthGate = DepthGate {
    from: 10e-3,
    to: 19.82e-3,
};

/// Minimum frames per second with the fixed reading.
///
/// The processor executes an instruction a cycle at 1 GHz.
const REAL_TIME: [(&str, u32); 2] = [("mv", 25), ("esmv-rank1-gate", 15)];
const CYCLES: u32 = 1_000_000_000;

/// A bone map for every third frame.
const MAP_EVERY: u32 = 3;

/// A method, its gate, and the bound on a line's average with the fixed reading.
///
/// The bound is 5 % above the count of Rust 1.95.
struct Case {
    name: &'static str,
    method: Method,
    gate: Option<DepthGate>,
    bound: u32,
}

const fn case(name: &'static str, method: Method, gate: Option<DepthGate>, bound: u32) -> Case {
    Case {
        name,
        method,
        gate,
        bound,
    }
}

const CASES: [Case; 6] = [
    case("das", Method::Das, None, 260_000),
    case("mv", Method::Mv, None, 692_000),
    case("mv-gate", Method::Mv, Some(GATE), 506_000),
    case("esmv-rank1", Method::EsmvRank1, None, 1_598_000),
    case("esmv-rank1-gate", Method::EsmvRank1, Some(GATE), 999_000),
    case(
        "esmv-rank1-steps-gate",
        Method::EsmvRank1Steps(8),
        Some(GATE),
        736_000,
    ),
];
const INTERPOLATIONS: [(&str, IqInterpolation); 4] = [
    ("fixed", IqInterpolation::LinearFixed),
    ("linear", IqInterpolation::Linear),
    ("cubic", IqInterpolation::Cubic),
    ("sinc", IqInterpolation::Sinc),
];

arrays! {
    /// The memory of the chain, a block, and the aligned samples of a line.
    struct Workspaces {
        chain: ScanMemory = ScanMemory::new(),
        block: ScanBlock = ScanBlock::filled([0; 2]),
        aligned: [Complex<f32>; ELEMENTS * LENGTH] = [Complex::ZERO; _],
        scratch: [f32; LAGS] = [0.0; _],
    }
}

#[entry]
fn main() -> ! {
    counter::run("frames", |counter| run(counter, MEMORY.take()))
}

/// Counts; returns whether every frame stays within its bound.
fn run(counter: &mut Counter, workspaces: &mut Workspaces) -> Result<bool, Error> {
    let Workspaces {
        chain: memory,
        block,
        aligned,
        scratch,
    } = workspaces;
    let set_up = counter.cost(|| Chain::new(&Reference::plan()?, memory.scratch()).map(drop))?;
    let [block_bytes, plan_bytes] = [size_of::<ScanBlock>(), size_of::<Plan<Reference>>()];
    hprintln!("memory {block_bytes} {} {plan_bytes}", ScanMemory::BYTES);
    hprintln!("set-up {} {}", set_up.instructions, set_up.stack);
    for (name, interpolation) in INTERPOLATIONS {
        let plan = plan(&CASES[0], interpolation)?;
        let mut sum = 0;
        for beam in 0..BEAMS {
            load(block, beam);
            let cost = counter.cost(|| {
                let record = scan::record(block)?;
                let (transmits, lines) = ([(TRANSMIT, &record)], plan.pipeline().lines());
                let line = Block::of_line(lines.scan(), beam);
                let line = lines.align(0.0f32, line, transmits, scratch, aligned);
                line.map(drop)
            })?;
            sum += cost.instructions;
        }
        hprintln!("focus {name} {}", sum / BEAMS as u32);
    }
    let (mut picture, mut within) = (None, true);
    for case in CASES {
        for (interpolation_name, interpolation) in INTERPOLATIONS {
            let plan = plan(&case, interpolation)?;
            let mut chain = Chain::new(&plan, memory.scratch())?;
            let (mut sum, mut most, mut stack) = (0, 0, 0);
            for beam in 0..BEAMS {
                load(block, beam);
                let cost =
                    counter.cost(|| chain.line(beam, &scan::record(block)?, Stamp::default()))?;
                sum += cost.instructions;
                most = most.max(cost.instructions);
                stack = stack.max(cost.stack);
            }
            let (name, mean) = (case.name, sum / BEAMS as u32);
            hprintln!("line {name} {interpolation_name} {mean} {most} {stack}");
            let (image, map) = match picture {
                Some(picture) => picture,
                None => {
                    let image = counter.count(|| chain.image().is_ok());
                    let map = counter.count(|| chain.map().is_ok());
                    let stack = image.stack.max(map.stack);
                    let (image, map) = (image.instructions, map.instructions);
                    hprintln!("picture {image} {map} {stack}");
                    (image, map)
                }
            };
            picture = Some((image, map));
            let frame = sum + image + map / MAP_EVERY;
            hprintln!("frame {name} {interpolation_name} {frame}");
            if interpolation == IqInterpolation::LinearFixed {
                let real_time = REAL_TIME.iter().find(|(method, _)| *method == name);
                within &= (set_up.instructions..=case.bound).contains(&mean);
                within &= real_time.is_none_or(|(_, least)| frame <= CYCLES / least);
            }
        }
    }
    let inside = GATE.samples(&SCAN.depths())?;
    hprintln!("gate {} {} of {}", inside.start, inside.end, SCAN.samples());
    Ok(within)
}

fn plan(case: &Case, interpolation: IqInterpolation) -> Result<Plan<Reference>, Error> {
    let parameters = Parameters {
        beamformer: beamform::Parameters {
            method: case.method,
            ..PARAMETERS.beamformer
        },
        ..PARAMETERS
    };
    let input = IqInput {
        interpolation: Some(interpolation),
        ..INPUT
    };
    let pipeline = Pipeline::of_iq(parameters, input)?;
    Ok(Plan::of(match case.gate {
        Some(gate) => pipeline.with_gate(gate)?,
        None => pipeline,
    }))
}
