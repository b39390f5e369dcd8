//! The delay stage with any parameters: it refuses them, or puts out finite samples whose bits do not
//! depend on the instruction set.

#![no_main]

use arbitrary::Arbitrary;
use bonebeam::focus::{Compounding, Delay, DelayParameters, Record, ScanLine};
use bonebeam::geometry::{Active, Array, Ray, Transmit, TransmitLaw};
use bonebeam::simd::{InstructionSet, Task, Vector};
use bonebeam::{Complex, Error};
use bonebeam_fuzz::{finite_complex_bits, samples};
use libfuzzer_sys::fuzz_target;

#[derive(Arbitrary, Debug)]
struct Input {
    /// Whether the numbers that follow are taken as they are, or as parts of what is usual.
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
    record_samples: u16,
    hilbert_taps: u8,
    first: u8,
    count: u8,
    add: bool,
    any_bits: bool,
    exponent: i8,
    data: Vec<u8>,
}

/// A number between the two: where the input's lies in its range.
fn within(number: f64, [least, most]: [f64; 2]) -> f64 {
    let share = number.to_bits() as f64 / u64::MAX as f64;
    least + share * (most - least)
}

fuzz_target!(|input: Input| {
    let number = |number: f64, usual: [f64; 2]| match input.wild {
        true => number,
        false => within(number, usual),
    };
    let elements = 1 + usize::from(input.elements) % 20;
    let record_samples = 1 + usize::from(input.record_samples) % 400;
    let parameters = DelayParameters {
        sound_speed: number(input.sound_speed, [300.0, 4000.0]),
        sampling_rate: number(input.sampling_rate, [10e6, 200e6]),
        centre_frequency: number(input.centre_frequency, [1e6, 10e6]),
        output_rate: number(input.output_rate, [5e6, 60e6]),
        output_start: number(input.output_start, [-1e-6, 20e-6]),
        output_samples: usize::from(input.output_samples) % 100,
        elements,
        record_samples,
        hilbert_taps: usize::from(input.hilbert_taps),
    };
    let Ok(delay) = Delay::new(parameters) else {
        return;
    };
    let rf = samples(
        &input.data,
        elements * record_samples,
        input.any_bits,
        input.exponent,
    );
    let Ok(record) = Record::new(&rf, elements) else {
        return;
    };
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
            first: usize::from(input.first),
            count: usize::from(input.count),
        },
        compounding: Compounding::Replace,
    };
    let again = input.add.then_some(ScanLine {
        compounding: Compounding::Add,
        ..line
    });
    let of = |set: InstructionSet| {
        set.dispatch(Lined {
            delay: &delay,
            line: &line,
            again: again.as_ref(),
            record: &record,
        })
    };
    // An error may hold a NaN, which differs from itself.
    let of = |set| {
        of(set)
            .map(|x| finite_complex_bits(&x))
            .map_err(|e| format!("{e:?}"))
    };
    let expected = of(InstructionSet::Scalar);
    for set in InstructionSet::available() {
        assert_eq!(expected, of(set), "{}", set.name());
    }
});

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
        // What is in the memory does not matter.
        let mut scratch = vec![f32::NAN; parameters.scratch_len(V::LANES)];
        let mut x =
            vec![Complex::new(f32::NAN, f32::NAN); parameters.output_samples * parameters.elements];
        for line in [self.line].into_iter().chain(self.again) {
            self.delay
                .line(zero, line, self.record, &mut scratch, &mut x)?;
        }
        Ok(x)
    }
}
