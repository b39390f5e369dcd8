//! Time of one output sample, side by side: `cargo bench -p bonebeam-tests`. Read it as ratios; the
//! README's table is made of the fastest runs, each divided by the samples that it puts out.

use bonebeam::Complex;
use bonebeam::beamform::{Beamformer, DelayedLine, Method, Parameters, Run, Workspace};
use bonebeam::covariance::{Averaging, Forward, ForwardBackward};
use divan::{Bencher, black_box};

/// Samples a lane and call, a run as where the aperture is full: K = 10 adds 20 covariances to it.
const SAMPLES: usize = 128;

const METHODS: [(&str, Method); 4] = [
    ("DAS", Method::Das),
    ("MV", Method::Mv),
    ("ESMV rank 1", Method::EsmvRank1),
    ("ESMV beta 1 %", Method::EsmvBeta(0.01)),
];

fn main() {
    divan::main();
}

/// A wave from aside with noise 20 dB below it: power iteration arrives, as at an echo.
fn wave(elements: usize) -> Vec<Complex<f32>> {
    let mut state = 1u32;
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

fn bench<A: Averaging<W>, const M: usize, const L: usize, const SLOTS: usize, const W: usize>(
    bencher: Bencher<'_, '_>,
    method: &str,
    temporal: usize,
) {
    let method = METHODS.iter().find(|(name, _)| *name == method);
    let beamformer = Beamformer::new(Parameters {
        method: method.expect("a method of the table").1,
        temporal,
        ..Parameters::default()
    })
    .expect("valid parameters");
    let x = wave(M);
    let line = DelayedLine::new(&x, M).expect("finite samples");
    let runs = [Run {
        line,
        first_element: 0,
        first_sample: 0,
    }; W];
    let mut workspace = Box::new(Workspace::<A, M, L, SLOTS, W>::new());
    let mut z = [[Complex::ZERO; SAMPLES]; W];
    bencher
        .counter(divan::counter::ItemsCount::new(SAMPLES * W))
        .bench_local(|| {
            let mut out = z.each_mut().map(|lane| lane.as_mut_slice());
            beamformer
                .runs(&mut workspace, black_box(&runs), M, &mut out)
                .expect("runs that fit");
        });
}

/// The methods' names, for the arguments.
const NAMES: [&str; 4] = [METHODS[0].0, METHODS[1].0, METHODS[2].0, METHODS[3].0];

#[divan::bench(args = NAMES, sample_count = 20)]
fn m32_l16_forward_backward_8_lanes(bencher: Bencher, method: &str) {
    bench::<ForwardBackward, 32, 16, 1, 8>(bencher, method, 0);
}

#[divan::bench(args = NAMES, sample_count = 20)]
fn m32_l16_forward_8_lanes(bencher: Bencher, method: &str) {
    bench::<Forward, 32, 16, 1, 8>(bencher, method, 0);
}

#[divan::bench(args = NAMES, sample_count = 20)]
fn m32_l16_forward_backward_1_lane(bencher: Bencher, method: &str) {
    bench::<ForwardBackward, 32, 16, 1, 1>(bencher, method, 0);
}

#[divan::bench(args = NAMES, sample_count = 20)]
fn m32_l16_forward_backward_8_lanes_k10(bencher: Bencher, method: &str) {
    bench::<ForwardBackward, 32, 16, 21, 8>(bencher, method, 10);
}

#[divan::bench(args = NAMES, sample_count = 20)]
fn m64_l32_forward_backward_8_lanes(bencher: Bencher, method: &str) {
    bench::<ForwardBackward, 64, 32, 1, 8>(bencher, method, 0);
}

#[divan::bench(args = NAMES, sample_count = 20)]
fn m64_l32_forward_8_lanes(bencher: Bencher, method: &str) {
    bench::<Forward, 64, 32, 1, 8>(bencher, method, 0);
}

#[divan::bench(args = NAMES, sample_count = 20)]
fn m64_l32_forward_backward_1_lane(bencher: Bencher, method: &str) {
    bench::<ForwardBackward, 64, 32, 1, 1>(bencher, method, 0);
}

#[divan::bench(args = NAMES, sample_count = 20)]
fn m64_l32_forward_backward_8_lanes_k10(bencher: Bencher, method: &str) {
    bench::<ForwardBackward, 64, 32, 21, 8>(bencher, method, 10);
}

#[divan::bench(args = NAMES, sample_count = 20)]
fn m128_l64_forward_backward_8_lanes(bencher: Bencher, method: &str) {
    bench::<ForwardBackward, 128, 64, 1, 8>(bencher, method, 0);
}

#[divan::bench(args = NAMES, sample_count = 20)]
fn m128_l64_forward_8_lanes(bencher: Bencher, method: &str) {
    bench::<Forward, 128, 64, 1, 8>(bencher, method, 0);
}

#[divan::bench(args = NAMES, sample_count = 20)]
fn m128_l64_forward_backward_1_lane(bencher: Bencher, method: &str) {
    bench::<ForwardBackward, 128, 64, 1, 1>(bencher, method, 0);
}

#[divan::bench(args = NAMES, sample_count = 20)]
fn m128_l64_forward_backward_8_lanes_k10(bencher: Bencher, method: &str) {
    bench::<ForwardBackward, 128, 64, 21, 8>(bencher, method, 10);
}
