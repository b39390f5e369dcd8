//! I/Q: the delay stage against both references and against the RF of the same echoes, and its
//! invariants.

use crate::common;

use bonebeam::delay::{
    Compounding, Delay, DelayParameters, IqDelay, IqInterpolation, IqLayout, IqParameters,
    IqRecord, IqSamples, MAX_SAMPLES, Record, ScanLine, Stage, hilbert_taps,
};
use bonebeam::geometry::{
    Active, Array, Axis, Depth, Element, Lines, Ray, Scan, ScanParameters, Transmit, TransmitLaw,
};
use bonebeam::simd::{InstructionSet, Task, Vector};
use bonebeam::{Complex, Error};
use bonebeam_oracle::reference;
use common::tolerances::{DELAYED_PULSE_20_MHZ, DELAYED_PULSE_40_MHZ};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

const C: f64 = 1540.0;
const F0: f64 = 5e6;
const ELEMENTS: usize = 21;
const PITCH: f64 = 0.3e-3;
const INTERPOLATIONS: [IqInterpolation; 3] = [
    IqInterpolation::Linear,
    IqInterpolation::Cubic,
    IqInterpolation::Sinc,
];
const ZERO: Complex<f32> = Complex::new(0.0, 0.0);

fn convex() -> Vec<Element> {
    (0..ELEMENTS)
        .map(|m| Element::convex(ELEMENTS, PITCH, 40e-3, m))
        .collect()
}

fn parameters(fs: f64, samples: usize, interpolation: IqInterpolation) -> IqParameters {
    IqParameters {
        sound_speed: C,
        sampling_rate: fs,
        demodulation_frequency: 4.8e6,
        output_rate: 15e6,
        output_start: -0.5e-6,
        output_samples: (samples as f64 * 15e6 / fs) as usize + 5,
        elements: ELEMENTS,
        record_samples: samples,
        interpolation,
    }
}

/// A line and a law for each: straight down, of a sector, and along a convex array's normal.
fn lines(convex: &[Element]) -> [ScanLine<'_>; 4] {
    let linear = Array::linear(ELEMENTS, PITCH);
    let array = Array::At {
        elements: convex,
        pitch: PITCH,
    };
    let line = |array, ray, law| ScanLine {
        transmit: Transmit::new(law, 0.37e-6),
        ray,
        array,
        active: Active {
            first: 2,
            count: ELEMENTS - 3,
        },
        compounding: Compounding::Replace,
    };
    [
        line(linear, Ray::down(0.41e-3), TransmitLaw::Focused),
        line(
            linear,
            Ray::down(-0.6e-3),
            TransmitLaw::Plane { angle: 0.15 },
        ),
        line(
            linear,
            Ray::new(0.0, 0.0, 0.6),
            TransmitLaw::VirtualSource { x: 1e-3, z: -8e-3 },
        ),
        line(
            array,
            array.normal(15.2),
            TransmitLaw::Element {
                x: 1e-3,
                z: -0.1e-3,
            },
        ),
    ]
}

fn noise(length: usize, seed: u64) -> Vec<Complex<f32>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut number = || rng.random_range(-1.0f32..1.0);
    (0..length)
        .map(|_| Complex::new(number(), number()))
        .collect()
}

fn planar(iq: &[Complex<f32>]) -> IqRecord<'_> {
    IqRecord::new(IqSamples::Float(iq), IqLayout::Planar, ELEMENTS).unwrap()
}

fn core_line<V: Vector>(
    zero: V,
    p: &IqParameters,
    line: &ScanLine,
    record: &IqRecord,
) -> Vec<Complex<f32>> {
    let mut out = vec![Complex::new(f32::NAN, f32::NAN); p.output_samples * p.elements];
    line_into(zero, p, line, record, &mut out);
    out
}

fn line_into<V: Vector>(
    zero: V,
    p: &IqParameters,
    line: &ScanLine,
    record: &IqRecord,
    out: &mut [Complex<f32>],
) {
    let delay = IqDelay::new(*p).unwrap();
    let mut scratch = vec![f32::NAN; p.scratch_len(V::LANES)];
    delay.line(zero, line, record, &mut scratch, out).unwrap();
}

fn assert_same_bits(left: &[Complex<f32>], right: &[Complex<f32>], what: &str) {
    assert_eq!(left.len(), right.len());
    for (index, (a, b)) in left.iter().zip(right).enumerate() {
        let same = a.re.to_bits() == b.re.to_bits() && a.im.to_bits() == b.im.to_bits();
        assert!(same, "{what}: {a} and {b} at {index}");
    }
}

struct Twice<'a>(&'a IqParameters, &'a ScanLine<'a>, &'a IqRecord<'a>);

impl Task for Twice<'_> {
    type Output = Vec<Complex<f32>>;
    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let Twice(p, line, record) = self;
        let mut out = core_line(zero, p, line, record);
        let add = ScanLine {
            compounding: Compounding::Add,
            ..*line
        };
        line_into(zero, p, &add, record, &mut out);
        out
    }
}

#[test]
fn equals_the_f32_reference_to_the_bit_on_every_instruction_set() {
    let convex = convex();
    let mut seed = 0;
    for (fs, samples) in [(10e6, 300), (4.7e6, 170), (40e6, 900)] {
        for interpolation in INTERPOLATIONS {
            let p = parameters(fs, samples, interpolation);
            for line in lines(&convex) {
                seed += 1;
                let iq = noise(ELEMENTS * samples, seed);
                let what = format!("{fs}, {interpolation:?}, {line:?}");
                let record = planar(&iq).with_phase(0.7).unwrap();
                let mut expected = vec![Complex::new(7.0, 7.0); p.output_samples * ELEMENTS];
                reference::f32::iq::line(&p, &line, (&iq, 1.0, 0.7), &mut expected);
                assert_same_bits(&core_line(0.0f32, &p, &line, &record), &expected, &what);
                assert!(expected.iter().any(|y| *y != ZERO), "{what}: empty");
                // Once more, on top.
                let add = ScanLine {
                    compounding: Compounding::Add,
                    ..line
                };
                reference::f32::iq::line(&p, &add, (&iq, 1.0, 0.7), &mut expected);
                for set in InstructionSet::available() {
                    let ours = set.dispatch(Twice(&p, &line, &record));
                    assert_same_bits(&ours, &expected, &format!("{what}: {set:?}"));
                }
            }
        }
    }
}

#[test]
fn counts_and_either_order_have_the_bits_of_complex_numbers() {
    let convex = convex();
    let samples = 200;
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let counts: Vec<[i16; 2]> = (0..ELEMENTS * samples).map(|_| rng.random()).collect();
    let turned: Vec<[i16; 2]> = (0..ELEMENTS * samples)
        .map(|i| counts[(i % ELEMENTS) * samples + i / ELEMENTS])
        .collect();
    let complex = |counts: &[[i16; 2]], scale: f32| -> Vec<Complex<f32>> {
        let parts = counts.iter();
        parts
            .map(|&[i, q]| Complex::new(scale * f32::from(i), scale * f32::from(q)))
            .collect()
    };
    for interpolation in INTERPOLATIONS {
        let p = parameters(10e6, samples, interpolation);
        for line in lines(&convex) {
            // A power of two changes no rounding, so that scaling first or last is the same.
            let scale = 1.0 / 4096.0;
            let floats = complex(&counts, scale);
            let expected = core_line(0.0f32, &p, &line, &planar(&floats));
            let interleaved = complex(&turned, scale);
            for (samples, layout) in [
                (IqSamples::Float(&interleaved), IqLayout::Interleaved),
                (IqSamples::Counts(&counts, scale), IqLayout::Planar),
                (IqSamples::Counts(&turned, scale), IqLayout::Interleaved),
            ] {
                let record = IqRecord::new(samples, layout, ELEMENTS).unwrap();
                let ours = core_line(0.0f32, &p, &line, &record);
                assert_same_bits(&ours, &expected, &format!("{interpolation:?} {layout:?}"));
            }
            // Any scale: the reference's order.
            let record = IqRecord::new(IqSamples::Counts(&counts, 0.3), IqLayout::Planar, ELEMENTS);
            let ours = core_line(0.0f32, &p, &line, &record.unwrap());
            let mut reference = vec![ZERO; ours.len()];
            reference::f32::iq::line(
                &p,
                &line,
                (&complex(&counts, 1.0), 0.3, 0.0),
                &mut reference,
            );
            assert_same_bits(&ours, &reference, "scaled");
        }
    }
}

/// The envelope of a Gaussian pulse of so much bandwidth at −6 dB, Hz.
fn envelope(t: f64, bandwidth: f64) -> f64 {
    let a = (PI * bandwidth).powi(2) / (4.0 * 10f64.powf(6.0 / 20.0).ln());
    (-a * t * t).exp()
}

/// Echoes of points (x, z) as I/Q and as RF: on each element a pulse around 5 MHz centred on the time
/// that the wave takes.
fn echoes(
    p: &IqParameters,
    line: &ScanLine,
    points: &[[f64; 2]],
    (bandwidth, rf_rate, rf_samples): (f64, f64, usize),
) -> (Vec<Complex<f32>>, Vec<f32>) {
    let transmit = |x: f64, z: f64| match line.transmit.law {
        TransmitLaw::Focused => (x - line.ray.x()).hypot(z) / C,
        TransmitLaw::Plane { angle } => (x * angle.sin() + z * angle.cos()) / C,
        TransmitLaw::Element { x: ex, z: ez } => (x - ex).hypot(z - ez) / C,
        TransmitLaw::VirtualSource { x: sx, z: sz } => ((x - sx).hypot(z - sz) - sx.hypot(sz)) / C,
        TransmitLaw::Delays(_) => unreachable!("not one of `lines`"),
    };
    let (mut iq, mut rf) = (Vec::new(), Vec::new());
    for m in 0..ELEMENTS {
        let [ex, ez] = line.array.position(m);
        let arrivals: Vec<f64> = (points.iter())
            .map(|&[x, z]| transmit(x, z) + (x - ex).hypot(z - ez) / C)
            .collect();
        for k in 0..p.record_samples {
            let t = line.transmit.t0 + k as f64 / p.sampling_rate;
            let mut sum = Complex::new(0.0, 0.0);
            for arrival in &arrivals {
                let late = t - arrival;
                let angle = TAU * (F0 * late - p.demodulation_frequency * t);
                sum += Complex::from_polar(envelope(late, bandwidth), angle);
            }
            iq.push(Complex::new(sum.re as f32, sum.im as f32));
        }
        for k in 0..rf_samples {
            let t = line.transmit.t0 + k as f64 / rf_rate;
            let echo = |arrival: &f64| {
                let late = t - arrival;
                envelope(late, bandwidth) * (TAU * F0 * late).cos()
            };
            rf.push(arrivals.iter().map(echo).sum::<f64>() as f32);
        }
    }
    (iq, rf)
}

/// The largest difference, of a peak of 1.
fn worst(ours: &[Complex<f32>], exact: impl Iterator<Item = Complex<f64>>) -> f64 {
    let difference = |(y, e): (&Complex<f32>, Complex<f64>)| {
        (f64::from(y.re) - e.re).hypot(f64::from(y.im) - e.im)
    };
    ours.iter().zip(exact).map(difference).fold(0.0, f64::max)
}

/// The table of docs/numerics.md: rate over bandwidth, and the largest error of each reading on echoes,
/// against the f64 reference and against the delayed analytic samples of the RF.
const ERRORS: [(f64, f64, [f64; 3]); 6] = [
    // bandwidth of 5 MHz, complex rate, linear, cubic, sinc
    (0.6, 10e6, [8.0e-2, 2.4e-2, 6.9e-4]),
    (0.6, 15e6, [3.7e-2, 5.5e-3, 3.6e-4]),
    (0.6, 25e6, [1.4e-2, 7.7e-4, 3.5e-4]),
    (0.6, 100e6, [8.5e-4, 1.2e-5, 3.4e-4]),
    (0.3, 10e6, [2.3e-2, 2.1e-3, 3.6e-4]),
    (0.8, 15e6, [6.4e-2, 1.6e-2, 3.9e-4]),
];

#[test]
fn the_documented_errors_hold_against_the_reference_and_against_rf() {
    let convex = convex();
    const RF_RATE: f64 = 80e6;
    for (bandwidth, fs, bounds) in ERRORS {
        for line in lines(&convex) {
            for (interpolation, bound) in INTERPOLATIONS.into_iter().zip(bounds) {
                let mut p = parameters(fs, (30e-6 * fs) as usize, interpolation);
                p.output_rate = 40e6;
                p.output_start = 5e-6;
                p.output_samples = 800;
                let [x, z] = line.ray.point(17e-3);
                let points = [[x, z], [x + 1e-3, z - 6e-3]];
                let rf_samples = (30e-6 * RF_RATE) as usize;
                let scene = (bandwidth * F0, RF_RATE, rf_samples);
                let (iq, rf) = echoes(&p, &line, &points, scene);
                let ours = core_line(0.0f32, &p, &line, &planar(&iq));
                let what = format!("{bandwidth}, {fs}, {interpolation:?}");
                let exact = reference::f64::iq::line(&p, &line, &iq);
                let error = worst(&ours, exact.iter().copied());
                println!("{what}: {error:.2e}");
                assert!(error < bound, "{what}: {error}");
                assert!(ours.iter().any(|y| y.norm() > 0.95), "{what}: empty");

                // The RF of the same echoes: the same samples.
                let of_rf = DelayParameters {
                    sound_speed: C,
                    sampling_rate: RF_RATE,
                    centre_frequency: F0,
                    output_rate: p.output_rate,
                    output_start: p.output_start,
                    output_samples: p.output_samples,
                    elements: ELEMENTS,
                    record_samples: rf_samples,
                    hilbert_taps: hilbert_taps(p.output_rate, F0),
                };
                let mut analytic = vec![ZERO; ours.len()];
                let mut scratch = vec![0.0; of_rf.scratch_len(1)];
                let delay = Delay::new(of_rf).unwrap();
                let record = Record::new(&rf, ELEMENTS).unwrap();
                delay
                    .line(0.0f32, &line, &record, &mut scratch, &mut analytic)
                    .unwrap();
                let wide = |y: &Complex<f32>| Complex::new(f64::from(y.re), f64::from(y.im));
                let error = worst(&ours, analytic.iter().map(wide));
                // A pulse of 80 % reaches down to where the Hilbert transformer errs more.
                let of_rf = if bandwidth > 0.6 {
                    DELAYED_PULSE_20_MHZ
                } else {
                    DELAYED_PULSE_40_MHZ
                };
                assert!(error < bound + of_rf, "{what}, RF: {error}");
            }
        }
    }
}

#[test]
fn the_default_is_the_cheapest_within_a_thousandth() {
    for (bandwidth, fs, errors) in ERRORS {
        let interpolation = IqInterpolation::for_band(fs, bandwidth * F0);
        let chosen = INTERPOLATIONS
            .iter()
            .position(|r| *r == interpolation)
            .unwrap();
        assert!(errors[chosen] <= 1e-3, "{bandwidth} {fs}");
        assert!(
            errors[..chosen]
                .iter()
                .all(|&error| error > 1e-3 || fs < 8.0 * bandwidth * F0)
        );
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
    let iq = vec![Complex::new(1e29, -1e29); 30];
    for round in 0..3000 {
        let elements = [0, 1, 2].map(|_| Element {
            x: extreme(true),
            z: extreme(true),
            angle: 0.0,
        });
        let delays = [extreme(true), extreme(true), f64::NAN];
        let law = match round % 5 {
            0 => TransmitLaw::Plane { angle: 1.5 },
            1 => TransmitLaw::Focused,
            2 => TransmitLaw::VirtualSource {
                x: extreme(true),
                z: extreme(true),
            },
            3 => TransmitLaw::Delays(&delays),
            _ => TransmitLaw::Element {
                x: extreme(true),
                z: extreme(true),
            },
        };
        let fs = extreme(false) + 1e-60;
        let p = IqParameters {
            sound_speed: extreme(false) + 1e-60,
            sampling_rate: fs,
            demodulation_frequency: fs * [0.3, 0.9e6, -7.0, 0.0][round % 4],
            output_rate: fs,
            output_start: extreme(true),
            output_samples: 20,
            elements: 3,
            record_samples: 10,
            interpolation: INTERPOLATIONS[round % 3],
        };
        let line = ScanLine {
            transmit: Transmit::new(law, extreme(true)),
            ray: Ray::new(extreme(true), extreme(true), extreme(true)),
            array: Array::At {
                elements: &elements,
                pitch: 1.0,
            },
            active: Active { first: 0, count: 3 },
            compounding: Compounding::Replace,
        };
        let what = format!("{p:?} {line:?}");
        let record = IqRecord::new(IqSamples::Float(&iq), IqLayout::Planar, 3).unwrap();
        let ours = core_line(0.0f32, &p, &line, &record);
        for y in &ours {
            assert!(y.re.is_finite() && y.im.is_finite(), "{what}");
        }
        let mut reference = vec![Complex::new(7.0, 7.0); ours.len()];
        reference::f32::iq::line(&p, &line, (&iq, 1.0, 0.0), &mut reference);
        assert_same_bits(&ours, &reference, &what);
    }
}

#[test]
fn what_is_wrong_is_named() {
    let good = parameters(10e6, 100, IqInterpolation::Cubic);
    let name = |change: fn(&mut IqParameters)| {
        let mut p = good;
        change(&mut p);
        match IqDelay::new(p) {
            Err(Error::Parameter { name, .. } | Error::Capacity { name, .. }) => name,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(name(|p| p.sound_speed = 0.0), "sound_speed");
    assert_eq!(name(|p| p.sampling_rate = f64::NAN), "sampling_rate");
    assert_eq!(name(|p| p.output_rate = -1.0), "output_rate");
    assert_eq!(name(|p| p.output_start = f64::INFINITY), "output_start");
    assert_eq!(name(|p| p.output_samples = 0), "output_samples");
    assert_eq!(
        name(|p| p.record_samples = MAX_SAMPLES + 1),
        "record_samples"
    );
    assert_eq!(name(|p| p.elements = 0), "elements");
    assert_eq!(name(|p| p.elements = usize::MAX), "elements");
    let demodulation = "demodulation_frequency";
    assert_eq!(name(|p| p.demodulation_frequency = f64::NAN), demodulation);
    assert_eq!(name(|p| p.demodulation_frequency = 1e14), demodulation);

    let mut iq = noise(ELEMENTS * 100, 1);
    let record = |iq: &[Complex<f32>], elements: usize| {
        IqRecord::new(IqSamples::Float(iq), IqLayout::Planar, elements).map(|_| ())
    };
    assert_eq!(
        record(&iq, 0).unwrap_err().to_string().split(' ').next(),
        Some("elements")
    );
    assert!(matches!(
        record(&iq[1..], ELEMENTS),
        Err(Error::Length { name: "iq", .. })
    ));
    assert!(matches!(
        record(&[], 2),
        Err(Error::Length { name: "iq", .. })
    ));
    iq[777].im = 2e29;
    assert!(matches!(
        record(&iq, ELEMENTS),
        Err(Error::Parameter { name: "iq", .. })
    ));
    iq[777].im = f32::NAN;
    assert_eq!(
        record(&iq, ELEMENTS),
        Err(Error::NonFinite {
            name: "iq",
            index: 777
        })
    );
    for scale in [f32::NAN, 1e25] {
        let counts = IqSamples::Counts(&[[1, 2]], scale);
        let error = IqRecord::new(counts, IqLayout::Planar, 1).unwrap_err();
        assert!(matches!(
            error,
            Error::Parameter {
                name: "iq scale",
                ..
            }
        ));
    }

    let convex = convex();
    let [line, ..] = lines(&convex);
    let iq = noise(ELEMENTS * 100, 1);
    let delay = IqDelay::new(good).unwrap();
    let refused = |line: &ScanLine, scratch: usize, out: usize| {
        let mut out = vec![Complex::new(5.0, 6.0); out];
        let scratch = &mut vec![0.0; scratch];
        let result = delay.line(0.0f32, line, &planar(&iq), scratch, &mut out);
        assert!(out.iter().all(|y| *y == Complex::new(5.0, 6.0)));
        result.unwrap_err().to_string()
    };
    let (scratch, out) = (good.scratch_len(1), good.output_samples * ELEMENTS);
    assert!(refused(&line, scratch - 1, out).starts_with("scratch"));
    assert!(refused(&line, scratch, out + 1).starts_with("out"));
    let beyond = ScanLine {
        active: Active {
            first: 1,
            count: ELEMENTS,
        },
        ..line
    };
    assert!(refused(&beyond, scratch, out).starts_with("active"));
    let nowhere = ScanLine {
        ray: Ray::new(0.0, f64::NAN, 0.0),
        ..line
    };
    assert!(refused(&nowhere, scratch, out).starts_with("line depth"));
}

/// Noise as counts, and the same numbers as f32.
fn counted(samples: usize, seed: u64) -> (Vec<[i16; 2]>, Vec<Complex<f32>>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let counts: Vec<[i16; 2]> = (0..ELEMENTS * samples).map(|_| rng.random()).collect();
    let floats = counts.iter();
    let floats = floats.map(|&[i, q]| Complex::new(f32::from(i), f32::from(q)));
    let floats = floats.collect();
    (counts, floats)
}

#[test]
fn fixed_point_equals_the_reference_to_the_bit() {
    let convex = convex();
    for (fs, samples) in [(10e6, 300), (4.7e6, 170), (40e6, 900)] {
        let p = parameters(fs, samples, IqInterpolation::LinearFixed);
        for (seed, line) in lines(&convex).into_iter().enumerate() {
            let (counts, floats) = counted(samples, seed as u64);
            let interleaved: Vec<[i16; 2]> = (0..ELEMENTS * samples)
                .map(|i| counts[(i % ELEMENTS) * samples + i / ELEMENTS])
                .collect();
            let mut expected = vec![Complex::new(7.0, 7.0); p.output_samples * ELEMENTS];
            reference::f32::iq::line(&p, &line, (&floats, 0.3, 0.7), &mut expected);
            assert!(expected.iter().any(|y| *y != ZERO), "{line:?}: empty");
            let mut twice = expected.clone();
            let add = ScanLine {
                compounding: Compounding::Add,
                ..line
            };
            reference::f32::iq::line(&p, &add, (&floats, 0.3, 0.7), &mut twice);
            for (counts, layout) in [
                (&counts, IqLayout::Planar),
                (&interleaved, IqLayout::Interleaved),
            ] {
                let record = IqRecord::new(IqSamples::Counts(counts, 0.3), layout, ELEMENTS);
                let record = record.unwrap().with_phase(0.7).unwrap();
                let what = format!("{fs}, {layout:?}, {line:?}");
                assert_same_bits(&core_line(0.0f32, &p, &line, &record), &expected, &what);
                for set in InstructionSet::available() {
                    let ours = set.dispatch(Twice(&p, &line, &record));
                    assert_same_bits(&ours, &twice, &format!("{what}: {set:?}"));
                }
            }
        }
    }
}

/// The table of docs/numerics.md, its last column: the pulse's peak has 16 000 counts.
#[test]
fn the_documented_errors_of_fixed_point_hold() {
    let convex = convex();
    let bounds = [8.0e-2, 3.7e-2, 1.4e-2, 1.2e-3, 2.3e-2, 6.4e-2];
    for ((bandwidth, fs, _), bound) in ERRORS.into_iter().zip(bounds) {
        for line in lines(&convex) {
            let mut p = parameters(fs, (30e-6 * fs) as usize, IqInterpolation::LinearFixed);
            p.output_rate = 40e6;
            p.output_start = 5e-6;
            p.output_samples = 800;
            let [x, z] = line.ray.point(17e-3);
            let (iq, _) = echoes(&p, &line, &[[x, z]], (bandwidth * F0, 1e6, 1));
            let counts: Vec<[i16; 2]> = iq
                .iter()
                .map(|y| [y.re, y.im].map(|part| (16_000.0 * part).round() as i16))
                .collect();
            let samples = IqSamples::Counts(&counts, 1.0 / 16_000.0);
            let record = IqRecord::new(samples, IqLayout::Planar, ELEMENTS).unwrap();
            let ours = core_line(0.0f32, &p, &line, &record);
            let exact = reference::f64::iq::line(&p, &line, &iq);
            let error = worst(&ours, exact.iter().copied());
            println!("{bandwidth}, {fs}: {error:.2e}");
            assert!(error < bound, "{bandwidth}, {fs}: {error}");
            assert!(
                ours.iter().any(|y| y.norm() > 0.9),
                "{bandwidth}, {fs}: empty"
            );
        }
    }
}

#[test]
fn fixed_point_takes_extreme_geometry_and_refuses_what_it_cannot_read() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let mut extreme = || {
        let magnitude = 10f64.powf(rng.random_range(-40.0..40.0));
        [magnitude, -magnitude, 0.0, 1e-2][rng.random_range(0..4)]
    };
    let counts = [[i16::MIN, i16::MAX]; 30];
    let record = IqRecord::new(IqSamples::Counts(&counts, 1e24), IqLayout::Planar, 3).unwrap();
    let (mut read, mut refused) = (0, 0);
    for round in 0..3000 {
        let x = [extreme(), extreme(), extreme()];
        let fs = extreme().abs() + 1e-40;
        let p = IqParameters {
            sound_speed: extreme().abs() + 1e-40,
            sampling_rate: fs,
            demodulation_frequency: fs * [0.3, 1.9, -1.9, 0.0][round % 4],
            output_rate: extreme().abs() + 1e-40,
            output_start: extreme(),
            output_samples: 20,
            elements: 3,
            record_samples: 10,
            interpolation: IqInterpolation::LinearFixed,
        };
        let ray = if round % 2 == 0 {
            Ray::down(extreme())
        } else {
            Ray::new(extreme(), extreme(), extreme())
        };
        let line = ScanLine {
            transmit: Transmit::new(TransmitLaw::Plane { angle: 0.3 }, extreme()),
            ray,
            array: Array::LinearAt(&x),
            active: Active { first: 0, count: 3 },
            compounding: Compounding::Replace,
        };
        let mut out = vec![Complex::new(f32::NAN, 0.0); p.output_samples * p.elements];
        let mut scratch = vec![0.0; p.scratch_len(1)];
        let delay = IqDelay::new(p).unwrap();
        match delay.line(0.0f32, &line, &record, &mut scratch, &mut out) {
            Ok(()) => read += 1,
            Err(Error::Parameter { name, .. }) => {
                assert_eq!(name, "element's way to the line");
                assert!(out.iter().all(|y| y.re.is_nan()), "written, then refused");
                refused += 1;
                continue;
            }
            Err(error) => panic!("{error}"),
        }
        for y in out {
            assert!(y.re.is_finite() && y.im.is_finite(), "{p:?} {line:?}");
        }
    }
    assert!(read > 300 && refused > 300, "{read} {refused}");
    let good = parameters(10e6, 100, IqInterpolation::LinearFixed);
    let name = |p: IqParameters| match IqDelay::new(p) {
        Err(Error::Parameter { name, .. } | Error::Capacity { name, .. }) => name,
        other => panic!("{other:?}"),
    };
    let demodulation_frequency = 20e6;
    assert_eq!(
        name(IqParameters {
            demodulation_frequency,
            ..good
        }),
        "demodulation_frequency"
    );
    let record_samples = 65_537;
    assert_eq!(
        name(IqParameters {
            record_samples,
            ..good
        }),
        "record_samples"
    );
    let elements = 4097;
    assert_eq!(name(IqParameters { elements, ..good }), "elements");
    let floats = noise(ELEMENTS * 100, 1);
    let mut scratch = vec![0.0; good.scratch_len(1)];
    let mut out = vec![ZERO; good.output_samples * ELEMENTS];
    let refused = IqDelay::new(good).unwrap().line(
        0.0f32,
        &lines(&convex())[0],
        &planar(&floats),
        &mut scratch,
        &mut out,
    );
    assert!(matches!(refused, Err(Error::Parameter { name: "iq", .. })));
}

/// The aligned samples of counts by both, onto the same numbers.
fn assert_reference(
    p: &IqParameters,
    line: &ScanLine,
    (counts, scale, phase): (&[[i16; 2]], f32, f64),
    before: &[Complex<f32>],
    what: &str,
) {
    let floats: Vec<_> = counts
        .iter()
        .map(|&[i, q]| Complex::new(f32::from(i), f32::from(q)))
        .collect();
    let mut expected = before.to_vec();
    reference::f32::iq::line(p, line, (&floats, scale, phase), &mut expected);
    let samples = p.record_samples;
    let interleaved: Vec<[i16; 2]> = (0..counts.len())
        .map(|i| counts[(i % p.elements) * samples + i / p.elements])
        .collect();
    for (counts, layout) in [
        (counts, IqLayout::Planar),
        (&interleaved[..], IqLayout::Interleaved),
    ] {
        let samples = IqSamples::Counts(counts, scale);
        let record = IqRecord::new(samples, layout, p.elements).unwrap();
        let record = record.with_phase(phase).unwrap();
        let mut ours = before.to_vec();
        line_into(0.0f32, p, line, &record, &mut ours);
        assert_same_bits(&ours, &expected, &format!("{what}, {layout:?}, {line:?}"));
    }
}

/// A scene where a place is a number of samples: a line straight down from the middle one of three elements, a
/// sample a second of a wave of 2 m/s. The place at t is t − t0, the depth t.
fn plain(interpolation: IqInterpolation) -> (IqParameters, ScanLine<'static>) {
    let p = IqParameters {
        sound_speed: 2.0,
        sampling_rate: 1.0,
        demodulation_frequency: 0.3,
        output_rate: 1.0,
        output_start: 0.0,
        output_samples: 40,
        elements: 3,
        record_samples: 200,
        interpolation,
    };
    let line = ScanLine {
        transmit: Transmit::new(TransmitLaw::Focused, 0.0),
        ray: Ray::down(0.0),
        array: Array::linear(3, 7.0),
        active: Active { first: 0, count: 3 },
        compounding: Compounding::Add,
    };
    (p, line)
}

#[test]
fn fixed_point_reads_to_the_end_of_a_record_and_no_further() {
    let convex = convex();
    let mut p = parameters(10e6, 60, IqInterpolation::LinearFixed);
    p.output_samples = 120;
    for (seed, line) in lines(&convex).into_iter().enumerate() {
        let (counts, _) = counted(60, seed as u64);
        let before = vec![ZERO; p.output_samples * ELEMENTS];
        assert_reference(&p, &line, (&counts, 0.3, 0.7), &before, "end");
    }
}

#[test]
fn fixed_point_has_the_bits_of_the_reference_where_nothing_is_above_and_far_from_t0() {
    let (counts, _) = counted(200, 5);
    let counts = &counts[..600];
    let before = noise(120, 6);
    let (p, line) = plain(IqInterpolation::LinearFixed);
    // The first sample lies at depth 0; what stood there stays.
    let mut at_five = line;
    at_five.transmit.t0 = -5.0;
    assert_reference(&p, &at_five, (counts, 0.3, 0.0), &before, "depth 0");
    // Whole samples, beyond the 64th too, and more than 2¹⁹ whole turns.
    let mut at_sixty = line;
    at_sixty.transmit.t0 = -60.0;
    for phase in [0.7, -1e7, 1e7] {
        assert_reference(&p, &at_sixty, (counts, 0.3, phase), &before, "turns");
    }
    // A scale below 0: zeros have its sign.
    let replace = ScanLine {
        compounding: Compounding::Replace,
        ..at_five
    };
    let zeros = vec![[0; 2]; 600];
    let samples = IqSamples::Counts(&zeros, -0.3);
    let record = IqRecord::new(samples, IqLayout::Interleaved, 3).unwrap();
    let floats = vec![ZERO; 600];
    let (mut ours, mut expected) = (before.clone(), before.clone());
    line_into(0.0f32, &p, &replace, &record, &mut ours);
    reference::f32::iq::line(&p, &replace, (&floats, -0.3, 0.0), &mut expected);
    assert_same_bits(&ours, &expected, "scale below 0");
    // A depth that is the largest number.
    let mut deepest = p;
    deepest.sound_speed = 2f64.powi(100);
    deepest.output_start = 2.0 * f64::from(f32::MAX) / deepest.sound_speed;
    let mut there = line;
    there.transmit.t0 = deepest.output_start - 50.0;
    assert_reference(&deepest, &there, (counts, 0.3, 0.0), &before, "deepest");
}

/// Added to −0, whatever is read gives 0; where nothing is, −0 stays.
#[test]
fn places_beyond_two_to_the_23_are_left_alone_as_in_the_reference() {
    const FAR: f64 = 8_388_608.0;
    let (counts, _) = counted(200, 5);
    let counts = &counts[..600];
    let before = vec![Complex::new(-0.0, -0.0); 120];
    for interpolation in INTERPOLATIONS
        .into_iter()
        .chain([IqInterpolation::LinearFixed])
    {
        for law in [
            TransmitLaw::Focused,
            TransmitLaw::Element { x: 0.0, z: 0.0 },
        ] {
            let (mut p, mut line) = plain(interpolation);
            line.transmit.law = law;
            // The first place, and the last one: before, at and behind the limit.
            for aside in [-45.0, -39.0, -38.0, -20.0, -1.0, 0.0, 1.0, 5.0] {
                p.output_start = 1.0;
                line.transmit.t0 = 1.0 + FAR - aside;
                let what = format!("{interpolation:?} {aside}");
                assert_reference(&p, &line, (counts, 0.3, 0.7), &before, &what);
                p.output_start = FAR + aside;
                line.transmit.t0 = 0.0;
                assert_reference(&p, &line, (counts, 0.3, 0.7), &before, &what);
            }
        }
    }
    // As many turns as there are numbers.
    for interpolation in INTERPOLATIONS {
        for demodulation_frequency in [2.0, -2.0] {
            let (mut p, mut line) = plain(interpolation);
            (p.sound_speed, p.sampling_rate, p.output_samples) = (1.0, 2.0, 1);
            p.demodulation_frequency = demodulation_frequency;
            p.output_start = f64::MAX / 2.0;
            line.transmit.t0 = p.output_start;
            let what = format!("{interpolation:?} {demodulation_frequency}");
            assert_reference(&p, &line, (counts, 0.3, 0.0), &before[..3], &what);
        }
    }
}

/// Places grow evenly from the first sample to the last; one behind the last that were too far does not
/// matter.
#[test]
fn fixed_point_of_a_line_that_ends_near_the_limit_is_even() {
    let (mut p, mut line) = plain(IqInterpolation::LinearFixed);
    p.record_samples = 65_000;
    p.output_rate = 1.0 / 1000.37;
    p.output_start = 1.0;
    p.output_samples = 8386;
    line.array = Array::linear(3, 6000.0);
    let last = p.output_start + 8385.0 / p.output_rate;
    assert!(last < 8_388_608.0 && last + 1.0 / p.output_rate > 8_388_608.0);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let counts: Vec<[i16; 2]> = (0..3 * 65_000).map(|_| rng.random()).collect();
    let before = vec![ZERO; 3 * p.output_samples];
    assert_reference(&p, &line, (&counts, 0.3, 0.0), &before, "even");
}

#[test]
fn fixed_point_reads_elements_below_8191_samples_way() {
    let (mut p, mut line) = plain(IqInterpolation::LinearFixed);
    p.elements = 1;
    // Two samples a metre.
    (p.sound_speed, p.sampling_rate) = (1.0, 2.0);
    line.active.count = 1;
    let counts = vec![[1i16, 2]; 200];
    let record = IqRecord::new(IqSamples::Counts(&counts, 1.0), IqLayout::Planar, 1).unwrap();
    let read = |array: Array| {
        let line = ScanLine { array, ..line };
        let mut out = vec![ZERO; p.output_samples];
        let mut scratch = vec![0.0; p.scratch_len(1)];
        let delay = IqDelay::new(p).unwrap();
        let result = delay.line(0.0f32, &line, &record, &mut scratch, &mut out);
        match result {
            Ok(()) => Ok(out),
            Err(Error::Parameter { name, value, .. }) => Err((name, value)),
            Err(error) => panic!("{error}"),
        }
    };
    let beyond = Err(("element's way to the line", 4095.5));
    for sign in [1.0, -1.0] {
        assert!(read(Array::LinearAt(&[sign * 4095.25])).is_ok());
        assert_eq!(read(Array::LinearAt(&[sign * 4095.5])), beyond);
        // How far it lies along the line counts twice.
        let along = |z: f64| {
            let element = Element {
                x: 0.0,
                z: sign * z,
                angle: 0.0,
            };
            read(Array::At {
                elements: &[element],
                pitch: 1.0,
            })
        };
        assert!(along(2047.5).is_ok());
        assert_eq!(along(2047.75), beyond);
    }
    // One element alone has no pitch.
    assert_eq!(
        read(Array::LinearAt(&[0.0])),
        read(Array::linear(1, 0.3e-3))
    );
}

#[test]
fn memory_and_the_way_of_reading_follow_from_the_parameters() {
    let p = parameters(10e6, 100, IqInterpolation::Cubic);
    // Seven numbers an element, up to full vectors.
    for (lanes, elements) in [(0, 21), (1, 21), (4, 24), (8, 24), (16, 32)] {
        assert_eq!(p.scratch_len(lanes), 7 * elements, "{lanes}");
    }
    // A pulse of 60 % of 5 MHz: 3 MHz, of which 96 MHz are 32 times as much.
    for (sampling_rate, interpolation) in [
        (96e6, IqInterpolation::Linear),
        (95e6, IqInterpolation::Cubic),
        (24e6, IqInterpolation::Cubic),
        (23e6, IqInterpolation::Sinc),
    ] {
        let scan = Scan::of_iq(ScanParameters {
            array: Array::linear(16, PITCH),
            lines: Lines::Even(Axis::centred(5, 0.1e-3)),
            sound_speed: C,
            centre_frequency: F0,
            sampling_rate,
            record_samples: 256,
            output_rate: 15e6,
            start: Depth::Metres(4e-3),
            end: Depth::Metres(12e-3),
            f_number: 1.5,
            min_elements: 8,
        });
        let found = IqParameters::of(&scan.unwrap(), 4.8e6).interpolation;
        assert_eq!(found, interpolation, "{sampling_rate}");
    }
}

#[test]
fn a_sample_of_which_both_parts_are_too_large_is_named() {
    let mut iq = noise(ELEMENTS * 10, 1);
    iq[77] = Complex::new(-2e29, 3e29);
    let refused = IqRecord::new(IqSamples::Float(&iq), IqLayout::Planar, ELEMENTS);
    let Err(Error::Parameter { name, value, .. }) = refused else {
        panic!("{refused:?}");
    };
    assert_eq!((name, value), ("iq", f64::from(-2e29f32)));
}

/// Places behind the longest record, and an element that hears them thousands of samples earlier: within the record, or
/// still behind it.
#[test]
fn fixed_point_of_an_element_far_ahead_has_the_bits_of_the_reference() {
    let (mut p, line) = plain(IqInterpolation::LinearFixed);
    (p.elements, p.record_samples) = (1, 65_536);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let counts: Vec<[i16; 2]> = (0..65_536).map(|_| rng.random()).collect();
    for sign in [1.0, -1.0] {
        let element = Element {
            x: 0.0,
            z: sign * 8000.0,
            angle: 0.0,
        };
        let mut line = ScanLine {
            array: Array::At {
                elements: &[element],
                pitch: 1.0,
            },
            active: Active { first: 0, count: 1 },
            ..line
        };
        for position in [-100_000.0, -66_000.0, 66_000.0, 100_000.0] {
            p.output_start = 10_000.0;
            line.transmit.t0 = p.output_start - position;
            let before = vec![ZERO; p.output_samples];
            let what = format!("{sign} {position}");
            assert_reference(&p, &line, (&counts, 0.3, 0.0), &before, &what);
        }
    }
}
