//! The delay stage: against both references, against echoes computed by hand, and its invariants.

use crate::common;

use bonebeam::Complex;
use bonebeam::delay::{Compounding, Delay, DelayParameters, Record, ScanLine, Stage};
use bonebeam::geometry::{Active, Array, Element, Ray, Transmit, TransmitLaw};
use bonebeam::simd::{Lanes, Vector};
use bonebeam_drive::config::Beamform;
use bonebeam_drive::delay::DelayStage;
use bonebeam_files::{ChannelData, Transmits};
use bonebeam_oracle::reference;
use common::tolerances::{DELAY_SHIFT, DELAYED_PULSE_20_MHZ, DELAYED_PULSE_40_MHZ, FILTER_IN_F32};
use fearless_simd::Level;
use ndarray::{Array3, Axis};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

const C: f64 = 1540.0;
const F0: f64 = 5e6;
const PITCH: f64 = 0.308e-3;
const HILBERT_TAPS: usize = 8;
const ZERO: Complex<f32> = Complex::new(0.0, 0.0);
const LAWS: [TransmitLaw<'static>; 3] = [
    TransmitLaw::Focused,
    TransmitLaw::Plane { angle: -0.15 },
    TransmitLaw::Element { x: 2.1e-3, z: 0.0 },
];

fn parameters(fs: f64, fout: f64, elements: usize, record_samples: usize) -> DelayParameters {
    DelayParameters {
        sound_speed: C,
        sampling_rate: fs,
        centre_frequency: F0,
        output_rate: fout,
        output_start: 0.0,
        output_samples: (record_samples as f64 * fout / fs) as usize + 7,
        elements,
        record_samples,
        hilbert_taps: HILBERT_TAPS,
    }
}

fn line_up(elements: usize) -> Vec<f64> {
    (0..elements)
        .map(|m| (m as f64 - (elements as f64 - 1.0) / 2.0) * PITCH)
        .collect()
}

fn noise(length: usize, seed: u64) -> Vec<f32> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..length).map(|_| rng.random_range(-1.0..1.0)).collect()
}

/// The line at 0.3 mm, every element of it, recorded from t = 0.
fn line_of<'a>(law: TransmitLaw<'a>, element_x: &'a [f64]) -> ScanLine<'a> {
    ScanLine {
        transmit: Transmit { law, t0: 0.0 },
        ray: Ray::down(0.3e-3),
        array: Array::LinearAt(element_x),
        active: Active {
            first: 0,
            count: element_x.len(),
        },
        compounding: Compounding::Replace,
    }
}

fn core_line(p: &DelayParameters, line: &ScanLine, rf: &[f32]) -> Vec<Complex<f32>> {
    // Whatever is not overwritten shows.
    let mut out = vec![Complex::new(f32::NAN, f32::NAN); p.output_samples * p.elements];
    line_into(0.0f32, p, line, rf, &mut out);
    out
}

fn line_into<V: Vector>(
    zero: V,
    p: &DelayParameters,
    line: &ScanLine,
    rf: &[f32],
    out: &mut [Complex<f32>],
) {
    line_by(&Delay::new(*p).unwrap(), zero, line, rf, out);
}

fn line_by<V: Vector>(
    delay: &Delay,
    zero: V,
    line: &ScanLine,
    rf: &[f32],
    out: &mut [Complex<f32>],
) {
    let p = delay.parameters();
    let record = Record::new(rf, p.elements).unwrap();
    let mut scratch = vec![f32::NAN; p.scratch_len(V::LANES)];
    delay.line(zero, line, &record, &mut scratch, out).unwrap();
}

fn assert_same_bits(left: &[Complex<f32>], right: &[Complex<f32>], what: &str) {
    assert_eq!(left.len(), right.len());
    for (index, (a, b)) in left.iter().zip(right).enumerate() {
        let same = a.re.to_bits() == b.re.to_bits() && a.im.to_bits() == b.im.to_bits();
        assert!(same, "{what}: {a} and {b} at {index}");
    }
}

/// `ours` has the bits of the reference, which has no lanes, blocks or shared tables.
fn assert_reference(
    ours: &[Complex<f32>],
    p: &DelayParameters,
    line: &ScanLine,
    rf: &[f32],
    what: &str,
) {
    // Whatever is not overwritten shows.
    let mut reference = vec![Complex::new(7.0, 7.0); ours.len()];
    reference::f32::delay::line(p, line, rf, &mut reference);
    assert_same_bits(ours, &reference, what);
}

#[test]
fn a_stage_that_is_set_is_a_new_one() {
    let element_x = line_up(5);
    let line = line_of(TransmitLaw::Focused, &element_x);
    let rf = noise(5 * 400, 3);
    let first = parameters(40e6, 20e6, 5, 400);
    // Each from the one before: what keeps the filters, what changes one of them, and both.
    let all = [
        DelayParameters {
            sound_speed: 1580.0,
            ..first
        },
        DelayParameters {
            output_start: 1e-6,
            output_samples: 31,
            ..first
        },
        DelayParameters {
            hilbert_taps: 3,
            ..first
        },
        DelayParameters {
            centre_frequency: 3e6,
            ..first
        },
        parameters(100e6, 20e6, 5, 400),
        parameters(20e6, 20e6, 5, 400),
        DelayParameters {
            hilbert_taps: 31,
            output_rate: 30e6,
            ..first
        },
    ];
    let mut delay = Delay::new(first).unwrap();
    for p in all {
        delay.set(p).unwrap();
        assert_eq!(delay.parameters(), &p);
        // A refusal leaves everything, whichever parameter is wrong.
        for wrong in [
            DelayParameters {
                sound_speed: 0.0,
                ..parameters(60e6, 20e6, 5, 400)
            },
            DelayParameters {
                hilbert_taps: 0,
                ..parameters(60e6, 20e6, 5, 400)
            },
            DelayParameters {
                hilbert_taps: 4,
                ..parameters(600e6, 20e6, 5, 400)
            },
        ] {
            delay.set(wrong).unwrap_err();
        }
        let mut out = vec![ZERO; p.output_samples * 5];
        line_by(&delay, 0.0f32, &line, &rf, &mut out);
        assert_same_bits(&out, &core_line(&p, &line, &rf), &format!("{p:?}"));
    }
}

/// The compiler computes it by other means than the processor.
#[test]
fn a_constant_stage_is_one_made_when_the_program_runs() {
    const PARAMETERS: DelayParameters = DelayParameters {
        sound_speed: C,
        sampling_rate: 100e6,
        centre_frequency: F0,
        output_rate: 20e6,
        output_start: 0.0,
        output_samples: 87,
        elements: 5,
        record_samples: 400,
        hilbert_taps: HILBERT_TAPS,
    };
    static DELAY: Delay = match Delay::new(PARAMETERS) {
        Ok(delay) => delay,
        Err(_) => panic!("the parameters are not valid"),
    };
    let element_x = line_up(5);
    let line = line_of(TransmitLaw::Focused, &element_x);
    let rf = noise(5 * 400, 3);
    let mut out = vec![ZERO; 87 * 5];
    line_by(&DELAY, 0.0f32, &line, &rf, &mut out);
    let p = std::hint::black_box(PARAMETERS);
    assert_same_bits(&out, &core_line(&p, &line, &rf), "constant");
}

#[test]
fn equals_the_f32_reference_to_the_bit() {
    let mut seed = 0;
    for (fs, fout) in [
        (20e6, 20e6),
        (100e6, 20e6),
        (40e6, 20e6),
        (50e6, 20e6),
        (20e6, 40e6),
        (62.5e6, 5e6),
        (75e6, 20e6),
        (80e6, 5e6),
    ] {
        for law in LAWS {
            for (elements, record_samples, taps) in [(1, 1, 1), (5, 211, 8), (13, 1777, 33)] {
                seed += 1;
                let rf = noise(elements * record_samples, seed);
                let element_x = line_up(elements);
                let mut p = parameters(fs, fout, elements, record_samples);
                p.output_start = -1.3e-6;
                p.hilbert_taps = taps;
                let line = ScanLine {
                    transmit: Transmit { law, t0: 0.37e-6 },
                    ray: Ray::down(-0.41e-3),
                    active: Active {
                        first: elements / 3,
                        count: elements - elements / 3,
                    },
                    ..line_of(law, &element_x)
                };
                let what = format!("{fs} -> {fout}, {law:?}, {elements} elements");
                let mut ours = core_line(&p, &line, &rf);
                let mut reference = vec![Complex::new(7.0, 7.0); ours.len()];
                reference::f32::delay::line(&p, &line, &rf, &mut reference);
                assert_same_bits(&ours, &reference, &what);
                assert!(
                    record_samples == 1 || ours.iter().any(|y| y.im != 0.0),
                    "{what}: empty"
                );

                // Once more, on top.
                let line = ScanLine {
                    ray: Ray::down(0.2e-3),
                    compounding: Compounding::Add,
                    ..line
                };
                line_into(0.0f32, &p, &line, &rf, &mut ours);
                reference::f32::delay::line(&p, &line, &rf, &mut reference);
                assert_same_bits(&ours, &reference, &what);
            }
        }
    }
}

/// As both references have it: to the bit of the f32 one, and near the line of a filter in f64.
#[test]
fn a_filter_in_f32_equals_its_reference_to_the_bit() {
    let element_x = line_up(5);
    let mut delay = Delay::new(parameters(20e6, 20e6, 1, 1)).unwrap();
    for (fs, fout, f0) in [
        (20e6, 20e6, 5e6),
        (20e6, 20e6, 6.6e6),
        (20e6, 40e6, 5e6),
        (25e6, 20e6, 5e6),
        (40e6, 20e6, 5e6),
        (41.66e6, 20.83e6, 4.2e6),
        (62.5e6, 8e6, 2e6),
        (100e6, 20e6, 5e6),
        (80e6, 5e6, 1.5e6),
    ] {
        for law in LAWS {
            let p = DelayParameters {
                centre_frequency: f0,
                ..parameters(fs, fout, 5, 911)
            };
            let (rf, line) = (noise(5 * 911, 21), line_of(law, &element_x));
            delay.set_in_f32(p).unwrap();
            let mut ours = vec![Complex::new(f32::NAN, f32::NAN); p.output_samples * 5];
            line_by(&delay, 0.0f32, &line, &rf, &mut ours);
            let mut reference = vec![Complex::new(7.0, 7.0); ours.len()];
            reference::f32::delay::line_in_f32(&p, &line, &rf, &mut reference);
            let what = format!("{fs} -> {fout}, {f0}, {law:?}");
            assert_same_bits(&ours, &reference, &what);

            let in_f64 = core_line(&p, &line, &rf);
            assert!(ours != in_f64, "{what}: no other bits");
            let errors = ours.iter().zip(&in_f64).map(|(a, b)| (a - b).norm());
            let worst = errors.fold(0.0, f32::max);
            assert!(worst < FILTER_IN_F32, "{what}: {worst}");
        }
    }
}

/// The line, and another one added to it, with the vectors of `zero`.
fn twice<V: Vector>(
    zero: V,
    p: &DelayParameters,
    line: &ScanLine,
    rf: &[f32],
) -> Vec<Complex<f32>> {
    let mut out = vec![Complex::new(f32::NAN, f32::NAN); p.output_samples * p.elements];
    line_into(zero, p, line, rf, &mut out);
    let add = ScanLine {
        compounding: Compounding::Add,
        ray: Ray::down(line.ray.x() - 0.5 * PITCH),
        ..*line
    };
    line_into(zero, p, &add, rf, &mut out);
    out
}

#[test]
fn every_instruction_set_gives_the_bits_of_one_lane() {
    let level = Level::new();
    for (fs, fout) in [(100e6, 20e6), (40e6, 20e6), (20e6, 20e6), (80e6, 5e6)] {
        // Elements that do not fill a vector, or some and a part; lines that end within one.
        for (elements, record_samples) in [(5, 211), (37, 1777)] {
            let rf = noise(elements * record_samples, elements as u64);
            let element_x = line_up(elements);
            let mut p = parameters(fs, fout, elements, record_samples);
            // A line that begins where none of its elements needs the record's beginning, too.
            for (x, start) in [
                (0.3e-3, 0.0),
                (0.0, 0.0),
                (0.0, 0.4 * record_samples as f64 / fs),
                (1.5 * PITCH, 0.0),
                (-17.0 * PITCH, 0.0),
                (-40.0 * PITCH, 0.0),
            ] {
                p.output_start = start;
                let line = ScanLine {
                    ray: Ray::down(x),
                    active: Active {
                        first: 1,
                        count: elements - 2,
                    },
                    ..line_of(TransmitLaw::Plane { angle: 0.1 }, &element_x)
                };
                let one = twice(0.0f32, &p, &line, &rf);
                let check = |many: Option<Vec<_>>, name: &str| match many {
                    Some(many) => assert_same_bits(&many, &one, name),
                    None => println!("this machine has no {name}"),
                };
                #[cfg(target_arch = "x86_64")]
                {
                    let many = level.as_sse2();
                    let many = many.map(|simd| twice(Lanes::new(simd), &p, &line, &rf));
                    check(many, "SSE2");
                    let many = level.as_avx2();
                    let many = many.map(|simd| twice(Lanes::new(simd), &p, &line, &rf));
                    check(many, "AVX2");
                    let many = level.as_avx512();
                    let many = many.map(|simd| twice(Lanes::new(simd), &p, &line, &rf));
                    check(many, "AVX-512");
                }
                #[cfg(target_arch = "aarch64")]
                {
                    let many = level.as_neon();
                    let many = many.map(|simd| twice(Lanes::new(simd), &p, &line, &rf));
                    check(many, "NEON");
                }
            }
        }
    }
}

/// A Gaussian pulse of 5 MHz and 60 % bandwidth at −6 dB.
fn pulse(t: f64) -> f64 {
    let a = (PI * F0 * 0.6).powi(2) / (4.0 * 10f64.powf(6.0 / 20.0).ln());
    (-a * t * t).exp() * (2.0 * PI * F0 * t).cos()
}

/// The echo of a point: on each element a pulse centred on the time the wave takes to the point
/// and back.
fn echo(p: &DelayParameters, line: &ScanLine, point: (f64, f64)) -> Vec<f32> {
    let (x, z) = point;
    let transmit = match line.transmit.law {
        TransmitLaw::Focused => z / C,
        TransmitLaw::Plane { angle } => (x * angle.sin() + z * angle.cos()) / C,
        TransmitLaw::Element { x: source, .. } => (x - source).hypot(z) / C,
        _ => unreachable!("not one of `LAWS`"),
    };
    let mut rf = Vec::new();
    for element in (0..line.array.elements()).map(|m| line.array.x(m)) {
        let arrival = transmit + (x - element).hypot(z) / C;
        for k in 0..p.record_samples {
            rf.push(pulse(line.transmit.t0 + k as f64 / p.sampling_rate - arrival) as f32);
        }
    }
    rf
}

const RATES: [(f64, f64, f64); 6] = [
    (20e6, 20e6, DELAYED_PULSE_20_MHZ),
    (40e6, 20e6, DELAYED_PULSE_20_MHZ),
    (100e6, 20e6, DELAYED_PULSE_20_MHZ),
    (200e6, 20e6, DELAYED_PULSE_20_MHZ),
    (40e6, 40e6, DELAYED_PULSE_40_MHZ),
    (100e6, 100e6, DELAYED_PULSE_40_MHZ),
];

#[test]
fn a_point_echo_becomes_a_flat_wavefront() {
    let element_x = line_up(33);
    for (fs, fout, tolerance) in RATES {
        let taps = (2.0 * fout / F0) as usize;
        for law in LAWS {
            let (x, z) = (0.7e-3, 17.3e-3);
            let mut p = parameters(fs, fout, 33, (30e-6 * fs) as usize);
            // Output sample 100 lies on the point.
            p.output_start = 2.0 * z / C - 100.0 / fout;
            p.output_samples = 200;
            p.hilbert_taps = taps;
            let line = ScanLine {
                transmit: Transmit { law, t0: 1.234e-6 },
                ray: Ray::down(x),
                ..line_of(law, &element_x)
            };
            let out = core_line(&p, &line, &echo(&p, &line, (x, z)));
            for m in 0..33 {
                // The pulse's middle: magnitude 1, phase 0, on every element.
                let y = out[100 * 33 + m];
                let error = (f64::from(y.re) - 1.0).hypot(f64::from(y.im));
                assert!(
                    error < tolerance,
                    "{fs} -> {fout}, {law:?}, element {m}: {y}"
                );
                // And its envelope is highest there.
                for n in [90, 99, 101, 110] {
                    assert!(out[n * 33 + m].norm() < y.norm());
                }
            }
        }
    }
}

#[test]
fn stays_within_its_bound_of_the_f64_reference() {
    let element_x = line_up(33);
    for (fs, fout, tolerance) in RATES {
        let taps = (2.0 * fout / F0) as usize;
        for law in LAWS {
            let p = DelayParameters {
                output_samples: (28e-6 * fout) as usize,
                hilbert_taps: taps,
                ..parameters(fs, fout, 33, (30e-6 * fs) as usize)
            };
            let line = ScanLine {
                transmit: Transmit { law, t0: -0.2e-6 },
                ray: Ray::down(-1.1e-3),
                active: Active {
                    first: 2,
                    count: 30,
                },
                ..line_of(law, &element_x)
            };
            // Two points that do not overlap, one near and off the line, one far.
            let mut rf = echo(&p, &line, (0.3e-3, 8e-3));
            for (sum, value) in rf.iter_mut().zip(echo(&p, &line, (-1.1e-3, 16e-3))) {
                *sum += value;
            }
            let ours = core_line(&p, &line, &rf);
            let exact = reference::f64::delay::line(&p, &line, &rf);
            let mut worst = 0.0f64;
            for (y, e) in ours.iter().zip(&exact) {
                let difference = (f64::from(y.re) - e.re).hypot(f64::from(y.im) - e.im);
                worst = worst.max(difference);
            }
            println!("{fs} -> {fout}, {law:?}: {worst:.2e}");
            assert!(worst < tolerance, "{fs} -> {fout}, {law:?}: {worst}");
        }
    }
}

#[test]
fn the_ends_of_a_line_are_as_good_as_its_middle() {
    let element_x = line_up(9);
    let rf = noise(9 * 900, 4);
    let whole = DelayParameters {
        output_samples: 300,
        ..parameters(40e6, 20e6, 9, 900)
    };
    // A power of two of samples, so that both start times are exact.
    let part = DelayParameters {
        output_start: 128.0 / 20e6,
        output_samples: 64,
        ..whole
    };
    let line = line_of(TransmitLaw::Focused, &element_x);
    let whole = core_line(&whole, &line, &rf);
    let part = core_line(&part, &line, &rf);
    for (a, b) in part.iter().zip(&whole[128 * 9..192 * 9]) {
        assert!((a - b).norm() < DELAY_SHIFT, "{a} {b}");
    }
}

#[test]
fn moving_record_and_t0_together_changes_nothing() {
    let element_x = line_up(9);
    let (elements, samples, shift) = (9, 800, 37);
    let rf = noise(elements * samples, 5);
    let mut moved = vec![0.0; elements * (samples + shift)];
    for m in 0..elements {
        moved[m * (samples + shift) + shift..][..samples]
            .copy_from_slice(&rf[m * samples..][..samples]);
    }
    for law in LAWS {
        let p = parameters(40e6, 20e6, elements, samples);
        let line = ScanLine {
            transmit: Transmit { law, t0: 1e-6 },
            ..line_of(law, &element_x)
        };
        let at_rest = core_line(&p, &line, &rf);
        let p = DelayParameters {
            record_samples: samples + shift,
            ..p
        };
        let line = ScanLine {
            transmit: Transmit {
                law,
                t0: 1e-6 - shift as f64 / 40e6,
            },
            ..line
        };
        let shifted = core_line(&p, &line, &moved);
        for (a, b) in at_rest.iter().zip(&shifted) {
            assert!((a - b).norm() < DELAY_SHIFT, "{law:?}: {a} {b}");
        }
    }
}

#[test]
fn the_mirror_image_and_powers_of_two_are_exact() {
    let element_x = line_up(9);
    let rf = noise(9 * 700, 6);
    for law in LAWS {
        let p = parameters(40e6, 20e6, 9, 700);
        let line = line_of(law, &element_x);
        let direct = core_line(&p, &line, &rf);

        let scaled: Vec<f32> = rf.iter().map(|x| x * 1024.0).collect();
        let scaled = core_line(&p, &line, &scaled);
        let expected: Vec<_> = direct.iter().map(|y| y * 1024.0).collect();
        assert_same_bits(&scaled, &expected, "scaled");

        let law = match law {
            TransmitLaw::Focused => TransmitLaw::Focused,
            TransmitLaw::Plane { angle } => TransmitLaw::Plane { angle: -angle },
            TransmitLaw::Element { x, z } => TransmitLaw::Element { x: -x, z },
            _ => unreachable!("not one of `LAWS`"),
        };
        let mirrored_rf: Vec<f32> = rf.chunks(700).rev().flatten().copied().collect();
        let line = ScanLine {
            transmit: Transmit { law, t0: 0.0 },
            ray: Ray::down(-0.3e-3),
            ..line
        };
        let mirrored = core_line(&p, &line, &mirrored_rf);
        let expected: Vec<_> = direct
            .chunks(9)
            .flat_map(|row| row.iter().rev().copied())
            .collect();
        assert_same_bits(&mirrored, &expected, "mirrored");
    }
}

#[test]
fn elements_outside_the_active_range_are_zero_and_the_others_unaffected() {
    let element_x = line_up(9);
    let rf = noise(9 * 700, 7);
    let p = parameters(40e6, 20e6, 9, 700);
    let line = line_of(TransmitLaw::Focused, &element_x);
    let every = core_line(&p, &line, &rf);
    for (first, count) in [(0, 0), (9, 0), (2, 4), (8, 1)] {
        let line = ScanLine {
            active: Active { first, count },
            ..line
        };
        let some = core_line(&p, &line, &rf);
        for (index, (s, e)) in some.iter().zip(&every).enumerate() {
            let inside = (first..first + count).contains(&(index % 9));
            assert_eq!(*s, if inside { *e } else { ZERO });
        }
    }
}

#[test]
fn extreme_geometry_gives_the_bits_of_the_reference_and_never_nan_or_infinity() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut extreme = |allow_negative: bool| {
        let magnitude = 10f64.powf(rng.random_range(-60.0..60.0));
        match rng.random_range(0..4) {
            0 => 0.0,
            1 if allow_negative => -magnitude,
            2 => rng.random_range(0.0..1.0) * 1e-2,
            _ => magnitude,
        }
    };
    for round in 0..2000 {
        let element_x = [extreme(true), extreme(true), 0.0];
        let law = match extreme(true) {
            v if v < 0.0 => TransmitLaw::Plane { angle: 1.5 },
            0.0 => TransmitLaw::Focused,
            v => TransmitLaw::Element { x: v, z: 0.0 },
        };
        let fs = extreme(false) + 1e-60;
        let p = DelayParameters {
            sound_speed: extreme(false) + 1e-60,
            sampling_rate: fs,
            centre_frequency: extreme(false) + 1e-60,
            // Every other record is halved.
            output_rate: if round % 2 == 0 { fs } else { fs / 3.0 },
            output_start: extreme(true),
            output_samples: 20,
            elements: 3,
            record_samples: 10,
            hilbert_taps: 2,
        };
        let line = ScanLine {
            transmit: Transmit {
                law,
                t0: extreme(true),
            },
            ray: Ray::down(extreme(true)),
            ..line_of(law, &element_x)
        };
        let what = format!("{p:?} {line:?}");
        let ours = core_line(&p, &line, &[1e29; 30]);
        for y in &ours {
            assert!(y.re.is_finite() && y.im.is_finite(), "{what}");
        }
        assert_reference(&ours, &p, &line, &[1e29; 30], &what);
    }
}

/// Where a position on the axis is ±2²³ samples, nothing is read, although the element's lag, or its lead,
/// brings the place near the record; one sample on, or back, it is. Depths and times are exact: c = 2, fs = 1.
#[test]
fn nothing_is_read_from_2_to_the_23_samples_on() {
    let far = 8_388_608.0;
    let deep = 2.0 * far - 100.0;
    for (x, z, depth, t0, beside) in [
        (4.0, deep, deep, deep - far, -1),
        (2.0 * far, 0.0, 10.0, 10.0 + far, 1),
    ] {
        let p = DelayParameters {
            sound_speed: 2.0,
            output_start: depth - 9.0,
            output_samples: 19,
            ..parameters(1.0, 1.0, 1, 100)
        };
        let elements = [Element { x, z, angle: 0.0 }];
        let line = ScanLine {
            transmit: Transmit::new(TransmitLaw::Focused, t0),
            ray: Ray::down(0.0),
            array: Array::At {
                elements: &elements,
                pitch: 1.0,
            },
            ..line_of(TransmitLaw::Focused, &[0.0])
        };
        let rf = noise(100, 9);
        let ours = core_line(&p, &line, &rf);
        assert_reference(&ours, &p, &line, &rf, &format!("{depth}"));
        assert!(ours[9].re == 0.0 && ours[(9 + beside) as usize].re != 0.0);
    }
}

/// Straight towards an element the way there grows as the way back shrinks: every depth is read at one place.
/// Depths and times are exact: c = 2, and a halved record's rate is 2.
#[test]
fn a_line_towards_an_element_reads_one_place() {
    let p = DelayParameters {
        sound_speed: 2.0,
        output_start: 20.0,
        output_samples: 32,
        ..parameters(4.0, 1.0, 1, 2500)
    };
    let elements = [Element {
        x: 0.0,
        z: 1000.0,
        angle: 0.0,
    }];
    let line = ScanLine {
        ray: Ray::down(0.0),
        array: Array::At {
            elements: &elements,
            pitch: 1.0,
        },
        ..line_of(TransmitLaw::Focused, &[0.0])
    };
    let rf = noise(2500, 13);
    let ours = core_line(&p, &line, &rf);
    assert_reference(&ours, &p, &line, &rf, "one place");
    assert!(ours.iter().all(|y| y.re == ours[0].re && y.re != 0.0));
}

/// Lines all over a halved record, in front of it and behind it: only what they read is halved, and the
/// rest of the memory is no numbers. Elements beside the line and in front of where it begins.
#[test]
fn any_part_of_a_halved_record_has_the_bits_of_the_reference() {
    let samples = 700;
    let rf = noise(3 * samples, 12);
    let level = [-9e-3, 0.4e-3, 14e-3];
    let elements =
        [(-5e-3, 3e-3), (1e-3, 9e-3), (12e-3, -4e-3)].map(|(x, z)| Element { x, z, angle: 0.0 });
    let arrays = [
        Array::LinearAt(&level),
        Array::At {
            elements: &elements,
            pitch: 6e-3,
        },
    ];
    let mut read = 0;
    for (array, fs) in arrays
        .into_iter()
        .flat_map(|a| [50e6, 100e6].map(|fs| (a, fs)))
    {
        let mut p = parameters(fs, 20e6, 3, samples);
        (p.output_samples, p.hilbert_taps) = (32, 4);
        let mut delay = Delay::new(p).unwrap();
        // All residues of where they begin and end, and a depth of 0 at any of the line's samples.
        let starts = (-60..400).step_by(3).map(|k| (k, 0.0));
        let starts = starts.chain((0..130).map(|k| (k, 5.1e-6)));
        for (k, late) in starts.chain((-60..0).map(|k| (k, -6.3e-6))) {
            p.output_start = f64::from(k) / 20e6;
            delay.set(p).unwrap();
            let line = ScanLine {
                transmit: Transmit::new(TransmitLaw::Focused, late),
                array,
                ..line_of(TransmitLaw::Focused, &level)
            };
            let mut ours = vec![ZERO; 3 * 32];
            line_by(&delay, 0.0f32, &line, &rf, &mut ours);
            let what = format!("{array:?} {fs} {k} {late}");
            assert_reference(&ours, &p, &line, &rf, &what);
            read += ours.iter().filter(|y| y.re != 0.0).count();
        }
    }
    assert!(read > 5000, "{read}");
}

/// Half of the line lies so deep that the product c·t overflows: the other half is read all the same.
#[test]
fn depths_beyond_all_numbers_read_0_and_the_others_what_they_are() {
    for fs in [50.0, 200.0] {
        let p = DelayParameters {
            sound_speed: 1e308,
            output_start: 1.0,
            output_samples: 80,
            ..parameters(fs, 50.0, 2, 600)
        };
        let line = line_of(TransmitLaw::Focused, &[0.0, 1.0]);
        let rf = noise(1200, 10);
        let ours = core_line(&p, &line, &rf);
        assert_reference(&ours, &p, &line, &rf, &format!("{fs}"));
        assert!(ours[..70].iter().all(|y| y.re != 0.0));
        assert!(ours[90..].iter().all(|y| y.re == 0.0));
    }
}

/// Noise recorded of three transmits by an array of nine elements.
fn recording(transmits: Transmits) -> ChannelData {
    ChannelData {
        samples: Array3::from_shape_vec((3, 9, 1500), noise(3 * 9 * 1500, 11))
            .unwrap()
            .into(),
        fs: 100e6,
        t0: vec![0.0, 1e-7, -2e-7],
        element_x: line_up(9),
        element_z: None,
        element_angle: None,
        c: C,
        f0: F0,
        transmits,
        lens_delay: 0.0,
    }
}

#[test]
fn frames_do_not_depend_on_the_threads_or_on_the_range_of_beams() {
    let focused = Transmits::Focused {
        x: vec![-PITCH, 0.0, 0.4 * PITCH],
        focus: vec![20e-3; 3],
        f_number: None,
    };
    let plane = Transmits::Plane {
        angle: vec![-0.1, 0.0, 0.2],
    };
    for transmits in [focused, plane] {
        let data = recording(transmits);
        let stage = DelayStage::new(&data, &Beamform::default()).unwrap();
        let beams = stage.beam_x().len();
        let frames = [1, 2, 7].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let frame = pool.build().unwrap().install(|| stage.delay(0..beams));
            frame.unwrap()
        });
        assert_eq!(frames[0], frames[1]);
        assert_eq!(frames[0], frames[2]);
        assert!(frames[0].iter().any(|y| y.im != 0.0));
        let part = stage.delay(1..beams).unwrap();
        assert_eq!(part, frames[0].slice_axis(Axis(0), (1..).into()));
    }
}
