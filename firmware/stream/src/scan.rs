//! The scan that the image `stream` runs: 16 elements, 24 lines, minimum variance over subapertures of 8.
//!
//! [`echoes`] stands in for a recording: firmware/build.rs makes the blocks of it that are compiled in.

use bonebeam::Error;
use bonebeam::beamform::{self, Method, Workspace};
use bonebeam::geometry::{Array, Axis, Depth, Lines, ScanParameters, Transmit, TransmitLaw};
use bonebeam::pipeline::{Parameters, Pipeline, Sizes};

use crate::{Block, ChainMemory};

/// Elements.
pub const ELEMENTS: usize = 16;
/// Samples of a block.
pub const SAMPLES: usize = 256;
/// Beams of a frame.
pub const BEAMS: usize = 24;

/// The pipeline.
pub const PARAMETERS: Parameters = Parameters {
    scan: ScanParameters {
        array: Array::linear(ELEMENTS, 0.3e-3),
        lines: Lines::Even(Axis::centred(BEAMS, 0.35e-3)),
        sound_speed: 1540.0,
        centre_frequency: 5e6,
        sampling_rate: 20e6,
        record_samples: SAMPLES,
        output_rate: 20e6,
        start: Depth::Metres(4e-3),
        end: Depth::Metres(12e-3),
        f_number: 1.5,
        min_elements: 8,
    },
    beamformer: beamform::Parameters {
        method: Method::Mv,
        temporal_half_window: 0,
        ..beamform::Parameters::DEFAULT
    },
    rows: 64,
    columns: 64,
    dynamic_range: 50.0,
    median: true,
    scales: &[1.0 / 8.0, 1.0 / 16.0, 1.0 / 32.0],
    threshold: 10.0,
    strip: 8,
};

/// The sizes of its memory.
pub const SIZES: Sizes = match PARAMETERS.sizes() {
    Ok(sizes) => sizes,
    Err(_) => panic!("the scan is not valid"),
};

/// A beam's transmit: focused on its axis. The record begins 4 µs after it.
pub const TRANSMIT: Transmit = Transmit::new(TransmitLaw::Focused, 4e-6);

/// What the front end delivers.
pub type ScanBlock = Block<i16, ELEMENTS, SAMPLES>;
/// The chain's memory.
pub type ScanMemory = ChainMemory<{ SIZES.real }, { SIZES.complex }, { ELEMENTS * SAMPLES }>;
/// The beamformer's memory.
pub type LineWorkspace =
    Workspace<{ SIZES.elements }, { SIZES.subaperture }, { SIZES.temporal_half_window }>;

/// The plan.
///
/// # Errors
/// None: [`PARAMETERS`] are valid.
pub fn pipeline() -> Result<Pipeline<'static>, Error> {
    Pipeline::new(PARAMETERS)
}

/// What the elements record of a beam: pulses from a bent surface, weaker ones from within tissue above
/// it, and noise; 14 bits.
pub fn echoes(beam: usize) -> [[i16; ELEMENTS]; SAMPLES] {
    let scan = &PARAMETERS.scan;
    let beam_x = scan.lines.x(beam);
    let mut sums = [[0.0f64; ELEMENTS]; SAMPLES];
    let mut add = |x: f64, z: f64, amplitude: f64| {
        for m in 0..ELEMENTS {
            let way = z + libm::hypot(scan.array.x(m) - x, z);
            let arrival = (way / scan.sound_speed - TRANSMIT.t0) * scan.sampling_rate;
            for (sample, row) in sums.iter_mut().enumerate() {
                let s = (sample as f64 - arrival) / 4.0;
                if libm::fabs(s) < 1.0 {
                    let window = (1.0 - s * s) * (1.0 - s * s);
                    row[m] += amplitude * window * window * (1.0 - 11.0 * s * s);
                }
            }
        }
    };
    for k in -3..=3 {
        let x = beam_x + f64::from(k) * 0.1e-3;
        add(x, 8.5e-3 - 60.0 * x * x, 900.0);
    }
    // The same scatterers for every beam that they are near to.
    let mut random = Random(0x2545_F491);
    for _ in 0..200 {
        let (x, z) = (random.next() * 5e-3, 6e-3 + random.next() * 1.8e-3);
        let amplitude = 60.0 * random.next();
        if libm::fabs(x - beam_x) < 0.6e-3 {
            add(x, z, amplitude);
        }
    }
    let mut noise = Random(beam as u32 + 1);
    sums.map(|row| row.map(|sum| libm::round(sum + 4.0 * noise.next()) as i16))
}

/// A linear congruential generator; its numbers lie between −1 and 1.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from((self.0 >> 8) as i32 - (1 << 23)) / f64::from(1 << 23)
    }
}

/// FNV-1a over the bits of a picture, a word at a time: what tells two apart.
pub fn hash(picture: &[f32]) -> u64 {
    let word = |hash: u64, x: &f32| (hash ^ u64::from(x.to_bits())).wrapping_mul(0x100_0000_01b3);
    picture.iter().fold(0xcbf2_9ce4_8422_2325, word)
}
