//! Compounding of upsampled records: positions, the delay stage, and invariants.
//!
//! The delay stage interpolates in another way.

use crate::common::delays::{C, F0, line_up, noise, pulse};
use crate::common::kit::*;
use crate::delay::frames::assert_frames_alike;
use bonebeam_drive::config::RfInterpolation;

/// Error of linear interpolation between 16 samples a recorded one.
///
/// A tone of 1.3·f0 at 4·f0 errs by (2π·1.3/64)²/8 = 2.0e-3. All other differences are below 1e-4.
const STRAIGHT: f32 = 2.2e-3;

/// One sample a second, one a metre of depth: times are positions without rounding.
const EXACT: DelayParameters = DelayParameters {
    sound_speed: 2.0,
    sampling_rate: 1.0,
    centre_frequency: 0.25,
    output_rate: 1.0,
    output_start: 0.0,
    output_samples: 300,
    elements: 1,
    record_samples: 300,
    hilbert_taps: 2,
};
/// Units of a position between two recorded samples.
const A_SAMPLE: f64 = 32_768.0;
/// Largest lag, in either direction.
const MOST: i32 = 1 << 29;

/// A focused line straight down from an array, recorded from `t0` on.
fn straight_down(array: Array<'_>, t0: f64) -> ScanLine<'_> {
    ScanLine::new(
        Transmit::new(TransmitLaw::Focused, t0),
        Ray::down(0.0),
        array,
    )
}

/// Depths are −3, −2, …: an echo from z comes at z.
#[test]
fn positions_are_those_of_the_law_or_far_in_front_of_the_record() {
    let farthest = f64::from((1 << 30) - 1);
    let delay = Delay::new(EXACT).unwrap();
    let upsampled = Upsampled::new(&delay).unwrap();
    let taps = upsampled.record_len() / 16 - EXACT.record_samples - 2;
    let before = (taps / 2 + 1) as f64;
    let half = 0.5 / A_SAMPLE;
    // Depth 100 is at the farthest position, and one unit nearer.
    let last = 100.0 - ((farthest - 0.5) / A_SAMPLE - before);
    for t0 in [
        0.0,
        -5.0,
        123.0,
        20e3 + half,
        20e3 + 0.3 * half,
        last,
        1e6,
        -1e6,
    ] {
        let mut positions = vec![7; upsampled.line_len()];
        let line = straight_down(Array::LinearAt(&[0.0]), t0);
        upsampled.centre(&line, &mut positions).unwrap();
        for (n, &position) in positions.iter().enumerate() {
            let z = n as f64 - 3.0;
            let units = ((z - t0 + before) * A_SAMPLE + 0.5).floor();
            if z > 0.0 && units.abs() < farthest {
                assert_eq!(f64::from(position), units, "{t0} {z}");
            } else {
                assert!(
                    position < -MOST && position > -2 * MOST,
                    "{t0} {z}: {position}"
                );
            }
        }
    }
}

#[test]
fn lags_are_paths_or_behind_any_record() {
    let delay = Delay::new(EXACT).unwrap();
    let upsampled = Upsampled::new(&delay).unwrap();
    let mut receive_delays = vec![7; upsampled.line_len()];
    for x in [0.0, 9.0, 1e3, 4e4, 1e5, 3e5, 1e9, 1e30] {
        for depth in [0.0, -40.0] {
            let elements = [Element::down(x, depth)];
            let line = straight_down(Array::at(&elements, 1.0), 0.0);
            upsampled
                .receive_delays(0.0f32, &line, 0, &mut receive_delays)
                .unwrap();
            for (n, &lag) in receive_delays.iter().enumerate() {
                let z = n as f64 - 3.0;
                let path = x.hypot(z - depth);
                let units = (path - z) / EXACT.sound_speed * A_SAMPLE;
                if z > 0.0 && units < f64::from(MOST) {
                    // The roundings of f32, and the truncation.
                    let error = (f64::from(lag) - units).abs();
                    let size = (path + 100.0) * A_SAMPLE;
                    assert!(error <= 1.0 + size * 2f64.powi(-22), "{x} {z}: {error}");
                } else {
                    assert_eq!(lag, MOST, "{x} {z}");
                }
            }
        }
    }
}

#[test]
fn nothing_is_added_from_beyond_the_record() {
    let delay = Delay::new(EXACT).unwrap();
    let upsampled = Upsampled::new(&delay).unwrap();
    let mut record = vec![f32::NAN; upsampled.record_len()];
    let mut scratch = vec![f32::NAN; upsampled.need().real];
    upsampled
        .record(0.0f32, &noise(300, 5), &mut scratch, &mut record)
        .unwrap();
    // Some values are read within the record, the others beyond it.
    let within: Vec<i32> = (0..300).map(|n| (n + 20) * A_SAMPLE as i32).collect();
    for beyond in [-2 * MOST + 1, -1, 330 * A_SAMPLE as i32, 2 * MOST - 1] {
        let mut centre = within.clone();
        centre[140..].fill(beyond);
        let contribution = Contribution {
            record: &record,
            centre: &centre,
            receive_delays: &[0; 300],
        };
        let mut line = [0.75; 300];
        upsampled.add(0.0f32, &contribution, &mut line).unwrap();
        assert!(line[..140].iter().all(|&y| y != 0.75));
        assert!(line[140..].iter().all(|&y| y == 0.75), "{beyond}");
    }
}

/// Echoes of points, of seven plane waves, by 32 elements at 20 MHz.
fn recording() -> ChannelData {
    let (waves, elements, samples, fs) = (7, 32, 560, 20e6);
    let angle: Vec<f64> = (0..waves).map(|k| (k as f64 - 3.0) * 0.08).collect();
    let x = line_up(elements, 0.3e-3);
    let points = [[-2e-3, 8e-3], [0.4e-3, 11e-3], [3e-3, 15e-3]];
    let rf = Array3::from_shape_fn((waves, elements, samples), |(wave, m, n)| {
        let echo = |[px, pz]: [f64; 2]| {
            let there = px * angle[wave].sin() + pz * angle[wave].cos();
            pulse(n as f64 / fs - (there + (px - x[m]).hypot(pz)) / C)
        };
        points.into_iter().map(echo).sum::<f64>() as f32
    });
    ChannelData::linear(rf, x, Transmits::Plane { angle }, ([fs, F0], C))
}

fn parameters(interpolation: RfInterpolation) -> Beamform {
    Beamform {
        rf_interpolation: Some(interpolation),
        depth_start: Some(3e-3),
        depth_end: Some(19e-3),
        sub_lines: Some(1),
        ..Beamform::default()
    }
}

#[test]
fn is_the_delay_stages_own_way_to_what_straight_lines_leave() {
    let data = recording();
    let [filtered, upsampled] =
        [RfInterpolation::Filtered, RfInterpolation::Upsampled].map(|interpolation| {
            let stage = DelayStage::new(&data, &parameters(interpolation)).unwrap();
            let x = stage.delay(0..stage.beam_x().len()).unwrap();
            (stage, x)
        });
    let (stage, filtered) = filtered;
    let (_, upsampled) = upsampled;
    let largest = filtered.iter().map(|y| y.norm()).fold(0.0, f32::max);
    let mut difference = 0.0f32;
    for ((beam, sample, element), ours) in upsampled.indexed_iter() {
        let active = stage.active(beam, sample);
        if (active.first..active.first + active.count).contains(&element) {
            difference = difference.max((ours - filtered[[beam, sample, element]]).norm());
        } else {
            assert_eq!(*ours, Complex::ZERO, "{beam} {sample} {element}");
        }
    }
    println!("{:.2e} of the largest", difference / largest);
    assert!(difference <= STRAIGHT * largest, "{}", difference / largest);
    // The two ways do differ.
    assert!(difference > 1e-5 * largest);
}

#[test]
fn frames_do_not_depend_on_the_threads_the_instruction_set_or_the_range_of_beams() {
    let data = recording();
    let parameters = parameters(RfInterpolation::Upsampled);
    assert_frames_alike(DelayStage::new(&data, &parameters).unwrap());
}

#[test]
fn what_cannot_be_upsampled_is_refused() {
    let refused = |data: &ChannelData, parameters: &Beamform| {
        let error = DelayStage::new(data, parameters).err().unwrap();
        error.to_string()
    };
    let parameters = parameters(RfInterpolation::Upsampled);
    let mut fast = recording();
    fast.fs = 60e6;
    assert!(refused(&fast, &parameters).contains("2.5 times"));
    let mut focused = recording();
    focused.transmits = Transmits::focused(focused.element_x[..7].to_vec(), 10e-3);
    assert!(refused(&focused, &parameters).contains("compounded"));
}
