//! Runs of a program, [`PROGRAM`](crate::PROGRAM), and its errors for bad input.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::SystemTime;

use tempfile::TempDir;

/// The exit status of a wrong command line or configuration.
pub const USAGE: i32 = 2;
/// The exit status of wrong data.
pub const DATA: i32 = 1;

/// The program in a folder, with these arguments.
pub fn program(folder: impl AsRef<Path>, arguments: &str) -> Command {
    let mut command = Command::new(crate::PROGRAM);
    command.args(arguments.split(' ')).current_dir(folder);
    command
}

/// The program in a folder, by a line of the shell; `$0` is its name.
pub fn shell(folder: impl AsRef<Path>, script: &str) -> Command {
    let mut command = Command::new("sh");
    command
        .args(["-c", script, crate::PROGRAM])
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
///
/// What a killed run left beside its output is removed.
pub fn run(folder: &TempDir, arguments: &str) -> (i32, String) {
    let left = folder.path().join(".host-sim-1-7");
    let output = arguments.split_once(" -o ").map(|(_, after)| after);
    let beside = output.is_some_and(|after| !after.split(' ').next().unwrap_or("/").contains('/'));
    if beside {
        fs::write(&left, "left").unwrap();
    }
    let (status, _, message) = ended(&mut program(folder, arguments));
    assert!(
        !(status == 0 && left.exists()),
        "{arguments}: a file of a killed run stays"
    );
    let _ = fs::remove_file(&left);
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

/// The names of the files in a folder, in order.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}
