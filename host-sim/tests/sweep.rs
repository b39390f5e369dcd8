//! The command `sweep`: a drawn sweep over a shaft with known poses, its files, its errors.

use crate::common;

use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use crate::resumed::killed_at;
use bonebeam_files::image;
use bonebeam_tracked::{IDENTITY, apply, inverse, product};
use common::program::{Folder, names, program, run, succeeded};
use common::shaft::*;
use ndarray::Array2;
use tempfile::tempdir;

/// The rows of a cloud's CSV: frame, line, position, normal, path, confidence.
fn rows(path: &Path) -> Vec<[f64; 12]> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    assert_eq!(
        lines.next(),
        Some("# SPACE=RAS, mm, frame of reference Reference")
    );
    assert_eq!(
        lines.next(),
        Some("frame,line,x,y,z,nx,ny,nz,px,py,pz,confidence")
    );
    let row = |line: &str| {
        let numbers: Vec<f64> = line.split(',').map(|n| n.parse().unwrap()).collect();
        numbers.try_into().unwrap()
    };
    lines.map(row).collect()
}

#[test]
fn points_lie_on_a_shaft_in_the_references_frame() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let common = "sweep sweep.igs.mha --calibration plus.xml --min-confidence 0.3";
    folder.works(&format!(
        "{common} -o a.csv --image views.png --overlay frame.png"
    ));
    let rows = rows(&at("a.csv"));
    let frames: std::collections::BTreeSet<usize> =
        rows.iter().map(|row| row[0] as usize).collect();
    let expected = (0..FRAMES).filter(|k| ![LOST, JUMP, EMPTY].contains(k));
    assert!(frames.into_iter().eq(expected));
    assert!(rows.len() > 80 * (FRAMES - 3), "{}", rows.len());

    let part =
        |row: &[f64; 12], from: usize| -> [f64; 3] { std::array::from_fn(|k| row[from + k]) };
    let mut off: Vec<f64> = rows
        .iter()
        .map(|row| (length(from_axis(part(row, 2))) - RADIUS).abs())
        .collect();
    off.sort_by(f64::total_cmp);
    let mean = off.iter().sum::<f64>() / off.len() as f64;
    let most = off[off.len() * 95 / 100];
    assert!(mean <= 0.15 && most <= 0.5, "mean {mean}, 95 % {most}");
    // Normals point outwards, and the sound came from the picture's top.
    let outwards = rows.iter().filter(|row| {
        let [out, normal] = [from_axis(part(row, 2)), part(row, 5)];
        (0..3).map(|k| out[k] * normal[k]).sum::<f64>() > 0.95 * length(out)
    });
    assert!(outwards.count() > rows.len() * 9 / 10);
    for row in &rows {
        let matrix = image_to_reference(row[0] as usize);
        let top = apply(&matrix, [row[1], 0.0, 0.0]);
        let came: [f64; 3] = std::array::from_fn(|k| row[2 + k] - row[8 + k] - top[k]);
        assert!(length(came) < 1e-3, "{row:?}");
    }
    assert_eq!(image::read(&at("views.png")).unwrap().dim(), (640, 1920));
    assert_eq!(
        image::read(&at("frame.png")).unwrap().dim(),
        (ROWS, COLUMNS)
    );

    // A part of the frames and of the picture, by numbers in place of the configuration, in a tracker's frame.
    let numbers = text(&calibration()).trim().replace(' ', ",");
    let rest =
        format!("--calibration {numbers} --frames 2..9 --every 3 --crop 20,10,130,230 --threads 1");
    folder.works(&format!(
        "sweep sweep.igs.mha -o b.ply --to Tracker --space LPS {rest}"
    ));
    let ply = fs::read(at("b.ply")).unwrap();
    let head = String::from_utf8_lossy(&ply[..600]);
    for line in [
        "comment SPACE=LPS",
        "in the frame Tracker",
        "property float confidence",
        "property int line",
    ] {
        assert!(head.contains(line), "{head}");
    }
    let end = head.find("end_header\n").unwrap() + 11;
    let points = (ply.len() - end) / 48;
    assert!(
        head.contains(&format!("element vertex {points}\n"))
            && (ply.len() - end).is_multiple_of(48)
    );
    let number = |k: usize| f32::from_le_bytes(*ply[end + 4 * k..].first_chunk().unwrap());
    let first = [0, 1, 2].map(|k| f64::from(number(k)));
    let back = apply(&inverse(&reference()).unwrap(), first);
    assert!((length(from_axis(back)) - RADIUS).abs() < 1.0);

    folder.works(&format!("{common} -o c.vtp"));
    folder.works(&format!("{common} -o c.vtk"));
    folder.works(&format!("{common} -o c.mrk.json"));
    let vtk = fs::read_to_string(at("c.vtk")).unwrap();
    let vtk: Vec<&str> = vtk.lines().collect();
    // VTK 9.7.2 reads such a file; 3D Slicer takes the axes from its title (vtkMRMLModelStorageNode.cxx).
    assert_eq!(vtk[1], "bone, mm, SPACE=RAS");
    let count: usize = vtk[4].split(' ').nth(1).unwrap().parse().unwrap();
    assert_eq!(vtk[5 + count], format!("VERTICES {count} {}", 2 * count));
    assert_eq!(vtk.len(), 13 + 6 * count);
    let vtp = fs::read_to_string(at("c.vtp")).unwrap();
    assert!(vtp.contains("Name=\"SPACE\" NumberOfTuples=\"1\" format=\"ascii\">\n82\n65\n83\n0\n"));
    let markups: serde_json::Value =
        serde_json::from_slice(&fs::read(at("c.mrk.json")).unwrap()).unwrap();
    assert_eq!(markups["markups"][0]["coordinateSystem"], "RAS");
    let count = markups["markups"][0]["controlPoints"]
        .as_array()
        .unwrap()
        .len();
    assert!((500..=1000).contains(&count), "{count}");
}

#[test]
fn a_folder_of_pngs_gives_the_points_of_the_same_sweep() {
    let folder = folder();
    let pngs = folder.path().join("pngs");
    fs::create_dir(&pngs).unwrap();
    let mut table = "file,tx,ty,tz,qw,qx,qy,qz\n".to_owned();
    for k in 0..6 {
        let levels: Vec<f32> = picture(k, &image_to_reference(k))
            .into_iter()
            .map(f32::from)
            .collect();
        let picture = Array2::from_shape_vec((ROWS, COLUMNS), levels).unwrap();
        image::write(&picture, &pngs.join(format!("{k}.png"))).unwrap();
        let to_image = inverse(&calibration()).unwrap();
        let m = product(&image_to_reference(k), &to_image);
        let w = (1.0 + m[0][0] + m[1][1] + m[2][2]).sqrt() / 2.0;
        let [x, y, z] =
            [m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]].map(|v| v / (4.0 * w));
        let [tx, ty, tz] = [m[0][3], m[1][3], m[2][3]].map(|mm| mm / 1e3);
        table += &format!("{k}.png,{tx},{ty},{tz},{w},{x},{y},{z}\n");
    }
    folder.write("poses.csv", table);
    // The calibration in mm, with the pixel's size apart.
    let mut rigid = calibration();
    rigid
        .iter_mut()
        .take(3)
        .for_each(|row| row[..2].iter_mut().for_each(|value| *value /= PIXEL));
    folder.write("rigid.txt", text(&rigid));
    folder.works(
        "sweep pngs --pose-unit m --calibration rigid.txt --pixel-size 0.00015 -o a.csv --join 0",
    );
    folder.works("sweep sweep.igs.mha --calibration plus.xml --frames 0..6 -o b.csv --join 0");
    let [a, b] = ["a.csv", "b.csv"].map(|name| rows(&folder.path().join(name)));
    let a: Vec<_> = a
        .into_iter()
        .filter(|row| row[0] as usize != LOST)
        .collect();
    assert_eq!(a.len(), b.len());
    for (a, b) in a.iter().zip(&b) {
        assert_eq!(a[..2], b[..2]);
        assert!((2..5).all(|k| (a[k] - b[k]).abs() < 2e-4), "{a:?} {b:?}");
    }
}

#[test]
fn a_delay_is_taken_away_and_estimated_by_passes_over_the_same_bone() {
    // To and fro across the shaft, 5 mm in 24 frames; poses of 0.08 s later.
    let at = |k: f64| {
        let mut sideways = IDENTITY;
        sideways[0][3] = 5.0 / PIXEL * (k * std::f64::consts::TAU / 24.0).sin();
        product(&image_to_reference(12), &sideways)
    };
    let folder = folder_of(72, |k| at(k as f64), |k| at(k as f64 + 0.08 / 0.05));
    let common = "sweep sweep.igs.mha --calibration plus.xml --join 0 --min-confidence 0.3";
    let mean = |name: &str| {
        let rows = rows(&folder.path().join(name));
        let off = rows
            .iter()
            .map(|row| (length(from_axis([2, 3, 4].map(|k| row[k]))) - RADIUS).abs());
        off.sum::<f64>() / rows.len() as f64
    };
    folder.works(&format!("{common} -o late.csv"));
    folder.works(&format!("{common} --delay 0.08 -o known.csv"));
    let message = folder.ends(&format!("{common} --delay estimate -o found.csv"), 0, "");
    let [late, known, found] = ["late.csv", "known.csv", "found.csv"].map(mean);
    assert!(
        late > 0.5 && known < 0.15 && found < 0.15,
        "{late} {known} {found}"
    );
    let number = message.split("pictures are ").nth(1).expect(&message);
    let number: f64 = number.split(' ').next().unwrap().parse().unwrap();
    assert!((number - 0.08).abs() < 0.01, "{message}");
}

#[test]
fn a_killed_sweep_resumes_with_the_same_points() {
    let folder = folder();
    let text = |name: &str| fs::read(folder.path().join(name)).unwrap();
    let command = "sweep sweep.igs.mha --calibration plus.xml --threads 1 -o";
    folder.works(&format!("{command} whole.csv"));
    let names_before = names(folder.path());
    killed_at(&folder, &format!("{command} a.csv"), "a.csv", 10_000);
    let [message, _] = succeeded(&mut program(&folder, &format!("{command} a.csv")));
    assert!(message.contains("from an interrupted run"), "{message}");
    assert_eq!(text("a.csv"), text("whole.csv"));
    assert_eq!(names(folder.path()).len(), names_before.len() + 1);

    // Pictures that changed are searched again.
    fs::remove_file(folder.path().join("a.csv")).unwrap();
    killed_at(&folder, &format!("{command} a.csv"), "a.csv", 10_000);
    let mut bytes = text("sweep.igs.mha");
    let pixels = bytes.len() - FRAMES * ROWS * COLUMNS;
    bytes[pixels..].fill(20);
    folder.write("sweep.igs.mha", bytes);
    folder.ends(&format!("{command} a.csv"), 0, "belongs to another run");
    assert!(rows(&folder.path().join("a.csv")).is_empty());
}

#[test]
fn what_a_sweep_lacks_is_named() {
    let folder = folder();
    folder.write("short.mha", "ObjectType = Image\nNDims = 2\n");
    folder.write("mm.txt", "1 0 0 0 0 1 0 0 0 0 1 0");
    // Numbers of 0 to 1 are no grey levels.
    let header = "ObjectType = Image\nNDims = 3\nBinaryData = True\nCompressedData = False\nDimSize = 64 64 1\n\
                  ElementType = MET_FLOAT\nUltrasoundImageOrientation = MFA\nElementDataFile = LOCAL\n";
    let levels = (0..64 * 64).flat_map(|k| (k as f32 / 4096.0).to_le_bytes());
    let levels: Vec<u8> = header.bytes().chain(levels).collect();
    folder.write("levels.mha", levels);
    folder.ends(
        "surface levels.mha --pixel-size 0.0001 -o a.csv",
        1,
        "multiply by 255",
    );
    // Decibels are no grey levels: 0 is the brightest of them.
    let levels = (0..64 * 64).flat_map(|k| (-(k as f32) / 64.0).to_le_bytes());
    let levels: Vec<u8> = header.bytes().chain(levels).collect();
    folder.write("decibels.mha", levels);
    // Nothing but speckle, by a calibration whose first number is negative.
    let mut mirrored = calibration();
    (0..3).for_each(|row| mirrored[row][0] = -mirrored[row][0]);
    assert!(mirrored[0][0] < 0.0, "{mirrored:?}");
    let numbers = text(&mirrored).trim().replace(' ', ",");
    let speckle = format!("sweep sweep.igs.mha -o n.ply --crop 0,0,160,40 --calibration {numbers}");
    folder.ends(&speckle, 0, "no bone in any frame; the middle one: ");
    folder.write("p.csv", "x,y,z\n".to_owned() + &"1,2,3\n".repeat(8));
    folder.ends(
        "register p.csv sweep.igs.mha -o a.ply",
        1,
        "is a tracked sequence of pictures",
    );
    for row in REFUSED.lines() {
        let cells: Vec<&str> = row.split(" | ").collect();
        let [arguments, status, words] = cells[..] else {
            panic!("{row}")
        };
        let (found, message) = run(&folder, &format!("sweep {arguments}"));
        assert_eq!(found.to_string(), status, "{arguments}: {message}");
        assert!(
            message.contains(words) && message.lines().count() == 1,
            "{row}: {message}"
        );
        assert!(!folder.path().join("a.ply").exists());
    }
}

/// Arguments, exit status, words of the message.
const REFUSED: &str = "\
sweep.igs.mha -o a.ply | 1 | ImageToProbe by --calibration
sweep.igs.mha -o a.ply --calibration plus.xml --to Phantom | 1 | from Image to Phantom
sweep.igs.mha -o a.ply --calibration mm.txt | 1 | give --pixel-size
sweep.igs.mha -o a.ply --calibration 1,2 | 2 | 2 numbers
sweep.igs.mha -o a.ply --calibration none.xml | 1 | no such file
short.mha -o a.ply | 1 | no ElementDataFile
plus.xml -o a.ply | 1 | no tracked sequence
levels.mha -o a.ply --calibration ImageToReference=0.1,0,0,0,0,0.1,0,0,0,0,1,0,0,0,0,1 | 1 | multiply by 255
decibels.mha -o a.ply --calibration ImageToReference=0.1,0,0,0,0,0.1,0,0,0,0,1,0,0,0,0,1 | 1 | of decibels
sweep.igs.mha -o a.obj | 2 | .mrk.json
sweep.igs.mha -o a.ply --calibration plus.xml --crop 100,0,100,10 | 2 | beyond the 160 x 240
sweep.igs.mha -o a.ply --calibration plus.xml --frames 5 | 1 | no frame with a picture and a pose
sweep.igs.mha -o a.ply --calibration plus.xml --frames 30 | 2 | frames 0 to 23
sweep.igs.mha -o a.ply --calibration plus.xml --sweep-step 0.001 | 2 | --sweep-step
sweep.igs.mha -o a.ply --calibration plus.xml --join 3 | 2 | --join is 3
sweep.igs.mha -o a.ply --calibration plus.xml --delay soon | 2 | expected a time or estimate
sweep.igs.mha -o a.ply --calibration plus.xml --delay estimate | 1 | passes too seldom
sweep.igs.mha -o a.ply --calibration plus.xml --euler abc | 2 | xyz";

/// A recording of zea with poses of the probe: the points of its frames, at the poses of their middles.
#[test]
fn a_recording_with_poses_is_a_sweep() {
    let folder = tempdir().unwrap();
    let scanner = "--elements 32 --beams 16 --beam-step 2 --depth-start 0.012 --depth-end 0.03";
    folder.works(&format!(
        "simulate vertebra-3d --sweep 3 --sweep-step 0.0015 --thickness 0.003 --iq {scanner} -o s.npz"
    ));
    folder.works("convert s.npz -o s.hdf5");
    folder.works("surface s.npz -o s.csv");
    // A millisecond between transmits, a pose each 10 ms from -2 ms on; the third frame's middle is after the last.
    let (transmits, step, count) = (16, 1e-3, 4);
    // Of 0.3 rad about x, then a quarter about y.
    let [sin, cos] = [0.15f64.sin(), 0.15f64.cos()].map(|part| part / 2f64.sqrt());
    let q = [cos, sin, cos, -sin];
    let position = |k: f64| [0.01 + 0.002 * k, 0.03, -0.05 + 0.001 * k];
    let file = rust_hdf5::H5File::open_rw(folder.path().join("s.hdf5")).unwrap();
    let put = |name: &str, shape: &[usize], values: Vec<f64>| {
        let dataset = file.new_dataset::<f64>().shape(shape);
        dataset.create(name).unwrap().write_raw(&values).unwrap();
    };
    for name in ["metadata", "metadata/probe_pose"] {
        file.create_group(name).unwrap();
    }
    put(
        "tracks/track_0/scan/time_to_next_transmit",
        &[3, transmits],
        vec![step; 3 * transmits],
    );
    let poses = (0..count).map(|k| k as f64);
    put(
        "metadata/probe_pose/translation",
        &[count, 3],
        poses.clone().flat_map(position).collect(),
    );
    // A quaternion and its negative are one rotation.
    let signs = poses.flat_map(|k| q.map(|part| if k % 2.0 == 0.0 { part } else { -part }));
    put("metadata/probe_pose/rotation", &[count, 4], signs.collect());
    put("metadata/probe_pose/sampling_frequency", &[1], vec![100.0]);
    put("metadata/probe_pose/start_time_offset", &[1], vec![-2e-3]);
    file.write_vlen_strings(
        "metadata/probe_pose/rotation_representation",
        &["quaternion_wxyz"],
    )
    .unwrap();
    file.close().unwrap();
    let [info, _] = succeeded(&mut program(&folder, "info s.hdf5"));
    assert!(
        info.contains("of the probe in 2 of 3 frames, for `sweep`"),
        "{info}"
    );
    let sweep = "sweep s.hdf5 -o a.csv --join 0 --overlay frame.png";
    let [told, _] = succeeded(&mut program(&folder, sweep));
    assert!(
        told.contains("left out: 1 (ProbeToReference missing)"),
        "{told}"
    );
    let found = rows(&folder.path().join("a.csv"));
    let surface = fs::read_to_string(folder.path().join("s.csv")).unwrap();
    let surface: Vec<Vec<f64>> = surface
        .lines()
        .skip(1)
        .map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect())
        .filter(|row: &Vec<f64>| row[0] < 2.0)
        .collect();
    assert!(
        found.len() == surface.len() && found.len() > 10,
        "{} {}",
        found.len(),
        surface.len()
    );
    let turn = |[a, b, c]: [f64; 3]| apply(&pose([0.3, PI / 2.0, 0.0], [0.0; 3]), [a, b, c]);
    for (found, own) in found.iter().zip(&surface) {
        let middle = step * (own[0] * transmits as f64 + (transmits - 1) as f64 / 2.0);
        let from = position((middle + 2e-3) / 0.01);
        let at = turn([own[2], 0.0, own[3]]);
        for k in 0..3 {
            let expected = 1e3 * (from[k] + at[k]);
            assert!(
                (found[2 + k] - expected).abs() < 2e-3,
                "{found:?}, {own:?}: {expected}"
            );
        }
        // The sound came straight down.
        let down = turn([0.0, 0.0, own[3]]).map(|metres| 1e3 * metres);
        assert!(
            (0..3).all(|k| (found[8 + k] - down[k]).abs() < 2e-3),
            "{found:?}"
        );
    }
    folder.works("sweep s.hdf5 -o e.csv --join 0 --every 2");
    let every = rows(&folder.path().join("e.csv"));
    let first = found.iter().filter(|row| row[0] == 0.0);
    assert_eq!(every, first.copied().collect::<Vec<_>>());
    folder.ends("sweep s.npz -o b.csv", 1, "no tracked sequence");
    folder.ends(
        "sweep s.hdf5 -o b.csv --pixel-size 0.0001",
        2,
        "--pixel-size has no effect",
    );
}
