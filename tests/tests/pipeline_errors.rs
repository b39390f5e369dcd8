//! The errors of the pipeline, and the sizes of its memory.

use crate::common;
use crate::common::kit::*;
use common::frames::{ELEMENTS, LINES, NEED, PARAMETERS, focused, record};

#[test]
fn a_gate_that_is_none_is_refused() {
    let refused = |from, to| {
        let gate = DepthGate { from, to };
        name(Pipeline::new(PARAMETERS).unwrap().with_gate(gate))
    };
    let (start, end) = ("depth gate's start", "depth gate's end");
    assert_eq!(refused(f64::NAN, 8e-3), start);
    assert_eq!(refused(f64::NEG_INFINITY, 8e-3), start);
    assert_eq!(refused(8e-3, f64::NAN), end);
    assert_eq!(refused(8e-3, f64::INFINITY), end);
    assert_eq!(refused(8e-3, 8e-3), end);
    // Above the line, below it, and between two samples.
    assert_eq!(refused(1e-3, 2e-3), end);
    assert_eq!(refused(13e-3, 14e-3), start);
    let between = Scan::new(PARAMETERS.scan).unwrap().depth(20) + 1e-6;
    assert_eq!(refused(between, between + 1e-6), start);
}

#[test]
fn sizes_follow_from_the_parameters_and_others_are_refused() {
    let pipeline = Pipeline::new(PARAMETERS).unwrap();
    assert_eq!(pipeline.need(1), NEED);
    let (mut real, mut complex) = (vec![0.0; NEED.real], vec![Complex::ZERO; NEED.complex]);
    for (shorter, name) in [(0, "real memory"), (1, "complex memory")] {
        let memory = Scratch::new(&mut real[1 - shorter..], &mut complex[shorter..]);
        assert_refused(Frame::new(&pipeline, memory), &format!("length {name} "));
    }
    let memory = Scratch::new(&mut real, &mut complex);
    let mut frame = Frame::new(&pipeline, memory).unwrap();
    let rf = record(0);
    let record = Record::new(&rf, ELEMENTS).unwrap();
    assert_refused(frame.line(LINES, [(focused(), &record)]), "capacity line ");
    // Before the first line the image is black, and the map is 0.
    assert!(frame.image().unwrap().iter().all(|&pixel| pixel == 0.0));
    assert!(frame.bone_map().unwrap().iter().all(|&ps| ps == 0.0));
}

/// 64 lines of two directions at every second sample: a frame had 430,848 bytes when it held its directions.
#[test]
fn directions_are_the_plans_and_not_the_frames() {
    const OF_SUB_LINES: Parameters = Parameters {
        scan: ScanParameters {
            lines: Lines::Even(Axis::centred(64, 0.2e-3)),
            end: Depth::Metres(4e-3 + 239.0 * 38.5e-6),
            ..PARAMETERS.scan
        },
        beamformer: beamform::Parameters {
            sub_lines: 2,
            depth_step: 2,
            ..beamform::Parameters::of(Method::Mv)
        },
        block: 64,
        ..PARAMETERS
    };
    const LENGTH: usize = valid!(OF_SUB_LINES.directions_len());
    const NEED: Need = valid!(OF_SUB_LINES.need(Input::Rf, 1));
    assert_eq!(8 * LENGTH, 245_760);
    let bytes = 4 * NEED.real + 8 * NEED.complex;
    assert!(bytes <= 260_000, "{bytes}");
    let plan = || Pipeline::new(OF_SUB_LINES).unwrap();
    assert_eq!(
        (plan().need(1), plan().lines().directions_len()),
        (NEED, LENGTH)
    );
    let mut directions = vec![Complex::ZERO; LENGTH];
    plan().lines().directions(&mut directions).unwrap();
    let (mut real, mut complex) = (vec![0.0; NEED.real], vec![Complex::ZERO; NEED.complex]);
    let mut made =
        |plan: &Pipeline| Frame::new(plan, Scratch::new(&mut real, &mut complex)).map(drop);
    let expected = format!("length directions 0 for {LENGTH}");
    assert_eq!(refused(made(&plan())), expected);
    let short = plan().with_directions(&directions[1..]).map(drop);
    assert_refused(short, "length directions ");
    assert_eq!(made(&plan().with_directions(&directions).unwrap()), Ok(()));
    assert_eq!(PARAMETERS.directions_len(), Ok(0));
}

#[test]
fn bad_parameters_are_named() {
    let name = |change: fn(&mut Parameters)| name(Pipeline::new(changed(PARAMETERS, change)));
    assert_eq!(name(|p| p.scan.sound_speed = -1.0), "sound_speed");
    assert_eq!(name(|p| p.scan.lines = Lines::At(&[0.0, 1e-3])), "lines");
    assert_eq!(name(|p| p.scan.sampling_rate = 400e6), "output_rate");
    assert_eq!(name(|p| p.scan.end = Depth::Metres(1e9)), "output_samples");
    assert_eq!(
        name(|p| p.beamformer.subaperture_ratio = 0.0),
        "subaperture_ratio"
    );
    assert_eq!(name(|p| p.dynamic_range = 0.0), "dynamic range in dB");
    assert_eq!(name(|p| p.rows = 65), "image rows");
    assert_eq!(name(|p| p.columns = 0), "image columns");
    assert_eq!(name(|p| p.strip = 0), "strip height");
    assert_eq!(name(|p| p.scales = &[1.0]), "scale in cycles per pixel");
}
