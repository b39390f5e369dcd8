//! The recording for verification: a curved surface under a small array.
//!
//! It is not made by the simulator, whose transforms choose their instructions by the machine. It uses + − × ÷ √ in a
//! fixed order, and `libm` for other functions. So the recording and all results have the same bits on every machine.

use std::f64::consts::PI;

use ndarray::Array3;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use bonebeam_files::{ChannelData, Transmits};

const ELEMENTS: usize = 48;
const BEAMS: usize = 12;
const SAMPLES: usize = 700;
const PITCH: f64 = 0.308e-3;
const SOUND_SPEED: f64 = 1540.0;
const SAMPLING_RATE: f64 = 40e6;
const CENTRE_FREQUENCY: f64 = 5e6;
const FOCUS: f64 = 9e-3;
/// Half the width of the transmitted beam at 1/e, m.
const BEAM_WIDTH: f64 = 0.6e-3;
/// Half the width of the pulse at 1/e, s.
const PULSE_WIDTH: f64 = 0.09e-6;
/// The time of the first sample, s.
const START: f64 = 2.0 * 5e-3 / SOUND_SPEED - 0.5e-6;
/// Number of scatterers on the surface.
const SCATTERERS: usize = 141;
/// Lateral distance of the scatterers, m.
const SPACING: f64 = 0.1e-3;
/// Noise relative to an echo.
const NOISE: f64 = 0.02;

/// A recording of a surface at 8 to 10 mm of depth, with noise.
///
/// The array has 48 elements and 12 focused beams, at the paper's pitch and frequency.
pub fn recording() -> ChannelData {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let centred = |k: usize, count: usize| k as f64 - (count - 1) as f64 / 2.0;
    let element_x: Vec<f64> = (0..ELEMENTS)
        .map(|m| centred(m, ELEMENTS) * PITCH)
        .collect();
    let beam_x: Vec<f64> = (0..BEAMS).map(|b| element_x[4 * b + 2]).collect();
    let scatterers: Vec<_> = (0..SCATTERERS)
        .map(|k| {
            let x = centred(k, SCATTERERS) * SPACING;
            (x, 8e-3 + x * x / 25e-3, 0.5 + random.random::<f64>())
        })
        .collect();
    let mut rf = Array3::zeros((BEAMS, ELEMENTS, SAMPLES));
    for (mut record, beam_x) in rf.outer_iter_mut().zip(&beam_x) {
        for (mut samples, element_x) in record.outer_iter_mut().zip(&element_x) {
            let mut line = [0.0f64; SAMPLES];
            line.fill_with(|| NOISE * (random.random::<f64>() - 0.5));
            for &(x, z, amplitude) in &scatterers {
                let aside = (x - beam_x) / BEAM_WIDTH;
                if aside.abs() > 3.0 {
                    continue;
                }
                let receive = ((x - element_x) * (x - element_x) + z * z).sqrt();
                let echo = (z + receive) / SOUND_SPEED - START;
                let amplitude = amplitude * libm::exp(-aside * aside);
                add_pulse(&mut line, echo, amplitude);
            }
            for (sample, &value) in samples.iter_mut().zip(&line) {
                *sample = value as f32;
            }
        }
    }
    ChannelData {
        t0: vec![START; BEAMS],
        ..ChannelData::linear(
            rf,
            element_x,
            Transmits::focused(beam_x, FOCUS),
            ([SAMPLING_RATE, CENTRE_FREQUENCY], SOUND_SPEED),
        )
    }
}

/// Adds a Gaussian pulse `centre` s after the first sample.
fn add_pulse(line: &mut [f64], centre: f64, amplitude: f64) {
    let reach = 3.5 * PULSE_WIDTH;
    let sample = |time: f64| (time * SAMPLING_RATE).max(0.0) as usize;
    let (first, end) = (sample(centre - reach), sample(centre + reach) + 1);
    for (n, value) in line.iter_mut().enumerate().take(end).skip(first) {
        let t = n as f64 / SAMPLING_RATE - centre;
        let envelope = libm::exp(-(t / PULSE_WIDTH) * (t / PULSE_WIDTH));
        *value += amplitude * envelope * libm::cos(2.0 * PI * CENTRE_FREQUENCY * t);
    }
}
