//! Time of one output sample, side by side: `cargo bench -p bonebeam-tests --bench beamform`. Read it
//! as ratios; `host-sim bench` compares with other implementations.

use bonebeam::Complex;
use bonebeam::beamform::{AlignedLine, Beamformer, Method, Parameters, Segment};
use bonebeam::covariance::{Averaging, Covariance, Forward, ForwardBackward};
use bonebeam::simd::{InstructionSet, Task, Vector};
use bonebeam_drive::beamform::Memory;
use divan::{Bencher, black_box};

/// Samples a lane and call.
const SAMPLES: usize = 128;

fn main() {
    divan::main();
}

/// What is timed.
#[derive(Clone, Copy)]
struct Case {
    set: InstructionSet,
    covariance: Covariance,
    method: Method,
    temporal_half_window: usize,
}

impl std::fmt::Display for Case {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (set, covariance) = (self.set.name(), self.covariance);
        write!(
            f,
            "{set}, {covariance:?}, {:?}, K = {}",
            self.method, self.temporal_half_window
        )
    }
}

/// Every instruction set with MV and rank 1; with the fastest also the others.
fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for set in InstructionSet::available() {
        let mut add = |covariance, method, temporal_half_window| {
            cases.push(Case {
                set,
                covariance,
                method,
                temporal_half_window,
            });
        };
        add(Covariance::ForwardBackward, Method::Mv, 0);
        add(Covariance::ForwardBackward, Method::EsmvRank1, 0);
        if set == InstructionSet::detect() {
            add(Covariance::ForwardBackward, Method::Das, 0);
            add(Covariance::ForwardBackward, Method::Mv, 10);
            add(Covariance::ForwardBackward, Method::EsmvBeta(0.01), 0);
            add(Covariance::Forward, Method::Mv, 0);
            add(Covariance::Forward, Method::EsmvRank1, 0);
        }
    }
    cases
}

/// A wave from aside with noise 20 dB below it, as at an echo.
fn wave(elements: usize, seed: u32) -> Vec<Complex<f32>> {
    let mut state = seed;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        0.1 * ((state >> 8) as f32 / (1 << 24) as f32 - 0.5)
    };
    let samples = (0..SAMPLES * elements).map(|i| {
        let phase = 0.1 * (i % elements) as f32 + 0.3 * (i / elements) as f32;
        Complex::new(libm::cosf(phase) + noise(), libm::sinf(phase) + noise())
    });
    samples.collect()
}

struct Timed<'a, 'b> {
    elements: usize,
    case: Case,
    bencher: Bencher<'a, 'b>,
}

impl Task for Timed<'_, '_> {
    type Output = ();

    fn run<V: Vector>(self, zero: V) {
        match self.case.covariance {
            Covariance::Forward => self.average::<Forward, V>(zero),
            Covariance::ForwardBackward => self.average::<ForwardBackward, V>(zero),
        }
    }
}

impl Timed<'_, '_> {
    fn average<A: Averaging<V>, V: Vector>(self, zero: V) {
        let beamformer = Beamformer::new(Parameters {
            method: self.case.method,
            temporal_half_window: self.case.temporal_half_window,
            ..Parameters::default()
        })
        .expect("valid parameters");
        let x: Vec<_> = (0..V::LANES)
            .map(|lane| wave(self.elements, lane as u32))
            .collect();
        let segments: Vec<_> = x
            .iter()
            .map(|x| Segment {
                line: AlignedLine::new(x, self.elements).expect("finite samples"),
                first_element: 0,
                first_sample: 0,
            })
            .collect();
        let sizes = beamformer.sizes(self.elements);
        let mut memory = Memory::<A, V>::new(zero, sizes).expect("enough memory");
        let mut z = vec![[Complex::ZERO; SAMPLES]; V::LANES];
        self.bencher
            .counter(divan::counter::ItemsCount::new(SAMPLES * V::LANES))
            .bench_local(|| {
                let mut out: Vec<_> = z.iter_mut().map(|lane| lane.as_mut_slice()).collect();
                beamformer
                    .segments(
                        &mut memory.view(),
                        black_box(&segments),
                        self.elements,
                        &mut out,
                    )
                    .expect("runs that fit");
            });
    }
}

#[divan::bench(args = cases(), sample_count = 20)]
fn m32_l16(bencher: Bencher, case: &Case) {
    let (case, elements) = (*case, 32);
    case.set.dispatch(Timed {
        elements,
        case,
        bencher,
    });
}

#[divan::bench(args = cases(), sample_count = 20)]
fn m64_l32(bencher: Bencher, case: &Case) {
    let (case, elements) = (*case, 64);
    case.set.dispatch(Timed {
        elements,
        case,
        bencher,
    });
}

#[divan::bench(args = cases(), sample_count = 20)]
fn m128_l64(bencher: Bencher, case: &Case) {
    let (case, elements) = (*case, 128);
    case.set.dispatch(Timed {
        elements,
        case,
        bencher,
    });
}
