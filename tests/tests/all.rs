//! The tests across crates, one module a subject, linked into one program.

mod beamform_bits;
mod beamform_errors;
mod beamform_f64;
mod beamform_properties;
mod circles;
mod coherence;
mod common;
mod delay;
mod delay_errors;
mod depth_step;
mod documents;
mod formats;
mod geometry;
mod golden;
mod image;
mod iq;
mod kernels;
mod measure;
mod partial_line;
mod phantom;
mod phase_symmetry;
mod pipeline;
mod pipeline_blocks;
mod pipeline_errors;
mod points;
mod simulate;
mod sound_speed;
mod sub_lines;
mod surface;
mod upsampled;
mod volume;

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
    for tests in ["tests", "../host-sim/tests"] {
        check(&Path::new(env!("CARGO_MANIFEST_DIR")).join(tests), "all.rs");
    }
}
