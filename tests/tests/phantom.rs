//! The vertebra, built in or from a mesh: its anatomy, its geometry, and bad files.

use crate::common::kit::*;
use bonebeam_drive::image::PixelGrid;
use bonebeam_simulate::{Outline, Phantom, Tissue, slice_mesh, slice_vertebra, visible};

/// The built-in vertebra as it is imaged: its shallowest point at 15 mm.
fn vertebra(slice: f64) -> Outline {
    slice_vertebra(slice).unwrap().at_depth(15e-3).unwrap()
}

/// Depth of the first bone on a vertical line at `x`, by steps of 10 µm.
fn surface(outline: &Outline, x: f64) -> f64 {
    let hit = (0..10_000)
        .map(|k| f64::from(k) * 10e-6)
        .find(|&z| outline.signed_distance(x, z) >= 0.0);
    hit.expect("bone below")
}

#[test]
fn vertebra_has_its_landmarks() {
    let bone = vertebra(-4e-3);
    // Seen from behind: the spinous process in the middle at 15 mm, laminae and articular
    // processes beside it at 23 to 32 mm as in the paper's Fig. 3, hollows between them.
    assert!((surface(&bone, 0.0) - 15e-3).abs() < 0.05e-3);
    for x in [-14e-3, -10e-3, -6e-3, 6e-3, 10e-3, 14e-3] {
        let depth = surface(&bone, x);
        assert!((23e-3..32e-3).contains(&depth), "{x}: {depth}");
    }
    assert!(surface(&bone, 6e-3) > surface(&bone, 12e-3));
    // The body lies in front of the open foramen.
    assert!(bone.signed_distance(0.0, 42e-3) < 0.0 && bone.signed_distance(0.0, 65e-3) > 10e-3);
    // Left and right alike.
    for (x, z) in [(3e-3, 20e-3), (11e-3, 24e-3), (20e-3, 60e-3)] {
        assert!((bone.signed_distance(x, z) - bone.signed_distance(-x, z)).abs() < 1e-6);
    }
}

#[test]
fn vertebral_canal_is_open_and_can_be_closed() {
    let bone = vertebra(3e-3);
    let canal = (0.0, 15e-3 + 22e-3);
    assert!(bone.signed_distance(canal.0, canal.1) < -4e-3);
    let outer = bone.without_holes().unwrap();
    assert!(outer.signed_distance(canal.0, canal.1) > 4e-3);
    // Transverse processes to both sides, and none in a lower slice.
    let reach = |outline: &Outline| {
        let x = outline.loops().iter().flatten().map(|p| p[0]);
        x.fold(0.0, f64::max)
    };
    assert!(reach(&bone) > 30e-3 && reach(&vertebra(-10e-3)) < 25e-3);
}

#[test]
fn slices_outside_the_vertebra_are_refused() {
    for slice in [0.1, -0.1] {
        let message = slice_vertebra(slice).unwrap_err().to_string();
        assert!(message.contains("slice"), "{message}");
    }
}

#[test]
fn scatterers_lie_on_the_surface_and_only_its_back_is_seen() {
    let smooth = vertebra(-4e-3);
    let phantom = Phantom::bone(&smooth).unwrap();
    let surface = phantom.bone.as_ref().unwrap();
    let element_x: Vec<f64> = (0..128).map(|k| (f64::from(k) - 63.5) * 0.308e-3).collect();
    let points: Vec<[f64; 2]> = phantom.scatterers.iter().map(|s| [s.x, s.z]).collect();
    for p in points.iter().step_by(37) {
        assert!(surface.signed_distance(p[0], p[1]).abs() < 1e-9);
        // Roughness of 10 µm: six standard deviations, and the chord of a 0.19 mm facet.
        assert!(smooth.signed_distance(p[0], p[1]).abs() < 65e-6);
    }
    let seen = visible(surface, &element_x, &points);
    let anyone = |k: usize| seen.iter().any(|element| element[k]);
    for (k, p) in points.iter().enumerate() {
        if p[1] > 45e-3 && p[0].abs() < 10e-3 {
            assert!(!anyone(k), "the body is in the shadow: {p:?}");
        }
        if p[1] < 16e-3 {
            assert!(anyone(k), "the tip is seen: {p:?}");
        }
    }
    // From the far left the right flank of the spinous process is dark, and the other way round.
    let points = &points;
    let flank = |side: f64| {
        (0..points.len()).filter(move |&k| {
            let p = points[k];
            p[0] * side > 2e-3 && p[0] * side < 4e-3 && p[1] > 17e-3 && p[1] < 20e-3
        })
    };
    assert!(flank(1.0).count() > 100);
    assert!(flank(1.0).all(|k| !seen[0][k]) && flank(-1.0).all(|k| !seen[127][k]));
    assert!(flank(1.0).any(|k| seen[127][k]) && flank(-1.0).any(|k| seen[0][k]));
}

#[test]
fn tissue_fills_its_rectangle_but_not_the_bone() {
    let tissue = changed(Tissue::default(), |s| s.density = 10e6);
    let bone = Phantom::vertebra(-4e-3, 15e-3).unwrap();
    let on_bone = bone.scatterers.len();
    let phantom = bone.clone().with_tissue(&tissue);
    let added = &phantom.scatterers[on_bone..];
    let outline = phantom.bone.as_ref().unwrap();
    for s in added {
        assert!(s.x.abs() <= 15e-3 && (12e-3..=37e-3).contains(&s.z));
        assert!(outline.signed_distance(s.x, s.z) < 0.0);
    }
    // The share of the rectangle that is not bone, on a grid; four standard deviations of a
    // count of some 5000.
    let map = outline.distance_map(&PixelGrid::new([-15e-3, 12e-3], 0.1e-3, [251, 301]));
    let outside = map.iter().filter(|&&s| s < 0.0).count() as f64 / map.len() as f64;
    let expected = outside * 10e6 * 30e-3 * 25e-3;
    assert!((added.len() as f64 - expected).abs() < 4.0 * expected.sqrt() + 0.01 * expected);
    assert_eq!(bone.with_tissue(&tissue), phantom);
}

/// A box from (0, −1, 0) to (4, 3, 2) mm in the mesh's axes, as text.
fn box_ply(faces: &str) -> String {
    let count = faces.lines().count();
    format!(
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\n\
         property float z\nelement face {count}\nproperty list uchar int vertex_indices\n\
         end_header\n0 -1 0\n4 -1 0\n4 3 0\n0 3 0\n0 -1 2\n4 -1 2\n4 3 2\n0 3 2\n{faces}\n"
    )
}

/// Four walls of quadrilaterals, a floor and a lid.
const BOX: &str = "4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n4 3 2 1 0\n4 4 5 6 7";

fn slice_text(text: &str, slice: f64) -> bonebeam_files::Result<Outline> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("box.ply");
    fs::write(&path, text).unwrap();
    slice_mesh(&path, slice)
}

#[test]
fn mesh_slice_has_the_boxs_distances_with_its_back_up() {
    let outline = slice_text(&box_ply(BOX), 0.7e-3).unwrap();
    assert_eq!(outline.loops().len(), 1);
    // The mesh's x of 0 to 4 is depth, its y of −1 to 3 is lateral; floats of some mm.
    for (x, z, expected) in [
        (1e-3, 2e-3, 2e-3),
        (0.0, 0.5e-3, 0.5e-3),
        (2.5e-3, -1e-3, -1e-3),
        (-2e-3, 2e-3, -1e-3),
        (5e-3, 2e-3, -2e-3),
    ] {
        let found = outline.signed_distance(x, z);
        assert!((found - expected).abs() < 1e-9, "({x}, {z}): {found}");
    }
    let placed = outline.at_depth(15e-3).unwrap();
    assert!((placed.signed_distance(0.0, 15.5e-3) - 0.5e-3).abs() < 1e-9);
    // A slice through the vertices of the lid's plane is no special case of one below it.
    assert!(slice_text(&box_ply(BOX), 2e-3).is_ok());
}

#[test]
fn binary_mesh_reads_like_text() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("box.ply");
    let text = box_ply(BOX);
    let (head, _) = text.split_once("end_header\n").unwrap();
    let mut bytes = head.replace("ascii", "binary_little_endian").into_bytes();
    bytes.extend(b"end_header\n");
    let mut lines = text
        .lines()
        .skip_while(|line| *line != "end_header")
        .skip(1);
    for vertex in lines.by_ref().take(8) {
        for v in vertex.split(' ') {
            bytes.extend(v.parse::<f32>().unwrap().to_le_bytes());
        }
    }
    for face in lines {
        for (k, v) in face.split(' ').enumerate() {
            if k == 0 {
                bytes.push(v.parse().unwrap());
            } else {
                bytes.extend(v.parse::<i32>().unwrap().to_le_bytes());
            }
        }
    }
    fs::write(&path, &bytes).unwrap();
    let binary = slice_mesh(&path, 0.7e-3).unwrap();
    assert_eq!(binary, slice_text(&text, 0.7e-3).unwrap());
    // A truncated file, or a vertex that does not exist, is an error with the file and the vertex.
    let fails = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        slice_mesh(&path, 0.7e-3).unwrap_err().to_string()
    };
    let message = fails(&bytes[..bytes.len() - 20]);
    assert!(
        message.contains("box.ply") && !message.contains('\n'),
        "{message}"
    );
    let second = bytes.len() - 6 * 17 - 7 * 12;
    bytes[second..second + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    let message = fails(&bytes);
    assert!(message.contains("vertex 1: x"), "{message}");
}

/// Properties and elements other than the mesh's, in every type and byte order.
#[test]
fn what_a_mesh_does_not_need_is_skipped() {
    const HEAD: &str = "element vertex 8\nproperty uchar red\nproperty double x\nproperty list ushort short pair\n\
        property float y\nproperty float z\nproperty uint16 last\nelement edge 1\nproperty int32 a\n\
        property int8 b\nelement face 6\nproperty char group\nproperty list uint uint vertex_index\n";
    let corners = box_ply(BOX);
    let corners = corners.lines().skip_while(|line| *line != "end_header");
    let vertices = corners.skip(1).take(8).map(|line| {
        let [x, y, z] = [0, 1, 2].map(|k| line.split(' ').nth(k).unwrap());
        format!("u1:255 f8:{x} u2:2 i2:-7 i2:300 f4:{y} f4:{z} u2:65535")
    });
    let faces = BOX.lines().map(|line| {
        let corners = line.replace(' ', " u4:");
        format!("i1:-1 u4:{corners}")
    });
    let rows: Vec<String> = vertices
        .chain(["i4:-100000 i1:-128".into()])
        .chain(faces)
        .collect();
    let expected = slice_text(&box_ply(BOX), 0.7e-3).unwrap();
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        let mut file =
            format!("ply\r\nformat {format} 1.0\r\ncomment of a test\n{HEAD}end_header\n")
                .into_bytes();
        for (kind, value) in rows
            .iter()
            .flat_map(|row| row.split(' '))
            .map(|word| word.split_once(':').unwrap())
        {
            let mut bytes = match kind {
                "f8" => value.parse::<f64>().unwrap().to_le_bytes().to_vec(),
                "f4" => value.parse::<f32>().unwrap().to_le_bytes().to_vec(),
                _ => {
                    let size = usize::from(kind.as_bytes()[1] - b'0');
                    value.parse::<i64>().unwrap().to_le_bytes()[..size].to_vec()
                }
            };
            match format {
                "ascii" => bytes = format!("{value} \n").into_bytes(),
                "binary_big_endian" => bytes.reverse(),
                _ => {}
            }
            file.extend(bytes);
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("box.ply");
        fs::write(&path, &file).unwrap();
        assert_eq!(slice_mesh(&path, 0.7e-3).unwrap(), expected, "{format}");
    }
}

#[test]
fn unusable_meshes_are_named() {
    let without_a_wall: String = BOX.lines().skip(1).collect::<Vec<_>>().join("\n");
    let beyond = BOX.replace("4 0 1 5 4", "4 0 1 5 9");
    for (text, name) in [
        (box_ply(&without_a_wall), "closed"),
        (box_ply(&beyond), "vertex 9 of 8"),
        (box_ply(BOX).replace("0 -1 0\n", "nan -1 0\n"), "PLY"),
        (
            box_ply(BOX).replace("property float y", "property float w"),
            "needs y",
        ),
        (box_ply(BOX).replace("element face", "element edge"), "face"),
        ("not a mesh".to_string(), "PLY"),
        (String::new(), "PLY"),
    ] {
        let message = slice_text(&text, 0.7e-3).unwrap_err().to_string();
        assert!(
            message.contains(name) && !message.contains('\n'),
            "{name}: {message}"
        );
    }
    let message = slice_text(&box_ply(BOX), 5e-3).unwrap_err().to_string();
    assert!(
        message.contains("5 mm") && message.contains("0 to 2 mm"),
        "{message}"
    );
    let message = slice_mesh(Path::new("/nowhere/bone.ply"), 0.0)
        .unwrap_err()
        .to_string();
    assert!(message.contains("/nowhere/bone.ply"), "{message}");
}

#[test]
fn a_beam_meets_a_circle_where_geometry_puts_it() {
    let n = 2000;
    let point = |k: usize| {
        let angle = std::f64::consts::TAU * k as f64 / n as f64;
        [5e-3 * angle.sin(), 20e-3 + 5e-3 * angle.cos()]
    };
    let circle = Outline::new(vec![(0..n).map(point).collect()]).unwrap();
    for x in [-4.2e-3f64, -1e-3, 0.0, 3.3e-3] {
        let expected = 20e-3 - (25e-6 - x * x).sqrt();
        // The chords of 2000 corners lie within 6 nm of the circle; steeper there, twice as much in depth.
        let found = circle.first_hit(x).unwrap();
        assert!((found - expected).abs() < 15e-9, "{x}: {found} {expected}");
    }
    assert_eq!(circle.first_hit(5.1e-3), None);
}
