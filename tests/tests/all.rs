//! The tests across crates, one module a subject, linked into one program.

mod beamform_bits;
mod beamform_errors;
mod beamform_f64;
mod beamform_properties;
mod circles;
mod common;
mod delay;
mod delay_errors;
mod documents;
mod formats;
mod geometry;
mod golden;
mod image;
mod iq;
mod measure;
mod phantom;
mod phase_symmetry;
mod pipeline;
mod pipeline_blocks;
mod pipeline_errors;
mod simulate;
mod upsampled;
mod volume;

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
