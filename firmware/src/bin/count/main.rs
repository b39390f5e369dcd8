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
use static_cell::ConstStaticCell;

static DELAY: ConstStaticCell<delay::Workspaces> = ConstStaticCell::new(delay::Workspaces::new());
static IQ: ConstStaticCell<iq::Workspaces> = ConstStaticCell::new(iq::Workspaces::new());
static BEAMFORM: ConstStaticCell<beamform::Workspaces> =
    ConstStaticCell::new(beamform::Workspaces::new());
static DECIBELS: ConstStaticCell<decibels::Workspaces> =
    ConstStaticCell::new(decibels::Workspaces::new());
static PHASE_SYMMETRY: ConstStaticCell<phase_symmetry::Workspaces> =
    ConstStaticCell::new(phase_symmetry::Workspaces::new());
static SURFACE: ConstStaticCell<surface::Workspaces> =
    ConstStaticCell::new(surface::Workspaces::new());
static COHERENCE: ConstStaticCell<coherence::Workspaces> =
    ConstStaticCell::new(coherence::Workspaces::new());

#[entry]
fn main() -> ! {
    counter::run("count", count)
}

fn count(counter: &mut Counter) -> Result<bool, Error> {
    let set_ups = set_up::run(counter)?;
    let delays = delay::run(counter, DELAY.take())?;
    let iq = iq::run(counter, IQ.take())?;
    let beamformers = beamform::run(counter, BEAMFORM.take())?;
    let decibels = decibels::run(counter, DECIBELS.take())?;
    let filters = phase_symmetry::run(counter, PHASE_SYMMETRY.take())?;
    let surfaces = surface::run(counter, SURFACE.take())?;
    let coherence = coherence::run(counter, COHERENCE.take())?;
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
