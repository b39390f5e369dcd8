//! Configurations and reports that cannot be read, or that do not fit.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::tempdir;

/// Asserts that a run fails in one line with these words, and leaves no file.
fn fails(folder: &Path, arguments: &str, status: i32, words: &[&str]) {
    let files = || fs::read_dir(folder).unwrap().count();
    let before = files();
    // A pipe without a writer would wait for ever.
    let script = format!("ulimit -v 4000000; exec timeout 60 \"$0\" {arguments}");
    let output = Command::new("sh")
        .args(["-c", &script, env!("CARGO_BIN_EXE_bonebeam-paper")])
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(status), "{arguments}: {message}");
    assert!(message.starts_with("host-sim: "), "{arguments}: {message}");
    assert_eq!(message.lines().count(), 1, "{arguments}: {message}");
    for word in words {
        assert!(message.contains(word), "{arguments}: {word}: {message}");
    }
    assert_eq!(files(), before, "{arguments}");
}

#[test]
fn inputs_that_are_no_regular_file_are_refused() {
    let folder = tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let made = Command::new("mkfifo").arg(at("pipe")).status().unwrap();
    assert!(made.success());
    for kind in ["toml", "json"] {
        symlink("/dev/zero", at(&format!("device.{kind}"))).unwrap();
        symlink("pipe", at(&format!("pipe.{kind}"))).unwrap();
    }
    for stem in ["device", "pipe"] {
        for (arguments, status) in [
            ("paper --config FILE.toml -o out", 2),
            ("paper --claims --merge FILE.json -o out", 1),
        ] {
            let arguments = arguments.replace("FILE", stem);
            fails(folder.path(), &arguments, status, &["not a regular file"]);
        }
    }
}

#[test]
fn configurations_and_reports_have_a_largest_size() {
    let folder = tempdir().unwrap();
    for (name, length, arguments, status) in [
        ("big.toml", (1 << 20) + 1, "--config big.toml", 2),
        ("big.json", 100_000_001, "--claims --merge big.json", 1),
    ] {
        let file = fs::File::create(folder.path().join(name)).unwrap();
        file.set_len(length).unwrap();
        let arguments = format!("paper {arguments} -o out");
        fails(folder.path(), &arguments, status, &[name, "too large"]);
    }
}

/// Reports to merge are checked first.
///
/// The claims' quick run takes minutes: an error comes before it, and before a folder is made.
#[test]
fn reports_to_merge_are_checked_before_anything_is_computed() {
    let folder = tempdir().unwrap();
    for (text, part) in [
        ("no JSON", "is not the report.json"),
        ("{}", "has no `claims`"),
        ("[1, 2]", "has no `claims`"),
        (r#"{"claims": {}}"#, "`claims.scenes` is not a list"),
        (
            r#"{"claims": {"scenes": [{"bone": 1}]}}"#,
            "`claims.scenes` is not a list",
        ),
    ] {
        fs::write(folder.path().join("report.json"), text).unwrap();
        let begin = Instant::now();
        let paper = "paper --quick --claims --merge report.json -o out";
        fails(folder.path(), paper, 1, &["report.json", part]);
        assert!(begin.elapsed() < Duration::from_secs(5), "{text}");
    }
}
