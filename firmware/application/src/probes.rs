//! The two probes, which the compiler and build.rs share.

use bonebeam::prelude::stages::*;
use bonebeam::{beamform::ShortLagCoherence, surface};
use bonebeam_stream::{Probe, scan};

/// The lines of both: 24, of two directions at every second depth, by MV over subapertures of 8.
const fn parameters(depth: f64) -> Parameters<'static> {
    Parameters {
        scan: ScanParameters {
            array: Array::linear(scan::ELEMENTS, 0.5e-3),
            lines: Lines::Even(Axis::centred(scan::BEAMS, 0.5e-3)),
            sound_speed: 1540.0,
            centre_frequency: 5e6,
            sampling_rate: 10e6,
            record_samples: scan::SAMPLES,
            output_rate: 10e6,
            start: Depth::Metres(5e-3),
            end: Depth::Metres(depth),
            f_number: 1.5,
            min_elements: 8,
        },
        beamformer: beamform::Parameters {
            temporal_half_window: 0,
            sub_lines: 2,
            depth_step: 2,
            ..beamform::Parameters::of(Method::Mv)
        },
        dynamic_range: 60.0,
        ..Parameters::EXAMPLE
    }
}

/// The surface in the lines of a probe, and the coherence that it takes.
pub const fn detector(of: &Parameters<'_>) -> surface::Detector {
    let settings = surface::Settings::COHERENCE;
    valid!(surface::Detector::new(valid!(of.surface(settings))))
}

/// Coherence over half a wavelength and more above and below a sample.
pub const fn coherence(of: &Parameters<'_>) -> ShortLagCoherence {
    ShortLagCoherence::over(0.4e-3, &valid!(Scan::of_iq(of.scan)).depths())
}

/// I/Q as the front end demodulates it, read in fixed point.
const INPUT: IqInput = IqInput {
    demodulation_frequency: 5e6,
    interpolation: Some(IqInterpolation::LinearFixed),
};

/// Defines a probe down to a depth in metres.
macro_rules! probe {
    ($name:ident, $depth:expr) => {
        /// A probe.
        pub enum $name {}

        impl Probe for $name {
            type Stage = IqDelay;
            const PARAMETERS: Parameters<'static> = parameters($depth);
            const NEED: Need = valid!(Self::PARAMETERS.need(Input::Iq, 1));
            const TRANSMIT: Transmit<'static> = Transmit::new(TransmitLaw::Focused, 5e-6);

            fn pipeline() -> Result<Pipeline<'static, IqDelay>, Error> {
                Pipeline::of_iq(Self::PARAMETERS, INPUT)
            }
        }
    };
}

probe!(Deep, 24e-3);
probe!(Shallow, 18e-3);
