//! Decimation of tones, of parts of records, and over lanes.

use super::*;
use core::f64::consts::PI;

fn memory<'s, 'd>(streams: &'s mut [f32], decimated: &'d mut [f32]) -> DecimatorMemory<'s, 'd> {
    DecimatorMemory { streams, decimated }
}

/// A record's samples after the halvings, from sample 0 on, and their number.
fn decimated(decimator: &Decimator, record: &[f32]) -> ([f32; 700], usize) {
    let (mut streams, mut decimated) = ([f32::NAN; 1200], [f32::NAN; 700]);
    let length = decimated_len(decimator.halvings(), record.len());
    let streams = &mut streams[..streams_len(decimator.halvings())];
    decimator.decimate(
        0.0f32,
        record,
        0..length,
        memory(streams, &mut decimated[..length]),
    );
    decimated[..length].rotate_left(MARGIN);
    (decimated, length)
}

#[test]
fn keeps_what_is_low_and_removes_what_would_fold_onto_it() {
    let ratios = [2.5, 3.125, 4.0, 4.9, 5.0, 8.0, 10.0, 12.0, 16.0];
    for ratio in ratios.into_iter().step_by(crate::step(8)) {
        let decimator = Decimator::new(ratio);
        let every = 1 << decimator.halvings();
        // The sum of the filters' errors, and roundings.
        let tolerance = 2.5e-4 + 1.6e-4 * (decimator.halvings() - 1) as f64 + 1e-6;
        let mut folding = 0;
        for part in (1..=400).step_by(crate::step(100)) {
            // In halves of the output rate, up to half the record's rate; then the folded frequency.
            let frequency = ratio * f64::from(part) / 400.0;
            let rate = 2.0 * ratio / every as f64;
            let folded = libm::fabs(frequency - libm::round(frequency / rate) * rate);
            if folded > 0.7 {
                continue;
            }
            let expected = if frequency <= 0.7 { 1.0 } else { 0.0 };
            folding += usize::from(expected == 0.0);
            let wave = |k: usize| libm::cos(PI * frequency / ratio * k as f64 + 0.3);
            let record: [f32; 400] = core::array::from_fn(|k| wave(k) as f32);
            let (decimated, _) = decimated(&decimator, &record);
            for j in 8..400 / every - 8 {
                let error = f64::from(decimated[j]) - expected * wave(every * j);
                assert!(
                    libm::fabs(error) < tolerance,
                    "{ratio} {frequency} at {j}: {error}"
                );
            }
        }
        assert!(folding * crate::step(100) > 50, "{ratio}: {folding}");
    }
}

#[test]
fn halves_down_to_between_1_25_and_2_5_times_the_output_rate() {
    for tenth in 1..=160 {
        let ratio = f64::from(tenth) / 10.0;
        let halvings = Decimator::new(ratio).halvings();
        let after = ratio / (1 << halvings) as f64;
        assert!(
            after < 2.5 && (halvings == 0 || after >= 1.25),
            "{ratio}: {halvings}"
        );
        assert!(halvings <= MAX_HALVINGS);
    }
    assert_eq!(halvings(f64::INFINITY), MAX_HALVINGS);
}

/// Once decimated, 5 samples in front and 4 where the filter before begins, those of the record, 6 behind, in
/// registers of 16.
#[test]
fn a_halved_record_takes_what_its_filters_reach() {
    assert_eq!(Decimator::new(5.0).origin(), 9);
    assert_eq!([66, 67].map(|samples| decimated_len(1, samples)), [48, 48]);
    assert_eq!([68, 98].map(|samples| decimated_len(1, samples)), [64, 64]);
    assert_eq!(decimated_len(0, 66), 0);
}

#[test]
fn behind_the_halved_record_there_is_nothing() {
    let record = [1.0; 512];
    for ratio in [2.5, 4.9, 5.0, 16.0].into_iter().step_by(crate::step(3)) {
        let decimator = Decimator::new(ratio);
        for samples in (1..=400).step_by(crate::step(399)) {
            let mut padded = [0.0; 512];
            padded[..samples].copy_from_slice(&record[..samples]);
            let (decimated, all) = decimated(&decimator, &padded);
            let end = decimated_len(decimator.halvings(), samples) - MARGIN;
            assert!(
                decimated[end..all - MARGIN].iter().all(|&y| y == 0.0),
                "{ratio}: {samples} samples"
            );
        }
    }
}

#[test]
fn an_impulse_loses_nothing_at_the_ends_and_short_records_fit() {
    for ratio in [2.5, 4.9, 5.0, 16.0].into_iter().step_by(crate::step(3)) {
        let decimator = Decimator::new(ratio);
        let every = 1 << decimator.halvings();
        for samples in (1..100).step_by(crate::step(60)) {
            // As many impulses as make up one output sample: their sum has no high frequencies.
            let mut record = [0.0; 100 + 8];
            record[samples - 1..][..every].fill(1.0);
            for record in [&record[..samples - 1 + every], &record] {
                let (decimated, length) = decimated(&decimator, record);
                let mut sum = 0.0;
                for &y in &decimated[..length] {
                    sum += y;
                }
                assert!(libm::fabsf(sum - 1.0) < 2e-3, "{ratio} {samples}: {sum}");
            }
        }
    }
}
