//! The program, run in a folder, and its errors for bad input.

use std::fs;
use std::path::Path;
use std::process::Command;

use tempfile::{TempDir, tempdir};

use super::channel_data_without;
pub use super::pages::loads_nothing;

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
