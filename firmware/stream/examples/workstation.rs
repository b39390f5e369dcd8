//! The scan of the image `stream` on a workstation, by the core alone, and the shallow one by a chain. Prints what the
//! images must come to.

#[path = "../tests/common/mod.rs"]
mod common;

use bonebeam::memory::Memory;
use bonebeam_stream::scan::{self, BEAMS, ScanBlock, Shallow};
use bonebeam_stream::{Chain, Probe, Stamp};

fn main() -> Result<(), bonebeam::Error> {
    let (image, map) = common::by_the_core()?;
    println!("bone map {:016x}", scan::hash(&map));
    println!("image {:016x}", scan::hash(&image));

    let plan = Shallow::plan()?;
    let mut memory = Box::new(Memory::<{ Shallow::NEED.real }, { Shallow::NEED.complex }>::new());
    let mut chain = Chain::<Shallow, BEAMS>::new(&plan, memory.scratch())?;
    let mut block = Box::new(ScanBlock::filled([0; 2]));
    for beam in 0..BEAMS {
        block.samples = scan::echoes(beam);
        chain.line(beam, &scan::record(&block)?, Stamp::default())?;
    }
    chain.image()?;
    println!("shallow bone map {:016x}", scan::hash(chain.map()?));
    Ok(())
}
