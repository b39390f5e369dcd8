//! From lines of a fan to pixels.
//!
//! Grey levels are finite, 0 to 255, with the same bits for every instruction set.

#![no_main]

use arbitrary::Arbitrary;
use bonebeam::Error;
use bonebeam::geometry::Axis;
use bonebeam::image::{BMode, BModeParameters, Fan, Logarithm, PixelGrid};
use bonebeam::simd::{InstructionSet, Task, Vector};
use bonebeam_fuzz::{finite_bits, instruction_set, samples, within};
use libfuzzer_sys::fuzz_target;

#[derive(Arbitrary, Debug)]
struct Input {
    /// Whether to take the next numbers directly, or as fractions of usual ranges.
    wild: bool,
    numbers: [f64; 10],
    counts: [u8; 4],
    dynamic_range: f32,
    polynomial: bool,
    median: bool,
    set: u8,
    any_bits: bool,
    exponent: i8,
    data: Vec<u8>,
}

/// Usual ranges of the numbers.
///
/// In order: first angle, angle step, first depth, depth step, corner and pixel, the fan's centre and radius.
const USUAL: [[f64; 2]; 10] = [
    [-0.8, 0.0],
    [1e-3, 0.2],
    [0.0, 1e-2],
    [1e-4, 2e-3],
    [-0.02, 0.0],
    [0.0, 0.02],
    [1e-4, 4e-3],
    [-0.01, 0.01],
    [-0.05, 0.0],
    [0.0, 0.05],
];

fuzz_target!(|input: Input| {
    let mut numbers = input.numbers;
    if !input.wild {
        for (number, usual) in numbers.iter_mut().zip(USUAL) {
            *number = within(*number, usual);
        }
    }
    let [
        angle,
        angle_step,
        depth,
        depth_step,
        x0,
        z0,
        pixel,
        x,
        z,
        radius,
    ] = numbers;
    let [lines, depths, rows, columns] = input.counts.map(|count| usize::from(count) % 12);
    let axis = |first, step, count| Axis { first, step, count };
    let parameters = BModeParameters {
        lines: axis(angle, angle_step, lines),
        samples: axis(depth, depth_step, depths),
        grid: PixelGrid {
            rows,
            columns,
            x0,
            z0,
            pixel,
        },
        dynamic_range: input.dynamic_range,
        logarithm: match input.polynomial {
            true => Logarithm::Polynomial,
            false => Logarithm::Exact,
        },
        median: input.median,
    };
    let Ok(b_mode) = BMode::of_fan(parameters, Fan { x, z, radius }) else {
        return;
    };
    let envelopes: Vec<f32> = samples(
        &input.data,
        b_mode.envelopes_len(),
        input.any_bits,
        input.exponent,
    )
    .into_iter()
    .map(f32::abs)
    .collect();
    let of = |set: InstructionSet| {
        let pixels = set.dispatch(Pixels {
            b_mode: &b_mode,
            envelopes: &envelopes,
        });
        // An error may hold a NaN, which differs from itself.
        let pixels = pixels.map_err(|e| format!("{e:?}"))?;
        // As in `image`: interpolation rounds.
        let highest = 255.0 * (1.0 + 4.0 * f32::EPSILON);
        let beyond = pixels
            .iter()
            .find(|pixel| !(0.0..=highest).contains(*pixel));
        assert_eq!(beyond, None, "a grey level beyond 0 to 255");
        Ok::<_, String>(finite_bits(&pixels))
    };
    let set = instruction_set(input.set);
    assert_eq!(of(InstructionSet::Scalar), of(set), "{}", set.name());
});

struct Pixels<'a> {
    b_mode: &'a BMode,
    envelopes: &'a [f32],
}

impl Task for Pixels<'_> {
    type Output = Result<Vec<f32>, Error>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let mut work = vec![f32::NAN; self.b_mode.need().real];
        let mut pixels = vec![f32::NAN; self.b_mode.parameters().grid.pixels()];
        self.b_mode
            .image(zero, self.envelopes, &mut work, &mut pixels)?;
        Ok(pixels)
    }
}
