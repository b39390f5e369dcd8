//! The symmetries of a line.

use super::*;
use crate::common::changed;

#[test]
fn the_ends_of_a_line_are_as_good_as_its_middle() {
    let element_x = line_up(9, PITCH);
    let rf = noise(9 * 900, 4);
    let whole = changed(parameters(40e6, 20e6, 9, 900), |p| p.output_samples = 300);
    // A power of two of samples, so that both start times are exact.
    let part = changed(whole, |p| {
        (p.output_start, p.output_samples) = (128.0 / 20e6, 64)
    });
    let line = line_of(TransmitLaw::Focused, &element_x);
    let whole = rf_line(&whole, &line, &rf);
    let part = rf_line(&part, &line, &rf);
    for (a, b) in part.iter().zip(&whole[128 * 9..192 * 9]) {
        assert!((a - b).norm() < DELAY_SHIFT, "{a} {b}");
    }
}

#[test]
fn moving_record_and_t0_together_changes_nothing() {
    let element_x = line_up(9, PITCH);
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
        let at_rest = rf_line(&p, &line, &rf);
        let p = changed(p, |p| p.record_samples = samples + shift);
        let line = ScanLine {
            transmit: Transmit {
                law,
                t0: 1e-6 - shift as f64 / 40e6,
            },
            ..line
        };
        let shifted = rf_line(&p, &line, &moved);
        for (a, b) in at_rest.iter().zip(&shifted) {
            assert!((a - b).norm() < DELAY_SHIFT, "{law:?}: {a} {b}");
        }
    }
}

#[test]
fn the_mirror_image_and_powers_of_two_are_exact() {
    let element_x = line_up(9, PITCH);
    let rf = noise(9 * 700, 6);
    for law in LAWS {
        let p = parameters(40e6, 20e6, 9, 700);
        let line = line_of(law, &element_x);
        let direct = rf_line(&p, &line, &rf);

        let scaled: Vec<f32> = rf.iter().map(|x| x * 1024.0).collect();
        let scaled = rf_line(&p, &line, &scaled);
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
        let mirrored = rf_line(&p, &line, &mirrored_rf);
        let expected: Vec<_> = direct
            .chunks(9)
            .flat_map(|row| row.iter().rev().copied())
            .collect();
        assert_same_bits(&mirrored, &expected, "mirrored");
    }
}

#[test]
fn elements_outside_the_active_range_are_zero_and_the_others_unaffected() {
    let element_x = line_up(9, PITCH);
    let rf = noise(9 * 700, 7);
    let p = parameters(40e6, 20e6, 9, 700);
    let line = line_of(TransmitLaw::Focused, &element_x);
    let every = rf_line(&p, &line, &rf);
    for (first, count) in [(0, 0), (9, 0), (2, 4), (8, 1)] {
        let line = changed(line, |l| l.active = Active::new(first, count));
        let some = rf_line(&p, &line, &rf);
        for (index, (s, e)) in some.iter().zip(&every).enumerate() {
            let inside = (first..first + count).contains(&(index % 9));
            assert_eq!(*s, if inside { *e } else { ZERO });
        }
    }
}
