//! Every beamformer, postfilter and covariance.
//!
//! The lanes of every instruction set, in used memory, have the bits of one lane in new memory. Finite samples give
//! finite lines.

#![no_main]

use arbitrary::Arbitrary;
use bonebeam::beamform::{
    AlignedLine, Apodization, Beamformer, Method, Parameter, Parameters, Postfilter, Segment,
    Sizes, Workspace, constant_segments,
};
use bonebeam::covariance::Covariance;
use bonebeam::geometry::Active;
use bonebeam::memory::Scratch;
use bonebeam::simd::{InstructionSet, Task, Vector};
use bonebeam::{Complex, Error};
use bonebeam_fuzz::{complex, finite_complex_bits, instruction_set, size, within};
use libfuzzer_sys::fuzz_target;

#[derive(Arbitrary, Debug)]
struct Input {
    /// Whether to take the next numbers directly, or as fractions of usual ranges.
    wild: bool,
    argument: f32,
    values: [f32; Parameters::TABLE.len()],
    elements: u8,
    samples: u8,
    count: u8,
    first_samples: [u8; 4],
    method: u8,
    postfilter: u8,
    apodization: u8,
    forward: bool,
    set: u8,
    other_runs_before: bool,
    any_bits: bool,
    exponent: i8,
    data: Vec<u8>,
}

fuzz_target!(|input: Input| {
    let elements = size(input.elements, 8, 20);
    let samples = size(input.samples, 4, 12);
    let count = usize::from(input.count) % (elements + 1);
    let number = |number: f32, row: &Parameter| match (input.wild, row.whole) {
        (true, _) => number.into(),
        (false, true) => within(number.into(), [row.range.least, 9.0]).floor(),
        (false, false) => within(number.into(), [row.range.least + 1e-3, 1.0]),
    };
    let method = Method::EXAMPLES[usize::from(input.method) % Method::EXAMPLES.len()];
    let postfilter =
        Postfilter::EXAMPLES[usize::from(input.postfilter) % Postfilter::EXAMPLES.len()];
    let apodization =
        Apodization::EXAMPLES[usize::from(input.apodization) % Apodization::EXAMPLES.len()];
    let mut parameters = Parameters {
        method: match method.parameter() {
            Some(row) => method.with_argument(number(input.argument, &row)),
            None => method,
        },
        covariance: match input.forward {
            true => Covariance::Forward,
            false => Covariance::ForwardBackward,
        },
        postfilter,
        apodization,
        ..Parameters::DEFAULT
    };
    for (row, value) in Parameters::TABLE.iter().zip(input.values) {
        let set = parameters.set(row.name, number(value, row));
        set.expect("a row's name");
    }
    parameters.temporal_half_window %= samples + 1;
    let Ok(beamformer) = Beamformer::new(parameters) else {
        return;
    };
    let x = complex(
        &input.data,
        elements * samples,
        input.any_bits,
        input.exponent,
    );
    let line = AlignedLine::new(&x, elements).expect("finite samples of whole rows");
    let set = instruction_set(input.set);
    let segments: Vec<Segment> = (0..set.dispatch(Width))
        .map(|k| Segment {
            line,
            first_element: k % (elements - count + 1),
            first_sample: usize::from(input.first_samples[k % 4]) % samples,
        })
        .collect();
    let lines = LinesTask {
        beamformer,
        segments: &segments,
        count,
        samples,
        memory: Content::New,
    };
    let expected = InstructionSet::Scalar.dispatch(lines);
    let memory = match input.other_runs_before {
        true => Content::OfOtherRuns,
        false => Content::NaN,
    };
    let found = set.dispatch(LinesTask { memory, ..lines });
    assert_eq!(bits(&expected), bits(&found), "{}", set.name());
    if expected.is_ok() {
        line_is_segments(lines);
    }
});

/// Number of lanes.
struct Width;

impl Task for Width {
    type Output = usize;

    fn run<V: Vector>(self, _: V) -> usize {
        V::LANES
    }
}

/// A whole line whose elements change half-way has the bits of its segments.
fn line_is_segments(lines: LinesTask<'_>) {
    let LinesTask {
        beamformer,
        segments,
        count,
        samples,
        ..
    } = lines;
    let line = segments[0].line;
    let active = |sample: usize| Active {
        first: match sample < samples / 2 {
            true => 0,
            false => line.elements() - count,
        },
        count,
    };
    let mut memory = Memory::new(0.0, beamformer.sizes(count), f32::NAN);
    let outputs = |samples| beamformer.parameters().line_samples(samples);
    let mut z = vec![Complex::ZERO; outputs(samples)];
    if beamformer
        .line(&mut memory.view(), line, active, &mut z)
        .is_err()
    {
        return;
    }
    let mut by_runs = vec![Complex::ZERO; outputs(samples)];
    for (first_sample, samples, active) in constant_segments(samples, active) {
        let segment = Segment {
            line,
            first_element: active.first,
            first_sample,
        };
        let z = &mut by_runs[outputs(first_sample)..outputs(first_sample + samples)];
        let segments = beamformer.segments(&mut memory.view(), &[segment], active.count, &mut [z]);
        segments.expect("what a line takes");
    }
    assert_eq!(
        finite_complex_bits(&z),
        finite_complex_bits(&by_runs),
        "a line against its segments"
    );
}

/// Compares errors as text, since a NaN in an error differs from itself.
fn bits(lines: &Result<Vec<Complex<f32>>, Error>) -> Result<Vec<u32>, String> {
    let bits = lines.as_ref().map(|lines| finite_complex_bits(lines));
    bits.map_err(|error| format!("{error:?}"))
}

/// Contents of memory before use, which must have no effect.
#[derive(Clone, Copy)]
enum Content {
    New,
    NaN,
    OfOtherRuns,
}

/// One segment for each lane at a time.
#[derive(Clone, Copy)]
struct LinesTask<'a> {
    beamformer: Beamformer,
    segments: &'a [Segment<'a>],
    count: usize,
    samples: usize,
    memory: Content,
}

impl Task for LinesTask<'_> {
    type Output = Result<Vec<Complex<f32>>, Error>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let sizes = self.beamformer.sizes(self.count);
        let larger = Sizes {
            elements: sizes.elements + 3,
            subaperture: sizes.subaperture + 2,
            temporal_half_window: sizes.temporal_half_window + 1,
            ..sizes
        };
        let mut memory = match self.memory {
            Content::New => Memory::new(zero, sizes, 0.0),
            Content::NaN | Content::OfOtherRuns => Memory::new(zero, larger, f32::NAN),
        };
        if let Content::OfOtherRuns = self.memory {
            // In another order, so that every lane has other data.
            let mut others = self.segments.to_vec();
            others.reverse();
            self.pass(&mut memory, &others)?;
        }
        self.pass(&mut memory, self.segments)
    }
}

impl LinesTask<'_> {
    fn pass<V: Vector>(
        self,
        memory: &mut Memory<V>,
        segments: &[Segment],
    ) -> Result<Vec<Complex<f32>>, Error> {
        let mut lines = Vec::new();
        for segments in segments.chunks(V::LANES) {
            let mut z: Vec<Vec<_>> = segments
                .iter()
                .map(|segment| {
                    let outputs = |samples| self.beamformer.parameters().line_samples(samples);
                    let before = outputs(segment.first_sample);
                    vec![Complex::ZERO; outputs(self.samples) - before]
                })
                .collect();
            let mut slices: Vec<_> = z.iter_mut().map(|z| z.as_mut_slice()).collect();
            self.beamformer
                .segments(&mut memory.view(), segments, self.count, &mut slices)?;
            lines.extend(z.into_iter().flatten());
        }
        Ok(lines)
    }
}

/// A beamformer's memory, filled with one number.
struct Memory<V> {
    zero: V,
    sizes: Sizes,
    real: Vec<V>,
    complex: Vec<Complex<V>>,
}

impl<V: Vector> Memory<V> {
    fn new(zero: V, sizes: Sizes, content: f32) -> Self {
        let need = sizes.need();
        let content = zero.splat(content);
        Memory {
            zero,
            sizes,
            real: vec![content; need.real],
            complex: vec![Complex::new(content, content); need.complex],
        }
    }

    fn view(&mut self) -> Workspace<'_, V> {
        let scratch = Scratch {
            real: &mut self.real,
            complex: &mut self.complex,
        };
        Workspace::new(self.zero, self.sizes, scratch).expect("memory of the length needed")
    }
}
