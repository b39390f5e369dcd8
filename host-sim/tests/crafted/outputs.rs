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

#[cfg(unix)]
#[test]
fn a_signal_leaves_the_outputs_whole_or_none() {
    let whole = [
        "data.npz",
        "lines.npz",
        "lines.npz.config.toml",
        "lines.png",
    ];
    let mut interrupted = 0;
    for (number, signal, status) in [("2", "INT", 130), ("15", "TERM", 143)] {
        for step in 0..12 {
            let folder = tempdir().unwrap();
            channel_data_without(&folder.path().join("data.npz"), &[]).finish();
            // The size makes the program run for longer than the time between the signals.
            let size = "--rows 2048 --columns 2048";
            let mut child = program(&folder, &format!("{BEAMFORM} --image lines.png {size}"))
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .unwrap();
            std::thread::sleep(Duration::from_millis(12 * step));
            let sent = Command::new("kill")
                .args([format!("-{number}"), child.id().to_string()])
                .stderr(Stdio::null())
                .status()
                .unwrap();
            let ended = child.wait().unwrap();
            let found = names(folder.path());
            match ended.code() {
                Some(0) => assert_eq!(found, whole),
                // Before the program catches the signal, the system ends it, and no file exists.
                None => assert_eq!(found, ["data.npz"], "{signal}"),
                Some(code) => {
                    interrupted += 1;
                    assert!(sent.success());
                    assert_eq!(code, status, "SIG{signal}");
                    assert!(found == ["data.npz"] || found == whole, "{found:?}");
                }
            }
        }
    }
    assert!(interrupted > 0, "no signal came while the program ran");
}
