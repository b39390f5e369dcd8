//! Phase symmetry of a 512×512 image with 18 filters: `cargo bench -p bonebeam-tests --bench
//! phase_symmetry`. Read the fastest runs, as ratios. Beside straight rustfft and scipy:
//! `host-sim bench --only phase-symmetry`.

use bonebeam::phase_symmetry::{
    self as core, GainTables, LogGabor, LogGaborTables, PhaseSymmetry, Sizes,
};
use bonebeam::simd::InstructionSet;
use bonebeam_drive::phase_symmetry::{Parameters, Plan};
use divan::{Bencher, black_box};
use ndarray::Array2;

const SIDE: usize = 512;
const SCALES: [f64; 3] = [1.0 / 128.0, 1.0 / 256.0, 1.0 / 512.0];
const THRESHOLD: f32 = 15.0;

fn main() {
    divan::main();
}

/// Whole numbers within 0..255; what they are does not change the time.
fn image() -> Array2<f32> {
    Array2::from_shape_fn((SIDE, SIDE), |(row, column)| {
        ((row * 7919 + column * 104_729 + row * column % 77 * 31) % 256) as f32
    })
}

fn plan(strip: usize) -> Plan {
    let parameters = Parameters {
        scales: SCALES.to_vec(),
        threshold: THRESHOLD,
        strip,
    };
    Plan::new((SIDE, SIDE), &parameters).expect("valid parameters")
}

/// Tables and memory ready; strips of 512 are the whole image.
fn frame(bencher: Bencher, set: InstructionSet, strip: usize, threads: usize) {
    // A processor without the instructions has nothing to measure.
    if !set.is_available() {
        return;
    }
    let image = image();
    let mut plan = plan(strip);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    let pool = pool.build().expect("threads");
    bencher.bench_local(|| pool.install(|| plan.run(black_box(image.view()), set, &mut |_, _| {})));
}

#[divan::bench(args = [16, 32, 64, 512], sample_count = 50)]
fn widest_instruction_set(bencher: Bencher, strip: usize) {
    frame(bencher, InstructionSet::detect(), strip, 1);
}

#[divan::bench(args = [16, 32, 64, 512], sample_count = 50)]
fn widest_instruction_set_two_threads(bencher: Bencher, strip: usize) {
    frame(bencher, InstructionSet::detect(), strip, 2);
}

#[cfg(target_arch = "x86_64")]
#[divan::bench(args = [16, 32, 64, 512], sample_count = 50)]
fn avx2(bencher: Bencher, strip: usize) {
    frame(bencher, InstructionSet::Avx2, strip, 1);
}

#[cfg(target_arch = "x86_64")]
#[divan::bench(args = [16, 32, 64, 512], sample_count = 50)]
fn sse2(bencher: Bencher, strip: usize) {
    frame(bencher, InstructionSet::Sse2, strip, 1);
}

#[divan::bench(sample_count = 50)]
fn gain_tables_from_parameters(bencher: Bencher) {
    let bank = PhaseSymmetry::new(&core::Parameters {
        sizes: Sizes {
            rows: SIDE,
            columns: SIDE,
            strip: 16,
        },
        scales: &SCALES,
        threshold: THRESHOLD,
    });
    let bank = bank.expect("valid parameters");
    let mut memory = vec![0.0; bank.gain_tables_len()];
    bencher.bench_local(|| {
        let mut tables = LogGaborTables::new();
        GainTables::new(&LogGabor::new(&mut tables), &bank, &mut memory[..]).map(|_| ())
    });
}
