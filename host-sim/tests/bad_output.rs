//! Outputs that cannot be written: a one-line error, and nothing is left behind.

use crate::common;

use std::process::Command;

use common::program::{BEAMFORM, DATA, folder_with_channel_data, names, run};

/// The shell's limit on the size of a file stands in for a full disk.
#[cfg(unix)]
#[test]
fn an_output_that_does_not_fit_leaves_nothing() {
    let folder = folder_with_channel_data();
    let made = run(&folder, "beamform data.npz -o lines.npz --line-count 1000");
    assert_eq!(made, (0, String::new()));
    let before = names(folder.path());
    for arguments in [
        "simulate point --beams 3 -o big.npz",
        "beamform data.npz -o other.npz --image big.npy",
        "convert lines.npz -o big.npz",
        "convert lines.npz -o big.hdf5",
        "convert lines.npz -o big.uff",
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
        for part in ["big.", "cannot be written", "File too large"] {
            assert!(message.contains(part), "{message}");
        }
        assert_eq!(output.status.code(), Some(DATA));
        assert_eq!(names(folder.path()), before);
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
