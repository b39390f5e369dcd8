//! Phase symmetry of a 512×512 image with 18 filters, one thread, beside a straight implementation
//! with rustfft: `cargo bench -p bonebeam-tests --bench phase_symmetry`. Read the fastest runs, as
//! ratios; `phase_symmetry.py` has the same with scipy.fft and pyfftw.

use std::sync::Arc;

use bonebeam::phase_symmetry::{GainTables, LogGabor, LogGaborTables, PhaseSymmetry};
use divan::{Bencher, black_box};
use host_sim::instruction_set::InstructionSet;
use host_sim::phase_symmetry::{Parameters, Plan};
use host_sim::reference::f64::phase_symmetry::log_gabor;
use ndarray::Array2;
use num_complex::Complex;
use rustfft::{Fft, FftPlanner};

const SIDE: usize = 512;
const SCALES: [f64; 3] = [1.0 / 128.0, 1.0 / 256.0, 1.0 / 512.0];
const THRESHOLD: f32 = 15.0;

fn main() {
    let map = plan(16).run(image().view(), InstructionSet::detect(), |_, _| {});
    let map = map.expect("a valid image");
    let straight = Straight::new().run(&image());
    for (a, b) in map.iter().zip(&straight) {
        assert!((a - b).abs() < 1e-5, "they compute the same: {a}, {b}");
    }
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
        low_rank: false,
    };
    Plan::new((SIDE, SIDE), &parameters).expect("valid parameters")
}

/// Tables and memory ready; strips of 512 are the whole image.
fn frame(bencher: Bencher, set: InstructionSet, strip: usize, threads: usize) {
    // A processor without the instructions has nothing to measure.
    if !InstructionSet::available().contains(&set) {
        return;
    }
    let image = image();
    let mut plan = plan(strip);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    let pool = pool.build().expect("threads");
    bencher.bench_local(|| pool.install(|| plan.run(black_box(image.view()), set, |_, _| {})));
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

/// Five octave scales, whole or from a low-rank basis; one thread.
#[divan::bench(args = [(false, 16), (true, 16), (false, 512), (true, 512)], sample_count = 50)]
fn five_scales_low_rank(bencher: Bencher, (low_rank, strip): (bool, usize)) {
    let image = image();
    let parameters = Parameters {
        scales: vec![
            1.0 / 32.0,
            1.0 / 64.0,
            1.0 / 128.0,
            1.0 / 256.0,
            1.0 / 512.0,
        ],
        threshold: THRESHOLD,
        strip,
        low_rank,
    };
    let mut plan = Plan::new((SIDE, SIDE), &parameters).expect("valid parameters");
    let set = InstructionSet::detect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1);
    let pool = pool.build().expect("threads");
    bencher.bench_local(|| pool.install(|| plan.run(black_box(image.view()), set, |_, _| {})));
}

#[divan::bench(sample_count = 50)]
fn gain_tables_from_parameters(bencher: Bencher) {
    let bank = PhaseSymmetry::new(SIDE, SIDE, &SCALES, THRESHOLD, 16).expect("valid parameters");
    let mut memory = vec![0.0; GainTables::len(&bank)];
    bencher.bench_local(|| {
        let mut tables = LogGaborTables::new();
        GainTables::new(&LogGabor::new(&mut tables), &bank, &mut memory[..]).map(|_| ())
    });
}

#[divan::bench(sample_count = 50)]
fn straight_rustfft(bencher: Bencher) {
    let image = image();
    let mut straight = Straight::new();
    bencher.bench_local(|| straight.run(black_box(&image)));
}

/// Dense filters, a whole complex transform each way by rustfft's planner, scalar sums.
struct Straight {
    /// Transposed, as the spectrum is.
    filters: Vec<Vec<f32>>,
    forward: Arc<dyn Fft<f32>>,
    inverse: Arc<dyn Fft<f32>>,
    scratch: Vec<Complex<f32>>,
    spectrum: Vec<Complex<f32>>,
    filtered: Vec<Complex<f32>>,
    turned: Vec<Complex<f32>>,
}

impl Straight {
    fn new() -> Self {
        use std::f64::consts::PI;
        let orientations = [0.0, -1.0, -2.0, -3.0, -4.0, -5.0].map(|k| k * PI / 6.0);
        let filters = SCALES.iter().flat_map(|&r0| {
            orientations.map(|theta0| {
                let filter = log_gabor((SIDE, SIDE), r0, theta0).mapv(|gain| gain.re as f32);
                filter.t().iter().copied().collect()
            })
        });
        let mut planner = FftPlanner::new();
        let zero = Complex::new(0.0, 0.0);
        Straight {
            filters: filters.collect(),
            forward: planner.plan_fft_forward(SIDE),
            inverse: planner.plan_fft_inverse(SIDE),
            scratch: vec![zero; SIDE],
            spectrum: vec![zero; SIDE * SIDE],
            filtered: vec![zero; SIDE * SIDE],
            turned: vec![zero; SIDE * SIDE],
        }
    }

    fn run(&mut self, image: &Array2<f32>) -> Vec<f32> {
        for (bin, &pixel) in self.turned.iter_mut().zip(image) {
            *bin = Complex::new(pixel, 0.0);
        }
        let scratch = &mut self.scratch;
        self.forward.process_with_scratch(&mut self.turned, scratch);
        transpose(&self.turned, &mut self.spectrum);
        self.forward
            .process_with_scratch(&mut self.spectrum, scratch);
        let mut sums = vec![(0.0f32, 0.0f32); SIDE * SIDE];
        let scale = 1.0 / (SIDE * SIDE) as f32;
        for filter in &self.filters {
            for ((to, from), gain) in self.filtered.iter_mut().zip(&self.spectrum).zip(filter) {
                *to = from * gain;
            }
            self.inverse
                .process_with_scratch(&mut self.filtered, scratch);
            transpose(&self.filtered, &mut self.turned);
            self.inverse.process_with_scratch(&mut self.turned, scratch);
            for ((above, below), c) in sums.iter_mut().zip(&self.turned) {
                let (e, o) = (c.re * scale, c.im * scale);
                let excess = e - o.abs() - THRESHOLD;
                *above += if excess > 0.0 { excess } else { 0.0 };
                *below += (e * e + o * o).sqrt();
            }
        }
        let map = sums.iter().map(|(above, below)| above / (below + 1e-10));
        map.collect()
    }
}

/// In squares that fit the fastest cache.
fn transpose(from: &[Complex<f32>], to: &mut [Complex<f32>]) {
    const SQUARE: usize = 16;
    for row in (0..SIDE).step_by(SQUARE) {
        for column in (0..SIDE).step_by(SQUARE) {
            for i in row..row + SQUARE {
                for k in column..column + SQUARE {
                    to[k * SIDE + i] = from[i * SIDE + k];
                }
            }
        }
    }
}
