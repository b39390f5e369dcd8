//! Counts two and eight directions of a line: 16 elements, forward-backward, K = 0.
//!
//! An image of its own: in `count`, the lines and their sub-lines would share kernels, which are slower then. Prints
//! `count NAME SIZE INSTRUCTIONS OUTPUTS BYTES STACK`. Ends with a failure if a case takes more instructions than its
//! bound.

#![no_std]
#![no_main]

#[path = "../count/counter.rs"]
mod counter;
#[path = "../count/input.rs"]
#[allow(dead_code, reason = "one kind of data serves")]
mod input;

use bonebeam::beamform::{Parameters, Sizes};
use bonebeam::prelude::stages::*;
use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use counter::Counter;
use firmware::arrays;
use input::{ECHO, SAMPLES, snapshots};
use static_cell::ConstStaticCell;

const ELEMENTS: usize = 16;
const MOST: usize = 8;

/// A method, the names of two and eight directions, and bounds on their instructions per sample.
///
/// They are a quarter above the counts of Rust 1.95, as those of the lines.
const CASES: [(Method, [&str; 2], [u32; 2]); 2] = [
    (
        Method::Mv,
        ["mv-2-sub-lines", "mv-8-sub-lines"],
        [4410, 9190],
    ),
    (
        Method::EsmvRank1,
        ["esmv-rank1-2-sub-lines", "esmv-rank1-8-sub-lines"],
        [7400, 11_800],
    ),
];

const fn parameters(method: Method, sub_lines: usize) -> Parameters {
    Parameters {
        sub_lines,
        ..Parameters::of(method)
    }
}

const fn sizes(sub_lines: usize) -> Sizes {
    parameters(Method::Mv, sub_lines).sizes(ELEMENTS)
}

arrays! {
    /// The memory of the cases.
    struct Workspaces {
        of_two: Memory<{ sizes(2).need().real }, { sizes(2).need().complex }> = Memory::new(),
        of_eight: Memory<{ sizes(MOST).need().real }, { sizes(MOST).need().complex }> = Memory::new(),
        directions: [Complex<f32>; Steering::need(SAMPLES, MOST).complex] = [Complex::ZERO; _],
        x: [Complex<f32>; SAMPLES * ELEMENTS] = [Complex::ZERO; _],
        z: [Complex<f32>; SAMPLES * MOST] = [Complex::ZERO; _],
    }
}
static MEMORY: ConstStaticCell<Workspaces> = ConstStaticCell::new(Workspaces::new());

#[entry]
fn main() -> ! {
    counter::run("sub_lines", |counter| run(counter, MEMORY.take()))
}

/// Counts every case; returns whether all stay within their bounds.
fn run(counter: &mut Counter, workspaces: &mut Workspaces) -> Result<bool, Error> {
    let Workspaces {
        of_two,
        of_eight,
        directions,
        x,
        z,
    } = workspaces;
    snapshots(x, ELEMENTS, ECHO);
    let mut within = true;
    for (method, names, bounds) in CASES {
        let mut lines: Lines<'_> = (x, directions, z);
        within &= of::<2, _, _>(counter, of_two, (method, names[0]), bounds[0], &mut lines)?;
        within &= of::<MOST, _, _>(counter, of_eight, (method, names[1]), bounds[1], &mut lines)?;
    }
    Ok(within)
}

/// The aligned samples, the directions and the output.
type Lines<'a> = (
    &'a [Complex<f32>],
    &'a mut [Complex<f32>],
    &'a mut [Complex<f32>],
);

fn of<const N: usize, const REAL: usize, const COMPLEX: usize>(
    counter: &mut Counter,
    memory: &mut Memory<REAL, COMPLEX>,
    (method, name): (Method, &str),
    bound: u32,
    (x, directions, z): &mut Lines<'_>,
) -> Result<bool, Error> {
    let beamformer = Beamformer::new(parameters(method, N))?;
    let directions = &mut directions[..Steering::need(SAMPLES, N).complex];
    // Phase steps of less than a tenth of a radian, to either side.
    let (phasors, _) = directions.as_chunks_mut::<2>();
    for (k, phasors) in phasors.iter_mut().enumerate() {
        let half = ((k % N) as f32 + 0.5 - N as f32 / 2.0) / (10 * N) as f32;
        let real = 1.0 - half * half / 2.0;
        *phasors = [Complex::new(real, half), Complex::new(real, -half)];
    }
    let steering = Steering::of(directions, N);
    let all = |_| Active::new(0, ELEMENTS);
    let z = &mut z[..SAMPLES * N];
    let cost = counter.cost(|| {
        let line = AlignedLine::new(x, ELEMENTS)?;
        let mut workspace = Workspace::new(0.0, sizes(N), memory.scratch())?;
        beamformer.sub_lines(&mut workspace, (line, steering), all, z)
    })?;
    let bytes = Memory::<REAL, COMPLEX>::BYTES;
    let (instructions, stack) = (cost.instructions, cost.stack);
    hprintln!("count {name} {ELEMENTS} {instructions} {SAMPLES} {bytes} {stack}");
    Ok(instructions <= bound * SAMPLES as u32)
}
