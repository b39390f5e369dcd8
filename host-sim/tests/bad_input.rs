//! Bad input to the program: one line that names the thing, the right exit status, and no output
//! left behind.

mod common;

use std::fs;
use std::path::Path;
use std::process::Command;

use common::{Npz, channel_data_without, ramp, scalar, vector};
use ndarray::{Array2, Array3, ArrayD};
use ndarray_npy::write_npy;
use num_complex::Complex;
use tempfile::{TempDir, tempdir};

/// The exit status of a wrong command line or configuration.
const USAGE: i32 = 2;
/// The exit status of wrong data.
const DATA: i32 = 1;

/// Runs the program in a folder of its own.
fn run(folder: &TempDir, arguments: &str) -> (i32, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_host-sim"))
        .args(arguments.split(' '))
        .current_dir(folder.path())
        .output()
        .unwrap();
    (
        output.status.code().expect("ended by a signal"),
        String::from_utf8(output.stderr).unwrap(),
    )
}

/// The names of the files in a folder, in order.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// Runs the program and asserts how it fails: the status, one line on the standard error that
/// holds all of `parts`, and nothing new in the folder.
fn fails(folder: &TempDir, arguments: &str, status: i32, parts: &[&str]) {
    let before = names(folder.path());
    let (code, message) = run(folder, arguments);
    assert!(message.starts_with("host-sim: "), "{arguments}: {message}");
    assert_eq!(
        message.trim_end().lines().count(),
        1,
        "{arguments}: {message}"
    );
    for part in parts {
        assert!(
            message.contains(part),
            "{arguments}: `{part}` is not in: {message}"
        );
    }
    assert_eq!(code, status, "{arguments}: {message}");
    assert_eq!(
        names(folder.path()),
        before,
        "{arguments}: outputs were left"
    );
}

/// A folder with valid channel data in `data.npz`.
fn folder_with_channel_data() -> TempDir {
    let folder = tempdir().unwrap();
    channel_data_without(&folder.path().join("data.npz"), &[]).finish();
    folder
}

const BEAMFORM: &str = "beamform data.npz -o lines.npz --image lines.png";

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
        // L > M.
        (
            "--subaperture-ratio 1.1",
            &["--subaperture-ratio", "1.1", "at most 1"],
        ),
        // K beyond the record.
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
        .with("rf", ramp().mapv(|v| v as u16).into_dyn())
        .finish();
    fails(
        &folder,
        BEAMFORM,
        DATA,
        &[
            "data.npz",
            "`rf` has dtype",
            "float32, float64, int16, int32 or uint8",
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
    fails(&folder, BEAMFORM, DATA, &["data.npz", "leaves no depth"]);
    for beams in [[1e-3, -1e-3], [1e-3, 1e-3]] {
        channel_data_without(&path, &["tx_angle"])
            .with("tx_x", vector(&beams))
            .with("tx_focus", scalar(15e-3))
            .finish();
        fails(&folder, BEAMFORM, DATA, &["data.npz", "from left to right"]);
    }
    let (code, message) = run(&folder, "beamform data.npz -o lines.npz");
    assert_eq!((code, message.as_str()), (0, ""));

    write_npy(folder.path().join("dot.npy"), &Array2::<f32>::zeros((1, 1))).unwrap();
    let resize = "phase-symmetry dot.npy --resize 64x64 -o ps.npy";
    fails(&folder, resize, DATA, &["dot.npy", "1x1", "at least 2"]);
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
        fails(&folder, &command, DATA, &[name, part, "expected an .npz"]);
    }
    // The name may say one thing and the file another.
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
        ("vertebra --f-number 0", USAGE, &["f_number", "positive"]),
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
fn outputs_that_cannot_be_written_are_told_before_anything_is_read() {
    let folder = tempdir().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    fs::create_dir(folder.path().join("folder")).unwrap();
    // There is no data.npz and no image.npy: what is told first is the output.
    for (output, part) in [
        ("none/out.npy", "does not exist"),
        ("file/out.npy", "is not a folder"),
        ("folder", "is not a file"),
    ] {
        let lines = format!("beamform data.npz -o {output}");
        fails(&folder, &lines, DATA, &[output, part]);
        if output != "folder" {
            let map = format!("phase-symmetry image.npy -o {output}");
            fails(&folder, &map, DATA, &[output, part]);
        }
    }
    fails(
        &folder,
        "beamform data.npz -o lines.npz --image none/lines.png",
        DATA,
        &["none/lines.png", "does not exist"],
    );
    #[cfg(target_os = "linux")]
    fails(
        &folder,
        "beamform data.npz -o /proc/lines.npz",
        DATA,
        &["/proc", "cannot be written"],
    );
}

/// The shell's limit on the size of a file stands in for a full disk.
#[cfg(unix)]
#[test]
fn an_output_that_does_not_fit_leaves_nothing() {
    let folder = folder_with_channel_data();
    let before = names(folder.path());
    for arguments in [
        "simulate point --beams 3 -o big.npz",
        "beamform data.npz -o lines.npz --image big.npy",
    ] {
        let program = env!("CARGO_BIN_EXE_host-sim");
        // 64 blocks of 512 or 1024 bytes; ignoring the signal makes the write fail instead.
        let script = format!("trap '' XFSZ; ulimit -f 64; exec '{program}' {arguments}");
        let output = Command::new("sh")
            .args(["-c", &script])
            .current_dir(folder.path())
            .output()
            .unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.starts_with("host-sim: "), "{message}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
        assert!(
            message.contains("big.np") && message.contains("cannot be written"),
            "{message}"
        );
        assert_eq!(output.status.code(), Some(DATA));
        assert_eq!(names(folder.path()), before);
    }
}

#[test]
fn an_output_does_not_take_the_place_of_an_input() {
    let folder = folder_with_channel_data();
    let before = fs::read(folder.path().join("data.npz")).unwrap();
    fs::create_dir(folder.path().join("sub")).unwrap();
    for output in ["data.npz", "sub/../data.npz"] {
        let arguments = format!("beamform data.npz -o {output}");
        fails(&folder, &arguments, USAGE, &["would overwrite data.npz"]);
    }
    let twice = "beamform data.npz -o lines.npz --image sub/../lines.npz.config.toml.png";
    assert_eq!(run(&folder, twice).0, 0);
    write_npy(
        folder.path().join("image.npy"),
        &Array2::<f32>::zeros((64, 64)),
    )
    .unwrap();
    let onto_itself = "phase-symmetry image.npy -o image.npy";
    fails(&folder, onto_itself, USAGE, &["would overwrite image.npy"]);
    let one_for_two = "phase-symmetry image.npy -o ps.npy --image ps.npy";
    fails(&folder, one_for_two, USAGE, &["would overwrite ps.npy"]);
    assert_eq!(fs::read(folder.path().join("data.npz")).unwrap(), before);
}

#[test]
fn numbers_beyond_all_use() {
    let folder = folder_with_channel_data();
    let threads = "beamform data.npz -o lines.npz --threads 100000";
    fails(&folder, threads, USAGE, &["--threads is 100000", "256"]);
    let threshold = "phase-symmetry image.npy -o ps.npy --threshold 1e39";
    fails(&folder, threshold, USAGE, &["--threshold", "1e12"]);
}

/// Every numeric flag with numbers that no machine or medium has. The parameter is named; where the
/// number does no harm, as a β of 1e-300 does none to a threshold, the run may also succeed.
#[test]
fn absurd_numbers_are_told_by_their_parameter() {
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
    // What is harmless though absurd: so little of something that it is none.
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

/// What is wrong with data that are valid in themselves, but of another unit or order.
#[test]
fn values_in_another_unit_and_swapped_axes() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("data.npz");
    let pitches = |pitch: f64| vector(&[-1.5, -0.5, 0.5, 1.5].map(|m| m * pitch));
    let cases: [(&str, ArrayD<f64>, &[&str]); 15] = [
        (
            "element_x",
            pitches(0.3),
            &["`element_x`", "0.3 m", "in mm"],
        ),
        ("element_x", pitches(300.0), &["300 m", "in µm"]),
        ("element_x", pitches(-3e-4), &["does not ascend"]),
        ("element_x", pitches(0.0), &["does not ascend"]),
        ("c", scalar(1.54), &["`c` is 1.54 m/s", "in km/s"]),
        ("c", scalar(154_000.0), &["`c` is 154000 m/s", "in cm/s"]),
        ("c", scalar(-1540.0), &["`c` is -1540"]),
        ("fs", scalar(40.0), &["`fs` is 40 Hz", "in MHz"]),
        ("fs", scalar(0.0), &["`fs` is 0"]),
        ("f0", scalar(5.0), &["`f0` is 5 Hz", "in MHz"]),
        ("f0", scalar(-5e6), &["`f0` is -5000000"]),
        // As of a record at 4/3 of f0.
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

/// What may be meant is told, and the run goes on.
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
    // The record is that of 0.77 to 2.75 mm, and of the whole of it no word is said.
    warned(
        "--depth-end 0.003",
        &["0.003 m", "the record holds 0.000770 m to"],
    );
    warned("--depth-start 0.0005", &["0.0005 m", "the record holds"]);
    let far = [("start", "0.01"), ("end", "0.0005"), ("end", "0.04")];
    for (flag, depth) in far {
        let arguments = format!("{BEAMFORM} --depth-{flag} {depth}");
        let told = format!("--depth-{flag} is {depth} m");
        fails(&folder, &arguments, USAGE, &[&told, "the record holds"]);
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
}
