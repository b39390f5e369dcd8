//! Bad input: one line that names the fault, the exit status, and no output.

use crate::common;

use std::fs;

use common::program::{BEAMFORM, DATA, USAGE, fails, folder_with_channel_data, names, run};
use common::{Npz, channel_data_without, ramp, scalar, vector};
use ndarray::{Array2, Array3, ArrayD};
use ndarray_npy::write_npy;
use num_complex::Complex;
use tempfile::tempdir;

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

#[test]
fn samples_that_are_not_finite() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    for value in [f32::NAN, f32::INFINITY] {
        let mut rf = ramp();
        rf[(1, 2, 33)] = value;
        channel_data_without(&path, &["rf"])
            .with("rf", rf.into_dyn())
            .finish();
        fails(
            &folder,
            BEAMFORM,
            DATA,
            &["data.npz", "transmit 1, element 2, sample 33"],
        );

        let mut x = Array3::from_elem((2, 30, 4), Complex::new(1.0f32, 0.0));
        x[(1, 7, 2)].re = value;
        let npz = Npz::create(&path).with("x", x.into_dyn());
        npz.with("fs", scalar(20e6))
            .with("t0", scalar(0.0))
            .finish();
        fails(
            &folder,
            BEAMFORM,
            DATA,
            &["data.npz", "beam 1, sample 7, element 2"],
        );
    }
}

#[test]
fn parameters_that_cannot_be() {
    let folder = folder_with_channel_data();
    let cases: [(&str, &[&str]); 17] = [
        // L is above M.
        (
            "--subaperture-ratio 1.1",
            &["--subaperture-ratio", "1.1", "at most 1"],
        ),
        // K is longer than the record.
        (
            "--temporal-half-window 100000",
            &["temporal_half_window", "100000", "at most"],
        ),
        ("--f-number 0", &["--f-number", "0", "above 0"]),
        ("--f-number nan", &["--f-number", "NaN", "above 0"]),
        (
            "--diagonal-loading -0.1",
            &["--diagonal-loading", "-0.1", "0 to 1e6"],
        ),
        (
            "--output-rate 5e6",
            &["--output-rate", "5000000", "centre frequency"],
        ),
        ("--depth-start 1", &["--depth-start", "1 m", "the record"]),
        ("--depth-end 9", &["--depth-end", "9 m", "the record holds"]),
        ("--depth 0", &["--depth", "above 0"]),
        ("--rows 0", &["--rows", "2 to"]),
        ("--dynamic-range 0", &["--dynamic-range", "dB"]),
        ("--sound-speed 0", &["--sound-speed", "m/s"]),
        ("--method esmv --rank 0", &["--rank", "at least 1"]),
        ("--method esmv --beta 2", &["--beta", "at most 1"]),
        // Above 0 in f64, but not in the core's f32.
        ("--method esmv --beta 1e-300", &["--beta", "above 0"]),
        ("--beta x", &["--beta", "'x'"]),
        ("--method music", &["--method", "music", "esmv-rank1"]),
    ];
    for (flags, parts) in cases {
        fails(&folder, &format!("{BEAMFORM} {flags}"), USAGE, parts);
    }
}

#[test]
fn flags_that_contradict_each_other() {
    let folder = folder_with_channel_data();
    for (flags, part) in [
        ("--method das --beta 0.1", "--beta needs --method esmv"),
        ("--method mv --rank 2", "--rank needs --method esmv"),
        ("--method esmv --rank 2 --beta 0.1", "--beta and --rank"),
        (
            "--method esmv --exclude-first",
            "--exclude-first needs --method esmv-rank1",
        ),
    ] {
        fails(&folder, &format!("{BEAMFORM} {flags}"), USAGE, &[part]);
    }
    let x = Array3::from_elem((2, 30, 4), Complex::new(1.0f32, 0.0)).into_dyn();
    let npz = Npz::create(&folder.path().join("delayed.npz")).with("x", x);
    npz.with("fs", scalar(20e6))
        .with("t0", scalar(0.0))
        .finish();
    let command = "beamform delayed.npz -o lines.npz --f-number 2";
    fails(
        &folder,
        command,
        USAGE,
        &["--f-number has no effect", "delayed.npz"],
    );
    let layout = format!("{BEAMFORM} --layout must");
    fails(
        &folder,
        &layout,
        DATA,
        &["--layout) has no effect", "data.npz"],
    );
    let spacing = format!("{BEAMFORM} --beam-spacing 1e-3");
    let parts = ["--beam-spacing has no effect", "channel data"];
    fails(&folder, &spacing, USAGE, &parts);
    fails(&folder, "beamform data.npz", USAGE, &["--output"]);
    fails(&folder, "beamfrom data.npz", USAGE, &["beamfrom"]);
    fails(
        &folder,
        &format!("--threads 0 {BEAMFORM}"),
        USAGE,
        &["--threads"],
    );
}

#[test]
fn arrays_of_the_wrong_kind() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    channel_data_without(&path, &["rf"])
        .with("rf", ArrayD::<f32>::zeros(vec![2, 4, 0]))
        .finish();
    fails(&folder, BEAMFORM, DATA, &["data.npz", "`rf` is empty"]);
    channel_data_without(&path, &["rf"])
        .with("rf", ramp().mapv(|v| v as u32).into_dyn())
        .finish();
    fails(
        &folder,
        BEAMFORM,
        DATA,
        &[
            "data.npz",
            "`rf` has dtype",
            "a float type, int8, int16, int32, int64, uint16 or uint8",
        ],
    );
    channel_data_without(&path, &["rf"])
        .with("rf", ArrayD::<f32>::zeros(vec![4, 64]))
        .finish();
    fails(
        &folder,
        BEAMFORM,
        DATA,
        &["data.npz", "`rf` has shape [4, 64]", "transmit"],
    );
    channel_data_without(&path, &["f0"]).finish();
    fails(&folder, BEAMFORM, DATA, &["data.npz", "no key `f0`"]);
    channel_data_without(&path, &["tx_angle"]).finish();
    fails(&folder, BEAMFORM, DATA, &["data.npz", "no delay law"]);
    for value in [0.0, -1.0] {
        channel_data_without(&path, &["fs"])
            .with("fs", scalar(value))
            .finish();
        fails(&folder, BEAMFORM, DATA, &["data.npz", "`fs` is", "above 0"]);
    }
    channel_data_without(&path, &["t0"])
        .with("t0", vector(&[0.0; 3]))
        .finish();
    fails(
        &folder,
        BEAMFORM,
        DATA,
        &["data.npz", "`t0` has length 3", "expected 2"],
    );
}

#[test]
fn records_that_make_no_line_or_no_image() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    channel_data_without(&path, &["t0"])
        .with("t0", vector(&[-0.005, -0.005]))
        .finish();
    fails(&folder, BEAMFORM, DATA, &["data.npz", "has no depth"]);
    channel_data_without(&path, &["tx_angle"])
        .with("tx_x", vector(&[1e-3, 1e-3]))
        .with("tx_focus", scalar(15e-3))
        .finish();
    fails(&folder, BEAMFORM, DATA, &["data.npz", "at least 2 beams"]);
    let (code, message) = run(&folder, "beamform data.npz -o lines.npz");
    assert_eq!((code, message.as_str()), (0, ""));

    write_npy(folder.path().join("dot.npy"), &Array2::<f32>::zeros((1, 1))).unwrap();
    let resize = "phase-symmetry dot.npy --resize 64x64 -o ps.npy";
    fails(&folder, resize, DATA, &["dot.npy", "1x1", "at least 2"]);
}

/// A bone map that cannot be made leaves no lines behind either.
#[test]
fn bone_maps_that_cannot_be_made() {
    let folder = folder_with_channel_data();
    let command = "beamform data.npz -o lines.npz";
    for (flags, status, parts) in [
        ("--threshold 5", USAGE, ["--threshold", "--bone-map"]),
        ("--pad --image image.npy", USAGE, ["--pad", "--bone-map"]),
        (
            "--wavelengths 0.002",
            USAGE,
            ["--wavelengths", "--bone-map"],
        ),
        (
            "--bone-map map.npy --wavelengths 2",
            USAGE,
            ["--wavelengths", "2 to 1024 pixels"],
        ),
        (
            "--bone-map map.npy --noise-by-direction",
            USAGE,
            ["--noise-by-direction", "--noise-deviations"],
        ),
        (
            "--bone-map map.npy --noise-deviations -1",
            USAGE,
            ["--noise-deviations", "0 to 100"],
        ),
        ("--bone-map map.tif", USAGE, ["map.tif", ".png or .npy"]),
        ("--bone-map lines.npz", USAGE, ["lines.npz", ""]),
        (
            "--rows 60 --columns 64 --image image.npy --bone-map map.npy",
            DATA,
            ["60 rows", "--pad"],
        ),
    ] {
        fails(&folder, &format!("{command} {flags}"), status, &parts);
    }
}

#[test]
fn files_that_are_not_whole() {
    let folder = folder_with_channel_data();
    let path = folder.path().join("data.npz");
    let whole = fs::read(&path).unwrap();
    for length in [0, 30, whole.len() / 2, whole.len() - 1] {
        fs::write(&path, &whole[..length]).unwrap();
        fails(&folder, BEAMFORM, DATA, &["data.npz", "truncated"]);
    }
    fails(
        &folder,
        "beamform none.npz -o lines.npz",
        DATA,
        &["none.npz", "cannot be opened: no such file"],
    );
    fails(
        &folder,
        &format!("{BEAMFORM} --config none.toml"),
        USAGE,
        &["none.toml"],
    );
    fs::write(folder.path().join("bad.toml"), "[beamform]\nloadin = 1\n").unwrap();
    fails(
        &folder,
        &format!("{BEAMFORM} --config bad.toml"),
        USAGE,
        &["bad.toml", "line 2", "loadin"],
    );
}

#[test]
fn recordings_of_formats_that_are_not_read() {
    let folder = tempdir().unwrap();
    let hdf5 = b"\x89HDF\r\n\x1a\n\0\0\0\0";
    let cases: [(&str, &[u8], &str); 8] = [
        (
            "old.mat",
            b"MATLAB 5.0 MAT-file, Platform: GLNXA64",
            "a MATLAB file that is damaged",
        ),
        ("rf.npy", b"\x93NUMPY\x01\0", ".npy array"),
        ("rf.npz.gz", b"\x1f\x8b\x08", "gzip"),
        ("scan.dcm", &[0; 132], "not of a known format"),
        ("notes.txt", b"rf", "not of a known format"),
        ("notes.mat", b"rf", "not the MATLAB file"),
        ("notes.uff", b"rf", "not the HDF5 file"),
        ("nothing", b"", "is empty"),
    ];
    for (name, bytes, part) in cases {
        fs::write(folder.path().join(name), bytes).unwrap();
        let command = format!("beamform {name} -o lines.npz");
        fails(
            &folder,
            &command,
            DATA,
            &[name, part, "expected one of .npz"],
        );
    }
    // The name may state one format and the contents another.
    for name in ["new.mat", "scan.uff", "renamed.npz"] {
        fs::write(folder.path().join(name), hdf5).unwrap();
        let command = format!("beamform {name} -o lines.npz");
        fails(&folder, &command, DATA, &[name, "HDF5"]);
    }
    fs::create_dir(folder.path().join("folder")).unwrap();
    let command = "beamform folder -o lines.npz";
    fails(&folder, command, DATA, &["folder", "CH000.daq"]);
}

#[test]
fn images_that_cannot_be_filtered() {
    let folder = tempdir().unwrap();
    let image = |pixels: Array2<f32>| write_npy(folder.path().join("image.npy"), &pixels).unwrap();
    let command = "phase-symmetry image.npy -o ps.npy --image ps.png";
    image(Array2::zeros((100, 128)));
    fails(
        &folder,
        command,
        DATA,
        &["image.npy", "100", "powers of two", "--resize 128x128"],
    );
    for (flags, parts) in [
        (
            "--pad --wavelengths 0.002",
            ["--wavelengths", "--pixel-size"],
        ),
        (
            "--wavelengths 0.002 --pixel-size 0.0001 --resize 64x64",
            ["--resize", "--wavelengths"],
        ),
        (
            "--pad --wavelengths 0.00001 --pixel-size 0.0001",
            ["--wavelengths", "2 to 1024 pixels of 0.0001 m"],
        ),
    ] {
        fails(&folder, &format!("{command} {flags}"), USAGE, &parts);
    }
    let mut pixels = Array2::zeros((64, 64));
    pixels[(5, 7)] = f32::NAN;
    image(pixels);
    fails(
        &folder,
        command,
        DATA,
        &["image.npy", "NaN", "row 5, column 7"],
    );
    image(Array2::zeros((0, 64)));
    fails(&folder, command, DATA, &["image.npy", "empty"]);
    write_npy(
        folder.path().join("image.npy"),
        &ArrayD::<f32>::zeros(vec![64]),
    )
    .unwrap();
    fails(
        &folder,
        command,
        DATA,
        &["image.npy", "shape [64]", "[row, column]"],
    );
    write_npy(
        folder.path().join("image.npy"),
        &Array2::<i64>::zeros((64, 64)),
    )
    .unwrap();
    fails(&folder, command, DATA, &["image.npy", "dtype", "float32"]);
    fs::write(folder.path().join("image.png"), b"\x89PNG\r\n").unwrap();
    fails(
        &folder,
        "phase-symmetry image.png -o ps.npy",
        DATA,
        &["image.png", "truncated"],
    );

    image(Array2::zeros((64, 64)));
    for (flags, part) in [
        ("--resize 100x128", "64, 128, 256, 512 or 1024"),
        ("--resize 512", "ROWSxCOLUMNS"),
        ("--scales 2^3", "2^-10 to 2^-1"),
        ("--scales 2^-7,x", "2^-7"),
        ("--threshold -1", "at least 0"),
        ("--strip 0", "at least 1"),
    ] {
        let name = flags.split(' ').next().unwrap();
        fails(&folder, &format!("{command} {flags}"), USAGE, &[name, part]);
    }
    fails(
        &folder,
        "phase-symmetry image.npy -o ps.png",
        USAGE,
        &["ps.png", ".npy"],
    );
    fails(
        &folder,
        "phase-symmetry image.tif -o ps.npy",
        USAGE,
        &["image.tif", ".png or .npy"],
    );
}
