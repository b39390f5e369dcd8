//! The scan, the records and the lines of a small frame, by RF and by I/Q.

use bonebeam::geometry::Axis as Positions;
use bonebeam::prelude::stages::*;

pub const ELEMENTS: usize = 16;
pub const LINES: usize = 40;
pub const PARAMETERS: Parameters = Parameters {
    scan: ScanParameters {
        array: Array::linear(ELEMENTS, 0.3e-3),
        lines: Lines::Even(Positions::centred(LINES, 0.2e-3)),
        sampling_rate: 40e6,
        record_samples: 700,
        ..ScanParameters::EXAMPLE
    },
    beamformer: beamform::Parameters {
        temporal_half_window: 1,
        ..beamform::Parameters::of(Method::EsmvRank1)
    },
    scales: &[1.0 / 8.0, 1.0 / 16.0, 1.0 / 32.0],
    block: usize::MAX,
    ..Parameters::EXAMPLE
};
/// Its memory.
pub const NEED: Need = valid!(PARAMETERS.need(Input::Rf, 1));

/// Depth of the surface at a lateral position, m.
pub fn surface(x: f64) -> f64 {
    8e-3 + 60.0 * x * x
}

/// The records of one focused line: pulses from the surface around it, and faint noise.
pub fn record(line: usize) -> Vec<f32> {
    let scan = &PARAMETERS.scan;
    let mut noise = 1u32;
    let mut rf: Vec<f32> = (0..ELEMENTS * scan.record_samples)
        .map(|_| {
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            1e-3 * ((noise >> 8) as f32 / 16_777_216.0 - 0.5)
        })
        .collect();
    for (m, rf) in rf.chunks_exact_mut(scan.record_samples).enumerate() {
        for k in -3..=3 {
            let x = scan.lines.x(line) + f64::from(k) * 0.1e-3;
            let path = surface(x) + surface(x).hypot(scan.array.x(m) - x);
            let arrival = path / scan.sound_speed * scan.sampling_rate;
            for (n, rf) in rf.iter_mut().enumerate() {
                let t = (n as f64 - arrival) / scan.sampling_rate * scan.centre_frequency;
                *rf += ((-4.0 * t * t).exp() * (2.0 * std::f64::consts::PI * t).cos()) as f32;
            }
        }
    }
    rf
}

pub fn focused() -> Transmit<'static> {
    Transmit::new(TransmitLaw::Focused, 0.0)
}

pub const DEMODULATION: f64 = 5.2e6;
/// The scan of `PARAMETERS` by a front end with a demodulator.
pub fn iq_parameters(block: usize) -> Parameters<'static> {
    Parameters {
        scan: ScanParameters {
            sampling_rate: 12.5e6,
            record_samples: 220,
            output_rate: 15e6,
            ..PARAMETERS.scan
        },
        block,
        ..PARAMETERS
    }
}

pub fn iq_input(interpolation: Option<IqInterpolation>) -> IqInput {
    IqInput {
        demodulation_frequency: DEMODULATION,
        interpolation,
    }
}

/// The echoes of `record` as counts, `[sample][element]`.
pub fn counts(line: usize) -> Vec<[i16; 2]> {
    let scan = iq_parameters(0).scan;
    let mut noise = 7u32;
    let mut random = || {
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(noise >> 8) / 16_777_216.0 - 0.5
    };
    let mut counts = Vec::new();
    for n in 0..scan.record_samples {
        for m in 0..ELEMENTS {
            let (mut re, mut im) = (4.0 * random(), 4.0 * random());
            for k in -3..=3 {
                let x = scan.lines.x(line) + f64::from(k) * 0.1e-3;
                let path = surface(x) + surface(x).hypot(scan.array.x(m) - x);
                let t = n as f64 / scan.sampling_rate - path / scan.sound_speed;
                let late = t * scan.centre_frequency;
                let angle = 2.0
                    * std::f64::consts::PI
                    * (late - DEMODULATION * n as f64 / scan.sampling_rate);
                re += 2000.0 * (-4.0 * late * late).exp() * angle.cos();
                im += 2000.0 * (-4.0 * late * late).exp() * angle.sin();
            }
            counts.push([re as i16, im as i16]);
        }
    }
    counts
}

pub fn counted(counts: &[[i16; 2]]) -> Record<'_> {
    Record::iq(
        IqSamples::Counts(counts, 0.25),
        IqLayout::Interleaved,
        ELEMENTS,
    )
    .unwrap()
}
