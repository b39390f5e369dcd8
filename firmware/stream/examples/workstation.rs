//! The scan of the image `stream` on a workstation: by the core alone, without blocks, pool and sequence.
//! Prints what the image must come to.

use bonebeam::Error;
use bonebeam::focus::Record;
use bonebeam::pipeline::{Frame, Memory};
use stream::scan::{self, BEAMS, ELEMENTS, LineWorkspace, SIZES, TRANSMIT};

fn main() -> Result<(), Error> {
    let mut memory = Box::new(Memory::<{ SIZES.real }, { SIZES.complex }>::new());
    let mut workspace = Box::new(LineWorkspace::new());
    let pipeline = scan::pipeline()?;
    let mut frame = Frame::new(&pipeline, memory.view())?;
    for beam in 0..BEAMS {
        let echoes = scan::echoes(beam);
        let rf: Vec<f32> = (0..ELEMENTS)
            .flat_map(|m| echoes.iter().map(move |row| row[m].into()))
            .collect();
        let record = Record::new(&rf, ELEMENTS)?;
        frame.line(beam, [(TRANSMIT, &record)], &mut workspace.view())?;
    }
    let image = scan::hash(frame.image()?);
    let map = scan::hash(frame.bone_map()?);
    println!("image {image:016x} bone map {map:016x}");
    Ok(())
}
