//! The tests of the host program, one module a subject, linked into one program.

mod agreement;
mod arrays;
mod bad_input;
mod bad_numbers;
mod bad_output;
#[cfg(feature = "bench")]
mod bench;
mod commands;
mod common;
mod config;
mod crafted;
mod defaults;
mod faults;
mod files;
mod frames;
mod golden_vectors;
mod in_place;
mod main_job;
mod paper;

#[test]
fn every_file_of_tests_is_a_module() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests");
    for entry in std::fs::read_dir(folder).unwrap() {
        let file = entry.unwrap().file_name().into_string().unwrap();
        if let Some(name) = file.strip_suffix(".rs").filter(|&name| name != "all") {
            let line = format!("\nmod {name};\n");
            assert!(include_str!("all.rs").contains(&line), "{name}");
        }
    }
}
