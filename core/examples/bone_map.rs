//! RF to bone map and bone surface in fixed memory; `firmware/src/bin/bone_map.rs` runs it on a Cortex-M7.
use bonebeam::beamform::ShortLagCoherence;
use bonebeam::prelude::*;
use bonebeam::surface::{self, Detector, Settings};

/// Elements of the array.
const ELEMENTS: usize = 16;
const LINES: usize = 64;
/// A scan of 16 elements, with its beamformer and image.
pub const PARAMETERS: Parameters = Parameters {
    scan: ScanParameters {
        array: Array::linear(ELEMENTS, 0.3e-3),
        lines: Lines::Even(Axis::centred(LINES, 0.15e-3)),
        sound_speed: 1540.0,
        centre_frequency: 5e6,
        sampling_rate: 20e6,
        record_samples: 384,
        output_rate: 20e6,
        start: Depth::Metres(4e-3),
        end: Depth::Metres(12e-3),
        f_number: 1.5,
        min_elements: 8,
    },
    beamformer: beamform::Parameters::DEFAULT,
    rows: 64,
    columns: 64,
    dynamic_range: 50.0,
    median: true,
    scales: &[1.0 / 8.0, 1.0 / 16.0, 1.0 / 32.0],
    threshold: 10.0,
    strip: 8,
    block: 64,
};
const NEED: Need = valid!(PARAMETERS.need(Input::Rf, 1));
/// Coherence over ±0.4 mm, which tells bone's shadow from clutter, and its memory.
const COHERENCE: ShortLagCoherence = ShortLagCoherence {
    temporal_half_window: 10,
};
const OF_COHERENCE: Need = Need::real(valid!(PARAMETERS.coherence_len(COHERENCE)));
const SURFACE: surface::Parameters = valid!(PARAMETERS.surface(Settings {
    depths: [5e-3, f64::INFINITY],
    ..Settings::COHERENCE
}));
const OF_SURFACE: Need = valid!(SURFACE.need());
const ALL: Need = NEED.and(OF_COHERENCE).and(OF_SURFACE);
/// All memory of a frame. It fits a `static`.
pub type FrameMemory = Memory<{ ALL.real }, { ALL.complex }>;

/// The hashes of a frame's bone map, 64 × 64 pixels, and of its bone surface.
pub fn bone_map(memory: &mut FrameMemory) -> Result<[u64; 2], Error> {
    let pipeline = Pipeline::new(PARAMETERS)?;
    let mut scratch = memory.scratch();
    let [coherence, of_surface] = [scratch.take(OF_COHERENCE)?, scratch.take(OF_SURFACE)?];
    let frame = Frame::new(&pipeline, scratch)?;
    let mut frame = frame.with_coherence(COHERENCE, coherence.real)?;
    for k in 0..LINES {
        let rf = echoes(PARAMETERS.scan.lines.x(k));
        let transmit = Transmit::new(TransmitLaw::Focused, 0.0);
        let record = Record::new(&rf, ELEMENTS)?;
        frame.line(k, [(transmit, &record)])?;
    }
    frame.image()?;
    let map = hash(frame.bone_map()?.iter().copied());
    let mut points = [None; LINES];
    frame.surface(&Detector::new(SURFACE)?, of_surface, &mut points)?;
    let numbers =
        |point: &Option<surface::Point>| point.map_or([0.0; 2], |p| [p.depth, p.confidence]);
    Ok([map, hash(points.iter().flat_map(numbers))])
}

fn hash(numbers: impl Iterator<Item = f32>) -> u64 {
    let fnv = |hash: u64, x: f32| (hash ^ u64::from(x.to_bits())).wrapping_mul(0x100_0000_01b3);
    numbers.fold(0xcbf2_9ce4_8422_2325, fnv)
}

/// Replaces a scanner: echoes from a bent surface near the line.
///
/// Each element receives a pulse from every point of it.
fn echoes(line_x: f64) -> [f32; ELEMENTS * PARAMETERS.scan.record_samples] {
    let scan = &PARAMETERS.scan;
    let mut rf = [0.0; ELEMENTS * PARAMETERS.scan.record_samples];
    for (m, rf) in rf.chunks_exact_mut(scan.record_samples).enumerate() {
        for x in (-3..=3).map(|k| line_x + f64::from(k) * 0.1e-3) {
            let (z, d) = (8e-3 + 60.0 * x * x, scan.array.x(m) - x);
            let arrival = (2.0 * z + d * d / (2.0 * z)) / scan.sound_speed * scan.sampling_rate;
            let first = arrival as usize - 3;
            for (n, value) in rf.iter_mut().skip(first).take(8).enumerate() {
                let s = ((first + n) as f64 - arrival) / 4.0;
                let window = (1.0 - s * s) * (1.0 - s * s);
                *value += (window * window * (1.0 - 11.0 * s * s)) as f32;
            }
        }
    }
    rf
}

#[cfg(not(target_os = "none"))]
fn main() -> Result<(), Error> {
    let mut memory = Box::new(FrameMemory::new());
    let [map, surface] = bone_map(&mut memory)?;
    println!("bone-map {map:016x} surface {surface:016x}");
    Ok(())
}
