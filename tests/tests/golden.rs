//! The golden cases on the workstation, with every instruction set.
//!
//! Their hashes are the recorded ones and the f32 references'. Run with every profile: bits must not depend on
//! optimisation.

use crate::common;

use std::collections::BTreeSet;

use bonebeam::Complex;
use bonebeam::beamform::{Method, Parameters};
use bonebeam::covariance::Covariance;
use bonebeam::geometry::{Active, Axis, Steering};
use bonebeam::image::Pooling;
use bonebeam::simd::InstructionSet;
use bonebeam_oracle::reference::f32 as reference;
use bonebeam_tests::snapshots::{self, ELEMENTS, PERIODIC, REAL_PARTS, SAMPLES, SNAPSHOTS};
use bonebeam_tests::{
    Workspaces, beamform, delay, hash, image, lanes, phase_symmetry, sqrt, surface,
};
use common::lines::{Line, scalar, scalar_sub_lines};
use ndarray::Array2;
use rand::rngs::ChaCha8Rng;
use rand::{Rng, SeedableRng};

const RECORDED: &str = include_str!("../golden/hashes.txt");

fn golden(file: &str) -> std::path::PathBuf {
    std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("golden")
        .join(file)
}

/// The lines that the firmware prints, too.
fn printed() -> String {
    let mut lines = String::new();
    bonebeam_tests::run(&mut Box::new(Workspaces::new()), &mut |name, hash| {
        lines += &format!("{name} {hash:016x}\n");
    })
    .expect("cases that the core takes");
    lines
}

fn recorded(name: &str) -> u64 {
    let hash = RECORDED
        .lines()
        .find_map(|line| line.strip_prefix(name)?.strip_prefix(' '))
        .unwrap_or_else(|| panic!("{name} is not in hashes.txt"));
    u64::from_str_radix(hash, 16).expect("a hash")
}

#[test]
fn the_recorded_hashes_are_met() {
    assert_eq!(printed(), RECORDED);
}

/// The recording of `host-sim verify` has the same bits on every machine.
///
/// Otherwise its hashes could not be compared. This is the hash of one machine's recording.
#[test]
fn what_is_verified_with_has_the_same_bits_everywhere() {
    let recording = bonebeam_oracle::verify::recording::recording();
    let hash = hash::of(recording.samples.rf(0).unwrap().iter().copied());
    assert_eq!(hash, 0x6f3f_d291_48b7_9299, "{hash:016x}");
}

/// Records the core's present hashes, after an intended change of bits.
///
/// Run
/// `cargo test -p bonebeam-tests --test across -- --ignored record_hashes`.
#[test]
#[ignore = "writes tests/golden/hashes.txt"]
fn record_hashes() {
    std::fs::write(golden("hashes.txt"), printed()).expect("a file that can be written");
}

#[test]
fn the_standard_librarys_square_root_has_the_hash() {
    assert_eq!(hash::of(sqrt::arguments().map(f32::sqrt)), recorded("sqrt"));
}

/// Computes `snapshots_m32.bin` by arithmetic, libm and ChaCha.
///
/// The bytes are the same everywhere.
fn make_snapshots() -> Vec<u8> {
    let mut rng = ChaCha8Rng::seed_from_u64(32);
    // The sum of twelve uniform numbers less 6: nearly Gaussian, of unit variance, and exact.
    let mut gaussian = || {
        let sum: f64 = (0..12)
            .map(|_| f64::from(rng.next_u32()) / 4_294_967_296.0)
            .sum();
        sum - 6.0
    };
    let pulse = |n: usize, at: f64| {
        let t = (n as f64 - at) / 3.0;
        libm::exp(-t * t)
    };
    let mut bytes = Vec::new();
    for n in 0..SAMPLES {
        for m in 0..ELEMENTS {
            let mut x = Complex::new(gaussian(), gaussian());
            // 5 MHz at 20 MHz: a quarter of a turn a sample.
            let carrier = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][n % 4];
            let carrier = Complex::new(carrier.0, carrier.1);
            let angle = 0.8 * m as f64;
            let side = Complex::new(libm::cos(angle), libm::sin(angle));
            x += carrier * (50.0 * pulse(n, 12.0));
            x += carrier * side * (20.0 * pulse(n, 26.0));
            let shadowed = (32..38).contains(&n) && m >= 20 || n >= 42;
            for part in [x.re, x.im] {
                let value = if shadowed { 0.0 } else { part as f32 };
                bytes.extend(value.to_le_bytes());
            }
        }
    }
    bytes
}

#[test]
fn the_snapshots_are_what_made_them() {
    assert!(make_snapshots() == snapshots::BYTES);
}

/// `cargo test -p bonebeam-tests --test across -- --ignored write_snapshots`
#[test]
#[ignore = "writes tests/golden/snapshots_m32.bin"]
fn write_snapshots() {
    std::fs::write(golden("snapshots_m32.bin"), make_snapshots())
        .expect("a file that can be written");
}

fn line_of(x: &[Complex<f32>], active: impl Fn(usize) -> Active) -> Line {
    let x = Array2::from_shape_vec((SAMPLES, ELEMENTS), x.to_vec());
    Line {
        x: x.expect("the sequence's shape"),
        active: (0..SAMPLES).map(active).collect(),
    }
}

fn all(_: usize) -> Active {
    Active {
        first: 0,
        count: ELEMENTS,
    }
}

#[test]
fn the_scalar_beamformers_have_the_hashes() {
    let check = |case: beamform::Case, line: &Line, covariance| {
        let z = scalar(line, case.parameters, covariance);
        assert_eq!(hash::complex(&z), recorded(case.name), "{}", case.name);
    };
    let line = line_of(&SNAPSHOTS, all);
    let others = beamform::POSTFILTERS.into_iter().chain(beamform::APODIZED);
    for case in others.chain(beamform::FORWARD_BACKWARD) {
        check(case, &line, Covariance::ForwardBackward);
    }
    for case in beamform::FORWARD {
        check(case, &line, Covariance::Forward);
    }
    let one = |case: &beamform::Case| case.parameters.sub_lines == 1;
    for case in beamform::DEPTH_STEPS.into_iter().filter(one) {
        check(case, &line, Covariance::ForwardBackward);
    }
    let growing = beamform::growing().expect("a valid aperture");
    let growing = line_of(&SNAPSHOTS, growing);
    check(beamform::GROWING, &growing, Covariance::ForwardBackward);
    check(
        beamform::GROWING_DEPTH_STEP,
        &growing,
        Covariance::ForwardBackward,
    );
    let adaptive = beamform::GATED.parameters;
    let das = Parameters {
        method: Method::Das,
        ..adaptive
    };
    let of = |parameters| scalar(&growing, parameters, Covariance::ForwardBackward);
    let (mut z, adaptive) = (of(das), of(adaptive));
    z[beamform::GATE].copy_from_slice(&adaptive[beamform::GATE]);
    assert_eq!(hash::complex(&z), recorded(beamform::GATED.name));
    let check = |case: beamform::Case, line: &Line, covariance| {
        let count = case.parameters.sub_lines;
        let mut memory = vec![Complex::ZERO; Steering::need(SAMPLES, count).complex];
        let scan = beamform::scan().expect("a valid scan");
        let steering = Steering::new(&scan, beamform::LINE, count, &mut memory).expect("memory");
        let z = scalar_sub_lines(line, steering, case.parameters, covariance);
        assert_eq!(hash::complex(&z), recorded(case.name), "{}", case.name);
    };
    let stepped = beamform::DEPTH_STEPS.into_iter().filter(|case| !one(case));
    for case in stepped.chain(beamform::SUB_LINES_FORWARD_BACKWARD) {
        check(case, &line, Covariance::ForwardBackward);
    }
    for case in beamform::SUB_LINES_FORWARD {
        check(case, &line, Covariance::Forward);
    }
    check(
        beamform::SUB_LINES_GROWING,
        &growing,
        Covariance::ForwardBackward,
    );
    let singular = line_of(&PERIODIC, all);
    let parameters = beamform::SINGULAR.parameters;
    let z = scalar(&singular, parameters, Covariance::ForwardBackward);
    assert_eq!(hash::complex(&z), recorded(beamform::SINGULAR.name));
}

#[test]
fn the_scalar_delay_stage_has_the_hashes() {
    let mut x = vec![Complex::new(f32::NAN, f32::NAN); delay::SAMPLES * delay::ELEMENTS];
    for (name, line) in delay::LINES {
        reference::delay::line(&delay::PARAMETERS, &line, &REAL_PARTS, &mut x);
        assert_eq!(hash::complex(&x), recorded(name), "{name}");
    }
    reference::delay::line(&delay::HALVED, &delay::LINES[0].1, &REAL_PARTS, &mut x);
    assert_eq!(hash::complex(&x), recorded("delay-halved"));
}

#[test]
fn the_scalar_image_stage_has_the_hashes() {
    let positions = |axis: Axis| reference::image::Positions {
        first: axis.first,
        step: axis.step,
        count: axis.count,
    };
    let envelope = reference::image::envelope(&SNAPSHOTS);
    let largest = envelope.iter().copied().fold(0.0, f32::max);
    let levels = reference::image::log_compression(&envelope, largest, image::DYNAMIC_RANGE);
    let [beams, depths, rows, columns] =
        [image::BEAMS, image::DEPTHS, image::ROWS, image::COLUMNS].map(positions);
    let pixels = reference::image::resample(&levels, beams, depths, rows, columns);
    let smooth = reference::image::median(&pixels, image::SIDE);
    for (name, values) in [
        ("envelope", envelope),
        ("log-compression", levels),
        ("resample", pixels),
        ("median", smooth),
    ] {
        assert_eq!(hash::real(&values), recorded(name), "{name}");
    }
}

#[test]
fn the_scalar_depth_interpolation_has_the_hashes() {
    for (name, case) in image::INTERPOLATED {
        let grid = (case.samples, case.depth_step, case.cycles);
        let outputs = case.samples.div_ceil(case.depth_step);
        let of_sub_line = |k: usize| {
            let own = SNAPSHOTS[..outputs * case.sub_lines].iter().skip(k);
            let z: Vec<_> = own.step_by(case.sub_lines).copied().collect();
            let y = reference::depth_interpolation::for_envelope(&z, grid);
            reference::image::envelope(&y)
        };
        let all: Vec<Vec<f32>> = (0..case.sub_lines).map(of_sub_line).collect();
        let pooled = |n: usize| {
            let levels = all.iter().map(|envelope| envelope[n]);
            let largest = levels.clone().fold(0.0, f32::max);
            match case.pooling {
                Pooling::Largest => largest,
                Pooling::Rms => {
                    let squares = levels.map(|level| (level / largest) * (level / largest));
                    let sum = squares.fold(0.0, |sum, square| sum + square);
                    largest * (sum / case.sub_lines as f32).sqrt()
                }
            }
        };
        let envelopes: Vec<f32> = (0..case.samples).map(pooled).collect();
        assert_eq!(hash::real(&envelopes), recorded(name), "{name}");
    }
    let z = &SNAPSHOTS[..image::LINE_SAMPLES.div_ceil(4)];
    let grid = (image::LINE_SAMPLES, 4, image::LINE_CYCLES);
    let line = reference::depth_interpolation::line(z, grid);
    assert_eq!(hash::complex(&line), recorded(image::LINE));
}

#[test]
fn phase_symmetry_of_the_whole_has_the_hash_of_every_strip() {
    let map = reference::phase_symmetry::phase_symmetry(
        &phase_symmetry::IMAGE,
        phase_symmetry::SIDE,
        phase_symmetry::SIDE,
        &phase_symmetry::SCALES,
        phase_symmetry::THRESHOLD,
    );
    let strips = phase_symmetry::STRIPS.map(|(name, _)| name);
    for name in strips.into_iter().chain([phase_symmetry::MAP]) {
        assert_eq!(hash::real(&map), recorded(name), "{name}");
    }
}

#[test]
fn the_surface_by_trying_all_paths_has_the_hashes() {
    let mut frame = [0; surface::LINES * surface::SAMPLES];
    surface::frame(&mut frame);
    for (name, parameters) in surface::CASES {
        let points = reference::surface::surface(&parameters, &frame);
        assert!(
            points.iter().flatten().count() > surface::LINES / 2,
            "{name}"
        );
        assert_eq!(surface::hash_of(&points), recorded(name), "{name}");
    }
}

/// Cases that are never computed over lanes, or only over lanes of a beam each.
const ONE_LANE: [&str; 25] = [
    "sqrt",
    "delay-filter-f32",
    "mv-growing-aperture",
    "mv-depth-gate",
    "envelope",
    "log-compression",
    "log-compression-polynomial",
    "resample",
    "pipeline-iq-left",
    "pipeline-iq-middle",
    "surface-frame",
    "surface-late",
    "surface-contrast",
    "surface-margin",
    "surface-learnt",
    "short-lag-coherence",
    "steering",
    "sub-lines-mv-growing-aperture",
    "sub-lines-pipeline-iq",
    "mv-growing-aperture-depth-step-3",
    "depth-interpolation-2",
    "depth-interpolation-3-rms",
    "depth-interpolation-8-largest",
    "depth-interpolation-line-4",
    "phase-symmetry-map",
];

#[test]
fn every_instruction_set_has_the_hashes() {
    let names = RECORDED.lines().filter_map(|line| line.split(' ').next());
    let expected: BTreeSet<&str> = names.filter(|name| !ONE_LANE.contains(name)).collect();
    for set in InstructionSet::available() {
        let mut met = BTreeSet::new();
        lanes::run(set, &mut |name, hash| {
            assert_eq!(hash, recorded(name), "{name} with {}", set.name());
            met.extend(expected.get(name));
        })
        .expect("cases that the core takes");
        assert_eq!(met, expected);
    }
}
