//! The image stage on the golden snapshots read as 32 beams of 48 samples.

use bonebeam::Error;
use bonebeam::geometry::Axis;
use bonebeam::image::{
    Logarithm, envelope, largest, log_compression, log_compression_with, median, resample,
};

use crate::hash;
use crate::snapshots::{ELEMENTS, LENGTH, SAMPLES, SNAPSHOTS};

/// Rows and columns of the image.
pub const SIDE: usize = 64;
/// In dB.
pub const DYNAMIC_RANGE: f32 = 50.0;

/// The beams, as a share of the image's side.
pub const BEAMS: Axis = Axis {
    first: 0.0,
    step: 1.0 / (ELEMENTS as f64 - 1.0),
    count: ELEMENTS,
};
/// The samples along a beam.
pub const DEPTHS: Axis = Axis {
    first: 0.0,
    step: 1.0 / (SAMPLES as f64 - 1.0),
    count: SAMPLES,
};
/// The rows; the last ones lie beyond the data.
pub const ROWS: Axis = Axis {
    first: 0.0,
    step: 1.0 / 60.0,
    count: SIDE,
};
/// The columns; the first one lies beyond the data.
pub const COLUMNS: Axis = Axis {
    first: -0.01,
    step: 1.0 / 63.0,
    count: SIDE,
};

/// The memory of the cases.
pub struct Memory {
    envelope: [f32; LENGTH],
    levels: [f32; LENGTH],
    image: [f32; SIDE * SIDE],
    smooth: [f32; SIDE * SIDE],
}

impl Memory {
    pub(crate) const fn new() -> Self {
        Memory {
            envelope: [0.0; LENGTH],
            levels: [0.0; LENGTH],
            image: [0.0; SIDE * SIDE],
            smooth: [0.0; SIDE * SIDE],
        }
    }
}

/// The pixels before the median, in the memory.
#[cfg(feature = "lanes")]
pub(crate) fn pixels(memory: &mut Memory) -> Result<&[f32], Error> {
    run(memory, &mut |_, _| ())?;
    Ok(&memory.image)
}

pub(crate) fn run(memory: &mut Memory, report: &mut impl FnMut(&str, u64)) -> Result<(), Error> {
    let Memory {
        envelope: magnitudes,
        levels,
        image,
        smooth,
    } = memory;
    envelope(&SNAPSHOTS, magnitudes)?;
    report("envelope", hash::real(magnitudes));
    log_compression(magnitudes, largest(magnitudes), DYNAMIC_RANGE, levels)?;
    report("log-compression", hash::real(levels));
    let reference = largest(magnitudes);
    let by = Logarithm::Polynomial;
    // In the image's place, so that what follows has the levels of before.
    let polynomial = &mut image[..LENGTH];
    log_compression_with(by, magnitudes, reference, DYNAMIC_RANGE, polynomial)?;
    report("log-compression-polynomial", hash::real(polynomial));
    resample(levels, [BEAMS, DEPTHS], [ROWS, COLUMNS], image)?;
    report("resample", hash::real(image));
    median(0.0f32, image, SIDE, smooth)?;
    report("median", hash::real(smooth));
    Ok(())
}
