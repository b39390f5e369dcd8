//! Signals, full disks, read-only or removed folders, other runs, a changing input.
//!
//! After each fault the folder has either the old outputs or the new ones, all of them complete, and nothing else.
//! The exit status says which.

#![cfg(unix)]

use crate::common;

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use common::channel_data_without;
use common::program::{DATA, program, shell};
use ndarray::Array3;
use tempfile::{TempDir, tempdir};

/// The outputs of a run, in order.
const OUTPUTS: [&str; 3] = ["image.npy", "lines.npz", "lines.npz.config.toml"];
/// Number of moments of a run at which a fault is tried.
const MOMENTS: u32 = 24;

type Files = Vec<(String, Vec<u8>)>;

/// The files of a folder except the recording, in order.
fn files(folder: &Path) -> Files {
    let mut files: Files = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap())
        .map(|entry| {
            let name = entry.file_name().into_string().unwrap();
            (name, fs::read(entry.path()).unwrap())
        })
        .filter(|(name, _)| name != "data.npz")
        .collect();
    files.sort();
    files
}

/// A run that writes four megabytes, so that writing takes time.
fn command(method: &str) -> String {
    format!(
        "beamform data.npz -o lines.npz --method {method} --image image.npy --rows 1000 --columns 1000"
    )
}

fn start(folder: &Path, method: &str) -> Child {
    program(folder, &command(method))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn finish(child: Child) -> Output {
    child.wait_with_output().unwrap()
}

/// A folder with a recording, old outputs (`das`), and the next run's (`mv`).
///
/// Also holds the duration of the next run.
struct Runs {
    folder: TempDir,
    old: Files,
    new: Files,
    takes: Duration,
}

impl Runs {
    fn new() -> Self {
        let folder = tempdir().unwrap();
        channel_data_without(&folder.path().join("data.npz"), &[]).finish();
        assert!(finish(start(folder.path(), "das")).status.success());
        let old = files(folder.path());
        let begin = Instant::now();
        assert!(finish(start(folder.path(), "mv")).status.success());
        let takes = begin.elapsed();
        let new = files(folder.path());
        let names: Vec<&str> = new.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, OUTPUTS);
        assert!(old.iter().zip(&new).all(|(old, new)| old != new));
        let runs = Runs {
            folder,
            old,
            new,
            takes,
        };
        runs.reset();
        runs
    }

    /// Of a folder without earlier outputs.
    fn fresh() -> Self {
        Runs {
            old: Files::new(),
            ..Runs::new()
        }
    }

    fn path(&self) -> &Path {
        self.folder.path()
    }

    /// The folder after the earlier run.
    fn reset(&self) {
        for (name, _) in files(self.path()) {
            fs::remove_file(self.path().join(name)).unwrap();
        }
        for (name, bytes) in &self.old {
            fs::write(self.path().join(name), bytes).unwrap();
        }
    }

    /// Asserts status 0 and the new outputs, or an error and the old ones.
    ///
    /// An error has one line and another status. Returns whether the run succeeded.
    fn check(&self, output: &Output, found: &Files, failures: &[i32], what: &str) -> bool {
        let message = String::from_utf8_lossy(&output.stderr);
        let code = output.status.code();
        let reported: Vec<(&str, usize)> =
            found.iter().map(|(n, b)| (n.as_str(), b.len())).collect();
        if code == Some(0) {
            assert!(
                *found == self.new,
                "{what}: not the new outputs: {reported:?}"
            );
            return true;
        }
        assert!(
            code.is_none_or(|code| failures.contains(&code)),
            "{what}: {code:?}: {message}"
        );
        assert!(
            *found == self.old,
            "{what}: not the old outputs: {reported:?}: {message}"
        );
        if code == Some(DATA) {
            assert!(message.starts_with("host-sim: "), "{what}: {message}");
            assert_eq!(message.lines().count(), 1, "{what}: {message}");
        }
        false
    }
}

#[test]
fn a_signal_at_any_moment() {
    let (over, fresh) = (Runs::new(), Runs::fresh());
    for (runs, signal, status) in [
        (&over, "INT", 130),
        (&over, "TERM", 143),
        (&fresh, "INT", 130),
        (&fresh, "TERM", 143),
    ] {
        let mut caught = 0;
        for moment in 0..MOMENTS {
            runs.reset();
            let child = start(runs.path(), "mv");
            sleep(runs.takes * moment / MOMENTS);
            Command::new("kill")
                .args(["-s", signal, &child.id().to_string()])
                .stderr(Stdio::null())
                .status()
                .unwrap();
            let output = finish(child);
            let what = format!("SIG{signal} at moment {moment}");
            let found = files(runs.path());
            // A signal that comes when the outputs are in place ends a run that is done.
            if output.status.code() == Some(status) && found == runs.new {
                continue;
            }
            runs.check(&output, &found, &[status], &what);
            caught += usize::from(output.status.code() == Some(status));
        }
        assert!(caught > 0, "no SIG{signal} came while the program ran");
    }
}

/// The shell's limit on file size makes a write fail anywhere, on every system.
#[test]
fn a_file_that_grows_no_further() {
    let runs = Runs::new();
    let mut succeeded = 0;
    // The image has 7813 blocks of 512 bytes and the lines have a few.
    for blocks in [0, 1, 2, 3, 5, 8, 100, 1000, 7000, 7812, 20_000] {
        runs.reset();
        let run = command("mv");
        let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" {run}");
        let output = shell(runs.path(), &script).output().unwrap();
        let found = files(runs.path());
        let what = format!("{blocks} blocks");
        succeeded += usize::from(runs.check(&output, &found, &[DATA], &what));
    }
    assert!((1..11).contains(&succeeded), "{succeeded}");
}

/// Whether a file system may be mounted here: as root, or in a user namespace.
fn namespace() -> Option<&'static [&'static str]> {
    const WAYS: [&[&str]; 2] = [&["-m"], &["-rm"]];
    WAYS.into_iter().find(|way| {
        let mount = "mount -t tmpfs -o size=64k tmpfs /mnt";
        let status = Command::new("unshare")
            .args(*way)
            .args(["sh", "-c", mount])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status();
        status.is_ok_and(|status| status.success())
    })
}

/// Runs over the old outputs on a new file system with these `options`.
///
/// Its files are copied out.
fn on_a_small_disk(runs: &Runs, way: &[&str], kilobytes: usize, then: &str) -> (Output, Files) {
    let out = tempdir().unwrap();
    let script = format!(
        "mount -t tmpfs -o size={kilobytes}k tmpfs /mnt && cp -a \"$FROM/.\" /mnt && cd /mnt || exit 99
         {then}
         \"$PROGRAM\" {}
         status=$?
         cp -a /mnt/. \"$TO\" || exit 98
         exit $status",
        command("mv")
    );
    let output = Command::new("unshare")
        .args(way)
        .args(["sh", "-c", &script])
        .env("FROM", runs.path())
        .env("TO", out.path())
        .env("PROGRAM", env!("CARGO_BIN_EXE_host-sim"))
        .output()
        .unwrap();
    (output, files(out.path()))
}

#[test]
fn a_disk_that_is_full_at_any_moment() {
    let Some(way) = namespace() else {
        println!("skipped: no file system can be mounted here");
        return;
    };
    let runs = Runs::new();
    let pages = |bytes: usize| bytes.div_ceil(4096) * 4;
    let size = |files: &Files| {
        files
            .iter()
            .map(|(_, bytes)| pages(bytes.len()))
            .sum::<usize>()
    };
    let recording = fs::metadata(runs.path().join("data.npz")).unwrap().len();
    let taken = pages(usize::try_from(recording).unwrap()) + size(&runs.old);
    let mut succeeded = 0;
    // Free space: one page after another for the first files, then for the image, up to more than enough.
    let room: Vec<usize> = (0..12)
        .map(|page| 4 * page)
        .chain([100, 1000, 3000, 3900, 8000])
        .collect();
    for kilobytes in &room {
        let (output, found) = on_a_small_disk(&runs, way, taken + kilobytes, "");
        let what = format!("{kilobytes} kB are left");
        succeeded += usize::from(runs.check(&output, &found, &[DATA], &what));
    }
    assert!(
        (1..room.len()).contains(&succeeded),
        "{succeeded} of {}",
        room.len()
    );
}

#[test]
fn a_folder_that_cannot_be_written() {
    let runs = Runs::new();
    if let Some(way) = namespace() {
        let (output, found) = on_a_small_disk(&runs, way, 100_000, "mount -o remount,ro /mnt");
        assert!(!runs.check(&output, &found, &[DATA], "a disk that is read only"));
    } else {
        println!("skipped: no file system can be mounted here");
    }
    // Root may write to any folder.
    let set = |mode: &str| {
        Command::new("chmod")
            .arg(mode)
            .arg(runs.path())
            .status()
            .unwrap()
    };
    set("555");
    if fs::write(runs.path().join("probe"), "").is_ok() {
        fs::remove_file(runs.path().join("probe")).unwrap();
        println!("skipped: this user may write to any folder");
    } else {
        let output = finish(start(runs.path(), "mv"));
        assert!(!runs.check(
            &output,
            &files(runs.path()),
            &[DATA],
            "a folder that is read only"
        ));
    }
    set("755");
}

#[test]
fn a_folder_that_goes_away() {
    let runs = Runs::new();
    let arguments = "beamform data.npz -o gone/lines.npz --method mv --image gone/image.npy --rows 1000 --columns 1000";
    let mut failed = 0;
    for moment in 0..MOMENTS {
        let gone = runs.path().join("gone");
        fs::create_dir_all(&gone).unwrap();
        let child = program(runs.path(), arguments)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        sleep(runs.takes * moment / MOMENTS);
        // A file that appears while the folder is emptied keeps the folder.
        while gone.exists() && fs::remove_dir_all(&gone).is_err() {}
        let output = finish(child);
        let message = String::from_utf8_lossy(&output.stderr);
        match output.status.code() {
            Some(0) => assert_eq!(message, ""),
            Some(DATA) => {
                failed += 1;
                assert!(message.starts_with("host-sim: gone/"), "{message}");
                assert_eq!(message.lines().count(), 1, "{message}");
            }
            other => panic!("moment {moment}: {other:?}: {message}"),
        }
        assert!(!gone.exists(), "moment {moment}: the folder came back");
    }
    assert!(failed > 0, "the folder never went away in time");
}

#[test]
fn two_runs_onto_one_name() {
    let runs = Runs::new();
    for turn in 0..MOMENTS {
        runs.reset();
        let (first, second) = (start(runs.path(), "das"), start(runs.path(), "mv"));
        for output in [finish(first), finish(second)] {
            assert!(
                output.status.success(),
                "{}",
                String::from_utf8_lossy(&output.stderr)
            );
        }
        let found = files(runs.path());
        assert!(
            found == runs.old || found == runs.new,
            "turn {turn}: a mixture of both"
        );
    }
}

#[test]
fn an_input_that_changes_while_it_is_read() {
    let runs = Runs::new();
    let input = runs.path().join("data.npz");
    let first = fs::read(&input).unwrap();
    let rf = Array3::from_shape_fn((2, 4, 64), |(t, m, n)| (n * 1000 + m * 100 + t) as f32);
    channel_data_without(&input, &["rf"])
        .with("rf", rf.into_dyn())
        .finish();
    let second = fs::read(&input).unwrap();
    runs.reset();
    assert!(finish(start(runs.path(), "mv")).status.success());
    let of_second = files(runs.path());
    assert_ne!(of_second, runs.new);
    let mut refused = 0;
    for moment in 0..MOMENTS {
        runs.reset();
        fs::write(&input, &first).unwrap();
        let child = start(runs.path(), "mv");
        // Repeatedly, in place: the file is empty, truncated or mixed in between.
        let begin = Instant::now();
        while begin.elapsed() < runs.takes * moment / MOMENTS {
            fs::write(&input, &second).unwrap();
            fs::write(&input, &first).unwrap();
        }
        let output = finish(child);
        let found = files(runs.path());
        if output.status.success() && found == of_second {
            continue;
        }
        let whole = runs.check(&output, &found, &[DATA], &format!("moment {moment}"));
        refused += usize::from(!whole);
    }
    println!("{refused} of {MOMENTS} runs refused what they read");
}
