//! Interpolation against its documented errors, and filters against their design.

use super::super::decimator::{DecimatorMemory, decimated_len, streams_len};
use super::*;
use crate::kaiser;
use core::f64::consts::PI;

const F0: f64 = 5e6;

fn filter(fs: f64, fout: f64, f0: f64) -> Result<Interpolator, Error> {
    let mut filter = Interpolator::NONE;
    filter.set(fs, fout, f0).map(|()| filter)
}

/// The longest filter and its table fit exactly: none smaller would do, none larger is needed.
#[test]
fn the_table_holds_either_filter() {
    for (fs, taps, phases) in [(20e6, 16, 150), (40e6, 32, 75)] {
        let filter = filter(fs, 20e6, F0).unwrap();
        assert_eq!((filter.taps(), filter.phases), (taps, phases));
        let rows = (phases + 1) * taps / PARTIAL_SUMS;
        assert!(taps <= MOST_TAPS && rows <= TABLE);
        assert!(taps < 32 || taps == MOST_TAPS && rows == TABLE);
    }
}

/// Every tap of many filters, with and without halving, of either length.
#[test]
fn a_filter_in_f32_has_the_documented_error() {
    let mut worst = 0.0f32;
    for (fs, fout, f0) in [
        (20e6, 20e6, 5e6),
        (20e6, 20e6, 6.6e6),
        (25e6, 20e6, 5e6),
        (40e6, 20e6, 5e6),
        (41.66e6, 20.83e6, 4.2e6),
        (100e6, 20e6, 5e6),
        (100e6, 40e6, 3e6),
        (62.5e6, 8e6, 2e6),
        (31.25e6, 31.25e6, 2e6),
    ]
    .into_iter()
    .step_by(crate::step(5))
    {
        let exact = filter(fs, fout, f0).unwrap();
        let mut single = Interpolator::NONE;
        single.set_in_f32(fs, fout, f0).unwrap();
        assert!(single.is_single() && !exact.is_single());
        assert_eq!(single.phases, exact.phases);
        let largest = exact.table.0.as_flattened().iter().copied();
        let largest = largest.fold(0.0, |a, b| if a > b { a } else { b });
        assert!(largest > 0.2);
        let pairs = exact.table.0.as_flattened().iter();
        for (a, b) in pairs.zip(single.table.0.as_flattened()) {
            let error = (a - b).abs() / largest;
            worst = if error > worst { error } else { worst };
        }
    }
    assert!(worst < 5e-7, "{worst}");
}

/// The value at `position` of a record, decimated if necessary.
fn at(filter: &Interpolator, record: &[f32], position: f64) -> f32 {
    let decimator = filter.decimator();
    let (mut decimated, mut streams) = ([0.0; 620], [0.0; 1200]);
    let decimated = &mut decimated[..decimated_len(decimator.halvings(), record.len())];
    let streams = &mut streams[..streams_len(decimator.halvings())];
    let memory = DecimatorMemory { streams, decimated };
    let record = decimator.decimate(0.0f32, record, 0..usize::MAX, memory);
    let position = position / (1 << filter.halvings()) as f64;
    let whole = libm::floor(position);
    let position = (whole as f32, (position - whole) as f32);
    let (mut positions, mut values) = ([TapPositions::ZERO], [f32::NAN; PARTIAL_SUMS]);
    let locator = filter.locator(0.0f32, (decimator.origin(), record.len()));
    locator.locate(position, true, (&mut positions[0], 0));
    filter.read(0.0f32, [record], &positions, [&mut values]);
    values[0]
}

/// A Gaussian pulse of 5 MHz and 60 % bandwidth at −6 dB.
fn pulse(t: f64) -> f64 {
    let a = PI * F0 * 0.6 * PI * F0 * 0.6 / (4.0 * libm::log(libm::pow(10.0, 6.0 / 20.0)));
    libm::exp(-a * t * t) * libm::cos(2.0 * PI * F0 * t)
}

/// Worst error of the filter, half the spread of its values over the sub-sample phases, and
/// worst error of linear interpolation, over 100 times × 211 sub-sample phases. The peak is 1.
fn errors(fs: f64, fout: f64) -> (f64, f64, f64) {
    let filter = filter(fs, fout, F0).unwrap();
    let mut record = [0.0f32; 512];
    let (mut total, mut spread, mut linear) = (0.0f64, 0.0f64, 0.0f64);
    for step in (0..100).step_by(crate::step(50)) {
        let t = (f64::from(step) - 49.7) * 12e-9;
        let (mut low, mut high) = (f64::MAX, f64::MIN);
        for phase in (0..211).step_by(crate::step(53)) {
            let fraction = f64::from(phase) / 211.0 * (1 << filter.halvings()) as f64;
            // The grid is laid so that t falls on sample 256 + fraction.
            let sample = |k: usize| pulse(t + (k as f64 - 256.0 - fraction) / fs);
            for (k, value) in record.iter_mut().enumerate().skip(150).take(220) {
                *value = sample(k) as f32;
            }
            let value = f64::from(at(&filter, &record, 256.0 + fraction));
            total = total.max(libm::fabs(value - pulse(t)));
            low = low.min(value);
            high = high.max(value);
            let whole = 256 + fraction as usize;
            let fraction = fraction - libm::floor(fraction);
            let straight = sample(whole) * (1.0 - fraction) + sample(whole + 1) * fraction;
            linear = linear.max(libm::fabs(straight - pulse(t)));
        }
        spread = spread.max((high - low) / 2.0);
    }
    (total, spread, linear)
}

#[test]
fn the_documented_errors_hold() {
    // (recorded, output, error, spread, linear): the figures of the module's documentation.
    for (fs, fout, error, spread, straight) in [
        (20e6, 20e6, 1.3e-3, 7e-4, 0.31),
        (40e6, 40e6, 9e-6, 6e-6, 0.081),
        (100e6, 100e6, 1.0e-5, 6e-6, 0.013),
        (40e6, 20e6, 7e-4, 2e-5, 0.081),
        (100e6, 20e6, 5e-4, 8e-5, 0.013),
        (62.5e6, 20e6, 5e-4, 2e-5, 0.033),
        (50e6, 20e6, 5e-4, 8e-5, 0.05),
    ]
    .into_iter()
    .step_by(crate::step(6))
    {
        let (e, s, l) = errors(fs, fout);
        assert!(e <= error, "{fs} -> {fout}: error {e}");
        assert!(s <= spread, "{fs} -> {fout}: spread {s}");
        assert!(l > 0.9 * straight && l < 1.1 * straight, "{fs}: linear {l}");
    }
}

#[test]
#[cfg_attr(miri, ignore = "11,000 values of long records")]
fn what_would_fold_into_the_pulse_is_removed() {
    // Tones of 14 MHz and more, at an output rate of 20 MHz, leave less than −60 dB below 6.5 MHz:
    // 80 outputs under a Blackman-Harris window, whose side lobes are at −92 dB.
    const OUTPUTS: usize = 80;
    let weights = [0.35875, -0.48829, 0.14128, -0.01168];
    let window: [f64; OUTPUTS] = core::array::from_fn(|n| {
        let turn = 2.0 * PI * n as f64 / OUTPUTS as f64;
        let term = |k: usize| weights[k] * libm::cos(k as f64 * turn);
        term(0) + term(1) + term(2) + term(3)
    });
    let full = weights[0] * OUTPUTS as f64 / 2.0;
    for fs in [40e6, 48e6, 62.5e6, 100e6] {
        let filter = filter(fs, 20e6, F0).unwrap();
        let tones = (28..100).map(|half| f64::from(half) * 0.5e6);
        for tone in tones.filter(|&tone| tone < fs / 2.0) {
            let wave = |k| libm::cos(2.0 * PI * tone * k as f64 / fs) as f32;
            let record: [f32; 600] = core::array::from_fn(wave);
            let mut outputs = [0.0; OUTPUTS];
            for (n, y) in outputs.iter_mut().enumerate() {
                *y = f64::from(at(&filter, &record, 90.0 + n as f64 * fs / 20e6));
            }
            for low in (12..=26).map(|quarter| f64::from(quarter) * 0.25e6) {
                let (mut re, mut im) = (0.0, 0.0);
                for n in 0..OUTPUTS {
                    let angle = 2.0 * PI * low / 20e6 * n as f64;
                    re += window[n] * outputs[n] * libm::cos(angle);
                    im += window[n] * outputs[n] * libm::sin(angle);
                }
                let found = libm::hypot(re, im) / full;
                assert!(found < 1e-3, "{fs}: {tone} at {low}: {found}");
            }
        }
    }
}

#[test]
#[cfg_attr(miri, ignore = "116,000 values of long records")]
fn white_noise_falls_by_the_ratio_of_the_rates() {
    // The mean power of the filter over the phases: the response to an impulse, in steps of 1/97.
    for (fs, tolerance) in [(25e6, 0.05), (40e6, 0.05), (48e6, 0.05), (100e6, 0.05)] {
        let filter = filter(fs, 20e6, F0).unwrap();
        let every = 1 << filter.halvings();
        let mut power = 0.0;
        for first in 0..every {
            let mut record = [0.0f32; 300];
            record[150 + first] = 1.0;
            for step in 0..97 * 300 / every {
                let position = step as f64 / 97.0 * every as f64;
                let y = f64::from(at(&filter, &record, position));
                power += y * y / 97.0;
            }
        }
        let ratio = power * fs / 20e6;
        assert!(libm::fabs(ratio - 1.0) < tolerance, "{fs}: {ratio}");
    }
}

#[test]
fn a_whole_position_returns_the_sample() {
    let filter = filter(40e6, 40e6, F0).unwrap();
    let record: [f32; 40] = core::array::from_fn(|k| ((k * 37) % 11) as f32 - 5.0);
    for k in (0..40).step_by(crate::step(13)) {
        // The sinc's zeros are zero to the rounding of π in f64.
        assert!(libm::fabsf(at(&filter, &record, k as f64) - record[k]) < 1e-6);
    }
}

/// Differences from the table in the documentation of [`Interpolator::set`].
///
/// That table is computed by libm's functions.
fn differences(fs: f64, fout: f64, f0: f64) -> usize {
    let filter = filter(fs, fout, f0).unwrap();
    let rate = fs / (1 << filter.halvings()) as f64;
    let (taps, q) = if rate > 1.25 * fout {
        (32, 1.02)
    } else {
        (16, 1.08)
    };
    let (cutoff, transition) = if rate > fout {
        let cutoff = q * fout / rate;
        (cutoff.min(1.0), cutoff - 2.85 * f0 / rate)
    } else {
        (1.0, 1.0 - 3.0 * f0 / rate)
    };
    let attenuation = 8.0 + 2.285 * 2.0 * PI * (f64::from(taps - 1) * transition);
    let beta = (0.1102 * (attenuation - 8.7)).clamp(4.0, 10.0);
    let half = f64::from(taps / 2);
    let table = filter.table.0.as_flattened().iter().enumerate();
    let differs = |(at, value): (usize, &f32)| {
        let (row, tap) = (at as u32 / taps, at as u32 % taps);
        // h is even: rows behind the middle are the first ones from behind.
        let behind = 2 * row as usize > filter.phases;
        let (row, tap) = if behind {
            (filter.phases as u32 - row, taps - 1 - tap)
        } else {
            (row, tap)
        };
        let u = f64::from(tap) - (half - 1.0) - f64::from(row) / filter.phases as f64;
        let angle = PI * (cutoff * u);
        let sinc = if angle == 0.0 {
            1.0
        } else {
            libm::sin(angle) / angle
        };
        let exact = (cutoff * sinc * kaiser::tests::plain(u / half, beta)) as f32;
        value.to_bits() != exact.to_bits()
    };
    table
        .take((filter.phases + 1) * taps as usize)
        .step_by(crate::step(61))
        .filter(|&entry| differs(entry))
        .count()
}

#[test]
fn the_usual_filters_are_those_of_libms_functions() {
    for fs in [
        20e6, 25e6, 30e6, 31.25e6, 40e6, 50e6, 60e6, 62.5e6, 65e6, 80e6, 100e6,
    ]
    .into_iter()
    .step_by(crate::step(10))
    {
        for fout in [fs, fs / 2.0, fs / 4.0, 20e6]
            .into_iter()
            .step_by(crate::step(3))
        {
            for f0 in [
                2.5e6, 3e6, 3.5e6, 5e6, 5.2e6, 6.25e6, 7.5e6, 7.6e6, 8e6, 10e6,
            ]
            .into_iter()
            .step_by(crate::step(10))
            {
                assert_eq!(differences(fs, fout, f0), 0, "{fs} {fout} {f0}");
            }
        }
    }
}

/// A zero of its sinc is in row 25, where a tap consists of rounding only.
#[test]
fn rows_behind_the_middle_have_the_bits_of_those_before_it() {
    assert_eq!(differences(34e6, 20e6, F0), 0);
}

#[test]
fn filters_of_any_rates_are_those_of_libms_functions() {
    let (mut state, mut found) = (1u32, 0);
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / 16_777_216.0
    };
    for _ in (0..500).step_by(crate::step(250)) {
        let (fout, ratio) = (4e6 + 96e6 * random(), 0.3 + 15.0 * random() * random());
        found += differences(ratio * fout, fout, fout * random());
    }
    assert_eq!(found, 0);
}

#[test]
fn outside_the_record_is_zero() {
    let filter = filter(40e6, 20e6, F0).unwrap();
    for whole in [-8e6, -1000.0, 1000.0, 8e6] {
        assert_eq!(at(&filter, &[1.0; 20], whole + 0.5), 0.0);
    }
    // At the edge: as if zeros surrounded the record.
    let mut wide = [0.0; 120];
    wide[50..70].fill(1.0);
    for whole in (-20..40).step_by(crate::step(19)) {
        let position = f64::from(whole) + 0.25;
        let inside = at(&filter, &[1.0; 20], position);
        assert_eq!(inside, at(&filter, &wide, position + 50.0));
    }
}

#[test]
fn a_position_that_is_not_valid_is_outside() {
    let filter = filter(20e6, 20e6, F0).unwrap();
    let record = [1.0f32; 40];
    for (valid, expected) in [(true, 1.0f32), (false, 0.0)] {
        let mut values = [f32::NAN; PARTIAL_SUMS];
        let mut positions = [TapPositions::ZERO];
        let locator = filter.locator(0.0f32, (0, record.len()));
        locator.locate((20.0, 0.0), valid, (&mut positions[0], 0));
        filter.read(0.0f32, [&record], &positions, [&mut values]);
        assert!(libm::fabsf(values[0] - expected) < 1e-6, "{valid}");
    }
}

#[test]
fn every_ratio_fits_the_table() {
    for tenth in (1..=160).step_by(crate::step(106)) {
        let ratio = f64::from(tenth) / 10.0;
        let filter = filter(ratio * 20e6, 20e6, F0).unwrap();
        // A constant is returned to the ripple of the filter, well under 1 %.
        let value = at(&filter, &[1.0; 512], 256.999_999_94);
        assert!(libm::fabsf(value - 1.0) < 0.01, "{ratio}: {value}");
    }
}

#[test]
fn bad_rates_are_named() {
    let name = |fs, fout, f0| match filter(fs, fout, f0) {
        Err(Error::Parameter { name, .. }) => name,
        other => panic!("{other:?}"),
    };
    assert_eq!(name(0.0, 20e6, F0), "sampling_rate");
    assert_eq!(name(f64::NAN, 20e6, F0), "sampling_rate");
    assert_eq!(name(40e6, -1.0, F0), "output_rate");
    assert_eq!(name(340e6, 20e6, F0), "output_rate");
    assert_eq!(name(f64::MAX, f64::MIN_POSITIVE, F0), "output_rate");
    assert_eq!(name(40e6, 20e6, f64::INFINITY), "centre_frequency");
}
