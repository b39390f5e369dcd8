//! Outputs that cannot be written: a one-line error, and nothing is left behind.

use crate::common;

use std::fs;
use std::process::Command;

use common::program::{DATA, USAGE, fails, folder_with_channel_data, names, run};
use ndarray::Array2;
use ndarray_npy::write_npy;
use tempfile::tempdir;

#[test]
fn outputs_that_cannot_be_written_are_reported_before_anything_is_read() {
    let folder = tempdir().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    fs::create_dir(folder.path().join("folder")).unwrap();
    // data.npz and image.npy do not exist: the error names the output first.
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
