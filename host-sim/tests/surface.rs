//! The command `surface`: pictures, lines and recordings, its files, its errors.

use crate::common;

use std::fs;
use std::path::Path;

use bonebeam_files::{BeamformedLines, image};
use bonebeam_simulate::Surface;
use common::program::Folder;
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

/// The rows of a surface's CSV: line, x, z, confidence, piece.
fn rows(folder: &TempDir, name: &str) -> Vec<[f64; 5]> {
    let text = folder.text(name);
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
    folder.works(&format!("{common} -o a.csv --image over.png"));
    let found = rows(&folder, "a.csv");
    follow(&found, [0.0; 2]);

    // The picture has an overlay along the bone only.
    let over = folder.image("over.png");
    let scan = folder.image("scan.png");
    let mut drawn = 0;
    for ((row, column), level) in over.indexed_iter() {
        if *level != scan[(row, column)] {
            let bone = bone(column.min(119)).unwrap() + 2;
            assert!(row.abs_diff(bone) < 5, "{row}, {column}");
            drawn += 1;
        }
    }
    assert!(drawn >= found.len());

    folder.works(&format!("{common} -o a.json"));
    let text = folder.text("a.json");
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["lines"], COLUMNS);
    assert_eq!(json["verdict"], "bone");
    let points = json["pieces"][0].as_array().unwrap();
    assert_eq!(points.len(), found.len());
    assert!((points[9]["z_m"].as_f64().unwrap() - found[9][2]).abs() < 1e-6);

    folder.works(&format!("{common} -o a.ply"));
    let text = folder.text("a.ply");
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

    // VTK's programs show lines and confidence of a .vtp.
    folder.works(&format!("{common} -o a.vtp"));
    let text = folder.text("a.vtp");
    let (points, edges) = (found.len(), found.len() - 1);
    let head = format!("NumberOfPoints=\"{points}\" NumberOfVerts=\"0\" NumberOfLines=\"{edges}\"");
    assert!(text.contains(&head), "{text}");
    let array = |name: &str| {
        let (_, after) = text.split_once(&format!("Name=\"{name}\"")).unwrap();
        let values = after.split(['>', '<']).nth(1).unwrap();
        values
            .split_whitespace()
            .map(|v| v.parse().unwrap())
            .collect::<Vec<f64>>()
    };
    assert_eq!(
        [array("Points").len(), array("confidence").len()],
        [3 * points, points]
    );
    assert!((array("Points")[3 * 9 + 2] - 1e3 * found[9][2]).abs() < 1e-3);
    assert_eq!(array("connectivity")[..4], [0.0, 1.0, 1.0, 2.0]);
    assert_eq!(array("offsets")[..2], [2.0, 4.0]);

    // The same run from the written configuration.
    folder.works(&format!("{common} --config a.csv.config.toml -o b.csv"));
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
    folder.works("surface screen.png --pixel-size 0.0001 --crop 40,20,160,300 -o a.csv");
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
    let z = Array2::from_shape_fn((COLUMNS, ROWS), |(line, n)| envelope(levels[(n, line)]));
    let x = (0..COLUMNS).map(|k| -8e-3 + PIXEL * k as f64);
    let lines = BeamformedLines::straight(z, x.collect(), [7.7e6, 0.0, 1540.0]);
    lines.write(&folder.path().join("lines.npz")).unwrap();
    folder.works("surface lines.npz -o a.csv --image over.png");
    follow(&rows(&folder, "a.csv"), [-8e-3, 0.0]);
    // Points of lower confidence are left out.
    folder.works("surface lines.npz -o b.csv --min-confidence 1");
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
    folder.works(
        "beamform data.npz --method das -o lines.npz --surface first.csv --coherence map.npy",
    );
    let map: Array2<f32> = ndarray_npy::read_npy(folder.path().join("map.npy")).unwrap();
    assert_eq!(map, Array2::from_elem((COLUMNS, ROWS), 1.0));
    let first = rows(&folder, "first.csv");
    follow(&first, [-8e-3, 0.0]);
    for input in ["lines.npz", "data.npz --method das"] {
        folder.works(&format!("surface {input} --frames 0 -o one.csv"));
        assert_eq!(rows(&folder, "one.csv"), first);
        folder.works(&format!("surface {input} -o both.csv"));
        let text = folder.text("both.csv");
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
    folder.works("surface lines.npz -o both.json");
    let text = folder.text("both.json");
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["frames"][1]["frame"], 1);
    assert!(json["frames"][1]["pieces"][0].as_array().unwrap().len() > 110);
    folder.works("surface lines.npz -o both.ply");
    let text = folder.text("both.ply");
    let points = 2 * first.len();
    assert!(text.contains(&format!("element vertex {points}\n")));
    assert!(text.contains("property int frame\n"));
    // No edge joins the frames.
    assert!(text.contains(&format!("element edge {}\n", points - 2)));
    assert!(!text.contains("element face"));

    // As a sweep, points have an elevation. The change of 1.2 mm is continuous over 0.5 mm, not over 0.4 mm.
    let sweep = "surface lines.npz --sweep-step 0.0005";
    folder.works(&format!("{sweep} -o sweep.csv"));
    let text = folder.text("sweep.csv");
    assert!(text.starts_with("frame,line,x_m,y_m,z_m,confidence,piece\n0,"));
    for row in text.lines().skip(1) {
        let y = row.split(',').nth(3).unwrap();
        assert_eq!(
            y,
            if row.starts_with("0,") {
                "0.0000000"
            } else {
                "0.0005000"
            }
        );
    }
    folder.works(&format!("{sweep} -o sweep.json"));
    let text = folder.text("sweep.json");
    let json: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(json["frames"][1]["pieces"][0][5]["y_m"], 0.5e-3);
    for (step, triangles) in [("0.0005", points - 2), ("0.0004", 0)] {
        folder.works(&format!(
            "surface lines.npz --sweep-step {step} -o sweep.ply"
        ));
        let text = folder.text("sweep.ply");
        assert!(
            text.contains(&format!("element face {triangles}\n")),
            "{text}"
        );
        let (_, body) = text.split_once("end_header\n").unwrap();
        assert_eq!(body.lines().count(), points + triangles + points - 2);
        let y = |row: &str| row.split(' ').nth(1).unwrap().parse::<f64>().unwrap();
        let last = 1e3 * step.parse::<f64>().unwrap();
        assert_eq!(y(body.lines().next().unwrap()), 0.0);
        assert_eq!(y(body.lines().nth(points - 1).unwrap()), last);
    }
    // The written configuration repeats the run.
    folder.works("surface lines.npz --config sweep.csv.config.toml -o again.csv");
    let again = ["sweep.csv", "again.csv"].map(|name| folder.bytes(name));
    assert!(again[0] == again[1]);
}

/// The vertices and the triangles of a PLY file, text or binary, mm.
fn ply(path: &Path) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let bytes = fs::read(path).unwrap();
    let end = b"end_header\n";
    let head = bytes.windows(end.len()).position(|w| w == end).unwrap() + end.len();
    let (head, body) = bytes.split_at(head);
    let head = std::str::from_utf8(head).unwrap();
    let count = |name: &str| -> usize {
        let (_, rest) = head.split_once(&format!("element {name} ")).unwrap();
        rest.lines().next().unwrap().parse().unwrap()
    };
    let (vertices, faces) = (count("vertex"), count("face"));
    if head.contains("ascii") {
        let text = std::str::from_utf8(body).unwrap();
        let numbers =
            |row: &str| -> Vec<f64> { row.split(' ').map(|n| n.parse().unwrap()).collect() };
        let rows: Vec<Vec<f64>> = text.lines().map(numbers).collect();
        let faces = &rows[vertices..vertices + faces];
        let vertices = rows[..vertices].iter().map(|r| [r[0], r[1], r[2]]);
        let faces = faces.iter().map(|r| [1, 2, 3].map(|k| r[k] as usize));
        return (vertices.collect(), faces.collect());
    }
    let (corners, triangles) = body.split_at(12 * vertices);
    let number = |b: &[u8]| f64::from(f32::from_le_bytes(b.try_into().unwrap()));
    let corners = corners
        .chunks(12)
        .map(|v| [0, 4, 8].map(|k| number(&v[k..k + 4])));
    let index = |b: &[u8]| u32::from_le_bytes(b.try_into().unwrap()) as usize;
    let triangles = triangles
        .chunks(13)
        .map(|t| [1, 5, 9].map(|k| index(&t[k..k + 4])));
    (corners.collect(), triangles.collect())
}

/// A vertebra whose laminae slope along the sweep: the points of the mesh lie on the bone.
///
/// The documents count an answer within 0.5 mm of the surface as a hit; nine of ten must be hits. Frames in the wrong
/// order, or at one elevation, have fewer.
#[test]
fn the_mesh_of_a_sweep_lies_on_the_bone() {
    let folder = tempdir().unwrap();
    let scanner = "--elements 48 --beams 24 --beam-step 2 --depth-start 0.012 --depth-end 0.036";
    folder.works(&format!(
            "simulate vertebra-3d --sweep 3 --sweep-step 0.0015 --thickness 0.003 --iq {scanner} -o sweep.npz"
        ));
    folder.works("surface sweep.npz --sweep-step 0.0015 -o found.ply");
    let (points, triangles) = ply(&folder.path().join("found.ply"));
    let (corners, faces) = ply(&folder.path().join("sweep.npz.surface.ply"));
    let bone = Surface::new(corners, faces.iter().map(|t| t.map(|k| k as u32)).collect());
    let mut used: Vec<usize> = triangles.concat();
    used.sort_unstable();
    used.dedup();
    assert!(used.len() > 50, "{}", used.len());
    let hits = |elevation: fn(f64) -> f64| {
        let on_bone = used.iter().filter(|index| {
            let [x, y, z] = points[**index];
            // A hair beside the plane, where the surface has corners.
            let first = bone.shallowest(x, elevation(y) + 1e-6);
            first.is_some_and(|(at, _)| (z - at[2]).abs() < 0.5)
        });
        on_bone.count() as f64 / used.len() as f64
    };
    let [right, reversed, flat] = [hits(|y| y), hits(|y| 3.0 - y), hits(|_| 0.0)];
    assert!(right > 0.9, "{right}");
    assert!(reversed < 0.75 && flat < 0.75, "{reversed} {flat}");
}

/// Below the last recorded echo there is silence, not a shadow.
#[test]
fn the_end_of_a_record_is_no_bone() {
    let folder = tempdir().unwrap();
    let scanner = "--elements 48 --beams 48 --depth-start 0.012 --depth-end 0.036 --iq";
    folder.works(&format!("simulate vertebra --tissue {scanner} -o bone.npz"));
    folder.works("surface bone.npz -o recorded.csv");
    folder.works("surface bone.npz --depth-end 0.055 -o beyond.csv");
    let [recorded, beyond] = ["recorded.csv", "beyond.csv"].map(|name| rows(&folder, name));
    assert!(recorded.len() > 10, "{}", recorded.len());
    assert_eq!(beyond, recorded);
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
    folder.works(&format!("{common} -o a.csv --image over.png"));
    let found = on_bone("a.csv");
    assert!(found > 550, "{found}");
    let config = folder.text("a.csv.config.toml");
    assert!(config.contains("[surface.fan]"), "{config}");
    let given = "--fan 0.045,-0.03,0.04,0.09,-0.5,0.5";
    folder.works(&format!("{common} {given} -o b.csv"));
    assert!(on_bone("b.csv").abs_diff(found) < 20);
    // A crop of the picture keeps the positions.
    let crop = "--crop 200,40,520,560";
    folder.works(&format!("{common} {given} {crop} -o c.csv"));
    assert!(on_bone("c.csv") > 400);
    folder.works(&format!("{common} --columns-as-lines -o d.csv"));
    let config = folder.text("d.csv.config.toml");
    assert!(!config.contains("[surface.fan]"), "{config}");
}
