//! The commands from file to file: the meaning of flags, and repeatable runs.

mod depth_step;
mod help;
mod pictures;
mod simulate;

use crate::common;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use bonebeam::beamform::{Apodization, Postfilter};
use bonebeam::covariance::Covariance;
use bonebeam_drive::config::{Beamform, Image};
use bonebeam_drive::methods::MethodName;
use bonebeam_files::{AlignedData, BeamformedLines, ChannelData, Transmits, image};
use common::program::{Folder, USAGE, folder_with, program, refused, run, succeeded};
use common::{Npz, scalar, vector};
use host_sim::config::Config;
use ndarray::{Array2, Array3, Axis};
use num_complex::Complex;
use std::f64::consts::TAU;
use std::fs;
use tempfile::{TempDir, tempdir};

const ELEMENTS: usize = 32;
const PITCH: f64 = 0.3e-3;
const C: f64 = 1540.0;
const FS: f64 = 40e6;
const F0: f64 = 5e6;
const T0: f64 = -1e-6;

/// Steered to one side only, so that a wrong sign shows.
const ANGLES: [f64; 3] = [0.1, 0.2, 0.3];

/// The reflecting point, (x, z) m: below element 20, off every grid in depth.
const POINT: (f64, f64) = (4.5 * PITCH, 11.234e-3);

/// Channel data of one point, straight from the arrival times of the contract.
///
/// The echo is a Gaussian pulse of 60 % bandwidth, centred on τ_tx + τ_rx.
fn point(transmits: Transmits) -> ChannelData {
    let element_x: Vec<f64> = (0..ELEMENTS).map(|m| (m as f64 - 15.5) * PITCH).collect();
    let (x, z) = POINT;
    let arrival = |t: usize| match &transmits {
        // z/c on the beam's axis. Beside it there is no wave: see the pulse's `height`.
        Transmits::Focused { .. } => z / C,
        Transmits::Plane { angle } => (x * angle[t].sin() + z * angle[t].cos()) / C,
        Transmits::Element { index } => z.hypot(x - element_x[index[t]]) / C,
        Transmits::VirtualSource { .. } | Transmits::Delays { .. } => unreachable!(),
    };
    let height = |t: usize| match &transmits {
        Transmits::Focused { x: axis, .. } => (-((axis[t] - x) / (0.5 * PITCH)).powi(2)).exp(),
        _ => 1.0,
    };
    let a = (std::f64::consts::PI * F0 * 0.6).powi(2) / (4.0 * 10f64.powf(6.0 / 20.0).ln());
    let rf = Array3::from_shape_fn((transmits.len(), ELEMENTS, 1000), |(t, m, n)| {
        let tau = arrival(t) + z.hypot(x - element_x[m]) / C;
        let u = n as f64 / FS + T0 - tau;
        (height(t) * (-a * u * u).exp() * (TAU * F0 * u).cos()) as f32
    });
    let t0 = vec![T0; transmits.len()];
    ChannelData {
        t0,
        ..ChannelData::linear(rf, element_x, transmits, ([FS, F0], C))
    }
}

/// A folder with `data.npz`, the point by focused beams.
fn folder_of_a_point() -> TempDir {
    let [focused, ..] = laws();
    folder_with(&point(focused))
}

/// The same by plane waves.
fn by_plane_waves() -> TempDir {
    let [_, plane, _] = laws();
    folder_with(&point(plane))
}

fn laws() -> [Transmits; 3] {
    let axes: Vec<f64> = (0..ELEMENTS).map(|m| (m as f64 - 15.5) * PITCH).collect();
    [
        Transmits::focused(axes, 11e-3),
        Transmits::Plane {
            angle: ANGLES.to_vec(),
        },
        Transmits::Element {
            index: (0..ELEMENTS).collect(),
        },
    ]
}

/// Position of the lines' largest envelope, (x, z) m.
fn brightest(lines: &BeamformedLines) -> (f64, f64) {
    let norms = lines.z.mapv(|z| z.norm());
    let mut best = (0, 0);
    for (position, &norm) in norms.indexed_iter() {
        if norm > norms[best] {
            best = position;
        }
    }
    let depth = lines.c * (lines.t0 + best.1 as f64 / lines.fs) / 2.0;
    (lines.beam_x[best.0], depth)
}

#[test]
fn a_point_appears_where_it_is_with_every_delay_law_and_method() {
    let depths = "--depth-start 0.009 --depth-end 0.0135";
    for law in laws() {
        let folder = folder_with(&point(law));
        for method in [
            "das",
            "mv",
            "esmv --rank 2",
            "esmv --beta 0.001",
            "esmv-rank1",
        ] {
            folder.works(&format!(
                "beamform data.npz -o lines.npz --method {method} {depths}"
            ));
            let (x, z) = brightest(&folder.lines("lines.npz"));
            // Half a line, and half a sample of 38.5 µm.
            assert!((x - POINT.0).abs() < 0.5 * PITCH, "{method}: x is {x}");
            assert!(
                (z - POINT.1).abs() < 0.5 * C / 20e6 / 2.0 + 1e-9,
                "{method}: z is {z}"
            );
        }
    }
}

#[test]
fn depths_and_rate_are_those_asked_for() {
    let folder = by_plane_waves();
    let command = "beamform data.npz -o lines.npz --depth-start 0.005 --depth-end 0.015";
    folder.works(&format!("{command} --output-rate 30.8e6"));
    let lines = folder.lines("lines.npz");
    // Four lines an element, 75 µm apart; 25 µm a sample: 401 of them from 5 to 15 mm.
    assert_eq!(lines.z.dim(), (4 * ELEMENTS, 401));
    assert!((lines.beam_x[1] - lines.beam_x[0] - PITCH / 4.0).abs() < 1e-12);
    assert_eq!(lines.fs, 30.8e6);
    assert_eq!(lines.t0, 2.0 * 0.005 / C);
}

/// `delayed.npz`: aligned data of 3 lines, each of its own frequency, 16 elements and `samples` samples.
fn write_aligned(folder: &TempDir, samples: usize) {
    let x = Array3::from_shape_fn((3, samples, 16), |(b, n, m)| {
        Complex::cis((b + 1) as f32 * 0.1 * n as f32 + 0.3 * m as f32) + 0.1 * (n % 7) as f32
    });
    let aligned = AlignedData {
        x: x.insert_axis(Axis(0)),
        fs: 20e6,
        t0: 13e-6,
        beam_x: None,
    };
    aligned.write(&folder.path().join("delayed.npz")).unwrap();
}

/// Between two depths the lines have the bits of the method, elsewhere of DAS.
///
/// A time window may reach past the two depths. Tested with channel data and with aligned data.
#[test]
fn the_method_works_between_the_depths_asked_for() {
    let folder = by_plane_waves();
    write_aligned(&folder, 120);
    // One direction a line, because the largest of several changes DAS as well.
    let depths = "--sub-lines 1 --depth-start 0.009 --depth-end 0.0135";
    for recording in [format!("data.npz {depths}"), "delayed.npz".into()] {
        let lines = |flags: &str| {
            folder.works(&format!("beamform {recording} -o lines.npz {flags}"));
            folder.lines("lines.npz")
        };
        let (method, das) = (
            "--power-steps 4 --temporal-half-window 2",
            lines("--method das"),
        );
        let adaptive = lines(method);
        for (flags, from, to) in [
            ("--adaptive-depth-start 0.0107", 0.0107, 1.0),
            ("--adaptive-depth-end 0.0121", 0.0, 0.0121),
            (
                "--adaptive-depth-start 0.0107 --adaptive-depth-end 0.0121",
                0.0107,
                0.0121,
            ),
        ] {
            let gated = lines(&format!("{method} {flags}"));
            let mut inside = 0;
            for ((line, n), z) in gated.z.indexed_iter() {
                let depth = gated.c * (gated.t0 + n as f64 / gated.fs) / 2.0;
                let within = (from..=to).contains(&depth);
                inside += usize::from(within);
                let expected = if within { &adaptive } else { &das };
                assert_eq!(*z, expected.z[[line, n]], "{flags}: line {line}, {depth} m");
            }
            assert!(inside > 0 && inside < gated.z.len());
        }
    }
    // A gate outside the lines.
    let command = "beamform delayed.npz -o lines.npz --adaptive-depth-start 0.5";
    let reach = "the lines reach from 0.010010 m to 0.01459";
    let words = ["--adaptive-depth-start 0.5", reach];
    refused(&folder, command, USAGE, &words);
}

#[test]
fn the_written_configuration_repeats_the_run() {
    let folder = folder_of_a_point();
    let flags = "--method esmv --rank 3 --temporal-half-window 2 --covariance forward --diagonal-loading 0.1 \
                 --subaperture-ratio 0.4 --postfilter coherence-factor --apodization hamming --f-number 2 --min-elements 6 --output-rate 25e6 \
                 --depth-start 0.004 --depth-end 0.018 --dynamic-range 45 --rows 200 --median";
    folder.works(&format!("beamform data.npz -o a.npz --image a.png {flags}"));
    let written = Config::read(&folder.path().join("a.npz.config.toml")).unwrap();
    let expected = Config {
        beamform: Beamform {
            method: MethodName::Esmv,
            rank: Some(3),
            temporal_half_window: 2,
            diagonal_loading: 0.1,
            subaperture_ratio: 0.4,
            depth_step: Some(1),
            postfilter: Postfilter::CoherenceFactor,
            apodization: Apodization::Hamming,
            covariance: Covariance::Forward,
            f_number: 2.0,
            min_elements: 6,
            output_rate: Some(25e6),
            depth_start: Some(0.004),
            depth_end: Some(0.018),
            ..Beamform::default()
        },
        image: Image {
            dynamic_range: 45.0,
            rows: Some(200),
            // As many square pixels as fill the image: 9.3 mm across, 14 mm down.
            columns: Some(133),
            median: true,
            ..Image::default()
        },
        ..Config::default()
    };
    assert_eq!(written, expected);
    folder.works("beamform data.npz -o b.npz --image b.png --config a.npz.config.toml");
    let same = |a: &str, b: &str| folder.bytes(a) == folder.bytes(b);
    assert!(same("a.npz", "b.npz"));
    assert!(same("a.png", "b.png"));

    // Flags have their older names, too.
    let older = flags
        .replace("temporal-half-window", "temporal")
        .replace("diagonal-loading", "loading")
        .replace("subaperture-ratio", "subarray-ratio");
    folder.works(&format!("beamform data.npz -o b.npz {older}"));
    assert!(same("a.npz", "b.npz"));

    // A flag overrides the file, and removes keys that contradict it.
    folder.works("beamform data.npz -o c.npz --config a.npz.config.toml --method mv");
    folder.works("beamform data.npz -o c.npz --config a.npz.config.toml --beta 0.5");
    let written = folder.text("c.npz.config.toml");
    assert!(
        written.contains("\nbeta = 0.5") && !written.contains("\nrank ="),
        "{written}"
    );
    assert!(!same("a.npz", "c.npz"));
}

#[test]
fn sixteen_bit_samples_give_the_lines_of_the_same_numbers_in_f32() {
    let folder = tempdir().unwrap();
    let [_, plane, _] = laws();
    let mut data = point(plane);
    let counts = (data.samples.rf(0).unwrap()).mapv(|v| (v * 1000.0).round());
    data.samples = counts.clone().into();
    data.write(&folder.path().join("f32.npz")).unwrap();
    Npz::create(&folder.path().join("i16.npz"))
        .with("rf", counts.mapv(|v| v as i16).into_dyn())
        .with("fs", scalar(data.fs))
        .with("t0", vector(&data.t0))
        .with("element_x", vector(&data.element_x))
        .with("c", scalar(data.c))
        .with("f0", scalar(data.f0))
        .with("tx_angle", vector(&ANGLES))
        .finish();
    let lines = |name: &str| {
        folder.works(&format!("beamform {name}.npz -o lines.npz"));
        folder.lines("lines.npz")
    };
    assert_eq!(lines("f32"), lines("i16"));
}

#[test]
fn aligned_data_are_not_delayed_again() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("delayed.npz");
    // Small integers: their sums are exact, and so is the mean over 8 elements.
    let x = Array3::from_shape_fn((3, 20, 8), |(b, n, m)| {
        Complex::new(
            (b * 7 + n * 3 + m * m) as f32 % 11.0,
            (b + n * m) as f32 % 5.0,
        )
    });
    let beam_x = Some(vec![-1e-3, 0.0, 1e-3]);
    let data = AlignedData {
        x: x.clone().insert_axis(Axis(0)),
        fs: 20e6,
        t0: 1e-6,
        beam_x: beam_x.clone(),
    };
    data.write(&path).unwrap();
    folder.works("beamform delayed.npz -o lines.npz --method das");
    let lines = folder.lines("lines.npz");
    let mean = Array2::from_shape_fn((3, 20), |(b, n)| {
        (0..8).map(|m| x[(b, n, m)]).sum::<Complex<f32>>() / 8.0
    });
    assert_eq!(lines.z, mean);
    assert_eq!((lines.fs, lines.t0, lines.c), (20e6, 1e-6, 1540.0));
    assert_eq!(Some(lines.beam_x), beam_x);

    // Beams without positions are spaced evenly about 0.
    AlignedData {
        beam_x: None,
        ..data
    }
    .write(&path)
    .unwrap();
    folder.works("beamform delayed.npz -o lines.npz --beam-spacing 0.002 --sound-speed 1480");
    let lines = folder.lines("lines.npz");
    assert_eq!(lines.beam_x, [-2e-3, 0.0, 2e-3]);
    assert_eq!(lines.c, 1480.0);
}

/// The measures of a run as one line of JSON.
#[test]
fn a_run_tells_its_measures() {
    let folder = by_plane_waves();
    let command = "beamform data.npz -o lines.npz --json --method das --depth-start 0.009";
    let [text, _] = succeeded(&mut program(&folder, command));
    assert_eq!(text.lines().count(), 1, "{text}");
    let measures: serde_json::Value = serde_json::from_str(&text).unwrap();
    let number = |path: &str| measures.pointer(path).and_then(|v| v.as_f64()).unwrap();
    assert_eq!(number("/lines/count"), (2 * ELEMENTS - 1) as f64);
    assert_eq!(number("/lines/rate_hz"), 20e6);
    assert_eq!(number("/parameters/output_rate"), 20e6);
    assert_eq!(measures["format"], ".npz archive");
    // Half a line, and half a sample.
    assert!((number("/point/x_m") - POINT.0).abs() < 0.5 * PITCH);
    assert!((number("/point/z_m") - POINT.1).abs() < 0.5 * C / 20e6 / 2.0);
    let [six, twelve] = ["/point/width_6db_m", "/point/width_12db_m"].map(number);
    assert!(six > 0.0 && six < twelve, "{six} m, {twelve} m");
    assert!(measures["image"].is_null());
}
