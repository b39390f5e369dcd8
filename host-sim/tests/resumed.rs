//! A killed run over many frames resumes where it stopped.

use crate::common;

use std::fs::{self, File};
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use common::channel_data_without;
use common::program::{Folder, names, program, succeeded};
use ndarray::{Array4, Axis};
use tempfile::{TempDir, tempdir};

const FRAMES: usize = 60;
const COMMAND: &str = "beamform data.npz -o lines.npz --method mv --line-count 40 --depth-start 0.005 \
                       --depth-end 0.02 --threads 1 --json";

/// A folder with plane-wave frames, each with different numbers.
fn folder_with_frames() -> TempDir {
    let folder = tempdir().unwrap();
    write_frames(&folder, 999.0);
    folder
}

fn write_frames(folder: &TempDir, offset: f32) {
    let rf = Array4::from_shape_fn((FRAMES, 2, 4, 2000), |(frame, t, m, n)| {
        (((n + 7 * m + 3 * t) * (2 * frame + 3)) % 1999) as f32 - offset
    });
    channel_data_without(&folder.path().join("data.npz"), &["rf"])
        .with("rf", rf.into_dyn())
        .finish();
}

/// Runs the command and returns its JSON and its standard error.
fn finished(folder: &TempDir) -> (serde_json::Value, String) {
    let [json, message] = succeeded(&mut program(folder, COMMAND));
    (serde_json::from_str(&json).unwrap(), message)
}

/// Starts the command, and kills it when its lines have this number of bytes.
fn killed(folder: &TempDir, bytes: u64) {
    killed_at(folder, COMMAND, "lines.npz", bytes);
}

/// Starts a command, and kills it when what it keeps beside its output has this number of bytes.
pub fn killed_at(folder: &TempDir, command: &str, output: &str, bytes: u64) {
    let mut child = program(folder, command)
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let begin = Instant::now();
    let path = folder.path().join(format!("{output}.partial"));
    while fs::metadata(&path).map_or(0, |m| m.len()) < bytes {
        assert!(
            begin.elapsed() < Duration::from_secs(120),
            "no lines of frames"
        );
        assert!(child.try_wait().unwrap().is_none(), "it ended too early");
        sleep(Duration::from_micros(200));
    }
    // SIGKILL: the program cannot clean up.
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!folder.path().join(output).exists());
}

#[test]
fn frames_that_were_done_are_not_made_again() {
    let folder = folder_with_frames();
    let (json, message) = finished(&folder);
    assert_eq!(
        (json["resumed_frames"].as_u64(), message.as_str()),
        (Some(0), "")
    );
    let whole = folder.frames();
    assert_eq!(whole.len_of(Axis(0)), FRAMES);
    let frame = whole.len() / FRAMES * 8 + 20;
    let expected = names(folder.path());
    fs::remove_file(folder.path().join("lines.npz")).unwrap();

    // Killed twice; the second run had resumed.
    killed(&folder, 5 * frame as u64);
    killed(&folder, 15 * frame as u64);
    let (json, message) = finished(&folder);
    let resumed = json["resumed_frames"].as_u64().unwrap();
    assert!((14..FRAMES as u64).contains(&resumed), "{resumed}");
    assert_eq!(message, "");
    assert_eq!(folder.frames(), whole);
    assert_eq!(names(folder.path()), expected);
    let written = folder.text("lines.npz.config.toml");
    let (version, commit) = (env!("CARGO_PKG_VERSION"), json["commit"].as_str().unwrap());
    assert!(written.starts_with(&format!("# host-sim {version}, commit {commit}: beamform")));
    let hash = json["input_xxh128"].as_str().unwrap();
    assert!(written.contains(&format!("\n# input data.npz, xxh128 {hash}\n")));

    // Lines of another configuration, or of other samples in a file of equal length and time, are not reused.
    fs::remove_file(folder.path().join("lines.npz")).unwrap();
    killed(&folder, 5 * frame as u64);
    let other = COMMAND.replace("mv", "das");
    folder.ends(&other, 0, "belongs to another run");
    assert_ne!(folder.frames(), whole);
    fs::remove_file(folder.path().join("lines.npz")).unwrap();
    killed(&folder, 5 * frame as u64);
    let path = folder.path().join("data.npz");
    let before = fs::metadata(&path).unwrap();
    // The contents decide, neither name nor time: written again, they are the same.
    write_frames(&folder, 999.0);
    let (json, message) = finished(&folder);
    assert_eq!(message, "");
    assert!(json["resumed_frames"].as_u64() >= Some(4));
    assert_eq!(folder.frames(), whole);
    assert_eq!(names(folder.path()), expected);
    fs::remove_file(folder.path().join("lines.npz")).unwrap();
    killed(&folder, 5 * frame as u64);
    write_frames(&folder, 998.0);
    let data = File::options().append(true).open(&path).unwrap();
    data.set_modified(before.modified().unwrap()).unwrap();
    assert_eq!(fs::metadata(&path).unwrap().len(), before.len());
    let (json, message) = finished(&folder);
    assert!(message.contains("belongs to another run"), "{message}");
    assert_eq!(json["resumed_frames"].as_u64(), Some(0));
}

/// A run that fails or is stopped early leaves nothing.
#[test]
fn a_run_that_fails_leaves_no_lines() {
    let folder = folder_with_frames();
    let path = folder.path().join("data.npz");
    let mut rf = Array4::<f32>::ones((4, 2, 4, 2000));
    rf[[3, 1, 2, 700]] = f32::NAN;
    channel_data_without(&path, &["rf"])
        .with("rf", rf.into_dyn())
        .finish();
    folder.ends(COMMAND, 1, "NaN");
    assert_eq!(names(folder.path()), ["data.npz"]);
}
