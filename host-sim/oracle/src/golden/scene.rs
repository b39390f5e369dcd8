//! The scene of the golden vectors: lines of 16 elements each.
//!
//! They are parts of the recording of `verify`.

use bonebeam::beamform::Parameters;
use bonebeam::delay::hilbert_taps;
use bonebeam::prelude::stages::*;
use ndarray::Axis;

use crate::verify::recording::recording;
use bonebeam_files::{ChannelData, Transmits};

/// Number of lines.
pub const LINES: usize = 12;
/// Elements of each line.
pub const ELEMENTS: usize = 16;
/// L: half of the elements.
pub const SUBAPERTURE: usize = 8;
/// Samples of a line, at 20 MHz.
pub const SAMPLES: usize = 96;
pub const OUTPUT_RATE: f64 = 20e6;
/// The depth of a line's first sample, m.
pub const START: f64 = 7.2e-3;
/// Lines whose intermediate values are given: the middle ones.
pub const TRACED: [usize; 2] = [5, 6];
/// Side of the image, pixels.
pub const SIDE: usize = 64;
/// Dynamic range of the image, dB.
pub const DYNAMIC_RANGE: f32 = 50.0;
/// Scales of phase symmetry.
pub const SCALES: [f64; 2] = [1.0 / 8.0, 1.0 / 16.0];
pub const THRESHOLD: f32 = 3.0;
pub const STRIP: usize = 16;

/// Parameters of a method, with K = 2 and Δ = 0.05.
pub fn parameters(method: Method, covariance: Covariance) -> Parameters {
    Parameters {
        covariance,
        temporal_half_window: 2,
        subaperture_ratio: SUBAPERTURE as f64 / ELEMENTS as f64,
        ..Parameters::of(method)
    }
}

/// Recording of the elements of one line.
pub struct LineRecord {
    /// Lateral position of the line, m.
    pub x: f64,
    /// Lateral positions of its elements, m.
    pub element_x: Vec<f64>,
    /// `[element][sample]`.
    pub rf: Vec<f32>,
    /// Time of sample 0, s.
    pub t0: f64,
}

pub fn records() -> (ChannelData, Vec<LineRecord>) {
    let data = recording();
    let records = {
        let frame = data.samples.rf(0);
        let frame = frame.expect("a recording of RF");
        let Transmits::Focused { x: beams, .. } = &data.transmits else {
            unreachable!("the recording has focused beams");
        };
        let record = |line: usize| {
            let middle = data.element_x.partition_point(|&x| x < beams[line]);
            let first = (middle.saturating_sub(ELEMENTS / 2)).min(data.element_x.len() - ELEMENTS);
            LineRecord {
                x: beams[line],
                element_x: data.element_x[first..first + ELEMENTS].to_vec(),
                rf: frame
                    .index_axis(Axis(0), line)
                    .outer_iter()
                    .skip(first)
                    .take(ELEMENTS)
                    .flat_map(|samples| samples.to_vec())
                    .collect(),
                t0: data.t0[line],
            }
        };
        (0..LINES).map(record).collect()
    };
    (data, records)
}

/// The delay stage of a line.
pub fn delay(data: &ChannelData) -> DelayParameters {
    DelayParameters {
        sound_speed: data.c,
        sampling_rate: data.fs,
        centre_frequency: data.f0,
        output_rate: OUTPUT_RATE,
        output_start: 2.0 * START / data.c,
        output_samples: SAMPLES,
        elements: ELEMENTS,
        record_samples: data.samples.dim().3,
        hilbert_taps: hilbert_taps(OUTPUT_RATE, data.f0),
    }
}
