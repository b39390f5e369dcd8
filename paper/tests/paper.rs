//! `bonebeam-paper paper` from the command to its folder.

use std::fs;
use std::path::Path;

use crate::killed::kill_after;
use crate::pages::loads_nothing;
use crate::runs::{DATA, USAGE, program, refused, succeeded};
use serde_json::Value;
use tempfile::tempdir;

#[test]
fn a_quick_figure_leaves_one_page_that_holds_its_pictures() {
    let folder = tempdir().unwrap();
    let out = folder.path().join("paper");
    let [text, _] = succeeded(&mut program(&folder, "paper --quick --figure 2 -o paper"));
    assert!(text.starts_with("Coarse: smaller arrays, "), "{text}");

    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains(": smaller arrays, "));
    // The page needs no other file, so it can be sent alone.
    let sources = page.matches("src=\"").count();
    assert!(sources > 4, "{sources} pictures");
    assert_eq!(
        sources,
        page.matches("src=\"data:image/png;base64,").count()
    );
    loads_nothing(&page);
    // Every picture has a text alternative.
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
fn help_has_examples_that_name_real_flags() {
    let [text, _] = succeeded(&mut program(".", "paper --help"));
    let (flags, examples) = text.split_once("Examples:").expect("examples");
    let words = examples.split_whitespace();
    for word in words.filter(|word| word.starts_with("--")) {
        assert!(flags.contains(word), "{word}");
    }
}

#[test]
fn what_cannot_be_reproduced_is_refused_with_what_can() {
    let folder = tempdir().unwrap();
    // A flag without an effect is an error.
    for (arguments, status, words) in [
        ("--figure 99", USAGE, ["--figure 99", "can: 2, 3, "]),
        ("--table 2", USAGE, ["--table 2", ""]),
        (
            "--merge no-such-report.json",
            DATA,
            ["no-such-report.json", ""],
        ),
        (
            "--figure 4 --only tissue",
            USAGE,
            ["--only has no effect on ", "it has on claims"],
        ),
        (
            "--table 1 --merge report.json",
            USAGE,
            ["--merge has no effect on ", "it has on claims"],
        ),
        (
            "--figure 10 --mesh bone.ply",
            USAGE,
            [
                "--mesh has no effect on ",
                "it has on vertebra_in_tissue, water_bath, claims",
            ],
        ),
        (
            "--figure 2 --keep kept",
            USAGE,
            ["--keep has no effect on ", "it has on vertebra_in_tissue, "],
        ),
    ] {
        refused(&folder, &format!("paper {arguments}"), status, &words);
    }
}

/// One scene a run: a bone in water, without noise.
const ONE_SCENE: &str = "\
[claims]
bones = 1
tuning_bones = 1
half_windows = [0]
only = [\"water\", \"quiet\"]

[claims.simulation]
beams = 32
beam_step = 4.0
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
fn runs_of_other_bones_are_judged_together() {
    let folder = tempdir().unwrap();
    fs::write(folder.path().join("claims.toml"), ONE_SCENE).unwrap();
    let scenes = |out: &str, more: &str| -> Vec<Value> {
        let command = format!("paper --claims --config claims.toml -o {out} {more}");
        succeeded(&mut program(&folder, &command));
        let text = fs::read_to_string(folder.path().join(out).join("report.json")).unwrap();
        let report: Value = serde_json::from_str(&text).unwrap();
        assert!(!report["verdicts"].as_array().unwrap().is_empty());
        report["claims"]["scenes"].as_array().unwrap().clone()
    };
    let first = scenes("first", "--seed 1 --keep kept");
    let both = scenes("both", "--seed 2 --keep kept --merge first/report.json");
    assert_eq!((first.len(), both.len()), (1, 2));
    assert_eq!(both[0], first[0], "a merged scene is as it was");
    assert_eq!(both[1]["bone"], 2);
    assert_ne!(both[1]["beamformers"], both[0]["beamformers"]);
    // The kept scene is the computed one.
    assert_eq!(scenes("again", "--seed 1 --keep kept"), first);
    refused(&folder, "paper --claims --only oil", USAGE, &["--only oil"]);
}

/// The water bath with few beams, few and thin slices, large pixels and voxels.
const SMALL_BATH: &str = "\
[water_bath]
sweep = 21
sweep_step = 1.5e-3
sweep_density = 2.0
thickness = 0.4e-3
ct_voxel = [0.38e-3, 0.38e-3, 0.6e-3]
tried = [
    { coherence = inf, noise = -60.0, noise_rise = 0.0 },
    { coherence = 0.0, noise = -60.0, noise_rise = 0.0 },
]

[water_bath.simulation]
fs = 40e6
c = 1480.0
beams = 32
beam_step = 4.0
depth_end = 45e-3
noise = -60.0
element_height = 4e-3
elevation_focus = 19e-3

[water_bath.image]
dynamic_range = 70.0
rows = 128
columns = 128
median = true
";

/// From CT to Table I; killed in the sweep and started again, with the bytes of an uninterrupted run.
#[test]
fn the_water_bath_goes_from_ct_to_table_one_also_after_an_end() {
    let folder = tempdir().unwrap();
    let path_of = |name: &str| folder.path().join(name);
    fs::write(path_of("bath.toml"), SMALL_BATH).unwrap();
    let run = |out: &str| {
        let command = format!("paper --figure 4 --config bath.toml -o {out}");
        program(&folder, &command)
    };
    let killed = path_of("killed");
    let kept = killed.join(".kept");
    let recordings = || {
        let all = fs::read_dir(&kept).into_iter().flatten().flatten();
        let done = all.filter(|entry| entry.path().extension().is_some_and(|e| e == "npz"));
        done.count()
    };
    kill_after(&mut run("killed"), recordings, 3);
    assert!(!killed.join("report.json").exists());
    let finished = |out: &str| {
        let [_, message] = succeeded(&mut run(out));
        // Without a terminal each step prints a line.
        assert!(
            message.contains("host-sim: water bath: CT: 0 %\n"),
            "{message}"
        );
    };
    finished("killed");
    assert!(!kept.exists(), "what was kept goes when the run is done");
    finished("whole");
    for file in ["report.json", "numbers.csv", "config.toml", "report.html"] {
        let [a, b] = [&killed, &path_of("whole")].map(|out| fs::read(out.join(file)).unwrap());
        assert!(a == b, "{file}");
    }
    assert_goes_from_ct_to_table_one(&path_of("whole"));
}

/// A water bath of known ends, with the files and pictures of its report in `out`.
fn assert_goes_from_ct_to_table_one(out: &Path) {
    let text = fs::read_to_string(out.join("report.json")).unwrap();
    let report: Value = serde_json::from_str(&text).unwrap();
    let bath = &report["water_bath"];
    let registration = |sources: &str, key: &str| -> f64 {
        let all = bath["registrations"].as_array().unwrap();
        let found = all.iter().find(|r| r["sources"] == sources);
        found.unwrap()[key].as_f64().unwrap()
    };
    // Without sources of error the contour is on the bone.
    assert!(registration("none", "tre_mm") < 1e-9);
    assert_eq!(registration("none", "fre_mm"), 0.0);
    // A scanner that assumes 1480 m/s for 1540 m/s shows a depth z at 1540/1480·z: the contour is above the echo by 4
    // % of the bone's depths, which begin at 15 mm.
    let shift = registration("sound speed", "towards_array_mm");
    let depth = shift / (1540.0 / 1480.0 - 1.0);
    assert!((15.0..40.0).contains(&depth), "{shift} mm");
    // Four balls located to whole voxels fit no better than to a few tenths.
    assert!(registration("registration", "fre_mm") > 0.05);

    // The level of the clutter is fitted to region C of DAS in slice 1. Incoherent clutter is suppressed.
    let level = bath["clutter"]["level"].as_f64().unwrap();
    let rows = bath["tried"].as_array().unwrap();
    let c = |row: usize, slice: usize, beamformer: usize| {
        let measured = &rows[row]["slices"][slice][beamformer][0];
        measured["c"].as_f64().unwrap()
    };
    assert!((-40.0..60.0).contains(&level), "{level} dB");
    for row in 0..2 {
        assert!((c(row, 0, 0) - 92.41).abs() < 2.0, "{}", c(row, 0, 0));
        assert!(c(row, 0, 1) < c(row, 0, 0));
    }
    assert!(c(1, 0, 1) < c(0, 0, 1) && c(1, 1, 1) < c(0, 1, 1));
    assert!((bath["slices"][0]["table"][0][0]["c"].as_f64().unwrap() - 92.41).abs() < 2.0);

    // Two slices, three beamformers, every combination of sources, and an image of one grey level.
    let slices = bath["slices"].as_array().unwrap();
    assert_eq!(slices.len(), 2);
    for slice in slices {
        assert_eq!(slice["table"].as_array().unwrap().len(), 3);
        assert_eq!(slice["sources"].as_array().unwrap().len(), 16);
        let uniform = &slice["uniform"][0];
        // Region A of the B-mode image reaches from -0.5 mm to 2.1 mm.
        let mean = uniform["error_mm"].as_f64().unwrap();
        assert!((mean - 0.8).abs() < 0.1, "{mean}");
    }
    let beside = report["comparisons"].as_array().unwrap();
    let table_one = beside.iter().filter(|c| c["group"] == "Table I").count();
    assert_eq!(table_one, 24);
    assert_eq!(report["checks_passed"], true);

    // The colour maps have axes and a colour bar: dots on white around the pixels.
    for (slice, key) in [(1, "das"), (2, "esmv-rank1")] {
        for kind in ["us", "ps"] {
            let name = format!("water-bath-{slice}-{key}-{kind}-distance.png");
            let file = std::io::BufReader::new(fs::File::open(out.join(&name)).unwrap());
            let mut map = png::Decoder::new(file).read_info().unwrap();
            assert_eq!(map.output_color_type().0, png::ColorType::Rgb);
            let (across, down) = map.info().size();
            assert!(across > down && down > 1000, "{name}: {across} × {down}");
            assert_eq!(map.next_row().unwrap().unwrap().data()[..3], [255; 3]);
        }
    }
    for file in [
        "water-bath-us.nii.gz",
        "water-bath-ct.nii.gz",
        "water-bath-ct-registered.ply",
    ] {
        assert!(out.join(file).exists(), "{file}");
    }
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(
        page.contains("signed distance, mm")
            && page.contains("linear-gradient(to right,rgb(0,0,255)")
    );
    assert_eq!(
        page.matches("src=\"").count(),
        page.matches("src=\"data:image/png;base64,").count()
    );
}
