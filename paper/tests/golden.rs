//! `bonebeam-paper golden`, and the main job with its references.

use crate::runs::{DATA, USAGE, ended, program, succeeded};
use std::fs;

#[test]
fn the_command_ends_with_1_where_a_file_differs() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = |arguments: &str| ended(&mut program(&folder, arguments));
    assert_eq!(run("golden -o vectors").0, 0);
    fs::remove_file(folder.path().join("vectors/chain.out.hex")).expect("removed");
    assert_eq!(run("golden --chain vectors").0, 0);
    assert_eq!(run("golden --check vectors").0, 0);
    let file = folder.path().join("vectors/covariance.out.hex");
    fs::write(&file, "00\n").expect("written");
    let (status, text, _) = run("golden --check vectors");
    assert_eq!(status, DATA);
    let differs = "DIFFERS covariance.out.hex: word 0 is 00; expected ";
    assert!(text.contains(differs), "{text}");
    let (status, _, message) = run("golden --check .");
    assert_eq!(status, DATA);
    assert!(message.contains("holds no golden vectors"), "{message}");
    assert_eq!(run("golden").0, USAGE);
}

#[test]
fn the_main_job_agrees_with_the_references() {
    let folder = tempfile::tempdir().expect("a folder");
    succeeded(&mut program(&folder, "--references --quick --out ."));
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
