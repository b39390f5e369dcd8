//! The bits of the references, of constant stages and of every instruction set.

use super::*;
use crate::common::changed;

#[test]
fn a_stage_that_is_set_is_a_new_one() {
    let element_x = line_up(5, PITCH);
    let line = line_of(TransmitLaw::Focused, &element_x);
    let rf = noise(5 * 400, 3);
    let record = Record::new(&rf, 5).unwrap();
    let first = parameters(40e6, 20e6, 5, 400);
    // Each stage from the one before: a change that keeps the filters, one that changes one of them, and one that
    // changes both.
    let all = [
        changed(first, |p| p.sound_speed = 1580.0),
        changed(first, |p| (p.output_start, p.output_samples) = (1e-6, 31)),
        changed(first, |p| p.hilbert_taps = 3),
        changed(first, |p| p.centre_frequency = 3e6),
        parameters(100e6, 20e6, 5, 400),
        parameters(20e6, 20e6, 5, 400),
        changed(first, |p| (p.hilbert_taps, p.output_rate) = (31, 30e6)),
    ];
    let mut delay = Delay::new(first).unwrap();
    for p in all {
        delay.set(p).unwrap();
        assert_eq!(delay.parameters(), &p);
        // An error leaves everything unchanged, for any wrong parameter.
        for wrong in [
            changed(parameters(60e6, 20e6, 5, 400), |p| p.sound_speed = 0.0),
            changed(parameters(60e6, 20e6, 5, 400), |p| p.hilbert_taps = 0),
            changed(parameters(600e6, 20e6, 5, 400), |p| p.hilbert_taps = 4),
        ] {
            delay.set(wrong).unwrap_err();
        }
        let out = aligned(&delay, p.output_samples, &line, &record);
        assert_same_bits(&out, &rf_line(&p, &line, &rf), &format!("{p:?}"));
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
    static DELAY: Delay = valid!(Delay::new(PARAMETERS));
    let element_x = line_up(5, PITCH);
    let line = line_of(TransmitLaw::Focused, &element_x);
    let rf = noise(5 * 400, 3);
    let out = aligned(&DELAY, 87, &line, &Record::new(&rf, 5).unwrap());
    let p = std::hint::black_box(PARAMETERS);
    assert_same_bits(&out, &rf_line(&p, &line, &rf), "constant");
}
