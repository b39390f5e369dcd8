//! `bonebeam-paper tune` from the command to its folder.

use std::fs;
use std::process::Command;

use crate::killed::kill_after;
use crate::runs::{program, run, succeeded};
use host_sim::config::Config;
use serde_json::Value;
use tempfile::{TempDir, tempdir};

/// A small array over few beams.
const SCANNER: &str = "\
[simulate.scanner]
elements = 48
beams = 24
first_beam = 12.0
fs = 20e6
depth_start = 2e-3
depth_end = 40e-3
focus = 20e-3
element_height = 4e-3
noise = -60.0

[surface]
search_end = 35e-3
";

fn tune(folder: &TempDir, arguments: &str) -> Command {
    program(folder, &format!("tune {arguments}"))
}

/// Killed in the search and started again: the files of an uninterrupted run.
///
/// Other commands accept the configuration.
#[test]
fn a_run_that_was_killed_goes_on_to_the_same_bytes() {
    let folder = tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("scanner.toml"), SCANNER).unwrap();
    let common = "--quick --config scanner.toml --methods das,mv --evaluations 10";
    let arguments = |out: &str| format!("{common} -o {out}");
    let kept = at("killed/.kept");
    let scores = || {
        let all = fs::read_dir(&kept).into_iter().flatten().flatten();
        let named = |name: &str| name.starts_with("tune-score") && name.ends_with(".json");
        all.filter(|entry| named(&entry.file_name().to_string_lossy()))
            .count()
    };
    let mut command = tune(&folder, &arguments("killed"));
    kill_after(&mut command, scores, 4);
    assert!(!at("killed/report.json").exists());
    // Damaged recordings are made again, and what else is left is removed.
    for entry in fs::read_dir(&kept).unwrap().flatten() {
        if entry.path().extension().is_some_and(|end| end == "npz") {
            fs::write(entry.path(), "damaged").unwrap();
        }
    }
    let left = at("killed/.host-sim-1-7");
    fs::write(&left, "left by a killed run").unwrap();
    let [table, _] = succeeded(&mut tune(&folder, &arguments("killed")));
    assert!(
        !kept.exists() && !left.exists(),
        "what was kept goes when the run is done"
    );
    assert!(table.contains("mv, tuned together"), "{table}");
    succeeded(&mut tune(&folder, &arguments("whole")));
    for file in ["tuned.toml", "report.json", "evaluations.csv"] {
        let [a, b] = ["killed", "whole"].map(|out| fs::read(at(out).join(file)).unwrap());
        assert!(a == b, "{file}");
    }

    let text = fs::read_to_string(at("whole/report.json")).unwrap();
    let report: Value = serde_json::from_str(&text).unwrap();
    let candidates = report["candidates"].as_array().unwrap();
    assert_eq!(candidates.len(), 4);
    // A header line, two searches of 10, and eight times 10 for the detector alone.
    let evaluations = fs::read_to_string(at("whole/evaluations.csv")).unwrap();
    assert_eq!(evaluations.lines().count(), 1 + 80 + 2 * 10);
    // The first evaluation of the detector is the default; no result is worse than its start.
    let score = |k: usize| candidates[k]["score"].as_f64().unwrap();
    assert!(score(1) >= score(0) && score(2) >= score(0));
    let config = Config::read(&at("whole/tuned.toml")).unwrap();
    config.validate().unwrap();
    assert_eq!(config.surface.search_end, Some(35e-3));
}

#[test]
fn what_cannot_be_tuned_is_refused_with_what_can() {
    let folder = tempdir().unwrap();
    fs::write(
        folder.path().join("wrong.toml"),
        "[beamform]\nf_number = 0.0\n",
    )
    .unwrap();
    for (arguments, words) in [
        ("-o out --bones 1", "--bones is 1; expected 2 to 1024"),
        (
            "-o out --evaluations 0",
            "--evaluations is 0; expected 1 to",
        ),
        ("-o out --methods das,mv,das", "--methods has das twice"),
        ("-o out --methods capon", "esmv-rank1"),
        ("-o out --config wrong.toml", "f_number"),
        ("-o out --docs none.md", "none.md"),
        ("--quick", "--output"),
    ] {
        let (status, message) = run(&folder, &format!("tune {arguments}"));
        assert!(status != 0, "{arguments}");
        assert!(message.contains(words), "{arguments}: {message}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
        assert!(!folder.path().join("out").exists(), "{arguments}");
    }
}
