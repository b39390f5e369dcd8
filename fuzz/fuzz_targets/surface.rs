//! Grey levels to the bone surface: an error, or valid points.
//!
//! Depths are within the searched range, and confidences are 0 to 1. A frame equals its lines one by one, and the
//! memory's former contents have no effect.

#![no_main]

use arbitrary::Arbitrary;
use bonebeam::geometry::Axis;
use bonebeam::memory::Scratch;
use bonebeam::surface::{Detector, Parameters, Point, Settings, Survey, Tracker, grey};
use bonebeam_fuzz::{samples, size, within};
use libfuzzer_sys::fuzz_target;

#[derive(Arbitrary, Debug)]
struct Input {
    wild: bool,
    picture: bool,
    lines: u8,
    samples: u8,
    latency: u8,
    numbers: [f64; 14],
    any_bits: bool,
    exponent: i8,
    data: Vec<u8>,
}

fuzz_target!(|input: Input| {
    let lines = size(input.lines, 6, 40);
    let samples = samples_of(&input);
    let parameters = Parameters {
        samples,
        spacing: if input.wild { input.numbers[2] } else { 0.3e-3 },
        settings: settings(&input),
        latency: lines - 1,
    };
    let Ok(detector) = Detector::new(parameters) else {
        return;
    };
    let levels = levels(&input, lines * samples.count);
    let found = frame(&detector, &levels, lines, 0.0);
    assert_eq!(found, frame(&detector, &levels, lines, f32::NAN), "memory");
    check(&found, &parameters);

    // Line by line with full latency gives the frame. Less latency still gives a point for each line.
    assert_eq!(found, by_lines(&detector, &levels, lines));
    let latency = usize::from(input.latency) % lines;
    let sooner = Detector::new(Parameters {
        latency,
        ..parameters
    });
    let sooner = sooner.expect("less latency is taken, too");
    check(&by_lines(&sooner, &levels, lines), &parameters);
});

/// An axis of a few millimetres; any axis of a few samples if the input is wild.
fn samples_of(input: &Input) -> Axis {
    let [first, step, ..] = input.numbers;
    let count = size(input.samples, 60, 2000);
    match input.wild {
        true => Axis { first, step, count },
        false => Axis {
            first: 0.0,
            step: within(step, [0.02e-3, 0.4e-3]),
            count,
        },
    }
}

/// Settings for lines or pictures, searched from the first sample on.
///
/// Prices and weights come from the input.
fn settings(input: &Input) -> Settings {
    let usual = match input.picture {
        true => Settings::PICTURE,
        false => Settings::DEFAULT,
    };
    let [
        ..,
        from,
        absence,
        end,
        jump,
        slope,
        cell,
        contrast,
        level,
        rest,
        shadow,
        width,
    ] = input.numbers;
    let mut settings = Settings {
        cell: within(cell, [0.01e-3, 1e-3]),
        depths: [within(from, [0.0, 2e-3]), f64::INFINITY],
        absence: within(absence, [-66.0, 66.0]),
        end: within(end, [0.0, 66.0]),
        jump: within(jump, [0.0, 66.0]),
        slope: within(slope, [0.0, 1e5]),
        ..usual
    };
    settings.contrast.weight = within(contrast, [-17.0, 17.0]);
    settings.level.weight = within(level, [-17.0, 17.0]);
    settings.rest.weight = within(rest, [-17.0, 17.0]);
    settings.shadow.weight = within(shadow, [-17.0, 17.0]);
    if input.wild {
        (settings.depths, settings.slope) = ([from, absence], slope);
        settings.level.width = width;
        settings.far = [width, level];
    }
    settings
}

/// Grey levels from numbers: any bits, or 0 to 255 and a little beyond.
fn levels(input: &Input, count: usize) -> Vec<u8> {
    let numbers = samples(&input.data, count, input.any_bits, input.exponent);
    let mut levels = vec![0; count];
    grey(&numbers, &mut levels).expect("finite numbers");
    levels
}

fn frame(detector: &Detector, levels: &[u8], lines: usize, held: f32) -> Vec<Option<Point>> {
    let mut real = vec![held; detector.need().real];
    let scratch = Scratch {
        real: &mut real,
        complex: &mut [],
    };
    let mut points = vec![None; lines];
    let done = detector.frame(levels, scratch, &mut points);
    done.expect("a frame of the detector's size");
    points
}

/// The surface of the levels, computed line by line.
fn by_lines(detector: &Detector, levels: &[u8], lines: usize) -> Vec<Option<Point>> {
    let mut real = vec![f32::NAN; detector.need().real];
    let mut scratch = Scratch {
        real: &mut real,
        complex: &mut [],
    };
    let of_line = || levels.chunks(levels.len() / lines);
    let mut survey = Survey::new(detector, scratch.reborrow()).expect("its memory");
    for line in of_line().step_by(Survey::EVERY) {
        survey.line(line).expect("a line of the detector's size");
    }
    let frame_levels = survey.levels();
    let mut tracker = Tracker::new(detector, scratch).expect("its memory");
    let mut points = Vec::new();
    for line in of_line() {
        let decided = tracker.line(line, frame_levels);
        points.extend(decided.expect("a line of the detector's size"));
    }
    tracker.finish(|point| points.push(point));
    assert_eq!(points.len(), lines);
    points
}

/// Finite depths between those of the samples, and confidences of 0 to 1.
fn check(points: &[Option<Point>], parameters: &Parameters) {
    let Axis { first, step, .. } = parameters.samples;
    let last = parameters.samples.last();
    for point in points.iter().flatten() {
        let depth = f64::from(point.depth);
        let rounded = 1e-6 * (first.abs() + last.abs());
        let inside = first - step - rounded..=last + step + rounded;
        assert!(inside.contains(&depth), "a depth of {depth}");
        assert!((0.0..=1.0).contains(&point.confidence), "{point:?}");
    }
}
