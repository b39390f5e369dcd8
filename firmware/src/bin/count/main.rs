//! Counts the instructions that the core takes on a Cortex-M7, per output sample and per pixel.
//!
//! Prints one line for each case, `count NAME SIZE INSTRUCTIONS OUTPUTS BYTES STACK`, after lines
//! `value NAME SIZE INDEX RE IM` with the results. `firmware/count` compares both with the same work in plain C.
//! Ends with a failure if a case takes more instructions than its bound.

#![no_std]
#![no_main]

mod beamform;
mod coherence;
mod counter;
mod decibels;
mod delay;
mod input;
mod iq;
mod phase_symmetry;
mod set_up;
mod surface;

use bonebeam::Error;
use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use counter::{Cost, Counter};

#[entry]
fn main() -> ! {
    counter::run("count", count)
}

fn count(counter: &mut Counter) -> Result<bool, Error> {
    let set_ups = set_up::run(counter)?;
    let delays = delay::run(counter)?;
    let iq = iq::run(counter)?;
    let beamformers = beamform::run(counter)?;
    let decibels = decibels::run(counter)?;
    let filters = phase_symmetry::run(counter)?;
    let surfaces = surface::run(counter)?;
    let coherence = coherence::run(counter)?;
    Ok(set_ups && delays && iq && beamformers && decibels && filters && surfaces && coherence)
}

/// Prints a case; returns whether its instructions per output are within `bound`.
fn report(name: &str, size: usize, outputs: usize, cost: &Cost, bytes: usize, bound: u32) -> bool {
    let Cost {
        instructions,
        stack,
    } = cost;
    hprintln!("count {name} {size} {instructions} {outputs} {bytes} {stack}");
    *instructions <= bound.saturating_mul(outputs as u32)
}
