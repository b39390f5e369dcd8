//! I/Q: the delay stage against both references and the RF of the same echoes.
//!
//! Also its invariants.

mod fixed_point;
mod refused;

use crate::common;
use crate::common::kit::*;
use bonebeam::delay::{MAX_SAMPLES, hilbert_taps};
use common::delays::{self, C, F0, aligned, arrival, convex, envelope, rf_line};
use common::tolerances::{DELAYED_PULSE_20_MHZ, DELAYED_PULSE_40_MHZ};

const ELEMENTS: usize = 21;
const PITCH: f64 = 0.3e-3;
const INTERPOLATIONS: [IqInterpolation; 3] = [
    IqInterpolation::Linear,
    IqInterpolation::Cubic,
    IqInterpolation::Sinc,
];
const ZERO: Complex<f32> = Complex::new(0.0, 0.0);

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
    let array = Array::at(convex, PITCH);
    let line = |array, ray, law| ScanLine {
        active: Active::new(2, ELEMENTS - 3),
        ..ScanLine::new(Transmit::new(law, 0.37e-6), ray, array)
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
    let numbers = delays::noise(2 * length, seed);
    let (pairs, _) = numbers.as_chunks::<2>();
    pairs.iter().map(|&[re, im]| Complex::new(re, im)).collect()
}

fn planar(iq: &[Complex<f32>]) -> Record<'_> {
    Record::iq(IqSamples::Float(iq), IqLayout::Planar, ELEMENTS).unwrap()
}

fn core_line(p: &IqParameters, line: &ScanLine, record: &Record) -> Vec<Complex<f32>> {
    aligned(&IqDelay::new(*p).unwrap(), p.output_samples, line, record)
}

/// Echoes of points (x, z) as I/Q and as RF.
///
/// Each element has a pulse around 5 MHz, centred on the wave's travel time.
fn echoes(
    p: &IqParameters,
    line: &ScanLine,
    points: &[[f64; 2]],
    (bandwidth, rf_rate, rf_samples): (f64, f64, usize),
) -> (Vec<Complex<f32>>, Vec<f32>) {
    let transmit =
        |x: f64, z: f64| arrival(line.transmit.law, &[], [x, z], (x - line.ray.x()).hypot(z));
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

/// The largest difference, relative to a peak of 1.
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
    let convex = convex(ELEMENTS);
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
                let ours = core_line(&p, &line, &planar(&iq));
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
                let analytic = rf_line(&of_rf, &line, &rf);
                let wide = |y: &Complex<f32>| Complex::new(f64::from(y.re), f64::from(y.im));
                let error = worst(&ours, analytic.iter().map(wide));
                // A pulse of 80 % reaches frequencies at which the Hilbert transformer errs more.
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
fn memory_and_the_way_of_reading_follow_from_the_parameters() {
    let p = parameters(10e6, 100, IqInterpolation::Cubic);
    // Seven numbers for each element, up to full vectors.
    for (lanes, elements) in [(0, 21), (1, 21), (4, 24), (8, 24), (16, 32)] {
        assert_eq!(p.need(lanes).real, 7 * elements, "{lanes}");
    }
    // A pulse of 60 % at 5 MHz has 3 MHz; 96 MHz are 32 times as much.
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
            ..ScanParameters::EXAMPLE
        });
        let found = IqParameters::of(&scan.unwrap(), 4.8e6).interpolation;
        assert_eq!(found, interpolation, "{sampling_rate}");
    }
}
