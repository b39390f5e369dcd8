//! Outputs that cannot be written: a one-line error, and nothing is left behind.

use crate::common;

use common::program::{BEAMFORM, DATA, ended, folder_with_channel_data, names, run, shell};

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
        // 64 blocks of 512 or 1024 bytes; ignoring the signal makes the write fail instead.
        let script = format!("trap '' XFSZ; ulimit -f 64; exec \"$0\" {arguments}");
        let (status, _, message) = ended(&mut shell(&folder, &script));
        assert!(message.starts_with("host-sim: "), "{message}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
        assert!(
            message.contains("big.np") && message.contains("cannot be written"),
            "{message}"
        );
        assert_eq!(status, DATA);
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
