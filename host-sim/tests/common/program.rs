//! The program, run in a folder, and its errors for bad input.

use std::fs::{self, File};

use bonebeam_files::{BeamformedLines, ChannelData};
use ndarray::{Array2, ArrayD};
use ndarray_npy::NpzReader;
use num_complex::Complex;
use tempfile::{TempDir, tempdir};

use super::channel_data_without;
pub use super::pages::loads_nothing;
pub use super::runs::*;

/// A folder in which the program runs, and the files that it leaves there.
pub trait Folder {
    /// Runs the program, which must succeed.
    fn works(&self, arguments: &str);
    /// Runs the program, which must end with this status and these words; returns its message.
    fn ends(&self, arguments: &str, status: i32, words: &str) -> String;
    fn write(&self, name: &str, contents: impl AsRef<[u8]>);
    fn bytes(&self, name: &str) -> Vec<u8>;
    fn text(&self, name: &str) -> String;
    fn lines(&self, name: &str) -> BeamformedLines;
    fn image(&self, name: &str) -> Array2<f32>;
    /// All frames of the lines in `lines.npz`.
    fn frames(&self) -> ArrayD<Complex<f32>>;
}

impl Folder for TempDir {
    fn works(&self, arguments: &str) {
        succeeded(&mut program(self, arguments));
    }

    fn ends(&self, arguments: &str, status: i32, words: &str) -> String {
        let (ended, message) = run(self, arguments);
        assert_eq!(ended, status, "{arguments}: {message}");
        assert!(message.contains(words), "{arguments}: {message}");
        message
    }

    fn write(&self, name: &str, contents: impl AsRef<[u8]>) {
        fs::write(self.path().join(name), contents).unwrap();
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

    fn frames(&self) -> ArrayD<Complex<f32>> {
        let file = File::open(self.path().join("lines.npz")).unwrap();
        NpzReader::new(file).unwrap().by_name("z").unwrap()
    }
}

/// A folder with a recording in `data.npz`.
pub fn folder_with(data: &ChannelData) -> TempDir {
    let folder = tempdir().unwrap();
    data.write(&folder.path().join("data.npz")).unwrap();
    folder
}

/// A folder with valid channel data in `data.npz`.
pub fn folder_with_channel_data() -> TempDir {
    let folder = tempdir().unwrap();
    channel_data_without(&folder.path().join("data.npz"), &[]).finish();
    folder
}

/// Arguments that make lines and a picture from `data.npz`.
pub const BEAMFORM: &str = "beamform data.npz -o lines.npz --image lines.png";
