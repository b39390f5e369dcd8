//! Records upsampled once and interpolated along lines.
//!
//! Samples are finite, with the same bits for every instruction set.

#![no_main]

use std::cell::RefCell;

use arbitrary::Arbitrary;
use bonebeam::delay::{Compounding, Contribution, Delay, DelayParameters, ScanLine, Upsampled};
use bonebeam::geometry::{Active, Array, Ray, Transmit, TransmitLaw};
use bonebeam::simd::{InstructionSet, Task, Vector};
use bonebeam::{Complex, Error};
use bonebeam_fuzz::{finite_bits, instruction_set, samples, size, within};
use libfuzzer_sys::fuzz_target;

#[derive(Arbitrary, Debug)]
struct Input {
    /// Whether to take the next numbers directly, or as fractions of usual ranges.
    wild: bool,
    numbers: [f64; 6],
    plane: bool,
    sizes: [u8; 3],
    active: [u8; 2],
    set: u8,
    any_bits: bool,
    exponent: i8,
    data: Vec<u8>,
}

/// Usual ranges of sound speed, start, `t0`, line, pitch and angle.
const USUAL: [[f64; 2]; 6] = [
    [300.0, 4000.0],
    [-1e-6, 3e-6],
    [-5e-6, 5e-6],
    [-0.02, 0.02],
    [1e-5, 2e-3],
    [-1.0, 1.0],
];

/// The stage, kept because its filter takes longer to make than a line.
const PARAMETERS: DelayParameters = DelayParameters {
    sound_speed: 1540.0,
    sampling_rate: 20e6,
    centre_frequency: 5e6,
    output_rate: 20e6,
    output_start: 0.0,
    output_samples: 1,
    elements: 1,
    record_samples: 1,
    hilbert_taps: 15,
};

thread_local! {
    static STAGE: RefCell<Delay> = RefCell::new(Delay::new(PARAMETERS).expect("usual rates"));
}

fuzz_target!(|input: Input| {
    let mut numbers = input.numbers;
    if !input.wild {
        for (number, usual) in numbers.iter_mut().zip(USUAL) {
            *number = within(*number, usual);
        }
    }
    let [sound_speed, output_start, t0, x, pitch, angle] = numbers;
    let elements = size(input.sizes[0], 4, 20);
    let parameters = DelayParameters {
        sound_speed,
        output_start,
        output_samples: size(input.sizes[1], 24, 100),
        elements,
        record_samples: size(input.sizes[2], 32, 200),
        ..PARAMETERS
    };
    let array: Vec<f64> = (0..elements).map(|m| m as f64 * pitch).collect();
    let line = ScanLine {
        transmit: Transmit {
            law: match input.plane {
                true => TransmitLaw::Plane { angle },
                false => TransmitLaw::Focused,
            },
            t0,
        },
        ray: Ray::down(x),
        array: Array::LinearAt(&array),
        active: Active {
            first: usize::from(input.active[0]) % 8,
            count: usize::from(input.active[1]) % 24,
        },
        compounding: Compounding::Replace,
    };
    STAGE.with_borrow_mut(|delay| {
        if delay.set(parameters).is_err() {
            return;
        }
        let Ok(upsampled) = Upsampled::new(delay) else {
            return;
        };
        let rf = samples(
            &input.data,
            elements * parameters.record_samples,
            input.any_bits,
            // Sums must not overflow: records are at most 2¹⁰⁰.
            input.exponent.min(80),
        );
        if rf.iter().any(|x| x.abs() > 1e30) {
            return;
        }
        let of = |set: InstructionSet| {
            let line = set.dispatch(Lined {
                upsampled: &upsampled,
                parameters: &parameters,
                line: &line,
                rf: &rf,
            });
            line.map_err(|e| format!("{e:?}"))
        };
        let set = instruction_set(input.set);
        assert_eq!(of(InstructionSet::Scalar), of(set), "{}", set.name());
    });
});

struct Lined<'a> {
    upsampled: &'a Upsampled<'a>,
    parameters: &'a DelayParameters,
    line: &'a ScanLine<'a>,
    rf: &'a [f32],
}

impl Task for Lined<'_> {
    type Output = Result<Vec<u32>, Error>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let Lined {
            upsampled,
            parameters,
            line,
            rf,
        } = self;
        let full = |length| vec![f32::NAN; length];
        let (mut scratch, mut record) = (full(upsampled.need().real), full(upsampled.record_len()));
        let length = upsampled.line_len();
        let (mut centre, mut delays) = (vec![i32::MAX; length], vec![i32::MAX; length]);
        upsampled.centre(line, &mut centre)?;
        let mut lines = vec![0.0; line.active.count * length];
        for (k, values) in lines.chunks_exact_mut(length).enumerate() {
            let element = line.active.first + k;
            let at = element.min(parameters.elements - 1) * parameters.record_samples;
            let samples = &rf[at..at + parameters.record_samples];
            upsampled.record(zero, samples, &mut scratch, &mut record)?;
            finite_bits(&record);
            upsampled.receive_delays(zero, line, element, &mut delays)?;
            let contribution = Contribution {
                record: &record,
                centre: &centre,
                receive_delays: &delays,
            };
            upsampled.add(zero, &contribution, values)?;
        }
        let nan = Complex::new(f32::NAN, f32::NAN);
        let mut out = vec![nan; parameters.output_samples * parameters.elements];
        let mut scratch = full(parameters.need(V::LANES).real);
        upsampled.analytic(zero, line, &lines, &mut scratch, &mut out)?;
        let parts: Vec<f32> = out.iter().flat_map(|x| [x.re, x.im]).collect();
        Ok(finite_bits(&parts))
    }
}
