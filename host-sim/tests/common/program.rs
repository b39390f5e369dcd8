//! The program, run in a folder, and its errors for bad input.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use tempfile::{TempDir, tempdir};

use super::channel_data_without;

/// The exit status of a wrong command line or configuration.
pub const USAGE: i32 = 2;
/// The exit status of wrong data.
pub const DATA: i32 = 1;

/// Runs the program in a folder.
pub fn run(folder: &TempDir, arguments: &str) -> (i32, String) {
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

/// Kills a run once it has `kept` this number of files, within five minutes.
pub fn kill_after(command: &mut Command, kept: impl Fn() -> usize, files: usize) {
    let mut child = command
        .stderr(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let begin = Instant::now();
    while kept() < files {
        assert!(begin.elapsed() < Duration::from_secs(300), "nothing kept");
        assert!(child.try_wait().unwrap().is_none(), "it ended too early");
        sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
}

/// Asserts that a page loads only its own style and pictures.
pub fn loads_nothing(page: &str) {
    let head = &page[..page.find("</head>").unwrap()];
    assert!(head.contains("http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "));
    assert!(!page.contains("<script") && !page.contains("href=\"http"));
}

/// The names of the files in a folder, in order.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// A folder with valid channel data in `data.npz`.
pub fn folder_with_channel_data() -> TempDir {
    let folder = tempdir().unwrap();
    channel_data_without(&folder.path().join("data.npz"), &[]).finish();
    folder
}

/// Arguments that make lines and a picture from `data.npz`.
pub const BEAMFORM: &str = "beamform data.npz -o lines.npz --image lines.png";
