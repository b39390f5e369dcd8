//! Echoes of points, and the symmetries of a line.

use super::*;

/// A Gaussian pulse of 5 MHz and 60 % bandwidth at −6 dB.
fn pulse(t: f64) -> f64 {
    let a = (PI * F0 * 0.6).powi(2) / (4.0 * 10f64.powf(6.0 / 20.0).ln());
    (-a * t * t).exp() * (2.0 * PI * F0 * t).cos()
}

/// The echo of a point: on each element a pulse at the two-way time.
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
            // Output sample 100 is at the point.
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
                // The pulse's centre: magnitude 1, phase 0, on every element.
                let y = out[100 * 33 + m];
                let error = (f64::from(y.re) - 1.0).hypot(f64::from(y.im));
                assert!(
                    error < tolerance,
                    "{fs} -> {fout}, {law:?}, element {m}: {y}"
                );
                // The envelope has its maximum there.
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
