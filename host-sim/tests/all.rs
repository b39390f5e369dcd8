//! The tests of the host program, one module a subject, linked into one program.

mod agreement;
mod arrays;
mod bad_numbers;
mod bad_output;
#[cfg(feature = "bench")]
mod bench;
mod commands;
mod common;
mod config;
mod crafted;
mod defaults;
#[cfg(unix)]
mod edges;
mod elsewhere;
mod faults;
mod files;
mod frames;
mod golden_vectors;
mod grid;
mod in_place;
mod main_job;
#[cfg(unix)]
mod refused;
mod resumed;
mod surface;
mod sweep;

use std::fs;
use std::path::Path;

#[test]
fn every_file_of_tests_is_a_module() {
    fn check(folder: &Path, root: &str) {
        let modules = fs::read_to_string(folder.join(root)).unwrap();
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_str().unwrap();
            let is_module = path.is_dir() || path.extension().is_some_and(|e| e == "rs");
            if is_module && !path.ends_with(root) {
                let line = format!("mod {name};");
                let mut lines = modules.lines();
                assert!(
                    lines.any(|l| l.trim_start_matches("pub ") == line),
                    "{path:?}"
                );
            }
            if path.is_dir() {
                check(&path, "mod.rs");
            }
        }
    }
    check(
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("tests"),
        "all.rs",
    );
}
