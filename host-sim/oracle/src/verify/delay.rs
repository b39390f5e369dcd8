//! The delay stage of focused channel data against the f32 reference.

use bonebeam::delay::hilbert_taps;
use bonebeam::prelude::stages::*;
use ndarray::{Array3, Axis};
use num_complex::Complex;
use rayon::prelude::*;

use crate::reference;
use bonebeam_drive::delay::DelayStage;
use bonebeam_files::ChannelData;

use super::Bits;

/// Compares every `step`-th beam of the samples `x` `[beam, sample, element]`.
///
/// The first beam of `x` is the stage's beam `first`. Transmits must be focused, one per beam.
pub fn check(
    data: &ChannelData,
    stage: &DelayStage<'_>,
    output_rate: f64,
    x: &Array3<Complex<f32>>,
    first: usize,
    step: usize,
) -> Bits {
    let parameters = DelayParameters {
        sound_speed: stage.sound_speed(),
        sampling_rate: data.fs,
        centre_frequency: data.f0,
        output_rate,
        output_start: stage.start(),
        output_samples: stage.samples(),
        elements: data.element_x.len(),
        record_samples: data.samples.dim().3,
        hilbert_taps: hilbert_taps(output_rate, data.f0),
    };
    let beams: Vec<usize> = (0..x.dim().0).step_by(step).collect();
    let compared = beams.par_iter().map(|&index| {
        let beam = first + index;
        let line = ScanLine {
            transmit: Transmit {
                law: TransmitLaw::Focused,
                t0: data.t0[beam],
            },
            ray: Ray::down(stage.beam_x()[beam]),
            array: Array::LinearAt(&data.element_x),
            // The last sample's active elements include those of all shallower ones.
            active: stage.active(beam, stage.samples() - 1),
            compounding: Compounding::Replace,
        };
        let rf = data.samples.rf(0).expect("simulated RF");
        let rf = rf.index_axis(Axis(0), beam);
        let rf = rf.as_standard_layout();
        let mut expected = vec![Complex::new(0.0, 0.0); x.dim().1 * x.dim().2];
        reference::f32::delay::line(
            &parameters,
            &line,
            rf.as_slice().unwrap_or_default(),
            &mut expected,
        );
        let line = x.index_axis(Axis(0), index);
        Bits::complex(line.as_slice().unwrap_or_default(), &expected)
    });
    compared.reduce(Bits::default, Bits::plus)
}
