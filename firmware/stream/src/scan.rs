//! The scan of the image `stream`: I/Q, minimum variance.
//!
//! 16 elements, 24 lines of 256 samples, subapertures of 8. [`echoes`] replaces a recording: firmware/build.rs
//! computes the blocks that are compiled in.

use bonebeam::prelude::stages::*;

use crate::{Block, Probe};

/// Number of elements.
pub const ELEMENTS: usize = 16;
/// Number of samples of a block.
pub const SAMPLES: usize = 280;
/// Number of beams of a frame.
pub const BEAMS: usize = 24;
/// Number of samples of a line.
pub const LENGTH: usize = 256;

const RATE: f64 = 10e6;
const SOUND_SPEED: f64 = 1540.0;
const START: f64 = 6e-6;

/// Parameters of scan, beamformer and image.
pub const PARAMETERS: Parameters<'static> = Parameters {
    scan: ScanParameters {
        array: Array::linear(ELEMENTS, 0.5e-3),
        lines: Lines::Even(Axis::centred(BEAMS, 0.5e-3)),
        sound_speed: SOUND_SPEED,
        centre_frequency: 5e6,
        sampling_rate: RATE,
        record_samples: SAMPLES,
        output_rate: RATE,
        start: Depth::Seconds(START),
        end: Depth::Seconds(START + (LENGTH - 1) as f64 / RATE),
        f_number: 1.5,
        min_elements: 8,
    },
    beamformer: beamform::Parameters {
        temporal_half_window: 0,
        ..beamform::Parameters::of(Method::Mv)
    },
    rows: 64,
    columns: 64,
    dynamic_range: 50.0,
    median: true,
    scales: &[1.0 / 4.0, 1.0 / 8.0, 1.0 / 16.0],
    threshold: 10.0,
    strip: 8,
    block: LENGTH,
};

/// Demodulation and interpolation of the I/Q, to 10⁻³ of the pulse's peak.
///
/// docs/integration.md gives cost and errors of other interpolations.
pub const INPUT: IqInput = IqInput {
    demodulation_frequency: 5e6,
    interpolation: Some(IqInterpolation::for_band(RATE, 3e6)),
};

/// Geometry of the scan.
pub const SCAN: Scan<'static> = valid!(Scan::of_iq(PARAMETERS.scan));
const _: () = assert!(SCAN.samples() == LENGTH);

/// Transmit of a beam, focused on its axis. The record begins 5 µs later.
pub const TRANSMIT: Transmit<'static> = Transmit::new(TransmitLaw::Focused, 5e-6);

/// Block of this scan's front end.
pub type ScanBlock = Block<[i16; 2], ELEMENTS, SAMPLES>;

/// The probe of this scan.
#[derive(Clone, Copy, Debug)]
pub enum Reference {}

impl Probe for Reference {
    type Stage = IqDelay;
    const PARAMETERS: Parameters<'static> = PARAMETERS;
    const NEED: Need = valid!(PARAMETERS.need(Input::Iq, 1));
    const TRANSMIT: Transmit<'static> = TRANSMIT;

    fn pipeline() -> Result<Pipeline<'static, IqDelay>, Error> {
        Pipeline::of_iq(PARAMETERS, INPUT)
    }
}

/// A second probe for the same blocks, with half of the depth.
#[derive(Clone, Copy, Debug)]
pub enum Shallow {}

impl Probe for Shallow {
    type Stage = IqDelay;
    const PARAMETERS: Parameters<'static> = Parameters {
        scan: ScanParameters {
            end: Depth::Seconds(START + (LENGTH / 2 - 1) as f64 / RATE),
            ..PARAMETERS.scan
        },
        block: LENGTH / 2,
        ..PARAMETERS
    };
    const NEED: Need = valid!(Self::PARAMETERS.need(Input::Iq, 1));
    const TRANSMIT: Transmit<'static> = TRANSMIT;

    fn pipeline() -> Result<Pipeline<'static, IqDelay>, Error> {
        Pipeline::of_iq(Self::PARAMETERS, INPUT)
    }
}

/// Memory of a chain of [`Reference`], for a `static`.
pub type ScanMemory = Memory<{ Reference::NEED.real }, { Reference::NEED.complex }>;

/// Record of a block.
///
/// # Errors
/// None: a block has the scan's elements.
pub fn record(block: &ScanBlock) -> Result<Record<'_>, Error> {
    let samples = IqSamples::Counts(block.samples.as_flattened(), 1.0);
    Record::iq(samples, IqLayout::Interleaved, ELEMENTS)
}

/// Simulated record of a beam: 14 bits, demodulated with [`INPUT`].
///
/// It has pulses from a curved surface, weaker ones from within tissue above it, and noise.
pub fn echoes(beam: usize) -> [[[i16; 2]; ELEMENTS]; SAMPLES] {
    let scan = SCAN.parameters();
    let beam_x = scan.lines.x(beam);
    let mut sums = [[[0.0f64; 2]; ELEMENTS]; SAMPLES];
    let mut add = |x: f64, z: f64, amplitude: f64| {
        for m in 0..ELEMENTS {
            let time = (z + libm::hypot(scan.array.x(m) - x, z)) / SOUND_SPEED;
            let angle = -core::f64::consts::TAU * INPUT.demodulation_frequency * time;
            for (sample, row) in sums.iter_mut().enumerate() {
                let late = (TRANSMIT.t0 + sample as f64 / RATE - time) / 0.2e-6;
                if libm::fabs(late) < 4.0 {
                    let envelope = amplitude * libm::exp(-late * late);
                    row[m][0] += envelope * libm::cos(angle);
                    row[m][1] += envelope * libm::sin(angle);
                }
            }
        }
    };
    for k in -3..=3 {
        let x = beam_x + f64::from(k) * 0.15e-3;
        add(x, 16e-3 - 25.0 * x * x, 900.0);
    }
    // The same scatterers for every beam that they are near to.
    let mut random = Random(0x2545_F491);
    for _ in 0..400 {
        let (x, z) = (random.next() * 7e-3, 9.5e-3 + random.next() * 4e-3);
        let amplitude = 60.0 * random.next();
        if libm::fabs(x - beam_x) < 0.8e-3 {
            add(x, z, amplitude);
        }
    }
    let mut noise = Random(beam as u32 + 1);
    sums.map(|row| row.map(|iq| iq.map(|sum| libm::round(sum + 4.0 * noise.next()) as i16)))
}

/// A linear congruential generator; its numbers lie between −1 and 1.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from((self.0 >> 8) as i32 - (1 << 23)) / f64::from(1 << 23)
    }
}

/// FNV-1a hash over the bits of a picture, a word at a time, to compare pictures.
pub fn hash(picture: &[f32]) -> u64 {
    let word = |hash: u64, x: &f32| (hash ^ u64::from(x.to_bits())).wrapping_mul(0x100_0000_01b3);
    picture.iter().fold(0xcbf2_9ce4_8422_2325, word)
}
