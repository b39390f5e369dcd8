//! Configurations and reports that cannot be read, or that do not fit.

use std::fs;
use std::os::unix::fs::symlink;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::runs::refused;
use tempfile::tempdir;

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
            refused(&folder, &arguments, status, &["not a regular file"]);
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
        refused(&folder, &arguments, status, &[name, "too large"]);
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
        refused(&folder, paper, 1, &["report.json", part]);
        assert!(begin.elapsed() < Duration::from_secs(5), "{text}");
    }
}
