//! The command `register`: its files, its starts and its figures.

use std::fmt::Write;
use std::fs;

use super::common::program::Folder;
use serde_json::Value;
use tempfile::{TempDir, tempdir};

/// A ridge with waves along it, over a bent base, as height over x and y, mm; seen from above.
fn height(x: f64, y: f64) -> f64 {
    let ridge = 6.0 * (-0.02 * (x - 0.2 * y).powi(2)).exp();
    ridge * (1.0 + 0.3 * (0.3 * y).sin()) - 0.01 * y * y + 0.05 * x
}

/// The surface as an ASCII STL, and its points with normals, moved by −(3, −2, 1) mm, as a CSV.
fn write_scene(folder: &TempDir) {
    let corner = |i: i32, j: i32| {
        let (x, y) = (f64::from(i), f64::from(j));
        format!("vertex {x} {y} {}\n", height(x, y))
    };
    let mut stl = String::from("solid ridge\n");
    let mut csv = String::from("# SPACE=LPS\nx,y,z,nx,ny,nz,confidence,frame\n");
    for (i, j) in (-25..25).flat_map(|i| (-20..20).map(move |j| (i, j))) {
        for corners in [[(0, 0), (1, 0), (1, 1)], [(0, 0), (1, 1), (0, 1)]] {
            let corners = corners.map(|(a, b)| corner(i + a, j + b)).concat();
            let _ = write!(
                stl,
                "facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n"
            );
        }
        if i.abs() < 20 && j.abs() < 15 {
            let (x, y) = (f64::from(i) + 0.3, f64::from(j) + 0.4);
            let slope = |dx, dy| height(x + dx, y + dy) - height(x - dx, y - dy);
            let (nx, ny) = (-slope(5e-4, 0.0) / 1e-3, -slope(0.0, 5e-4) / 1e-3);
            let [x, y, z] = [x - 3.0, y + 2.0, height(x, y) - 1.0];
            let _ = writeln!(csv, "{x},{y},{z},{nx},{ny},1,0.9,{j}");
        }
    }
    fs::write(folder.path().join("ct.stl"), stl + "endsolid ridge\n").unwrap();
    fs::write(folder.path().join("bone.csv"), csv).unwrap();
}

fn numbers(folder: &TempDir, name: &str) -> Vec<f64> {
    let text = folder.text(name);
    let text = text
        .split("Parameters: ")
        .nth(1)
        .unwrap_or(&text)
        .to_owned();
    let words = text.split_whitespace().map_while(|word| word.parse().ok());
    words.collect()
}

#[test]
fn a_registration_writes_points_pose_picture_and_report() {
    let folder = tempdir().unwrap();
    write_scene(&folder);
    folder.works("register bone.csv ct.stl -o out.ply --image out.png --transform pose.txt --report out.json \
         --truth 1,0,0,3,0,1,0,-2,0,0,1,1,0,0,0,1");
    let found = numbers(&folder, "pose.txt");
    let truth = [
        1., 0., 0., 3., 0., 1., 0., -2., 0., 0., 1., 1., 0., 0., 0., 1.,
    ];
    assert_eq!(found.len(), 16);
    for (found, expected) in found.iter().zip(truth) {
        assert!((found - expected).abs() < 0.05, "{found} {expected}");
    }
    let report: Value = serde_json::from_slice(&folder.bytes("out.json")).unwrap();
    let at = |path: &str| report.pointer(path).and_then(Value::as_f64).unwrap();
    assert!(at("/after_mm/median") < 0.02 && at("/before_mm/median") > 0.3);
    assert!(at("/after_mm/within") == 1.0 && at("/target_error_mm/rms") < 0.1);
    assert_eq!(report["motions"].as_array().unwrap().len(), 6);
    assert_eq!(report["regions_mm"].as_array().unwrap().len(), 9);
    let ply = folder.text("out.ply");
    let (head, rows) = ply.split_once("end_header\n").unwrap();
    for property in ["distance", "red", "nx", "confidence", "int frame"] {
        assert!(head.contains(property), "{property}");
    }
    assert_eq!(rows.lines().count(), 39 * 29);
    assert_eq!(rows.lines().next().unwrap().split(' ').count(), 12);
    assert_eq!(folder.image("out.png").dim(), (480, 1440));

    // What it wrote is registered already; a transform of ITK is the inverse.
    folder.works("register out.ply ct.stl -o again.ply --transform again.txt");
    assert!(numbers(&folder, "again.txt")[3].abs() < 0.05);
    folder.works("register bone.csv ct.stl -o again.ply --start pose.txt --transform pose.tfm");
    let back = numbers(&folder, "pose.tfm");
    assert_eq!(back.len(), 12);
    assert!(
        (back[9] + 3.0).abs() < 0.05 && (back[10] - 2.0).abs() < 0.05,
        "{back:?}"
    );
}

#[test]
fn landmarks_are_a_start_and_ras_is_turned() {
    let folder = tempdir().unwrap();
    write_scene(&folder);
    let list = |name: &str, points: &[[f64; 3]]| {
        let rows = points.iter().map(|[x, y, z]| format!("{x},{y},{z}\n"));
        let text = "x,y,z\n".to_owned() + &rows.collect::<String>();
        fs::write(folder.path().join(name), text).unwrap();
    };
    // 120 mm away from the points' own coordinates, and in RAS.
    let text = folder.text("bone.csv");
    let mut moved = String::from("# SPACE=RAS\n");
    for (k, line) in text.lines().skip(1).enumerate() {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |c: usize| cells[c].parse::<f64>().unwrap();
        match k {
            0 => moved += &format!("{line}\n"),
            _ => {
                let (x, y, nx, ny) = (-number(0) - 120.0, -number(1), -number(3), -number(4));
                let rest = cells[5..].join(",");
                let _ = writeln!(moved, "{x},{y},{},{nx},{ny},{rest}", cells[2]);
            }
        }
    }
    fs::write(folder.path().join("moved.csv"), moved).unwrap();
    let marks = [[0.0, 0.0, 6.0], [20.0, 0.0, 1.0], [0.0, 15.0, 2.0]];
    list("ct.csv", &marks);
    list(
        "tracked.csv",
        &marks.map(|[x, y, z]| [x - 3.0 + 120.0, y + 2.5, z - 1.5]),
    );
    folder.works(
        "register moved.csv ct.stl -o out.ply --landmarks tracked.csv ct.csv --transform pose.txt",
    );
    let found = numbers(&folder, "pose.txt");
    assert!(
        (found[3] + 117.0).abs() < 0.05 && (found[7] + 2.0).abs() < 0.05,
        "{found:?}"
    );
}
