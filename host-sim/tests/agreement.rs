//! Aligned data through files and flags: the lines that `host-sim beamform` writes have the driver's bits.
//!
//! `tests/tests/kernels.rs` and `beamform_f64.rs` beside it compare the driver with the references.

use crate::common::changed;
use crate::common::program::{program, succeeded};
use bonebeam::covariance::Covariance;
use std::path::Path;

use bonebeam::beamform::{Apodization, Method, Parameters, Postfilter};
use bonebeam::geometry::Active;
use bonebeam_drive::config::Beamform;
use bonebeam_files::{AlignedData, BeamformedLines};
use ndarray::{Array3, Axis};
use num_complex::Complex;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use toml::{Table, Value};

const COVARIANCES: [Covariance; 2] = [Covariance::Forward, Covariance::ForwardBackward];

const BEAMS: usize = 2;
const SAMPLES: usize = 40;
const ELEMENTS: usize = 24;

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
    let section = changed(Beamform::of(parameters), |b| b.covariance = covariance);
    succeeded(program(folder, "beamform delayed.npz -o lines.npz").args(flags(&section)));
    BeamformedLines::read(&folder.join("lines.npz")).expect("lines that were just written")
}

#[test]
fn flags_give_the_lines_of_their_parameters() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut rng = ChaCha8Rng::seed_from_u64(16);
    let mut noise = || rng.random_range(-1.0f32..1.0);
    let x = Array3::from_shape_simple_fn((BEAMS, SAMPLES, ELEMENTS), || {
        Complex::new(noise(), noise())
    });
    let data = AlignedData {
        x: x.clone().insert_axis(Axis(0)),
        fs: 20e6,
        t0: 0.0,
        beam_x: None,
    };
    let path = folder.path().join("delayed.npz");
    data.write(&path).expect("aligned data");
    let all = |_, _| Active::new(0, ELEMENTS);
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
    let variants = windows.into_iter().chain(postfilters).chain(apodizations);
    let variants = variants.flat_map(|p| COVARIANCES.map(|covariance| (p, covariance)));
    for (parameters, covariance) in variants {
        for method in Method::EXAMPLES {
            let parameters = Parameters {
                method,
                covariance,
                ..parameters
            };
            let z = beamform(folder.path(), parameters, covariance).z;
            let expected = bonebeam_drive::beamform::beamform(x.view(), &all, parameters, &|_| {});
            assert!(z == expected.expect("lines"), "{parameters:?}");
        }
    }
}
