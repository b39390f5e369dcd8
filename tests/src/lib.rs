//! Golden cases: fixed inputs, one hash for each kernel, the same on every target.
//!
//! A workstation's test and the firmware image both call [`run`] and print a line for each case. Both must give the
//! recorded lines of `tests/golden/hashes.txt`.

#![no_std]

#[cfg(feature = "lanes")]
extern crate std;

mod arrays;
pub mod beamform;
pub mod coherence;
pub mod delay;
#[cfg(feature = "lanes")]
pub mod draw;
pub mod hash;
pub mod image;
pub mod iq;
#[cfg(feature = "lanes")]
pub mod kernel;
#[cfg(feature = "lanes")]
pub mod kernels;
pub mod phase_symmetry;
pub mod pipeline;
pub mod snapshots;
pub mod sqrt;
pub mod surface;

/// The examples of the documents must compile and run.
#[cfg(doctest)]
mod documents {
    #[doc = include_str!("../../README.md")]
    struct Readme;
    #[doc = include_str!("../../docs/memory.md")]
    struct Memory;
}

use bonebeam::Error;

arrays! {
    /// The memory of all cases; fits a `static`.
    pub struct Workspaces {
        beamform: beamform::Memory = beamform::Memory::new(),
        coherence: coherence::Memory = coherence::Memory::new(),
        delay: delay::Memory = delay::Memory::new(),
        image: image::Memory = image::Memory::new(),
        iq: iq::Memory = iq::Memory::new(),
        phase_symmetry: phase_symmetry::Memory = phase_symmetry::Memory::new(),
        pipeline: pipeline::Memory = pipeline::Memory::new(),
        surface: surface::Memory = surface::Memory::new(),
    }
}

impl Workspaces {
    /// Size of this memory, bytes.
    pub const BYTES: usize = size_of::<Self>();
}

/// Runs every case and reports its name (without spaces) and its hash.
///
/// # Errors
/// Errors of the core, which are faults of a case.
pub fn run(workspaces: &mut Workspaces, report: &mut impl FnMut(&str, u64)) -> Result<(), Error> {
    sqrt::run(report);
    delay::run(&mut workspaces.delay, report)?;
    beamform::run(&mut workspaces.beamform, report)?;
    image::run(&mut workspaces.image, report)?;
    phase_symmetry::run(&mut workspaces.phase_symmetry, report)?;
    iq::run(&mut workspaces.iq, &mut workspaces.delay, report)?;
    pipeline::run(&mut workspaces.pipeline, report)?;
    surface::run(&mut workspaces.surface, report)?;
    coherence::run(&mut workspaces.coherence, report)
}
