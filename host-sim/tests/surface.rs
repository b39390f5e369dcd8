//! The command `surface`: pictures, lines and recordings, its files, its errors.

use crate::common;

use std::fs;

use bonebeam_files::{BeamformedLines, image};
use common::program::{DATA, USAGE, fails, folder_with_channel_data, names, run};
use common::{Npz, scalar, vector};
use ndarray::{Array2, Array4};
use num_complex::Complex;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use tempfile::{TempDir, tempdir};

const PIXEL: f64 = 0.1e-3;
const COLUMNS: usize = 160;
const ROWS: usize = 300;

/// Row of the bone in a column: a slope, and no bone in the last quarter.
fn bone(column: usize) -> Option<usize> {
    (column < 120).then_some(140 + column / 6)
}

/// Speckle with bone and its shadow, 0 to 255.
fn picture() -> Array2<f32> {
    let mut rng = ChaCha8Rng::seed_from_u64(34);
    Array2::from_shape_fn((ROWS, COLUMNS), |(row, column)| {
        let speckle: f32 = rng.random_range(0.0..60.0);
        match bone(column) {
            Some(bone) if row > bone + 4 => speckle / 4.0,
            Some(bone) if row >= bone => 190.0 + speckle,
            _ => 60.0 + speckle,
        }
    })
}

fn works(folder: &TempDir, arguments: &str) {
    let (status, message) = run(folder, arguments);
    assert_eq!(status, 0, "{arguments}: {message}");
}

/// The rows of a surface's CSV: line, x, z, confidence, piece.
fn rows(folder: &TempDir, name: &str) -> Vec<[f64; 5]> {
    let text = fs::read_to_string(folder.path().join(name)).unwrap();
    let (head, rows) = text.split_once('\n').unwrap();
    assert_eq!(head, "line,x_m,z_m,confidence,piece");
    let row = |line: &str| {
        let numbers: Vec<f64> = line.split(',').map(|n| n.parse().unwrap()).collect();
        numbers.try_into().unwrap()
    };
    rows.lines().map(row).collect()
}

/// The rows follow the bone to 0.3 mm, except at its ends.
fn follow(rows: &[[f64; 5]], [x0, z0]: [f64; 2]) {
    assert!(rows.len() > 110 && rows.len() < 125, "{}", rows.len());
    for &[line, x, z, confidence, piece] in rows {
        let column = line as usize;
        assert!((x - x0 - column as f64 * PIXEL).abs() < 1e-6);
        let middle = z0 + PIXEL * (bone(column.min(119)).unwrap() + 2) as f64;
        assert!((z - middle).abs() < 0.3e-3, "{line}: {z} and {middle}");
        assert!((0.0..=1.0).contains(&confidence) && piece == 0.0);
    }
}

#[test]
fn the_surface_of_a_picture_is_written_in_every_format_and_drawn() {
    let folder = tempdir().unwrap();
    image::write(&picture(), &folder.path().join("scan.png")).unwrap();
    let common = "surface scan.png --pixel-size 0.0001";
    works(&folder, &format!("{common} -o a.csv --image over.png"));
    let found = rows(&folder, "a.csv");
    follow(&found, [0.0; 2]);

    // The picture has an overlay along the bone only.
    let over = image::read(&folder.path().join("over.png")).unwrap();
    let scan = image::read(&folder.path().join("scan.png")).unwrap();
    let mut drawn = 0;
    for ((row, column), level) in over.indexed_iter() {
        if *level != scan[(row, column)] {
            let bone = bone(column.min(119)).unwrap() + 2;
            assert!(row.abs_diff(bone) < 5, "{row}, {column}");
            drawn += 1;
        }
    }
    assert!(drawn >= found.len());

    works(&folder, &format!("{common} -o a.json"));
    let text = fs::read_to_string(folder.path().join("a.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["lines"], COLUMNS);
    let points = json["pieces"][0].as_array().unwrap();
    assert_eq!(points.len(), found.len());
    assert!((points[9]["z_m"].as_f64().unwrap() - found[9][2]).abs() < 1e-6);

    works(&folder, &format!("{common} -o a.ply"));
    let text = fs::read_to_string(folder.path().join("a.ply")).unwrap();
    assert!(text.starts_with("ply\nformat ascii 1.0\n"));
    assert!(text.contains(&format!("element vertex {}\n", found.len())));
    assert!(text.contains(&format!("element edge {}\n", found.len() - 1)));
    let (_, body) = text.split_once("end_header\n").unwrap();
    assert_eq!(body.lines().count(), 2 * found.len() - 1);
    let z: f64 = body
        .lines()
        .nth(9)
        .unwrap()
        .split(' ')
        .nth(2)
        .unwrap()
        .parse()
        .unwrap();
    assert!((z - 1e3 * found[9][2]).abs() < 1e-3);

    // The same run from the written configuration.
    works(
        &folder,
        &format!("{common} --config a.csv.config.toml -o b.csv"),
    );
    assert_eq!(rows(&folder, "b.csv"), found);
}

#[test]
fn a_cropped_picture_has_the_places_of_the_whole() {
    let folder = tempdir().unwrap();
    let mut screen = Array2::from_elem((ROWS + 30, COLUMNS + 50), 255.0);
    for ((row, column), level) in picture().indexed_iter() {
        screen[(row + 20, column + 40)] = *level;
    }
    image::write(&screen, &folder.path().join("screen.png")).unwrap();
    works(
        &folder,
        "surface screen.png --pixel-size 0.0001 --crop 40,20,160,300 -o a.csv",
    );
    let found: Vec<_> = rows(&folder, "a.csv");
    let shifted: Vec<_> = found
        .iter()
        .map(|r| [r[0] - 40.0, r[1], r[2], r[3], r[4]])
        .collect();
    follow(&shifted, [4e-3, 2e-3]);
}

#[test]
fn the_surface_of_lines_lies_where_the_beams_do() {
    let folder = tempdir().unwrap();
    let levels = picture();
    let lines = BeamformedLines {
        z: Array2::from_shape_fn((COLUMNS, ROWS), |(line, sample)| {
            envelope(levels[(sample, line)])
        }),
        fs: 7.7e6,
        t0: 0.0,
        beam_x: (0..COLUMNS).map(|k| -8e-3 + PIXEL * k as f64).collect(),
        rays: None,
        sub_lines: 1,
        c: 1540.0,
    };
    lines.write(&folder.path().join("lines.npz")).unwrap();
    works(&folder, "surface lines.npz -o a.csv --image over.png");
    follow(&rows(&folder, "a.csv"), [-8e-3, 0.0]);
    // Points of lower confidence are left out.
    works(&folder, "surface lines.npz -o b.csv --min-confidence 1");
    assert!(rows(&folder, "b.csv").len() < 110);
}

/// Envelope with the picture's grey level over 60 dB.
fn envelope(level: f32) -> Complex<f32> {
    Complex::new(0.0, 10f32.powf(60.0 * (level / 250.0 - 1.0) / 20.0))
}

#[test]
fn frames_have_a_surface_each_and_beamforming_writes_that_of_the_first() {
    let folder = tempdir().unwrap();
    let levels = picture();
    // Two elements receive the same signal; bone is 12 samples higher in the second frame.
    let x = Array4::from_shape_fn((2, COLUMNS, ROWS, 2), |(frame, line, sample, _)| {
        envelope(levels[((sample + 12 * frame).min(ROWS - 1), line)])
    });
    let beam_x: Vec<f64> = (0..COLUMNS).map(|k| -8e-3 + PIXEL * k as f64).collect();
    Npz::create(&folder.path().join("data.npz"))
        .with("x", x.into_dyn())
        .with("fs", scalar(7.7e6))
        .with("t0", scalar(0.0))
        .with("c", scalar(1540.0))
        .with("beam_x", vector(&beam_x))
        .finish();
    works(
        &folder,
        "beamform data.npz --method das -o lines.npz --surface first.csv --coherence map.npy",
    );
    let map: Array2<f32> = ndarray_npy::read_npy(folder.path().join("map.npy")).unwrap();
    assert_eq!(map, Array2::from_elem((COLUMNS, ROWS), 1.0));
    let first = rows(&folder, "first.csv");
    follow(&first, [-8e-3, 0.0]);
    for input in ["lines.npz", "data.npz --method das"] {
        works(&folder, &format!("surface {input} --frames 0 -o one.csv"));
        assert_eq!(rows(&folder, "one.csv"), first);
        works(&folder, &format!("surface {input} -o both.csv"));
        let text = fs::read_to_string(folder.path().join("both.csv")).unwrap();
        let (head, body) = text.split_once('\n').unwrap();
        assert_eq!(head, "frame,line,x_m,z_m,confidence,piece");
        let of = |frame: &str| -> Vec<[f64; 2]> {
            let rows = body.lines().filter_map(|row| row.strip_prefix(frame));
            let depth = |row: &str| {
                let numbers: Vec<f64> = row.split(',').map(|n| n.parse().unwrap()).collect();
                [numbers[0], numbers[2]]
            };
            rows.map(depth).collect()
        };
        let [zeroth, next] = ["0,", "1,"].map(of);
        assert_eq!(
            zeroth,
            first.iter().map(|r| [r[0], r[2]]).collect::<Vec<_>>()
        );
        assert_eq!(next.len(), zeroth.len());
        for (a, b) in zeroth.iter().zip(&next) {
            assert!((a[1] - b[1] - 12.0 * PIXEL).abs() < 0.1e-3, "{a:?} {b:?}");
        }
    }
    works(&folder, "surface lines.npz -o both.json");
    let text = fs::read_to_string(folder.path().join("both.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["frames"][1]["frame"], 1);
    assert!(json["frames"][1]["pieces"][0].as_array().unwrap().len() > 110);
    works(&folder, "surface lines.npz -o both.ply");
    let text = fs::read_to_string(folder.path().join("both.ply")).unwrap();
    let points = 2 * first.len();
    assert!(text.contains(&format!("element vertex {points}\n")));
    assert!(text.contains("property int frame\n"));
    // No edge joins the frames.
    assert!(text.contains(&format!("element edge {}\n", points - 2)));
}

#[test]
fn the_fan_of_a_picture_is_found_told_and_written() {
    let folder = tempdir().unwrap();
    // The fan begins 40 mm below its apex, which is 30 mm above the picture. The bone is 20 mm deep.
    let mut rng = ChaCha8Rng::seed_from_u64(35);
    let fan = Array2::from_shape_fn((640, 900), |(row, column)| {
        let speckle: f32 = rng.random_range(0.0..60.0);
        let (u, v) = (PIXEL * column as f64 - 45e-3, PIXEL * row as f64 + 30e-3);
        let depth = u.hypot(v) - 40e-3;
        if !(0.0..50e-3).contains(&depth) || u.atan2(v).abs() > 0.5 {
            return 0.0;
        }
        match depth {
            ..20e-3 => 60.0 + speckle,
            ..20.5e-3 => 190.0 + speckle,
            _ => speckle / 4.0,
        }
    });
    image::write(&fan, &folder.path().join("fan.png")).unwrap();
    let on_bone = |name: &str| {
        let rows = rows(&folder, name);
        for [_, x, z, ..] in &rows {
            let depth = (x - 45e-3).hypot(z + 30e-3) - 40e-3;
            assert!((depth - 20.25e-3).abs() < 0.5e-3, "{x} {z}: {depth}");
        }
        rows.len()
    };
    let common = "surface fan.png --pixel-size 0.0001";
    works(&folder, &format!("{common} -o a.csv --image over.png"));
    let found = on_bone("a.csv");
    assert!(found > 550, "{found}");
    let config = fs::read_to_string(folder.path().join("a.csv.config.toml")).unwrap();
    assert!(config.contains("[surface.fan]"), "{config}");
    let given = "--fan 0.045,-0.03,0.04,0.09,-0.5,0.5";
    works(&folder, &format!("{common} {given} -o b.csv"));
    assert!(on_bone("b.csv").abs_diff(found) < 20);
    // A crop of the picture keeps the positions.
    let crop = "--crop 200,40,520,560";
    works(&folder, &format!("{common} {given} {crop} -o c.csv"));
    assert!(on_bone("c.csv") > 400);
    works(&folder, &format!("{common} --columns-as-lines -o d.csv"));
    let config = fs::read_to_string(folder.path().join("d.csv.config.toml")).unwrap();
    assert!(!config.contains("[surface.fan]"), "{config}");
}

#[test]
fn what_is_wrong_is_told() {
    let folder = folder_with_channel_data();
    image::write(&picture(), &folder.path().join("scan.png")).unwrap();
    let picture = "surface scan.png -o a.csv";
    let sized = "surface scan.png --pixel-size 0.0001";
    for (arguments, parts) in [
        (picture.into(), &["scan.png", "--pixel-size", "0.0001"][..]),
        (
            format!("{picture} --pixel-size 0.1"),
            &["--pixel-size is 0.1", "0.01 (m)"],
        ),
        (
            format!("{sized} -o a.txt"),
            &["a.txt", ".csv, .json or .ply"],
        ),
        (
            format!("{sized} -o a.csv --image a.npy"),
            &["a.npy", ".png"],
        ),
        (
            format!("{sized} -o a.csv --crop 0,0,200,10"),
            &["200,10", "160 x 300"],
        ),
        (
            format!("{sized} -o a.csv --crop 0,0,0,10"),
            &["--crop", "80,40,512,480"],
        ),
        (
            format!("{sized} -o a.csv --absence 100"),
            &["--absence", "[surface]", "-64 to 64"],
        ),
        (
            format!("{sized} -o a.csv --search-end 0.001"),
            &["--search-end", "--search-start"],
        ),
        (
            "surface data.npz --crop 0,0,9,9 -o a.csv".into(),
            &["--crop", "not a picture"],
        ),
        (
            "surface data.npz --frames 3 -o a.csv".into(),
            &["--frames asks for 3", "0 to 0"],
        ),
        (
            "surface data.npz --fan 0,0,1,2,0,1 -o a.csv".into(),
            &["--fan", "not a picture"],
        ),
        (
            format!("{sized} -o a.csv --fan 0,0,1,2,0"),
            &["--fan", "six numbers"],
        ),
        (
            format!("{sized} -o a.csv --fan 0,0,0.2,0.1,0,1"),
            &["--fan", "0 <= BEGIN < END"],
        ),
        (
            format!("{sized} -o a.csv --fan 0,0,0.01,0.1,0,1 --columns-as-lines"),
            &["--fan", "--columns-as-lines"],
        ),
        (
            format!("{sized} -o a.csv --fan 5,0,0.01,0.1,0,1"),
            &["--fan", "no beam"],
        ),
        (
            format!("{sized} -o a.csv --frames 0"),
            &["--frames", "a picture"],
        ),
        (
            "beamform data.npz -o a.npz --surface a.txt".into(),
            &["--surface is a.txt", ".ply"],
        ),
    ] {
        fails(&folder, &arguments, USAGE, parts);
    }
    // 3 mm are too short for the windows.
    let low = ndarray::Array2::from_elem((60, 50), 9.0);
    image::write(&low, &folder.path().join("low.png")).unwrap();
    let part = ["low.png", "end of the lines"];
    fails(
        &folder,
        "surface low.png --pixel-size 0.0001 -o a.csv",
        DATA,
        &part,
    );
    assert!(!names(folder.path()).contains(&"a.csv".to_owned()));
}
