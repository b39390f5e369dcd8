//! Every public type of the core can be logged on a target, or stands here with the reason why not.

use std::fs;
use std::path::{Path, PathBuf};

/// Memory, and what borrows it: contents that are no log's business. Vectors of lanes, which no
/// microcontroller has.
const NOT_LOGGED: [&str; 22] = [
    "ComplexVector",
    "External",
    "Frame",
    "GainTables",
    "IqSamples",
    "Kernels",
    "LaneFft",
    "Lanes",
    "LanesMask",
    "LineMemory",
    "LogGabor",
    "LogGaborTables",
    "Memory",
    "MemoryView",
    "Reduction",
    "Slices",
    "StripMemory",
    "StripSlices",
    "Term",
    "Tridiagonal",
    "Workspace",
    "WorkspaceView",
];

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

#[test]
fn every_public_type_can_be_logged() {
    let core = Path::new(env!("CARGO_MANIFEST_DIR")).join("../core/src");
    let mut files = vec![];
    sources(&core, &mut files);
    let texts: Vec<String> = files
        .iter()
        .map(|file| fs::read_to_string(file).unwrap())
        .collect();

    let (mut logged, mut not_logged) = (vec![], vec![]);
    for text in &texts {
        // Attributes and documentation stand before a type without an empty line between.
        let mut derived = false;
        for line in text.lines() {
            let line = line.trim_start();
            let declared = ["pub struct ", "pub enum "]
                .iter()
                .find_map(|keyword| line.strip_prefix(keyword));
            if let Some(rest) = declared {
                let end = rest.find(|c: char| !c.is_alphanumeric());
                let name = &rest[..end.unwrap_or(rest.len())];
                let written = texts
                    .iter()
                    .any(|text| text.contains(&format!("impl defmt::Format for {name}")));
                if derived || written {
                    logged.push(name);
                } else {
                    not_logged.push(name);
                }
            }
            let continues = line.starts_with("#[") || line.starts_with("///");
            derived = continues && (derived || line.contains("derive(defmt::Format)"));
        }
    }
    let missing: Vec<_> = not_logged
        .iter()
        .filter(|name| !NOT_LOGGED.contains(name))
        .collect();
    assert!(missing.is_empty(), "cannot be logged: {missing:?}");
    let stale: Vec<_> = NOT_LOGGED
        .iter()
        .filter(|name| !not_logged.contains(name))
        .collect();
    assert!(
        stale.is_empty(),
        "can be logged, or are not there: {stale:?}"
    );
    assert!(logged.len() > 30, "{logged:?}");
}
