//! Output names, streams and signals that make a write fail.

use super::*;

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_an_error_and_a_closed_one_is_not() {
    let folder = folder_with_channel_data();
    let full = || fs::File::create("/dev/full").unwrap();
    for arguments in ["--help", "info data.npz"] {
        let (status, _, message) = ended(program(&folder, arguments).stdout(full()));
        assert_eq!(status, DATA, "{message}");
        assert!(message.contains("standard output"), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
        let mut child = program(&folder, arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), message.as_str()), (Some(0), ""));
    }
    // No message can be written, but the status shows the failure.
    let status = program(&folder, "beamform missing.npz -o lines.npz")
        .stdout(full())
        .stderr(full())
        .status()
        .unwrap();
    assert_eq!(status.code(), Some(DATA));
}
