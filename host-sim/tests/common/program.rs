//! The program, run in a folder, and its errors for bad input.

use std::fs;
use std::path::Path;
use std::process::Command;

use bonebeam_files::BeamformedLines;
use ndarray::Array2;
use tempfile::{TempDir, tempdir};

use super::channel_data_without;
pub use super::pages::loads_nothing;

/// The exit status of a wrong command line or configuration.
pub const USAGE: i32 = 2;
/// The exit status of wrong data.
pub const DATA: i32 = 1;

/// Runs the program in a folder. What a killed run left beside its output is removed.
pub fn run(folder: &TempDir, arguments: &str) -> (i32, String) {
    let left = folder.path().join(".host-sim-1-7");
    let output = arguments.split_once(" -o ").map(|(_, after)| after);
    let beside = output.is_some_and(|after| !after.split(' ').next().unwrap_or("/").contains('/'));
    if beside {
        fs::write(&left, "left").unwrap();
    }
    let output = Command::new(env!("CARGO_BIN_EXE_host-sim"))
        .args(arguments.split(' '))
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(
        !(output.status.success() && left.exists()),
        "{arguments}: a file of a killed run stays"
    );
    let _ = fs::remove_file(&left);
    (
        output.status.code().expect("ended by a signal"),
        String::from_utf8(output.stderr).unwrap(),
    )
}

/// A folder in which the program runs, and the files that it leaves there.
pub trait Folder {
    /// Runs the program, which must succeed.
    fn works(&self, arguments: &str);
    fn bytes(&self, name: &str) -> Vec<u8>;
    fn text(&self, name: &str) -> String;
    fn lines(&self, name: &str) -> BeamformedLines;
    fn image(&self, name: &str) -> Array2<f32>;
}

impl Folder for TempDir {
    fn works(&self, arguments: &str) {
        let (status, message) = run(self, arguments);
        assert_eq!(status, 0, "{arguments}: {message}");
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path().join(name)).unwrap()
    }

    fn text(&self, name: &str) -> String {
        fs::read_to_string(self.path().join(name)).unwrap()
    }

    fn lines(&self, name: &str) -> BeamformedLines {
        BeamformedLines::read(&self.path().join(name)).unwrap()
    }

    fn image(&self, name: &str) -> Array2<f32> {
        bonebeam_files::image::read(&self.path().join(name)).unwrap()
    }
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
