//! Curved and phased arrays, rays, transmit laws and the active aperture.
//!
//! The delay stage is compared with the f64 reference.

use crate::common;

use bonebeam::prelude::stages::*;
use bonebeam_oracle::reference;
use common::delays::{C, F0, arrival, convex, pulse, rf_line};
use common::tolerances::{DELAYED_PULSE_20_MHZ, DELAYED_PULSE_40_MHZ};

const ELEMENTS: usize = 33;
const PITCH: f64 = 0.3e-3;

/// Delays of a wave from 15 mm behind the array; two elements do not fire.
fn delays(elements: &[Element]) -> Vec<f64> {
    let mut delays: Vec<f64> = (elements.iter())
        .map(|e| ((e.x - 1e-3).hypot(e.z + 15e-3) - 15e-3) / C)
        .collect();
    delays[3] = f64::NAN;
    delays[20] = f64::INFINITY;
    delays
}

fn laws(delays: &[f64]) -> [TransmitLaw<'_>; 6] {
    [
        TransmitLaw::Focused,
        TransmitLaw::Plane { angle: -0.15 },
        TransmitLaw::Element {
            x: 2.1e-3,
            z: -0.2e-3,
        },
        TransmitLaw::VirtualSource { x: 1e-3, z: -8e-3 },
        TransmitLaw::VirtualSource { x: 2e-3, z: 12e-3 },
        TransmitLaw::Delays(delays),
    ]
}

/// Lines of a linear, a phased and a convex array.
fn lines<'a>(convex: &'a [Element], pitch: f64) -> [(Array<'a>, Ray); 5] {
    let linear = Array::linear(ELEMENTS, pitch);
    let array = Array::at(convex, pitch);
    [
        (linear, Ray::down(0.41e-3)),
        (linear, Ray::new(0.0, 0.0, 0.7)),
        (linear, Ray::new(-1e-3, -0.3e-3, -0.2)),
        (array, array.normal(9.0)),
        (array, array.normal(24.3)),
    ]
}

fn parameters(fs: f64, samples: usize) -> DelayParameters {
    DelayParameters {
        sound_speed: C,
        sampling_rate: fs,
        centre_frequency: F0,
        output_rate: 20e6,
        output_start: -0.5e-6,
        // Down to the record's end.
        output_samples: (samples as f64 * 20e6 / fs) as usize,
        elements: ELEMENTS,
        record_samples: samples,
        hilbert_taps: 8,
    }
}

fn line<'a>(array: Array<'a>, ray: Ray, law: TransmitLaw<'a>) -> ScanLine<'a> {
    ScanLine {
        active: Active::new(2, ELEMENTS - 3),
        ..ScanLine::new(Transmit::new(law, 0.37e-6), ray, array)
    }
}

/// Rates of record and output, Hz, and the tolerance.
const RATES: [(f64, f64, f64); 6] = [
    (20e6, 20e6, DELAYED_PULSE_20_MHZ),
    (40e6, 20e6, DELAYED_PULSE_20_MHZ),
    (100e6, 20e6, DELAYED_PULSE_20_MHZ),
    (200e6, 20e6, DELAYED_PULSE_20_MHZ),
    (40e6, 40e6, DELAYED_PULSE_40_MHZ),
    (100e6, 100e6, DELAYED_PULSE_40_MHZ),
];

#[test]
fn a_point_on_the_line_becomes_a_flat_wavefront_and_the_f64_reference_agrees() {
    let convex = convex(ELEMENTS);
    let delays = delays(&convex);
    for (fs, output_rate, tolerance) in RATES {
        for (array, ray) in lines(&convex, PITCH) {
            for law in laws(&delays) {
                let r = 17.3e-3;
                // Output sample 100 is at the point.
                let p = DelayParameters {
                    output_rate,
                    output_start: 2.0 * r / C - 100.0 / output_rate,
                    output_samples: 200,
                    hilbert_taps: (2.0 * output_rate / F0) as usize,
                    ..parameters(fs, (32e-6 * fs) as usize)
                };
                let line = line(array, ray, law);
                let elements: Vec<[f64; 2]> = (0..ELEMENTS).map(|m| array.position(m)).collect();
                let point = ray.point(r);
                let transmit = arrival(law, &elements, point, r);
                let mut rf = Vec::new();
                for [x, z] in &elements {
                    let flight = transmit + (point[0] - x).hypot(point[1] - z) / C;
                    for k in 0..p.record_samples {
                        rf.push(pulse(line.transmit.t0 + k as f64 / fs - flight) as f32);
                    }
                }
                let out = rf_line(&p, &line, &rf);
                let what = format!("{fs}, {ray:?}, {law:?}");
                for m in line.active.first..line.active.first + line.active.count {
                    let y = out[100 * ELEMENTS + m];
                    let error = (f64::from(y.re) - 1.0).hypot(f64::from(y.im));
                    assert!(error < tolerance, "{what}, element {m}: {y}");
                    // The envelope has its maximum there.
                    for n in [90, 99, 101, 110] {
                        assert!(out[n * ELEMENTS + m].norm() < y.norm(), "{what}, {m}");
                    }
                }
                let exact = reference::f64::delay::line(&p, &line, &rf);
                for (y, e) in out.iter().zip(&exact) {
                    let error = (f64::from(y.re) - e.re).hypot(f64::from(y.im) - e.im);
                    assert!(error < tolerance, "{what}: {y} for {e}");
                }
            }
        }
    }
}

fn scan<'a>(array: Array<'a>, lines: Lines<'a>) -> Scan<'a> {
    Scan::new(ScanParameters {
        array,
        lines,
        sound_speed: C,
        centre_frequency: F0,
        sampling_rate: 40e6,
        record_samples: 2000,
        start: Depth::Metres(0.0),
        end: Depth::Metres(40e-3),
        ..ScanParameters::EXAMPLE
    })
    .unwrap()
}

#[test]
fn rays_straight_down_have_the_active_sets_of_lines() {
    let array = Array::linear(ELEMENTS, PITCH);
    let even = Lines::Even(Axis::centred(2 * ELEMENTS + 9, PITCH / 2.0));
    let rays: Vec<Ray> = (0..even.count()).map(|k| even.ray(k)).collect();
    // Elements without the form of a linear array: the general rule.
    let elements: Vec<Element> = (0..ELEMENTS).map(|m| array.element(m)).collect();
    let at = Array::at(&elements, PITCH);
    let (known, general) = (scan(array, even), scan(at, Lines::Rays(&rays)));
    for line in 0..known.lines() {
        for sample in 0..known.samples() {
            assert_eq!(known.active(line, sample), general.active(line, sample));
        }
    }
}

#[test]
fn the_aperture_is_centred_on_the_ray_and_grows_along_it() {
    let convex = convex(ELEMENTS);
    let array = Array::at(&convex, PITCH);
    let rays: Vec<Ray> = (0..2 * ELEMENTS - 1)
        .map(|k| array.normal(k as f64 / 2.0))
        .collect();
    let scan = scan(array, Lines::Rays(&rays));
    for line in 0..rays.len() {
        assert!((scan.aperture_centre(line) - line as f64 / 2.0).abs() < 1e-3);
        for sample in 0..scan.samples() {
            let active = scan.active(line, sample);
            // The rule for a linear array, with the position in elements and the distance along the ray.
            let expected = scan
                .aperture()
                .active(line as f64 / 2.0, scan.depth(sample));
            assert_eq!(active, expected, "{line} {sample}");
            assert!(sample == 0 || active.count >= scan.active(line, sample - 1).count);
        }
    }
    // A sector: all rays start in the middle, at any angle.
    let rays: Vec<Ray> = (-20..=20)
        .map(|k| Ray::new(0.0, 0.0, f64::from(k) * 0.03))
        .collect();
    let scan = self::scan(Array::linear(ELEMENTS, PITCH), Lines::Rays(&rays));
    for line in 0..rays.len() {
        assert_eq!(scan.active(line, 200), scan.active(20, 200));
    }
}
