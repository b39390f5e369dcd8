//! The bone surface: known answers, both references, any old memory, bad input.

use crate::common::kit::*;
use bonebeam::surface::{Levels, Parameters, Point, Settings, Survey, Tracker};
use bonebeam_tests::draw::Seed;
use bonebeam_tests::kernels::surface::settings as any_settings;

const PARAMETERS: Parameters = Parameters {
    samples: Axis::new(2e-3, 0.0385e-3, 600),
    spacing: 0.3e-3,
    settings: Settings::DEFAULT,
    latency: 39,
};

fn detector(parameters: Parameters) -> Detector {
    Detector::new(parameters).expect("valid parameters")
}

/// Computes a surface in memory full of NaN.
fn found(parameters: Parameters, frame: &[u8]) -> Vec<Option<Point>> {
    found_by(parameters, frame, |detector, scratch, points| {
        detector.frame(frame, scratch, points)
    })
}

/// The same with the coherence of each sample.
fn found_with_coherence(
    parameters: Parameters,
    frame: &[u8],
    coherence: &[u8],
) -> Vec<Option<Point>> {
    found_by(parameters, frame, |detector, scratch, points| {
        detector.frame_with_coherence(frame, coherence, scratch, points)
    })
}

fn found_by(
    parameters: Parameters,
    frame: &[u8],
    run: impl FnOnce(&Detector, Scratch<'_>, &mut [Option<Point>]) -> Result<(), Error>,
) -> Vec<Option<Point>> {
    let detector = detector(parameters);
    let mut real = vec![f32::NAN; detector.need().real];
    let scratch = Scratch::new(&mut real, &mut []);
    let mut points = vec![None; frame.len() / parameters.samples.count];
    run(&detector, scratch, &mut points).expect("a frame");
    points
}

/// Lines of speckle with bone at a sample of each line, and a shadow below it.
///
/// The shadow has the level `dark`. A line without bone has no shadow.
fn lines(samples: usize, bones: &[Option<usize>], dark: u8, seed: u64) -> Vec<u8> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut frame = Vec::new();
    for bone in bones {
        let bone = bone.unwrap_or(samples);
        frame.extend((0..samples).map(|sample| {
            let level: u8 = rng.random_range(0..60);
            match sample {
                _ if sample > bone + 8 => level / 6 + dark,
                _ if sample >= bone => 180 + level,
                _ => 90 + level,
            }
        }));
    }
    frame
}

#[test]
fn bone_is_found_where_it_is_and_nowhere_else() {
    // Slopes of 2 samples a line, a gap of 8 lines, a step of 4.6 mm.
    let bones: Vec<Option<usize>> = (0..40)
        .map(|line| match line {
            0..16 => Some(200 + 2 * line),
            16..24 => None,
            _ => Some(350 - line),
        })
        .collect();
    let points = found(PARAMETERS, &lines(600, &bones, 0, 1));
    for (line, (point, bone)) in points.iter().zip(&bones).enumerate() {
        assert_eq!(point.is_some(), bone.is_some(), "line {line}");
        let (Some(point), Some(bone)) = (point, bone) else {
            continue;
        };
        // The echo has nine samples from the bone on.
        let middle = PARAMETERS.samples.position(bone + 4);
        let error = f64::from(point.depth) - middle;
        // Within the echo or in the cell beside it, four samples.
        assert!(
            error.abs() < 9.0 * PARAMETERS.samples.step,
            "line {line}: {error}"
        );
        assert!(point.confidence > 0.5 && point.confidence <= 1.0);
        assert_eq!(point.begins, line == 0 || line == 24, "line {line}");
    }
}

/// Echoes between samples, along slopes: also the first and the last line of a piece have the depth of the bone.
#[test]
fn depth_is_that_of_a_straight_bone() {
    for slope in [-1.7, -0.4, 0.0, 0.3, 1.1] {
        let middle = |line: usize| 300.3 + slope * (line as f64 - 20.0);
        let frame: Vec<u8> = (0..24_000)
            .map(|n| {
                let below = (n % 600) as f64 - middle(n / 600);
                let tissue = if below < 0.0 { 90.0 } else { 5.0 };
                (250.0 - 1.6 * below * below).max(tissue) as u8
            })
            .collect();
        let points = found(PARAMETERS, &frame);
        for (line, point) in points.iter().enumerate() {
            let depth = f64::from(point.expect("bone in every line").depth);
            let off = (depth - PARAMETERS.samples.first) / PARAMETERS.samples.step - middle(line);
            // 0.06 mm.
            assert!(off.abs() < 1.5, "slope {slope}, line {line}: {off} samples");
        }
    }
}

/// Two pieces whose echoes lie at one depth and a cell below, by turns.
#[test]
fn depth_is_smooth_along_a_piece_alone() {
    let zigzag = |line: usize| if line < 20 { 200 } else { 350 } + 4 * (line % 2);
    let bones: Vec<Option<usize>> = (0..40).map(|line| Some(zigzag(line))).collect();
    let points = found(PARAMETERS, &lines(600, &bones, 0, 7));
    let depths: Vec<f64> = points.iter().flatten().map(|p| p.depth.into()).collect();
    assert_eq!(depths.len(), 40);
    for piece in [&depths[..20], &depths[20..]] {
        let mean = piece.iter().sum::<f64>() / 20.0;
        let off = |depth: &f64| (depth - mean).abs() / PARAMETERS.samples.step;
        // Lines with three others on both sides; alone, they would be off by two samples.
        assert!(
            piece[3..17].iter().all(|depth| off(depth) < 0.5),
            "{piece:?}"
        );
        assert!(piece.iter().all(|depth| off(depth) < 2.0), "{piece:?}");
    }
}

#[test]
fn tissue_alone_a_black_and_a_white_frame_have_no_surface() {
    let speckle = lines(600, &[None; 40], 0, 2);
    for frame in [speckle, vec![0; 24_000], vec![255; 24_000]] {
        let points = found(PARAMETERS, &frame);
        assert!(points.iter().all(Option::is_none));
    }
}

/// Below a bright layer is a grey of 110 levels: clutter in a shadow, or muscle, by its coherence.
#[test]
fn coherence_tells_clutter_from_tissue() {
    let frame = lines(600, &[Some(250); 40], 110, 3);
    let parameters = changed(PARAMETERS, |p| p.settings = Settings::COHERENCE);
    let found = |below: u8| {
        let coherence = |n: usize| if n % 600 < 250 { 130 } else { below };
        let coherence: Vec<u8> = (0..frame.len()).map(coherence).collect();
        let points = found_with_coherence(parameters, &frame, &coherence);
        let confidences = points
            .iter()
            .map(|point| point.map_or(0.0, |p| p.confidence));
        confidences.collect::<Vec<_>>()
    };
    for (clutter, muscle) in found(0).iter().zip(found(130)) {
        assert!(*clutter > muscle, "{clutter} and {muscle}");
    }
}

#[test]
fn a_single_bright_line_is_no_surface() {
    let mut bones = [None; 40];
    bones[20] = Some(250);
    let points = found(PARAMETERS, &lines(600, &bones, 0, 3));
    assert_eq!(points.iter().flatten().count(), 0);
}

/// A bright layer over tissue that is nearly as bright, and over shadows.
#[test]
fn bone_in_a_picture_has_a_shadow() {
    let lines_found = |tissue: u8, below: u8| {
        let mut line = vec![tissue; 250];
        line.extend([220; 6]);
        line.resize(400, below);
        let parameters = Parameters {
            samples: Axis::new(0.0, 0.1e-3, 400),
            settings: Settings::LEARNT,
            ..PARAMETERS
        };
        let points = found(parameters, &line.repeat(40));
        points.iter().flatten().count()
    };
    assert_eq!(
        [(110, 180), (80, 180)].map(|(t, b)| lines_found(t, b)),
        [0; 2]
    );
    assert_eq!(
        [(110, 20), (40, 10)].map(|(t, b)| lines_found(t, b)),
        [40; 2]
    );
}

/// Bound of a score's error.
///
/// Means are truncated to 1/16 of a grey level, and the logarithm comes from a table.
fn bound(settings: &Settings, [near, far]: [f64; 2]) -> f64 {
    let grey = 1.2 / 4080.0;
    // Both differences are rounded down.
    let onset = near * far + settings.onset_floor;
    let least = (near - grey).max(0.0) * (far - grey).max(0.0) + settings.onset_floor;
    let terms = [
        settings.contrast,
        settings.level,
        settings.rest,
        settings.shadow,
    ];
    let ramps = terms.map(|r| (r.weight / r.width).abs());
    settings.onset_weight * (0.016 + (onset / least).ln())
        + grey * (ramps[0] + ramps[1] + 2.0 * ramps[2] + ramps[3] / settings.shadow_range)
        + 0.005
}

#[test]
fn scores_stay_within_their_bound_of_the_f64_reference() {
    for seed in 0..20 {
        let settings = Settings {
            cell: 0.06e-3,
            depths: [5e-3, f64::INFINITY],
            learnt: false,
            ..any_settings(&mut Seed(seed), false)
        };
        let parameters = changed(PARAMETERS, |p| p.settings = settings);
        let frame = lines(600, &[Some(300)], 20, seed);
        let levels = reference::f32::surface::levels(&parameters, &frame);
        let scores = reference::f32::surface::scores(&parameters, &frame, levels);
        let terms = reference::f32::surface::coherence_term(&parameters, &frame);
        let grey: Vec<f64> = frame.iter().map(|&g| f64::from(g) / 255.0).collect();
        let ends = [levels.dark, levels.tissue].map(|level| f64::from(level) / 4080.0);
        let length = 2.0 * parameters.samples.step;
        let first = ((5e-3 - parameters.samples.first) / length).round() as usize;
        assert!(scores.len() > 200);
        for (k, &score) in scores.iter().enumerate() {
            let cell = [2, first + k];
            let (expected, means) =
                reference::f64::surface::score(&settings, &grey, cell, length, ends);
            let error = (score as f64 / 1024.0 - expected).abs();
            assert!(
                error <= bound(&settings, means),
                "{seed}, {k}: {score} and {expected}"
            );
            // The frame in place of its coherence.
            let expected = reference::f64::surface::coherence_term(&settings, &grey, cell, length);
            let error = (terms[k] as f64 / 1024.0 - expected).abs();
            let Ramp { weight, width, .. } = settings.coherence;
            let bound = 1.2 / 4080.0 * (weight / width).abs() + 0.005;
            assert!(error <= bound, "{seed}, {k}: {} and {expected}", terms[k]);
        }
    }
}

#[test]
fn line_by_line_is_the_frame_if_latency_is_long_enough() {
    let bones: Vec<_> = (0..40)
        .map(|line| (line > 5).then_some(200 + line))
        .collect();
    let frame = lines(600, &bones, 0, 6);
    let whole = found(PARAMETERS, &frame);
    let late = changed(PARAMETERS, |p| p.latency = 9);
    let detector = detector(late);
    assert!(detector.need().real < Detector::new(PARAMETERS).unwrap().need().real);
    let mut real = vec![f32::NAN; detector.need().real];
    let mut scratch = Scratch::new(&mut real, &mut []);
    let mut survey = Survey::new(&detector, scratch.reborrow()).unwrap();
    for line in frame.chunks(600).step_by(Survey::EVERY) {
        survey.line(line).unwrap();
    }
    let levels = survey.levels();
    let mut tracker = Tracker::new(&detector, scratch).unwrap();
    // A second frame: no state of the first remains.
    for _ in 0..2 {
        let mut points = Vec::new();
        for line in frame.chunks(600) {
            points.extend(tracker.line(line, levels).unwrap());
        }
        assert_eq!(points.len(), 31);
        tracker.finish(|point| points.push(point));
        let at = |points: &[Option<Point>]| -> Vec<_> {
            points
                .iter()
                .map(|p| p.map(|p| (p.depth, p.begins)))
                .collect()
        };
        assert_eq!(at(&points), at(&whole));
    }
}

#[test]
fn levels_are_percentiles_of_the_frame() {
    let detector = detector(PARAMETERS);
    let mut real = vec![0.0; detector.need().real];
    let scratch = Scratch::new(&mut real, &mut []);
    let mut survey = Survey::new(&detector, scratch).unwrap();
    let (none, line) = (survey.levels(), [[50u8; 600], [100; 600]]);
    assert_eq!((none.dark, none.tissue), (0, 0));
    survey.line(&line[0]).unwrap();
    survey.line(&line[1]).unwrap();
    let expected = Levels {
        dark: 50 * 16,
        tissue: 100 * 16,
        bright: 100 * 16,
    };
    assert_eq!(survey.levels(), expected);
    // Black beside the picture; a line with an echo in it counts.
    for _ in 0..3 {
        survey.line(&[0; 600]).unwrap();
    }
    assert_eq!(survey.levels(), expected);
    for _ in 0..4 {
        survey
            .line(&std::array::from_fn::<u8, 600, _>(|n| u8::from(n == 40)))
            .unwrap();
    }
    let darker = Levels {
        dark: 0,
        tissue: 0,
        // A sixth of the samples that count.
        bright: 100 * 16,
    };
    assert_eq!(survey.levels(), darker);
}

type Change<'a> = &'a dyn Fn(&mut Parameters);

#[test]
fn what_is_out_of_range_is_refused_by_its_name() {
    let cases: [(&str, Change); 30] = [
        ("samples", &|p| p.samples.step = 0.0),
        ("samples", &|p| p.samples.count = (1 << 16) + 1),
        ("line spacing", &|p| p.spacing = f64::NAN),
        ("line spacing over that of the settings", &|p| {
            p.spacing = 1.0
        }),
        ("latency", &|p| p.latency = 1 << 14),
        ("end of the lines (m)", &|p| p.samples.count = 100),
        ("depths", &|p| p.settings.depths = [2.0, 1.0]),
        ("depths", &|p| p.settings.depths = [f64::NAN, 1.0]),
        ("echo", &|p| p.settings.echo = -1e-3),
        ("near", &|p| p.settings.near = [2e-3, 1e-3]),
        ("far", &|p| p.settings.far = [0.0, f64::INFINITY]),
        ("above", &|p| p.settings.above[0] = f64::NAN),
        ("below", &|p| p.settings.below[1] = 2.0),
        ("shadow_from", &|p| p.settings.shadow_from = -1.0),
        ("rest_from", &|p| p.settings.rest_from = -1.0),
        ("rest_block", &|p| p.settings.rest_block = f64::NAN),
        ("rest", &|p| p.settings.rest.centre = 3.0),
        ("shadow_range", &|p| p.settings.shadow_range = 0.0),
        ("margin", &|p| p.settings.margin = 1.1),
        ("onset_floor", &|p| p.settings.onset_floor = 0.0),
        ("onset_weight", &|p| p.settings.onset_weight = -1.0),
        ("cell", &|p| p.settings.cell = 0.0),
        ("contrast", &|p| p.settings.contrast.weight = 17.0),
        ("level", &|p| p.settings.level.width = 0.0),
        ("shadow", &|p| p.settings.shadow.weight = f64::INFINITY),
        ("coherence", &|p| p.settings.coherence.centre = f64::NAN),
        ("absence", &|p| p.settings.absence = f64::NAN),
        ("jump", &|p| p.settings.jump = 65.0),
        ("slope", &|p| p.settings.slope = 1.0),
        ("confidence", &|p| p.settings.confidence[1] = f32::NAN),
    ];
    for (expected, change) in cases {
        let refused = Detector::new(changed(PARAMETERS, change));
        assert_eq!(name(refused), expected);
    }
}

#[test]
fn other_lengths_are_refused() {
    let detector = detector(PARAMETERS);
    let need = detector.need().real;
    let mut real = vec![0.0; need];
    let frame = vec![0; 1200];
    fn scratch(real: &mut [f32]) -> Scratch<'_> {
        Scratch::new(real, &mut [])
    }
    let mut run = |memory: usize, lines: usize| {
        let scratch = scratch(&mut real[..memory]);
        detector.frame(&frame, scratch, &mut vec![None; lines])
    };
    assert_refused(run(need, 3), "length grey levels ");
    assert_refused(run(need - 1, 2), "length real memory ");
    let of_frame =
        detector.frame_with_coherence(&frame, &frame[1..], scratch(&mut real), &mut [None; 2]);
    assert_refused(of_frame, "length coherence ");
    let levels = Levels {
        dark: 0,
        tissue: 0,
        bright: 0,
    };
    let mut tracker = Tracker::new(&detector, scratch(&mut real)).unwrap();
    let short = tracker.line(&frame[1..600], levels);
    assert_refused(short, "length line ");
    let short = tracker.line_with_coherence(&frame[..600], &frame[..599], levels);
    assert_refused(short, "length coherence ");
    let mut survey = Survey::new(&detector, scratch(&mut real)).unwrap();
    assert_refused(survey.line(&frame), "length line ");
}
