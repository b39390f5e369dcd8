//! Commands that another program runs.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use tempfile::tempdir;

/// Runs a copy of the program alone in a folder, with nothing else on the path.
fn run(folder: &Path, arguments: &[&str]) -> Output {
    let program = folder.join("host-sim");
    if !program.exists() {
        fs::copy(env!("CARGO_BIN_EXE_host-sim"), &program).unwrap();
    }
    let mut command = Command::new(program);
    command.args(arguments).env("PATH", "/bin:/usr/bin");
    command.output().unwrap()
}

#[test]
fn without_the_program_one_line_says_how_it_is_built() {
    let folder = tempdir().unwrap();
    for arguments in [
        &["paper", "--quick"][..],
        &["tune", "--help"],
        &["paper"],
        &["verify"],
        &["golden", "-o", "x"],
        &["--quick", "--references"],
    ] {
        let output = run(folder.path(), arguments);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
        let built = "bonebeam-paper, which is not here; build it in the folder paper";
        assert!(message.contains(built), "{message}");
    }
    let output = run(folder.path(), &["view", "-o", "page.html"]);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(
        message.contains("page.html, which is not here; build it by page/build"),
        "{message}"
    );
}

#[cfg(unix)]
#[test]
fn the_program_beside_receives_every_argument_and_gives_the_status() {
    use std::os::unix::fs::PermissionsExt;

    let folder = tempdir().unwrap();
    let program = folder.path().join("bonebeam-paper");
    fs::write(&program, "#!/bin/sh\nprintf '%s|' \"$@\"\nexit 7\n").unwrap();
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    for (arguments, received) in [
        (&["paper"][..], "paper|"),
        (&["paper", "--help"], "paper|--help|"),
        (&["tune", "-o", "a b", "--quick"], "tune|-o|a b|--quick|"),
        (
            &["--threads", "2", "paper", "--figure", "2"],
            "--threads|2|paper|--figure|2|",
        ),
        (
            &["paper", "--threads", "2", "--quick"],
            "paper|--threads|2|--quick|",
        ),
        (&["verify"], "verify|"),
        (&["golden", "--check", "x"], "golden|--check|x|"),
        (&["--quick", "--references"], "--quick|--references|"),
    ] {
        let output = run(folder.path(), arguments);
        let printed = String::from_utf8(output.stdout).unwrap();
        assert_eq!(
            (printed.as_str(), output.status.code()),
            (received, Some(7))
        );
    }
    // Flags of the main job have no effect on them.
    for flag in ["--quick", "--references"] {
        assert_eq!(run(folder.path(), &[flag, "paper"]).status.code(), Some(2));
    }
}
