//! The scan of the image `stream` without blocks, pool and sequence.

use bonebeam::prelude::stages::*;
use bonebeam_stream::scan::{self, BEAMS, ELEMENTS, INPUT, PARAMETERS, TRANSMIT};

/// Image and map by the core's frame alone: numbers instead of counts, `[element][sample]`.
///
/// # Errors
/// None: the scan is valid.
pub fn by_the_core() -> Result<(Vec<f32>, Vec<f32>), Error> {
    let pipeline = Pipeline::of_iq(PARAMETERS, INPUT)?;
    let need = pipeline.need(1);
    let (mut real, mut complex) = (vec![0.0; need.real], vec![Complex::ZERO; need.complex]);
    let mut frame = Frame::new(&pipeline, Scratch::new(&mut real, &mut complex))?;
    for beam in 0..BEAMS {
        let echoes = scan::echoes(beam);
        let iq: Vec<Complex<f32>> = (0..ELEMENTS)
            .flat_map(|m| echoes.iter().map(move |row| row[m]))
            .map(|[i, q]| Complex::new(i.into(), q.into()))
            .collect();
        let record = Record::iq(IqSamples::Float(&iq), IqLayout::Planar, ELEMENTS)?;
        frame.line(beam, [(TRANSMIT, &record)])?;
    }
    let image = frame.image()?.to_vec();
    Ok((image, frame.bone_map()?.to_vec()))
}
