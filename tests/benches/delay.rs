//! Time of one aligned sample of one element, on each instruction set, side by side:
//! `cargo bench -p bonebeam-tests --bench delay`. Read it as ratios.

use bonebeam::Complex;
use bonebeam::delay::{Compounding, Delay, DelayParameters, Record, ScanLine, Stage, hilbert_taps};
use bonebeam::geometry::{Active, Array, Ray, Transmit, TransmitLaw};
use bonebeam::simd::{Lanes, Vector};
use divan::{Bencher, black_box};
use fearless_simd::Level;

/// The paper's array, all of it active.
const ELEMENTS: usize = 128;
/// 40 mm at 20 MHz.
const SAMPLES: usize = 1040;
/// Recorded, in MHz.
const RATES: [u64; 3] = [100, 40, 20];

fn main() {
    divan::main();
}

fn bench<V: Vector>(bencher: Bencher<'_, '_>, zero: V, rate: u64) {
    let parameters = DelayParameters {
        sound_speed: 1540.0,
        sampling_rate: rate as f64 * 1e6,
        centre_frequency: 5e6,
        output_rate: 20e6,
        output_start: 0.0,
        output_samples: SAMPLES,
        elements: ELEMENTS,
        record_samples: SAMPLES * rate as usize / 20 + 400,
        hilbert_taps: hilbert_taps(20e6, 5e6),
    };
    let delay = Delay::new(parameters).expect("valid parameters");
    let rf: Vec<f32> = (0..ELEMENTS * parameters.record_samples)
        .map(|i| (i * 7919 % 1000) as f32 / 1000.0 - 0.5)
        .collect();
    let record = Record::new(&rf, ELEMENTS).expect("finite samples");
    let element_x: Vec<f64> = (0..ELEMENTS)
        .map(|m| (m as f64 - 63.5) * 0.308e-3)
        .collect();
    let line = ScanLine {
        transmit: Transmit {
            law: TransmitLaw::Focused,
            t0: 0.0,
        },
        ray: Ray::down(0.1e-3),
        array: Array::LinearAt(&element_x),
        active: Active {
            first: 0,
            count: ELEMENTS,
        },
        compounding: Compounding::Replace,
    };
    let mut scratch = vec![0.0; parameters.need(V::LANES).real];
    let mut out = vec![Complex::ZERO; SAMPLES * ELEMENTS];
    bencher
        .counter(divan::counter::ItemsCount::new(SAMPLES * ELEMENTS))
        .bench_local(|| {
            delay
                .line(zero, &line, black_box(&record), &mut scratch, &mut out)
                .expect("a line that fits");
        });
}

#[divan::bench(args = RATES, sample_count = 20)]
fn one_lane(bencher: Bencher, rate: u64) {
    bench(bencher, 0.0f32, rate);
}

/// What the processor cannot do is left out.
macro_rules! instruction_sets {
    ($($name:ident $token:ident;)*) => {$(
        #[divan::bench(args = RATES, sample_count = 20)]
        fn $name(bencher: Bencher, rate: u64) {
            if let Some(simd) = Level::new().$token() {
                bench(bencher, Lanes::new(simd), rate);
            }
        }
    )*};
}

#[cfg(target_arch = "x86_64")]
instruction_sets! {
    sse2 as_sse2;
    avx2 as_avx2;
    avx512 as_avx512;
}

#[cfg(target_arch = "aarch64")]
instruction_sets! {
    neon as_neon;
}
