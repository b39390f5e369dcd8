//! The program, run in a folder, and its errors for bad input.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::SystemTime;

use bonebeam_files::BeamformedLines;
use ndarray::{Array2, ArrayD};
use ndarray_npy::NpzReader;
use num_complex::Complex;
use tempfile::{TempDir, tempdir};

use super::channel_data_without;
pub use super::pages::loads_nothing;

/// The exit status of a wrong command line or configuration.
pub const USAGE: i32 = 2;
/// The exit status of wrong data.
pub const DATA: i32 = 1;

/// The program in a folder, with these arguments.
pub fn program(folder: impl AsRef<Path>, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
    command.args(arguments.split(' ')).current_dir(folder);
    command
}

/// The program in a folder, by a line of the shell; `$0` is its name.
pub fn shell(folder: impl AsRef<Path>, script: &str) -> Command {
    let mut command = Command::new("sh");
    command
        .args(["-c", script, env!("CARGO_BIN_EXE_host-sim")])
        .current_dir(folder)
        .env_remove("RUST_BACKTRACE")
        .stdin(Stdio::null());
    command
}

/// Exit status, standard output and standard error of a command.
pub fn ended(command: &mut Command) -> (i32, String, String) {
    let output = command.output().unwrap();
    let [out, err] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    (output.status.code().expect("ended by a signal"), out, err)
}

/// Standard output and standard error of a command, which must succeed.
pub fn succeeded(command: &mut Command) -> [String; 2] {
    let (status, out, err) = ended(command);
    assert_eq!(status, 0, "{command:?}: {err}");
    [out, err]
}

/// Runs the program in a folder; returns its status and its standard error.
pub fn run(folder: &TempDir, arguments: &str) -> (i32, String) {
    let (status, _, message) = ended(&mut program(folder, arguments));
    (status, message)
}

/// Runs the program in at most 4 GB of memory; it must be refused in one line with all of `words`.
pub fn refused(folder: &TempDir, arguments: &str, status: i32, words: &[&str]) {
    judged(folder, arguments, status, 1, words);
}

/// Runs the program in at most 4 GB of memory, and compares its status, its lines, and its words.
///
/// With status 0, the lines are warnings. The folder has the same files after.
pub fn judged(
    folder: &TempDir,
    arguments: &str,
    status: i32,
    lines: usize,
    words: &[impl AsRef<str>],
) {
    let before = files(folder.path());
    let script = format!("ulimit -v 4000000; exec timeout 60 \"$0\" {arguments}");
    let (ended, _, message) = ended(&mut shell(folder, &script));
    assert_eq!(ended, status, "{arguments}: {message}");
    let start = match status {
        0 => "host-sim: warning: ",
        _ => "host-sim: ",
    };
    let lines = if words.is_empty() { 0 } else { lines };
    assert_eq!(message.lines().count(), lines, "{arguments}: {message}");
    assert!(
        message.lines().all(|line| line.starts_with(start)),
        "{arguments}: {message}"
    );
    assert!(message.len() < 5000, "{arguments}: {} bytes", message.len());
    for word in words.iter().map(AsRef::as_ref) {
        assert!(
            message.contains(word),
            "{arguments}: `{word}` is not in: {message}"
        );
    }
    let mut left = files(folder.path());
    if status == 0 {
        for (name, _) in left.extract_if(.., |file| !before.contains(file)) {
            fs::remove_file(folder.path().join(name)).unwrap();
        }
    }
    assert_eq!(left, before, "{arguments}: outputs were left");
}

/// The files in a folder, and when each was written.
fn files(folder: &Path) -> Vec<(String, Option<SystemTime>)> {
    let written = |name: &str| {
        let file = folder.join(name).symlink_metadata().unwrap();
        file.modified().ok()
    };
    let all = names(folder).into_iter();
    all.map(|name| (name.clone(), written(&name))).collect()
}

/// A folder in which the program runs, and the files that it leaves there.
pub trait Folder {
    /// Runs the program, which must succeed.
    fn works(&self, arguments: &str);
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
