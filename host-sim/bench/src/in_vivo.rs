//! The paper's frame in vivo.

use bonebeam::beamform::Parameters;
use bonebeam::pipeline;
use bonebeam::prelude::stages::*;
use bonebeam_drive::phase_symmetry;

/// Side of the image in which bone is sought, pixels.
const PIXELS: usize = 512;
/// Dynamic range, dB.
const DYNAMIC_RANGE: f32 = 60.0;

/// The paper's array and its frame of a back in vivo.
pub(super) struct InVivo;

impl InVivo {
    pub(super) const ELEMENTS: usize = 128;
    pub(super) const PITCH: f64 = 0.308e-3;
    pub(super) const SOUND_SPEED: f64 = 1540.0;
    pub(super) const RATE: f64 = 20e6;
    pub(super) const DEPTH: f64 = 40e-3;
    pub(super) const BEAMS: usize = 256;
    /// Sampling rate of the recording, Hz.
    pub(super) const SAMPLING_RATE: f64 = 40e6;
    /// Centre frequency, and demodulation frequency of I/Q, Hz.
    const CENTRE_FREQUENCY: f64 = 5e6;

    pub(super) const PARAMETERS: Parameters = Parameters {
        temporal_half_window: 2,
        ..Parameters::of(Method::EsmvRank1)
    };

    /// Settings that its pipelines share.
    ///
    /// The sub-lines of `beamformer` times the lines are [`InVivo::BEAMS`]. Records have `record_samples` samples at
    /// `sampling_rate`, Hz.
    fn parameters(
        beamformer: Parameters,
        record_samples: usize,
        sampling_rate: f64,
    ) -> pipeline::Parameters<'static> {
        let width = (Self::ELEMENTS - 1) as f64 * Self::PITCH;
        let lines = Self::BEAMS / beamformer.sub_lines;
        pipeline::Parameters {
            scan: ScanParameters {
                array: Array::linear(Self::ELEMENTS, Self::PITCH),
                lines: Lines::Even(Axis::centred(lines, width / (lines - 1) as f64)),
                sound_speed: Self::SOUND_SPEED,
                centre_frequency: Self::CENTRE_FREQUENCY,
                sampling_rate,
                record_samples,
                output_rate: Self::RATE,
                start: Depth::Metres(0.0),
                end: Depth::Metres(Self::DEPTH),
                f_number: 1.5,
                min_elements: 8,
            },
            beamformer,
            rows: PIXELS,
            columns: PIXELS,
            dynamic_range: DYNAMIC_RANGE,
            median: true,
            scales: &[1.0 / 128.0, 1.0 / 256.0, 1.0 / 512.0],
            threshold: 15.0,
            strip: phase_symmetry::Parameters::STRIP,
            block: usize::MAX,
        }
    }

    /// The pipeline from RF.
    pub(super) fn pipeline(
        beamformer: Parameters,
        record_samples: usize,
    ) -> Result<Pipeline<'static>, bonebeam::Error> {
        Pipeline::new(Self::parameters(
            beamformer,
            record_samples,
            Self::SAMPLING_RATE,
        ))
    }

    /// The pipeline from I/Q, demodulated and sampled at twice the centre frequency.
    pub(super) fn pipeline_of_iq(
        beamformer: Parameters,
        record_samples: usize,
    ) -> Result<Pipeline<'static, IqDelay>, bonebeam::Error> {
        let parameters = Self::parameters(beamformer, record_samples, 2.0 * Self::CENTRE_FREQUENCY);
        let iq = IqInput {
            demodulation_frequency: Self::CENTRE_FREQUENCY,
            interpolation: None,
        };
        Pipeline::of_iq(parameters, iq)
    }
}
