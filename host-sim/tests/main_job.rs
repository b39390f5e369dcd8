//! The main job from the command to its folder.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use crate::common::program::{DATA, Folder, loads_nothing, refused, shell, succeeded};
use bonebeam_drive::methods::COMPARED;
use bonebeam_files::image;
use serde_json::Value;
use tempfile::tempdir;

/// A small main job: few beams, small pictures, all other parameters by default.
const SMALL: &str = "\
[checks]
every_f32 = 5
every_f64 = 5

[point.image]
rows = 64
columns = 64
width = 4.5e-3

[[point.sampling]]
beams = 31
step = 0.5
offset = 0.0

[vertebra.image]
rows = 64
columns = 64
median = true
dynamic_range = 70.0

[vertebra.simulation]
beams = 16
beam_step = 8.0
fs = 40e6
depth_end = 44.2e-3
noise = -40.0
";

fn report(folder: &Path) -> Value {
    serde_json::from_slice(&fs::read(folder.join("report.json")).unwrap()).unwrap()
}

/// The entry of a beamformer in a list.
fn of<'a>(list: &'a Value, beamformer: &str) -> &'a Value {
    let entries = list.as_array().unwrap();
    let found = entries.iter().find(|e| e["beamformer"] == beamformer);
    found.unwrap_or_else(|| panic!("no {beamformer}"))
}

#[test]
fn the_quick_main_job_leaves_a_whole_folder() {
    let folder = tempdir().unwrap();
    let out = folder.path().join("deep/out");
    fs::create_dir_all(&out).unwrap();
    fs::write(out.join(".host-sim-1-7"), "left by a killed run").unwrap();
    // Four gigabytes of address space are enough.
    let script = "ulimit -v 4000000 2>/dev/null; exec \"$0\" --quick --out deep/out";
    let [text, _] = succeeded(&mut shell(&folder, script));
    assert!(text.contains("Table I") && text.contains("report.html"));
    loads_nothing(&fs::read_to_string(out.join("report.html")).unwrap());

    let report = report(&out);
    assert_eq!(report["checks_passed"], Value::Null);
    assert_eq!(report["job"], "quick");
    let mut expected: BTreeSet<String> = ["report.html", "report.json", "config.toml"]
        .map(String::from)
        .into();
    for phantom in ["point", "vertebra"] {
        let pictures = report[phantom]["pictures"].as_array().unwrap();
        assert_eq!(pictures.len(), COMPARED.len());
        for pair in pictures {
            for kind in ["b_mode", "phase_symmetry"] {
                let file = pair[kind]["file"].as_str().unwrap();
                let pixels = image::read(&out.join(file)).unwrap();
                let pixel = pair[kind]["pixel_mm"].as_f64().unwrap();
                // 3 mm around the point's depth, the whole square of the vertebra.
                let rows = if phantom == "point" {
                    2 * (1.5 / pixel).round() as usize + 1
                } else {
                    256
                };
                assert!(
                    pixels.nrows().abs_diff(rows) <= 1,
                    "{file}: {:?}",
                    pixels.dim()
                );
                assert_eq!(pixels.ncols(), 256);
                // The largest pixel is white, except for losses by interpolation and median.
                assert!(pixels.iter().any(|&v| v > 200.0), "{file} is dark");
                expected.insert(file.to_owned());
            }
        }
    }
    let files = fs::read_dir(&out).unwrap();
    let found: BTreeSet<String> = files
        .map(|f| f.unwrap().file_name().into_string().unwrap())
        .collect();
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    // The live page is there if it was built beside the program.
    match found.contains("live.html") {
        true => assert!(expected.insert("live.html".into()) && page.contains("href=\"live.html\"")),
        false => assert!(page.contains("<code>page/build</code>")),
    }
    assert_eq!(found, expected);

    assert!(
        expected
            .iter()
            .filter(|f| f.ends_with(".png"))
            .all(|f| page.contains(f))
    );
    assert!(!page.contains("<script") && !page.contains("http://fonts") && !page.contains("NaN"));
    physics(&report);
}

/// Properties of any correct simulation.
fn physics(report: &Value) {
    for sampling in report["point"]["samplings"].as_array().unwrap() {
        let measure = |beamformer, key: &str| {
            let value = &of(&sampling["beamformers"], beamformer)[key];
            value
                .as_f64()
                .unwrap_or_else(|| panic!("{beamformer}: no {key}"))
        };
        for beamformer in ["das", "mv", "esmv-rank1"] {
            // The pulse is 0.3 mm long, and its echo is centred on the point.
            let depth = measure(beamformer, "peak_depth_mm");
            assert!((depth - 15.0).abs() < 0.05, "{beamformer}: {depth}");
        }
        // λ/D of the two-way aperture: between the values of both apertures and of one alone.
        let width = measure("das", "width_12db_mm");
        assert!((0.7..1.4).contains(&width), "{width}");
        assert!(measure("esmv-rank1", "width_12db_mm") < width);
    }
    let vertebra = &report["vertebra"];
    for beamformer in ["das", "esmv-rank1"] {
        let found = of(&vertebra["beamformers"], beamformer);
        // The tip is on the outline, within half a pulse.
        let bias = found["axial"]["b_mode"]["peak_bias_mm"].as_f64().unwrap();
        assert!(bias.abs() < 0.15, "{beamformer}: {bias}");
        for image in ["b_mode", "phase_symmetry"] {
            let surface = &found["surface"][image];
            for key in ["mean_mm", "std_mm", "intensity_b", "intensity_c"] {
                assert!(surface[key].is_f64(), "{beamformer} {image}: {key}");
            }
            // The intensity at the surface is above that beside it.
            assert!(surface["intensity_a"].as_f64() > surface["intensity_c"].as_f64());
        }
    }
    // The moments of an even distribution over region A.
    let uniform = &vertebra["uniform"]["b_mode"];
    assert!((uniform["std_mm"].as_f64().unwrap() - 0.75).abs() < 0.05);
}

#[test]
fn the_written_configuration_repeats_the_run_on_any_number_of_threads() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("small.toml"), SMALL).unwrap();
    folder.works("--config small.toml --out a");
    folder.works("--threads 1 --config a/config.toml --out b");
    let files = fs::read_dir(path("a")).unwrap();
    for file in files {
        let name = file.unwrap().file_name().into_string().unwrap();
        let [a, b] = ["a", "b"].map(|run| fs::read(path(&format!("{run}/{name}"))).unwrap());
        assert!(a == b, "{name} differs");
    }
}

#[test]
fn a_folder_that_cannot_be_written_is_reported_before_the_computation() {
    let folder = tempdir().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    for out in ["file", "file/below"] {
        refused(&folder, &format!("--quick --out {out}"), DATA, &["file"]);
    }
}
