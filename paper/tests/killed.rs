//! Runs that are killed.

use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

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
