//! The delay stage with any parameters.
//!
//! It refuses them, or outputs finite samples with the same bits for every instruction set.

#![no_main]

use std::cell::RefCell;

use arbitrary::Arbitrary;
use bonebeam::delay::{Compounding, Delay, DelayParameters, Record, ScanLine, Stage};
use bonebeam::geometry::{Active, Array, Ray, Transmit, TransmitLaw};
use bonebeam::simd::{InstructionSet, Task, Vector};
use bonebeam::{Complex, Error};
use bonebeam_fuzz::{finite_complex_bits, instruction_set, samples, size, within};
use libfuzzer_sys::fuzz_target;

#[derive(Arbitrary, Debug)]
struct Input {
    /// Whether to take the next numbers directly, or as fractions of usual ranges.
    wild: bool,
    sound_speed: f64,
    sampling_rate: f64,
    centre_frequency: f64,
    output_rate: f64,
    output_start: f64,
    law: u8,
    law_number: f64,
    t0: f64,
    x: f64,
    pitch: f64,
    output_samples: u8,
    elements: u8,
    record_samples: u8,
    /// Chooses a prepared stage, or one of the numbers.
    filter: u8,
    hilbert_taps: u8,
    first: u8,
    count: u8,
    add: bool,
    set: u8,
    any_bits: bool,
    exponent: i8,
    data: Vec<u8>,
}

/// Rate of the record, of the output, and centre frequency, Hz: records are interpolated, filtered, and
/// halved up to three times.
const FILTERS: [[f64; 3]; 6] = [
    [20e6, 20e6, 5e6],
    [20e6, 40e6, 5e6],
    [40e6, 20e6, 5e6],
    [50e6, 20e6, 3e6],
    [100e6, 20e6, 7e6],
    [160e6, 12e6, 2e6],
];

thread_local! {
    /// A stage for each of them, since filters take longer than lines.
    static STAGES: RefCell<Vec<Delay>> = RefCell::new(FILTERS.map(stage).into());
}

fn stage([sampling_rate, output_rate, centre_frequency]: [f64; 3]) -> Delay {
    let parameters = DelayParameters {
        sound_speed: 1540.0,
        sampling_rate,
        centre_frequency,
        output_rate,
        output_start: 0.0,
        output_samples: 1,
        elements: 1,
        record_samples: 1,
        hilbert_taps: 1,
    };
    Delay::new(parameters).expect("usual rates")
}

fuzz_target!(|input: Input| {
    let kept = usize::from(input.filter / 40);
    let [sampling_rate, output_rate, centre_frequency] = match FILTERS.get(kept) {
        Some(filter) => *filter,
        None => [
            number(&input, input.sampling_rate, [10e6, 200e6]),
            number(&input, input.output_rate, [5e6, 60e6]),
            number(&input, input.centre_frequency, [1e6, 10e6]),
        ],
    };
    let parameters = DelayParameters {
        sound_speed: number(&input, input.sound_speed, [300.0, 4000.0]),
        sampling_rate,
        centre_frequency,
        output_rate,
        output_start: number(&input, input.output_start, [-1e-6, 3e-6]),
        output_samples: size(input.output_samples, 24, 100),
        elements: size(input.elements, 4, 20),
        record_samples: size(input.record_samples, 64, 400),
        hilbert_taps: size(input.hilbert_taps, 8, 70) - 1,
    };
    STAGES.with_borrow_mut(|stages| match stages.get_mut(kept) {
        Some(stage) => {
            if stage.set(parameters).is_ok() {
                check(stage, &input);
            }
        }
        None => {
            if let Ok(stage) = Delay::new(parameters) {
                check(&stage, &input);
            }
        }
    });
});

fn number(input: &Input, number: f64, usual: [f64; 2]) -> f64 {
    match input.wild {
        true => number,
        false => within(number, usual),
    }
}

fn check(delay: &Delay, input: &Input) {
    let DelayParameters {
        elements,
        record_samples,
        ..
    } = *delay.parameters();
    let rf = samples(
        &input.data,
        elements * record_samples,
        input.any_bits,
        input.exponent,
    );
    let Ok(record) = Record::new(&rf, elements) else {
        return;
    };
    let number = |value: f64, usual: [f64; 2]| number(input, value, usual);
    let pitch = number(input.pitch, [1e-5, 2e-3]);
    let array: Vec<f64> = (0..elements).map(|m| m as f64 * pitch).collect();
    let line = ScanLine {
        transmit: Transmit {
            law: match input.law % 3 {
                0 => TransmitLaw::Focused,
                1 => TransmitLaw::Plane {
                    angle: number(input.law_number, [-1.0, 1.0]),
                },
                _ => TransmitLaw::Element {
                    x: number(input.law_number, [-0.02, 0.02]),
                    z: 0.0,
                },
            },
            t0: number(input.t0, [-5e-6, 5e-6]),
        },
        ray: Ray::down(number(input.x, [-0.02, 0.02])),
        array: Array::LinearAt(&array),
        active: Active {
            first: usize::from(input.first) % 8,
            count: usize::from(input.count) % 24,
        },
        compounding: Compounding::Replace,
    };
    let again = input.add.then_some(ScanLine {
        compounding: Compounding::Add,
        ..line
    });
    // An error may hold a NaN, which differs from itself.
    let of = |set: InstructionSet| {
        let line = set.dispatch(Lined {
            delay,
            line: &line,
            again: again.as_ref(),
            record: &record,
        });
        line.map(|x| finite_complex_bits(&x))
            .map_err(|e| format!("{e:?}"))
    };
    let set = instruction_set(input.set);
    assert_eq!(of(InstructionSet::Scalar), of(set), "{}", set.name());
}

struct Lined<'a> {
    delay: &'a Delay,
    line: &'a ScanLine<'a>,
    again: Option<&'a ScanLine<'a>>,
    record: &'a Record<'a>,
}

impl Task for Lined<'_> {
    type Output = Result<Vec<Complex<f32>>, Error>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let parameters = self.delay.parameters();
        // The former contents of the memory have no effect.
        let mut scratch = vec![f32::NAN; parameters.need(V::LANES).real];
        let mut x =
            vec![Complex::new(f32::NAN, f32::NAN); parameters.output_samples * parameters.elements];
        for line in [self.line].into_iter().chain(self.again) {
            self.delay
                .line(zero, line, self.record, &mut scratch, &mut x)?;
        }
        Ok(x)
    }
}
