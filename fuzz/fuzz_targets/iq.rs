//! The delay stage of I/Q with any parameters.
//!
//! It refuses them, or outputs finite samples with the same bits for every instruction set.

#![no_main]

use arbitrary::Arbitrary;
use bonebeam::delay::{
    Compounding, IqDelay, IqInterpolation, IqLayout, IqParameters, IqRecord, IqSamples, ScanLine,
    Stage,
};
use bonebeam::geometry::{Active, Array, Ray, Transmit, TransmitLaw};
use bonebeam::simd::{InstructionSet, Task, Vector};
use bonebeam::{Complex, Error};
use bonebeam_fuzz::{complex, finite_complex_bits, instruction_set, size, within};
use libfuzzer_sys::fuzz_target;

#[derive(Arbitrary, Debug)]
struct Input {
    /// Whether to take the next numbers directly, or as fractions of usual ranges.
    wild: bool,
    numbers: [f64; 9],
    interpolation: u8,
    counts: bool,
    interleaved: bool,
    plane: bool,
    sizes: [u8; 3],
    active: [u8; 2],
    set: u8,
    any_bits: bool,
    exponent: i8,
    data: Vec<u8>,
}

/// Usual ranges of the numbers.
///
/// In order: sound speed, rates, demodulation frequency, start, `t0`, line, pitch, angle and phase.
const USUAL: [[f64; 2]; 9] = [
    [300.0, 4000.0],
    [2e6, 40e6],
    [1e6, 10e6],
    [2e6, 40e6],
    [-1e-6, 3e-6],
    [-5e-6, 5e-6],
    [-0.02, 0.02],
    [1e-5, 2e-3],
    [-1.0, 1.0],
];

fuzz_target!(|input: Input| {
    let mut numbers = input.numbers;
    if !input.wild {
        for (number, usual) in numbers.iter_mut().zip(USUAL) {
            *number = within(*number, usual);
        }
    }
    let [
        sound_speed,
        sampling_rate,
        demodulation_frequency,
        output_rate,
        output_start,
        t0,
        x,
        pitch,
        angle,
    ] = numbers;
    let elements = size(input.sizes[0], 4, 20);
    let record_samples = size(input.sizes[1], 32, 200);
    let interpolations = [
        IqInterpolation::Linear,
        IqInterpolation::Cubic,
        IqInterpolation::Sinc,
        IqInterpolation::LinearFixed,
    ];
    let Ok(delay) = IqDelay::new(IqParameters {
        sound_speed,
        sampling_rate,
        demodulation_frequency,
        output_rate,
        output_start,
        output_samples: size(input.sizes[2], 24, 100),
        elements,
        record_samples,
        interpolation: interpolations[usize::from(input.interpolation % 4)],
    }) else {
        return;
    };
    let numbers = complex(
        &input.data,
        elements * record_samples,
        input.any_bits,
        input.exponent,
    );
    let counts: Vec<[i16; 2]> = numbers.iter().map(|x| [x.re as i16, x.im as i16]).collect();
    let samples = match input.counts {
        true => IqSamples::Counts(&counts, f32::from(input.exponent).exp2()),
        false => IqSamples::Float(&numbers),
    };
    let layout = match input.interleaved {
        true => IqLayout::Interleaved,
        false => IqLayout::Planar,
    };
    let Ok(record) = IqRecord::new(samples, layout, elements) else {
        return;
    };
    let Ok(record) = record.with_phase(angle) else {
        return;
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
    // An error may hold a NaN, which differs from itself.
    let of = |set: InstructionSet| {
        let line = set.dispatch(Lined {
            delay: &delay,
            line: &line,
            record: &record,
        });
        line.map(|x| finite_complex_bits(&x))
            .map_err(|e| format!("{e:?}"))
    };
    let set = instruction_set(input.set);
    assert_eq!(of(InstructionSet::Scalar), of(set), "{}", set.name());
});

struct Lined<'a> {
    delay: &'a IqDelay,
    line: &'a ScanLine<'a>,
    record: &'a IqRecord<'a>,
}

impl Task for Lined<'_> {
    type Output = Result<Vec<Complex<f32>>, Error>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let parameters = self.delay.parameters();
        // The former contents of the memory have no effect.
        let mut scratch = vec![f32::NAN; parameters.need(V::LANES).real];
        let nan = Complex::new(f32::NAN, f32::NAN);
        let mut x = vec![nan; parameters.output_samples * parameters.elements];
        self.delay
            .line(zero, self.line, self.record, &mut scratch, &mut x)?;
        Ok(x)
    }
}
