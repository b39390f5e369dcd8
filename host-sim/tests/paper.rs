//! `host-sim paper` from the command to its folder.

use std::fs;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::tempdir;

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_host-sim"))
        .arg("paper")
        .args(arguments)
        .output()
        .unwrap()
}

fn fail(arguments: &[&str], status: i32) -> String {
    let output = run(arguments);
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(status), "{message}");
    assert_eq!(message.trim_end().lines().count(), 1, "{message}");
    message
}

#[test]
fn a_quick_figure_leaves_one_page_that_holds_its_pictures() {
    let folder = tempdir().unwrap();
    let out = folder.path().join("paper");
    let output = run(&["--quick", "--figure", "2", "-o", out.to_str().unwrap()]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");

    let page = fs::read_to_string(out.join("report.html")).unwrap();
    // Nothing is outside of the page: it can be sent by itself.
    let sources = page.matches("src=\"").count();
    assert!(sources > 4, "{sources} pictures");
    assert_eq!(
        sources,
        page.matches("src=\"data:image/png;base64,").count()
    );
    assert!(!page.contains("<script") && !page.contains("href=\"http"));
    // Every picture has a text for those who do not see it.
    assert_eq!(
        page.matches("<img").count(),
        page.matches(" alt=\"").count()
    );

    let text = fs::read_to_string(out.join("report.json")).unwrap();
    let report: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(report["job"], "quick");
    assert!(
        report.get("vertebra_in_tissue").is_none(),
        "only Fig. 2 was asked for"
    );
    let numbers = fs::read_to_string(out.join("numbers.csv")).unwrap();
    assert!(numbers.lines().count() > 100);
    for file in ["config.toml", "point_spread-table-1.csv"] {
        assert!(out.join(file).exists(), "{file}");
    }
    // The configuration gives the same job again.
    let config = fs::read_to_string(out.join("config.toml")).unwrap();
    assert!(config.starts_with("# host-sim") && config.contains("[point_spread]"));
}

#[test]
fn what_cannot_be_reproduced_is_refused_with_what_can() {
    let message = fail(&["--figure", "99"], 2);
    assert!(
        message.contains("--figure 99") && message.contains("can: 2, 3, "),
        "{message}"
    );
    let message = fail(&["--table", "2"], 2);
    assert!(message.contains("--table 2"), "{message}");
    let message = fail(&["--merge", "no-such-report.json"], 1);
    assert!(message.contains("no-such-report.json"), "{message}");
    // A flag that would change nothing.
    for [wanted, number, flag, word, concerns] in [
        ["--figure", "4", "--only", "tissue", "it has on claims"],
        ["--table", "1", "--merge", "report.json", "it has on claims"],
        [
            "--figure",
            "10",
            "--mesh",
            "bone.ply",
            "it has on vertebra_in_tissue, water_bath, claims",
        ],
        [
            "--figure",
            "2",
            "--keep",
            "kept",
            "it has on vertebra_in_tissue, ",
        ],
    ] {
        let message = fail(&[wanted, number, flag, word], 2);
        let expected = [format!("{flag} has no effect on "), concerns.into()];
        assert!(expected.iter().all(|e| message.contains(e)), "{message}");
    }
}

/// One scene a run: a bone in water, quiet.
const ONE_SCENE: &str = "\
[claims]
seeds = 1
tuning_seeds = 1
half_windows = [0]
only = [\"built-in\", \"water\", \"quiet\"]

[claims.simulation]
beams = 16
beam_step = 8.0
fs = 40e6
depth_end = 44.2e-3
noise = -60.0

[claims.water]
dynamic_range = 70.0
rows = 64
columns = 64
median = true
";

#[test]
fn runs_of_other_seeds_are_judged_together() {
    let folder = tempdir().unwrap();
    let place = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    fs::write(place("claims.toml"), ONE_SCENE).unwrap();
    let scenes = |out: &str, more: &[&str]| -> Vec<Value> {
        let (config, out) = (place("claims.toml"), place(out));
        let first = ["--claims", "--config", &config, "-o", &out];
        let output = run(&[&first[..], more].concat());
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{message}");
        let text = fs::read_to_string(format!("{out}/report.json")).unwrap();
        let report: Value = serde_json::from_str(&text).unwrap();
        assert!(!report["verdicts"].as_array().unwrap().is_empty());
        report["claims"]["scenes"].as_array().unwrap().clone()
    };
    let kept = place("kept");
    let first = scenes("first", &["--seed", "1", "--keep", &kept]);
    let report = place("first/report.json");
    let both = scenes(
        "both",
        &["--seed", "2", "--keep", &kept, "--merge", &report],
    );
    assert_eq!((first.len(), both.len()), (1, 2));
    assert_eq!(both[0], first[0], "a merged scene is as it was");
    assert_eq!(both[1]["seed"], 2);
    assert_ne!(both[1]["beamformers"], both[0]["beamformers"]);
    // The scene that was kept is the one that was computed.
    assert_eq!(scenes("again", &["--seed", "1", "--keep", &kept]), first);
    let message = fail(&["--claims", "--only", "oil"], 2);
    assert!(message.contains("--only oil"), "{message}");
}
