//! Numbers that no recording and no simulation has: a one-line error or warning.

use crate::common;

use std::fs;

use common::program::{BEAMFORM, DATA, USAGE, fails, folder_with_channel_data, names, run};
use common::{Npz, channel_data_without, ramp, scalar, vector};
use ndarray::{Array2, Array3, ArrayD};
use ndarray_npy::write_npy;
use num_complex::Complex;
use tempfile::tempdir;

#[test]
fn simulations_that_cannot_be() {
    let folder = tempdir().unwrap();
    fs::write(folder.path().join("bone.ply"), "ply\nformat ascii 1.x\n").unwrap();
    let cases: [(&str, i32, &[&str]); 13] = [
        (
            "point --slice 0",
            USAGE,
            &["--slice has no effect", "point"],
        ),
        (
            "vertebra --offset 0",
            USAGE,
            &["--offset has no effect", "vertebra"],
        ),
        ("vertebra --slice 1", USAGE, &["slice", "1000 mm"]),
        ("vertebra --depth 0", USAGE, &["--depth", "above 0"]),
        // Millimetres for metres.
        ("vertebra --depth 15", USAGE, &["--depth", "15", "10 (m)"]),
        ("vertebra --depth 0.5", USAGE, &["nothing of the phantom"]),
        ("point --offset 2", USAGE, &["nothing of the phantom"]),
        ("vertebra --f-number 0", USAGE, &["f_number", "expected"]),
        (
            "vertebra --noise 0 --noise-free",
            USAGE,
            &["--noise", "--noise-free"],
        ),
        ("spine", USAGE, &["spine", "point, vertebra"]),
        ("vertebra --beams 0", USAGE, &["beams"]),
        ("vertebra --mesh none.ply", DATA, &["none.ply"]),
        ("vertebra --mesh bone.ply", DATA, &["bone.ply", "PLY"]),
    ];
    for (arguments, status, parts) in cases {
        fails(
            &folder,
            &format!("simulate {arguments} -o data.npz"),
            status,
            parts,
        );
    }
    fails(&folder, "simulate -o data.npz", USAGE, &["PHANTOM"]);
    fails(
        &folder,
        "simulate point -o none/data.npz",
        DATA,
        &["none", "does not exist"],
    );
}

#[test]
fn numbers_beyond_all_use() {
    let folder = folder_with_channel_data();
    let threads = "beamform data.npz -o lines.npz --threads 100000";
    fails(&folder, threads, USAGE, &["--threads is 100000", "256"]);
    let threshold = "phase-symmetry image.npy -o ps.npy --threshold 1e39";
    fails(&folder, threshold, USAGE, &["--threshold", "1e12"]);
}

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
    let commands: [(&str, &[&str]); 6] = [
        (
            "beamform data.npz -o out.npz --image out.png",
            &[
                "subaperture-ratio",
                "temporal-half-window",
                "diagonal-loading",
                "f-number",
                "min-elements",
                "output-rate",
                "depth-start",
                "depth-end",
                "sound-speed",
                "dynamic-range",
                "depth",
                "width",
                "rows",
                "columns",
                "threads",
            ],
        ),
        (
            "beamform aligned.npz -o out.npz --image out.png",
            &["beam-spacing", "sound-speed"],
        ),
        (
            "beamform data.npz -o out.npz --method esmv",
            &["beta", "rank"],
        ),
        (
            "phase-symmetry image.npy -o out.npy",
            &["scales", "threshold", "strip", "resize"],
        ),
        (
            "simulate vertebra --beams 2 --first-beam 62 -o out.npz",
            &[
                "slice",
                "depth",
                "noise",
                "focus",
                "f-number",
                "beams",
                "first-beam",
                "beam-step",
                "depth-start",
                "depth-end",
            ],
        ),
        (
            "simulate point --beams 2 --first-beam 62 -o out.npz",
            &["offset"],
        ),
    ];
    // Absurd but harmless numbers: so small that they act as 0.
    let harmless = [
        "subaperture-ratio",
        "diagonal-loading",
        "depth-start",
        "threshold",
        "slice",
        "offset",
        "noise",
    ];
    for (command, flags) in commands {
        for flag in flags {
            for value in [
                "1e300",
                "-1e300",
                "1e-300",
                "inf",
                "nan",
                "18446744073709551615",
                "-1",
                "99999999999999999999999",
            ] {
                let arguments = format!("{command} --{flag} {value}");
                if (value == "1e-300" && harmless.contains(flag))
                    || (value == "-1" && ["noise", "slice", "offset"].contains(flag))
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

/// Errors for data that are valid in themselves, but in another unit or order.
#[test]
fn values_in_another_unit_and_swapped_axes() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    let pitches = |pitch: f64| vector(&[-1.5, -0.5, 0.5, 1.5].map(|m| m * pitch));
    let cases: [(&str, ArrayD<f64>, &[&str]); 14] = [
        (
            "element_x",
            pitches(0.3),
            &["`element_x`", "0.3 m", "in mm"],
        ),
        ("element_x", pitches(300.0), &["300 m", "in µm"]),
        ("element_x", pitches(0.0), &["does not ascend"]),
        ("c", scalar(1.54), &["`c` is 1.54 m/s", "in km/s"]),
        ("c", scalar(154_000.0), &["`c` is 154000 m/s", "in cm/s"]),
        ("c", scalar(-1540.0), &["`c` is -1540"]),
        ("fs", scalar(40.0), &["`fs` is 40 Hz", "in MHz"]),
        ("fs", scalar(0.0), &["`fs` is 0"]),
        ("f0", scalar(5.0), &["`f0` is 5 Hz", "in MHz"]),
        ("f0", scalar(-5e6), &["`f0` is -5000000"]),
        // As for a record at 4/3 of f0.
        (
            "fs",
            scalar(20e6 / 3.0),
            &["`fs` of 6666670 Hz", "band-sampled", "make I/Q"],
        ),
        (
            "t0",
            vector(&[1.0, 2.0]),
            &["`t0` is 1 at transmit 0", "in µs"],
        ),
        (
            "t0",
            scalar(400.0),
            &["`t0` is 400 at transmit 0", "counted in samples"],
        ),
        (
            "tx_angle",
            vector(&[-5.0, 5.0]),
            &["`tx_angle` is -5 at transmit 0", "in degrees"],
        ),
    ];
    for (key, value, parts) in cases {
        channel_data_without(&path, &[key])
            .with(key, value)
            .finish();
        let parts: Vec<&str> = ["data.npz"].iter().chain(parts).copied().collect();
        fails(&folder, BEAMFORM, DATA, &parts);
    }
    let focused = |x: &[f64], focus: f64| {
        channel_data_without(&path, &["tx_angle"])
            .with("tx_x", vector(x))
            .with("tx_focus", scalar(focus))
            .finish();
    };
    focused(&[-15.0, 15.0], 15e-3);
    fails(
        &folder,
        BEAMFORM,
        DATA,
        &["`tx_x` is -15 m at transmit 0", "in mm"],
    );
    focused(&[-1e-4, 1e-4], 15.0);
    fails(
        &folder,
        BEAMFORM,
        DATA,
        &["`tx_focus` at transmit 0 is 15 m", "in mm"],
    );

    let swapped = |order: [usize; 3]| {
        ramp()
            .permuted_axes(order)
            .as_standard_layout()
            .into_owned()
    };
    for (order, axis) in [([0, 2, 1], "third"), ([1, 0, 2], "first")] {
        channel_data_without(&path, &["rf"])
            .with("rf", swapped(order).into_dyn())
            .finish();
        let axis = format!("{axis} axis");
        fails(
            &folder,
            BEAMFORM,
            DATA,
            &["`element_x` has length 4", &axis, "swapped"],
        );
    }
}

/// The warning suggests the likely value, and the run goes on.
#[test]
fn doubtful_values_are_warned_of() {
    let folder = folder_with_channel_data();
    let warned = |flags: &str, parts: &[&str]| {
        let (code, message) = run(&folder, format!("{BEAMFORM} {flags}").trim_end());
        assert_eq!(code, 0, "{flags}: {message}");
        assert!(
            message.starts_with("host-sim: warning: data.npz: "),
            "{message}"
        );
        assert_eq!(message.lines().count(), 1, "{message}");
        for part in parts {
            assert!(message.contains(part), "`{part}` is not in: {message}");
        }
    };
    // The record spans 0.77 to 2.75 mm; its full range gives no warning.
    warned(
        "--depth-end 0.003",
        &["0.003 m", "the record holds 0.000770 m to"],
    );
    warned("--depth-start 0.0005", &["0.0005 m", "the record holds"]);
    let far = [("start", "0.01"), ("end", "0.0005"), ("end", "0.04")];
    for (flag, depth) in far {
        let arguments = format!("{BEAMFORM} --depth-{flag} {depth}");
        let message = format!("--depth-{flag} is {depth} m");
        fails(&folder, &arguments, USAGE, &[&message, "the record holds"]);
    }
    let path = folder.path().join("data.npz");
    channel_data_without(&path, &["tx_angle"])
        .with("tx_angle", vector(&[-1.0, 1.0]))
        .finish();
    warned("", &["`tx_angle` is -1 rad", "degrees"]);
    channel_data_without(&path, &["tx_angle"])
        .with("tx_x", vector(&[-1e-4, 1e-4]))
        .with("tx_focus", scalar(5.0))
        .finish();
    warned("", &["`tx_focus` is 5 m", "in mm"]);
    // Samples in place of elements.
    let many: Vec<f64> = (0..1100).map(|m| 1e-4 * (f64::from(m) - 549.5)).collect();
    let rf = Array3::from_elem((2, 1100, 64), 1f32);
    channel_data_without(&path, &["rf", "element_x"])
        .with("rf", rf.into_dyn())
        .with("element_x", vector(&many))
        .finish();
    warned(
        "",
        &["1100 elements over 109.9 mm", "the axes of the samples"],
    );
}
