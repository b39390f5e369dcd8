//! `bonebeam-paper golden`, and the main job with its references.

use std::fs;
use std::process::Command;

#[test]
fn the_command_ends_with_1_where_a_file_differs() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |arguments: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_bonebeam-paper"))
            .arg("golden")
            .args(arguments)
            .current_dir(folder.path())
            .output()
            .expect("a run")
    };
    assert!(run(&["-o", "vectors"]).status.success());
    assert!(run(&["--check", "vectors"]).status.success());
    let file = folder.path().join("vectors/covariance.out.hex");
    fs::write(&file, "00\n").expect("written");
    let output = run(&["--check", "vectors"]);
    assert_eq!(output.status.code(), Some(1));
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        text.contains("DIFFERS covariance.out.hex: word 0 is 00; expected "),
        "{text}"
    );
    let nothing = run(&["--check", "."]);
    assert_eq!(nothing.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&nothing.stderr).contains("holds no golden vectors"));
    assert_eq!(run(&[]).status.code(), Some(2));
}

#[test]
fn the_main_job_agrees_with_the_references() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = Command::new(env!("CARGO_BIN_EXE_bonebeam-paper"))
        .args(["--references", "--quick", "--out", "."])
        .current_dir(folder.path())
        .output()
        .expect("a run");
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    let text = fs::read(folder.path().join("report.json")).expect("a report");
    let report: serde_json::Value = serde_json::from_slice(&text).expect("JSON");
    assert_eq!(report["checks_passed"], true);
    // Aligned samples of both phantoms; lines, image and map of each of the beamformers.
    let checks = report["checks"].as_array().map_or(0, Vec::len);
    assert_eq!(
        checks,
        2 * (1 + 3 * bonebeam_drive::methods::COMPARED.len())
    );
    let page = fs::read_to_string(folder.path().join("report.html")).expect("a page");
    assert!(page.contains("All checks passed.") && page.contains("id=\"checks\""));
}
