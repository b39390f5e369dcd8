//! Numbers that no recording and no simulation has: a one-line error or warning.

use crate::common;

use std::fs;

use common::program::{BEAMFORM, USAGE, folder_with_channel_data, names, run};
use common::{Npz, scalar};
use ndarray::{Array2, Array3};
use ndarray_npy::write_npy;
use num_complex::Complex;

/// Numbers that no machine or medium has.
const VALUES: &str = "1e300 -1e300 1e-300 inf nan 18446744073709551615 -1 99999999999999999999999";

/// Every numeric flag with numbers that no machine or medium has.
///
/// The error names the parameter. A harmless number, such as a threshold's β of 1e-300, may also succeed.
#[test]
fn absurd_numbers_are_reported_by_their_parameter() {
    let folder = folder_with_channel_data();
    let x = Array3::from_shape_fn((4, 30, 4), |(b, n, m)| {
        Complex::new((b + 2 * n) as f32, m as f32)
    });
    Npz::create(&folder.path().join("aligned.npz"))
        .with("x", x.into_dyn())
        .with("fs", scalar(20e6))
        .with("t0", scalar(1e-5))
        .finish();
    let image = folder.path().join("image.npy");
    write_npy(image, &Array2::<f32>::from_elem((64, 64), 3.0)).unwrap();
    let commands = [
        (
            "beamform data.npz -o out.npz --image out.png",
            "subaperture-ratio temporal-half-window diagonal-loading f-number min-elements output-rate \
             depth-start depth-end sound-speed dynamic-range depth width rows columns threads",
        ),
        (
            "beamform aligned.npz -o out.npz --image out.png",
            "beam-spacing sound-speed",
        ),
        ("beamform data.npz -o out.npz --method esmv", "beta rank"),
        (
            "phase-symmetry image.npy -o out.npy",
            "scales threshold strip resize",
        ),
        (
            "simulate vertebra --beams 2 --first-beam 62 -o out.npz",
            "slice depth noise focus f-number beams first-beam beam-step depth-start depth-end",
        ),
        (
            "simulate point --beams 2 --first-beam 62 -o out.npz",
            "offset",
        ),
    ];
    // Absurd but harmless numbers: so small that they act as 0.
    let harmless = "subaperture-ratio diagonal-loading depth-start threshold slice offset noise";
    for (command, flags) in commands {
        for flag in flags.split_whitespace() {
            for value in VALUES.split(' ') {
                let arguments = format!("{command} --{flag} {value}");
                if (value == "1e-300" && harmless.split(' ').any(|one| one == flag))
                    || (value == "-1" && ["noise", "slice", "offset"].contains(&flag))
                {
                    let (code, message) = run(&folder, &arguments);
                    assert!([0, 1, 2].contains(&code), "{arguments}: {message}");
                    for name in names(folder.path()) {
                        if name.starts_with("out.") {
                            fs::remove_file(folder.path().join(name)).unwrap();
                        }
                    }
                    continue;
                }
                let before = names(folder.path());
                let (code, message) = run(&folder, &arguments);
                assert_eq!(code, USAGE, "{arguments}: {message}");
                let key = flag.replace('-', "_");
                assert!(
                    message.contains(&format!("--{flag}")) || message.contains(&key),
                    "{arguments}: {message}"
                );
                assert_eq!(message.lines().count(), 1, "{arguments}: {message}");
                assert!(message.len() < 300, "{arguments}: {message}");
                assert_eq!(names(folder.path()), before, "{arguments}");
            }
        }
    }
}

#[test]
fn the_data_of_these_tests_are_good_where_they_are_not_spoilt() {
    let folder = folder_with_channel_data();
    for method in [
        "das",
        "mv",
        "esmv --rank 1",
        "esmv --beta 0.1",
        "esmv-rank1",
    ] {
        let (code, message) = run(&folder, &format!("{BEAMFORM} --method {method}"));
        assert_eq!((code, message.as_str()), (0, ""));
    }
    assert_eq!(
        names(folder.path()),
        [
            "data.npz",
            "lines.npz",
            "lines.npz.config.toml",
            "lines.png"
        ]
    );
    let (code, message) = run(
        &folder,
        "phase-symmetry lines.png --pad -o ps.npy --image ps.png",
    );
    assert_eq!((code, message.as_str()), (0, ""));
    assert!(folder.path().join("ps.npy.config.toml").exists());
}
