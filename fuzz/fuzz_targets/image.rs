//! From lines to pixels.
//!
//! Grey levels are finite, 0 to 255, with the same bits for every instruction set.

#![no_main]

use arbitrary::Arbitrary;
use bonebeam::Error;
use bonebeam::geometry::Axis;
use bonebeam::image::{BMode, BModeParameters, Logarithm, PixelGrid, envelope};
use bonebeam::simd::{InstructionSet, Task, Vector};
use bonebeam_fuzz::{complex, finite_bits, instruction_set};
use libfuzzer_sys::fuzz_target;

#[derive(Arbitrary, Debug)]
struct Input {
    wild: bool,
    lines: u8,
    samples: u8,
    rows: u8,
    columns: u8,
    numbers: [f64; 7],
    dynamic_range: f32,
    median: bool,
    any_bits: bool,
    exponent: i8,
    set: u8,
    data: Vec<u8>,
}

/// A small number, or one up to 39 for one choice in four.
fn count_of(choice: u8) -> usize {
    match usize::from(choice) {
        choice @ ..192 => choice % 12,
        choice => choice % 40,
    }
}

fuzz_target!(|input: Input| {
    let [
        first_line,
        line_step,
        first_sample,
        sample_step,
        x0,
        z0,
        pixel,
    ] = input.numbers;
    let axis = |first: f64, step: f64, count: u8| Axis {
        first,
        step,
        count: count_of(count),
    };
    let (lines, samples, grid) = match input.wild {
        true => (
            axis(first_line, line_step, input.lines),
            axis(first_sample, sample_step, input.samples),
            PixelGrid {
                rows: count_of(input.rows),
                columns: count_of(input.columns),
                x0,
                z0,
                pixel,
            },
        ),
        false => {
            let lines = axis(-5e-3, 0.3e-3, input.lines);
            let samples = axis(5e-3, 0.1e-3, input.samples);
            let (rows, columns) = (count_of(input.rows), count_of(input.columns));
            (
                lines,
                samples,
                PixelGrid::of_lines(&lines, &samples, rows, columns),
            )
        }
    };
    let parameters = BModeParameters {
        lines,
        samples,
        grid,
        dynamic_range: input.dynamic_range,
        // No field of its own, because a new field would change the meaning of the seeds.
        logarithm: match input.exponent % 2 == 0 {
            true => Logarithm::Exact,
            false => Logarithm::Polynomial,
        },
        median: input.median,
    };
    let Ok(b_mode) = BMode::new(parameters) else {
        return;
    };
    let z = complex(
        &input.data,
        b_mode.envelopes_len(),
        input.any_bits,
        input.exponent,
    );
    let mut envelopes = vec![f32::NAN; z.len()];
    if envelope(&z, &mut envelopes).is_err() {
        return;
    }
    finite_bits(&envelopes);
    let of = |set: InstructionSet| {
        set.dispatch(Pixels {
            b_mode: &b_mode,
            envelopes: &envelopes,
        })
    };
    let expected = of(InstructionSet::Scalar);
    if let Ok(pixels) = &expected {
        // Interpolation rounds: a pixel between two of 255 may be a bit above
        // (seeds/image/one_ulp_above_255).
        let highest = 255.0 * (1.0 + 4.0 * f32::EPSILON);
        let beyond = pixels
            .iter()
            .find(|pixel| !(0.0..=highest).contains(*pixel));
        assert_eq!(beyond, None, "a grey level beyond 0 to 255");
    }
    // An error may hold a NaN, which differs from itself.
    let bits = |pixels: Result<Vec<f32>, Error>| {
        pixels
            .map(|pixels| finite_bits(&pixels))
            .map_err(|e| format!("{e:?}"))
    };
    let expected = bits(expected);
    let set = instruction_set(input.set);
    assert_eq!(expected, bits(of(set)), "{}", set.name());
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
