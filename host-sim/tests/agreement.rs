//! Delayed random snapshots through the files: what `host-sim beamform` writes agrees with the f64
//! reference within the contract's bounds, for every method.

use bonebeam::covariance::Covariance;
use std::path::Path;
use std::process::Command;

use bonebeam::beamform::{Method, Parameters};
use bonebeam::geometry::Active;
use bonebeam_files::{AlignedData, Lines};
use bonebeam_oracle::validate::beamform::Frame;
use ndarray::{Array2, Array3, Axis};
use num_complex::Complex;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The flags of each method, and what the core calls it.
const METHODS: [(&[&str], Method); 8] = [
    (&["das"], Method::Das),
    (&["mv"], Method::Mv),
    (&["esmv", "--beta", "0.1"], Method::EsmvBeta(0.1)),
    (&["esmv", "--beta", "0.00001"], Method::EsmvBeta(1e-5)),
    (&["esmv", "--rank", "3"], Method::EsmvRank(3)),
    (&["esmv-rank1"], Method::EsmvRank1),
    (
        &["esmv-rank1", "--power-steps", "8"],
        Method::EsmvRank1Steps(8),
    ),
    (&["esmv-rank1", "--exclude-first"], Method::EsmvExcludeFirst),
];

const COVARIANCES: [(&str, Covariance); 2] = [
    ("forward", Covariance::Forward),
    ("forward-backward", Covariance::ForwardBackward),
];

/// Samples a beam, and beams.
const SAMPLES: usize = 40;
const BEAMS: usize = 2;

/// Of all samples, the most that may be ill-conditioned: in noise λ₂ > 0.99 λ₁ is rare.
const MOST_LEFT_OUT: usize = SAMPLES * BEAMS / 8;

fn beamform(
    folder: &Path,
    method: &[&str],
    temporal_half_window: usize,
    covariance: &str,
) -> Lines {
    let output = folder.join("lines.npz");
    let run = Command::new(env!("CARGO_BIN_EXE_host-sim"))
        .arg("beamform")
        .arg(folder.join("delayed.npz"))
        .arg("--method")
        .args(method)
        .args(["--temporal-half-window", &temporal_half_window.to_string()])
        .args(["--covariance", covariance, "-o"])
        .arg(&output)
        .output()
        .expect("the program runs");
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );
    Lines::read(&output).expect("lines that were just written")
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
    for temporal_half_window in [0, 2, 10] {
        for (flag, covariance) in COVARIANCES {
            let z: Vec<(Array2<Complex<f32>>, Parameters)> = METHODS
                .iter()
                .map(|&(method, core)| {
                    let parameters = Parameters {
                        method: core,
                        temporal_half_window,
                        ..Parameters::default()
                    };
                    (
                        beamform(folder.path(), method, temporal_half_window, flag).z,
                        parameters,
                    )
                })
                .collect();
            let frame = Frame {
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
                    "{elements} elements, {flag}, {parameters:?}: {bound:?}"
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
