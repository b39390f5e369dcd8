//! I/Q to bone map in fixed memory.
//!
//! The input is 16-bit counts as a front end sends them, read in place. `bone_map.rs` starts from RF.
use bonebeam::prelude::*;

const ELEMENTS: usize = 16;
const SAMPLES: usize = 208;
const PARAMETERS: Parameters = Parameters {
    scan: ScanParameters {
        array: Array::linear(ELEMENTS, 0.3e-3),
        lines: Lines::Even(Axis::centred(64, 0.15e-3)),
        sound_speed: 1540.0,
        centre_frequency: 5e6,
        sampling_rate: 10e6,
        record_samples: SAMPLES,
        output_rate: 10e6,
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
    block: 32,
};
const INPUT: IqInput = IqInput {
    demodulation_frequency: 5e6,
    interpolation: None,
};
const NEED: Need = valid!(PARAMETERS.need(Input::Iq, 1));
type FrameMemory = Memory<{ NEED.real }, { NEED.complex }>;

fn main() -> Result<(), Error> {
    let mut memory = Box::new(FrameMemory::new());
    let pipeline = Pipeline::of_iq(PARAMETERS, INPUT)?;
    let mut frame = Frame::new(&pipeline, memory.scratch())?;
    let transmit = Transmit::new(TransmitLaw::Focused, 0.0);
    for k in 0..PARAMETERS.scan.lines.count() {
        let counts = echoes(PARAMETERS.scan.lines.x(k));
        let samples = IqSamples::Counts(counts.as_flattened(), 1.0);
        let record = Record::iq(samples, IqLayout::Interleaved, ELEMENTS)?;
        frame.line(k, [(transmit, &record)])?;
    }
    frame.image()?;
    let map = frame.bone_map()?;
    let brightest = (0..map.len()).max_by(|&a, &b| map[a].total_cmp(&map[b]));
    let row = brightest.unwrap_or(0) / PARAMETERS.columns;
    println!("brightest in row {row} of {}", PARAMETERS.rows);
    println!("memory: {} bytes", FrameMemory::BYTES);
    Ok(())
}

/// Replaces a scanner: demodulated echoes of a bent surface, `[sample][element]`.
///
/// Each element receives a pulse from every point of the surface near the line.
fn echoes(line_x: f64) -> [[[i16; 2]; ELEMENTS]; SAMPLES] {
    let scan = &PARAMETERS.scan;
    let mut sums = [[[0.0f64; 2]; ELEMENTS]; SAMPLES];
    for x in (-3..=3).map(|k| line_x + f64::from(k) * 0.1e-3) {
        let z = 8e-3 + 60.0 * x * x;
        for m in 0..ELEMENTS {
            let arrival = (z + f64::hypot(scan.array.x(m) - x, z)) / scan.sound_speed;
            let angle = -std::f64::consts::TAU * INPUT.demodulation_frequency * arrival;
            for (n, row) in sums.iter_mut().enumerate() {
                let late = (n as f64 / scan.sampling_rate - arrival) / 0.25e-6;
                let envelope = 1000.0 * (-late * late).exp();
                row[m][0] += envelope * angle.cos();
                row[m][1] += envelope * angle.sin();
            }
        }
    }
    sums.map(|row| row.map(|iq| iq.map(|sum| sum.round() as i16)))
}
