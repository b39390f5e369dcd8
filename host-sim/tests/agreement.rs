//! Random aligned snapshots through the files, against the f64 reference.
//!
//! The lines that `host-sim beamform` writes agree with the reference within the contract's bounds, for every method.

use bonebeam::covariance::Covariance;
use std::path::Path;
use std::process::Command;

use bonebeam::beamform::{Apodization, Method, Parameters, Postfilter};
use bonebeam::geometry::Active;
use bonebeam_drive::config::Beamform;
use bonebeam_files::{AlignedData, BeamformedLines};
use bonebeam_oracle::verify::beamform::AlignedFrame;
use ndarray::{Array3, Axis};
use num_complex::Complex;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use toml::{Table, Value};

const COVARIANCES: [Covariance; 2] = [Covariance::Forward, Covariance::ForwardBackward];

/// Number of samples of a beam, and number of beams.
const SAMPLES: usize = 40;
const BEAMS: usize = 2;

/// Largest number of ill-conditioned samples: in noise λ₂ > 0.99 λ₁ is rare.
const MOST_LEFT_OUT: usize = SAMPLES * BEAMS / 8;

/// The flags of a section's keys that differ from the default.
fn flags(section: &Beamform) -> Vec<String> {
    let [given, default] =
        [section, &Beamform::default()].map(|section| Table::try_from(section).expect("a section"));
    let mut flags = Vec::new();
    for (key, value) in given
        .into_iter()
        .filter(|(key, value)| default.get(key) != Some(value))
    {
        flags.push(format!("--{}", key.replace('_', "-")));
        match value {
            Value::Boolean(_) => {}
            Value::String(word) => flags.push(word),
            number => flags.push(number.to_string()),
        }
    }
    flags
}

fn beamform(folder: &Path, parameters: Parameters, covariance: Covariance) -> BeamformedLines {
    let section = Beamform {
        covariance,
        ..Beamform::of(parameters)
    };
    let output = folder.join("lines.npz");
    let run = Command::new(env!("CARGO_BIN_EXE_host-sim"))
        .arg("beamform")
        .arg(folder.join("delayed.npz"))
        .args(flags(&section))
        .arg("-o")
        .arg(&output)
        .output()
        .expect("the program runs");
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );
    BeamformedLines::read(&output).expect("lines that were just written")
}

fn assert_agrees(elements: usize) {
    let folder = tempfile::tempdir().expect("a folder");
    let mut rng = ChaCha8Rng::seed_from_u64(elements as u64);
    let mut noise = || rng.random_range(-1.0f32..1.0);
    let x = Array3::from_shape_simple_fn((BEAMS, SAMPLES, elements), || {
        Complex::new(noise(), noise())
    });
    let data = AlignedData {
        x: x.clone().insert_axis(Axis(0)),
        fs: 20e6,
        t0: 0.0,
        beam_x: None,
    };
    data.write(&folder.path().join("delayed.npz"))
        .expect("aligned data");
    let windows = [0, 2, 10].map(|temporal_half_window| Parameters {
        temporal_half_window,
        ..Parameters::default()
    });
    let postfilters = Postfilter::EXAMPLES.map(|postfilter| Parameters {
        postfilter,
        ..Parameters::default()
    });
    let apodizations = Apodization::EXAMPLES.map(|apodization| Parameters {
        apodization,
        ..Parameters::default()
    });
    for parameters in windows.into_iter().chain(postfilters).chain(apodizations) {
        for covariance in COVARIANCES {
            let line = |method| {
                let parameters = Parameters {
                    method,
                    ..parameters
                };
                (
                    beamform(folder.path(), parameters, covariance).z,
                    parameters,
                )
            };
            let z = Method::EXAMPLES.map(line);
            let frame = AlignedFrame {
                x: &x,
                active: |_, _| Active {
                    first: 0,
                    count: elements,
                },
                covariance,
            };
            let lines: Vec<_> = z.iter().map(|(z, parameters)| (z, *parameters)).collect();
            let bounds = frame.errors(&lines, 1).expect("loaded covariances");
            for ((_, parameters), bound) in lines.iter().zip(&bounds) {
                assert!(
                    bound.holds() && bound.ill_conditioned <= MOST_LEFT_OUT,
                    "{elements} elements, {covariance:?}, {parameters:?}: {bound:?}"
                );
            }
        }
    }
}

#[test]
fn snapshots_of_16_elements_agree() {
    assert_agrees(16);
}

#[test]
fn snapshots_of_32_elements_agree() {
    assert_agrees(32);
}

#[test]
fn snapshots_of_64_elements_agree() {
    assert_agrees(64);
}

#[test]
fn snapshots_of_128_elements_agree() {
    assert_agrees(128);
}
