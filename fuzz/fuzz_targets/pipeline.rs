//! A line from RF or I/Q by the pipeline: finite, and the same bits in blocks of any length.

#![no_main]

use std::cell::RefCell;

use arbitrary::Arbitrary;
use bonebeam::Complex;
use bonebeam::beamform::{Apodization, Method, Parameters, Postfilter, Workspace};
use bonebeam::covariance::Covariance;
use bonebeam::delay::{
    Delay, DelayParameters, IqInterpolation, IqLayout, IqRecord, IqSamples, Record, Stage,
};
use bonebeam::geometry::{Array, Axis, Depth, Lines, Scan, ScanParameters, Transmit, TransmitLaw};
use bonebeam::memory::Scratch;
use bonebeam::pipeline::{DepthGate, IqInput, LinePipeline};
use bonebeam_fuzz::{complex, finite_complex_bits, size, within};
use libfuzzer_sys::fuzz_target;

#[derive(Arbitrary, Debug)]
struct Input {
    numbers: [f64; 6],
    gate: Option<[f64; 2]>,
    iq: bool,
    interpolation: u8,
    plane: bool,
    method: u8,
    postfilter: u8,
    apodization: u8,
    forward: bool,
    half_window: u8,
    elements: u8,
    record_samples: u8,
    line: u8,
    block: u8,
    any_bits: bool,
    exponent: i8,
    data: Vec<u8>,
}

const LINES: usize = 3;

thread_local! {
    /// The stage, kept because its filter takes longer to make than a line.
    static STAGE: RefCell<Option<Delay>> = const { RefCell::new(None) };
}

fuzz_target!(|input: Input| {
    let usual = [
        [300.0, 4000.0],
        [1e-5, 2e-3],
        [0.0, 2e-3],
        [1e-4, 2e-3],
        [0.5, 4.0],
        [-1.0, 1.0],
    ];
    let mut numbers = input.numbers;
    for (number, usual) in numbers.iter_mut().zip(usual) {
        *number = within(*number, usual);
    }
    let [sound_speed, pitch, start, length, f_number, angle] = numbers;
    let elements = size(input.elements, 6, 16);
    let record_samples = size(input.record_samples, 32, 100);
    let parameters = ScanParameters {
        array: Array::linear(elements, pitch),
        lines: Lines::Even(Axis::centred(LINES, pitch)),
        sound_speed,
        centre_frequency: 5e6,
        sampling_rate: 20e6,
        record_samples,
        output_rate: 20e6,
        start: Depth::Metres(start),
        end: Depth::Metres(start + length),
        f_number,
        min_elements: 1,
    };
    // The time of a line grows with its length.
    let Ok(scan) = Scan::new(parameters) else {
        return;
    };
    if scan.samples() > 40 {
        return;
    }
    let beamformer = Parameters {
        method: Method::EXAMPLES[usize::from(input.method) % Method::EXAMPLES.len()],
        postfilter: Postfilter::EXAMPLES
            [usize::from(input.postfilter) % Postfilter::EXAMPLES.len()],
        apodization: Apodization::EXAMPLES
            [usize::from(input.apodization) % Apodization::EXAMPLES.len()],
        covariance: match input.forward {
            true => Covariance::Forward,
            false => Covariance::ForwardBackward,
        },
        temporal_half_window: usize::from(input.half_window) % 4,
        ..Parameters::DEFAULT
    };
    let samples = complex(
        &input.data,
        elements * record_samples,
        input.any_bits,
        input.exponent,
    );
    if input.iq {
        let interpolations = [
            IqInterpolation::Linear,
            IqInterpolation::Cubic,
            IqInterpolation::Sinc,
        ];
        let iq = IqInput {
            demodulation_frequency: 5e6,
            interpolation: Some(interpolations[usize::from(input.interpolation) % 3]),
        };
        let (Ok(pipeline), Ok(record)) = (
            LinePipeline::of_iq(scan, iq, beamformer),
            IqRecord::new(IqSamples::Float(&samples), IqLayout::Planar, elements),
        ) else {
            return;
        };
        return lines(pipeline, &record, &input, angle);
    }
    let rf: Vec<f32> = samples.iter().map(|x| x.re).collect();
    let Ok(record) = Record::new(&rf, elements) else {
        return;
    };
    STAGE.with_borrow_mut(|stage| {
        let parameters = DelayParameters::of(&scan);
        let set = match stage {
            Some(stage) => stage.set(parameters),
            None => Delay::new(parameters).map(|new| *stage = Some(new)),
        };
        let (Ok(()), Some(stage)) = (set, stage) else {
            return;
        };
        if let Ok(pipeline) = LinePipeline::by(stage, scan, beamformer) {
            lines(pipeline, &record, &input, angle);
        }
    });
});

fn lines<'r, D: Stage>(
    pipeline: LinePipeline<'_, D>,
    record: &'r D::Record<'r>,
    input: &Input,
    angle: f64,
) {
    let pipeline = match input.gate {
        None => Ok(pipeline),
        Some([from, to]) => pipeline.with_gate(DepthGate {
            from: within(from, [0.0, 4e-3]),
            to: within(to, [0.0, 4e-3]),
        }),
    };
    let Ok(pipeline) = pipeline else {
        return;
    };
    blocks(&pipeline, record, input, angle);
}

/// The line in one block and in blocks of the input's length.
fn blocks<'r, D: Stage>(
    pipeline: &LinePipeline<'_, D>,
    record: &'r D::Record<'r>,
    input: &Input,
    angle: f64,
) {
    let (samples, elements) = (pipeline.scan().samples(), pipeline.scan().elements());
    let transmit = Transmit {
        law: match input.plane {
            true => TransmitLaw::Plane { angle },
            false => TransmitLaw::Focused,
        },
        t0: 0.0,
    };
    let of = |block: usize| {
        let nan = Complex::new(f32::NAN, f32::NAN);
        let sizes = pipeline.beamformer().sizes(elements);
        let (own, need) = (pipeline.need(1, block), sizes.need());
        let (mut real, mut numbers) = (vec![f32::NAN; need.real], vec![nan; need.complex]);
        let mut workspace = Workspace::new(
            0.0,
            sizes,
            Scratch {
                real: &mut real,
                complex: &mut numbers,
            },
        )
        .expect("memory of the length needed");
        let (mut real, mut numbers) = (vec![f32::NAN; own.real], vec![nan; own.complex]);
        let scratch = Scratch {
            real: &mut real,
            complex: &mut numbers,
        };
        let mut z = vec![nan; samples];
        let line = usize::from(input.line) % LINES;
        pipeline
            .line(line, [(transmit, record)], scratch, &mut workspace, &mut z)
            .map_err(|e| format!("{e:?}"))?;
        Ok::<_, String>(finite_complex_bits(&z))
    };
    assert_eq!(of(samples), of(usize::from(input.block) % (samples + 1)));
}
