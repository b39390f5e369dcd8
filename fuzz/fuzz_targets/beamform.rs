//! Every beamformer and covariance: the lanes of every instruction set have the bits of one lane, a
//! workspace that was used has those of a new one, and finite samples give finite lines.

#![no_main]

use arbitrary::Arbitrary;
use bonebeam::beamform::{AlignedLine, Beamformer, Method, Parameters, Run, Sizes, constant_runs};
use bonebeam::covariance::{Averaging, Forward, ForwardBackward};
use bonebeam::geometry::Active;
use bonebeam::simd::{InstructionSet, Task, Vector};
use bonebeam::{Complex, Error};
use bonebeam_fuzz::{complex, finite_complex_bits};
use host_sim::drive::beamform::Memory;
use libfuzzer_sys::fuzz_target;

/// The most lanes of any instruction set.
const RUNS: usize = 16;

#[derive(Arbitrary, Debug)]
struct Input {
    elements: u8,
    samples: u8,
    count: u8,
    first_samples: [u8; 4],
    temporal: u8,
    method: u8,
    beta: f32,
    rank: u8,
    loading: f32,
    ratio: f32,
    forward: bool,
    any_bits: bool,
    exponent: i8,
    data: Vec<u8>,
}

fuzz_target!(|input: Input| {
    let elements = 1 + usize::from(input.elements) % 20;
    let samples = 1 + usize::from(input.samples) % 12;
    let count = usize::from(input.count) % (elements + 1);
    let parameters = Parameters {
        method: match input.method % 7 {
            0 => Method::Das,
            1 => Method::Mv,
            2 => Method::EsmvRank1,
            3 => Method::EsmvBeta(input.beta),
            4 => Method::EsmvRank(usize::from(input.rank)),
            5 => Method::EsmvRank1Steps(usize::from(input.rank)),
            _ => Method::EsmvExcludeFirst,
        },
        temporal_half_window: usize::from(input.temporal) % 6,
        diagonal_loading: input.loading,
        subaperture_ratio: f64::from(input.ratio),
    };
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
    let runs: Vec<Run> = (0..RUNS)
        .map(|k| Run {
            line,
            first_element: k % (elements - count + 1),
            first_sample: usize::from(input.first_samples[k % 4]) % samples,
        })
        .collect();
    let case = Case {
        beamformer,
        runs: &runs,
        count,
        samples,
    };
    match input.forward {
        true => check::<Forwards>(case),
        false => check::<Both>(case),
    }
});

#[derive(Clone, Copy)]
struct Case<'a> {
    beamformer: Beamformer,
    runs: &'a [Run<'a>],
    count: usize,
    samples: usize,
}

/// An averaging for every vector.
trait Kind: Copy {
    type Of<V: Vector>: Averaging<V>;
}

#[derive(Clone, Copy)]
struct Forwards;
#[derive(Clone, Copy)]
struct Both;

impl Kind for Forwards {
    type Of<V: Vector> = Forward;
}

impl Kind for Both {
    type Of<V: Vector> = ForwardBackward;
}

fn check<K: Kind>(case: Case<'_>) {
    let fresh = |set: InstructionSet| {
        set.dispatch(Lines::<K> {
            case,
            used: false,
            kind: core::marker::PhantomData,
        })
    };
    let used = |set: InstructionSet| {
        set.dispatch(Lines::<K> {
            case,
            used: true,
            kind: core::marker::PhantomData,
        })
    };
    let expected = fresh(InstructionSet::Scalar);
    assert_eq!(
        bits(&expected),
        bits(&used(InstructionSet::Scalar)),
        "a used workspace, one lane"
    );
    for set in InstructionSet::available() {
        assert_eq!(bits(&expected), bits(&fresh(set)), "{}", set.name());
        assert_eq!(
            bits(&expected),
            bits(&used(set)),
            "a used workspace, {}",
            set.name()
        );
    }
    line_is_runs::<K>(case, &expected);
}

/// A whole line, whose elements change half-way, has the bits of its runs.
fn line_is_runs<K: Kind>(case: Case<'_>, expected: &Result<Lined, Error>) {
    let first = case.runs[0];
    if first.first_sample != 0 || expected.is_err() {
        return;
    }
    let elements = first.line.elements();
    let active = |sample: usize| match sample < case.samples / 2 {
        true => Active {
            first: 0,
            count: case.count,
        },
        false => Active {
            first: elements - case.count,
            count: case.count,
        },
    };
    let sizes = case.beamformer.sizes(case.count);
    let mut memory = Memory::<K::Of<f32>, f32>::new(0.0, sizes).expect("small sizes");
    let mut z = vec![Complex::ZERO; case.samples];
    let lined = case
        .beamformer
        .line(&mut memory.view(), first.line, active, &mut z);
    if lined.is_err() {
        return;
    }
    let mut by_runs = vec![Complex::ZERO; case.samples];
    for (first_sample, samples, active) in constant_runs(case.samples, active) {
        let run = Run {
            line: first.line,
            first_element: active.first,
            first_sample,
        };
        let z = &mut by_runs[first_sample..first_sample + samples];
        let runs = case
            .beamformer
            .runs(&mut memory.view(), &[run], active.count, &mut [z]);
        runs.expect("what a line takes");
    }
    assert_eq!(
        finite_complex_bits(&z),
        finite_complex_bits(&by_runs),
        "a line against its runs"
    );
}

type Lined = Vec<Complex<f32>>;

/// An error may hold a NaN, which differs from itself.
fn bits(lines: &Result<Lined, Error>) -> Result<Vec<u32>, String> {
    let bits = lines.as_ref().map(|lines| finite_complex_bits(lines));
    bits.map_err(|error| format!("{error:?}"))
}

struct Lines<'a, K> {
    case: Case<'a>,
    used: bool,
    kind: core::marker::PhantomData<K>,
}

impl<K: Kind> Task for Lines<'_, K> {
    type Output = Result<Lined, Error>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let Case {
            beamformer,
            runs,
            count,
            samples,
        } = self.case;
        let mut sizes = beamformer.sizes(count);
        if self.used {
            sizes = Sizes {
                elements: sizes.elements + 3,
                subaperture: sizes.subaperture + 2,
                temporal_half_window: sizes.temporal_half_window + 1,
            };
        }
        let mut memory = Memory::<K::Of<V>, V>::new(zero, sizes).expect("small sizes");
        let pass = |memory: &mut Memory<K::Of<V>, V>, runs: &[Run]| {
            let mut lines = Vec::new();
            for runs in runs.chunks(V::LANES) {
                let mut z: Vec<Lined> = runs
                    .iter()
                    .map(|run| vec![Complex::ZERO; samples - run.first_sample])
                    .collect();
                let mut slices: Vec<&mut [Complex<f32>]> =
                    z.iter_mut().map(|z| z.as_mut_slice()).collect();
                beamformer.runs(&mut memory.view(), runs, count, &mut slices)?;
                lines.extend(z.into_iter().flatten());
            }
            Ok(lines)
        };
        if self.used {
            // In another order, so that every lane had other data.
            let mut others = runs.to_vec();
            others.reverse();
            others.rotate_left(3);
            pass(&mut memory, &others)?;
        }
        pass(&mut memory, runs)
    }
}
