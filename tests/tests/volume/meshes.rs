//! Surfaces: files, functions, solids.

use super::*;

#[test]
fn a_surface_from_a_function_is_closed_and_has_its_volume() {
    let sphere = |[x, y, z]: [f64; 3]| (x * x + y * y + (z - 10e-3).powi(2)).sqrt() - 3e-3;
    let grid = VolumeGrid {
        corner: [-3.5e-3, -3.5e-3, 6.5e-3],
        step: [0.1e-3; 3],
        nodes: [71, 71, 71],
    };
    let surface = isosurface(&grid, sphere);
    let exact = 4.0 / 3.0 * std::f64::consts::PI * 27e-9;
    // Chords are h²/8r inside: 0.04 % of the radius, three times that of the volume.
    assert!(
        (surface.volume() / exact - 1.0).abs() < 2e-3,
        "{}",
        surface.volume()
    );
    for v in surface.vertices() {
        let r = sphere(*v).abs();
        // A corner lies on an edge of up to 0.17 mm, from which the sphere bends by l²/8r.
        assert!(r < 1.3e-6, "{r}");
    }
    let mut edges = std::collections::BTreeMap::new();
    for t in surface.triangles() {
        for k in 0..3 {
            *edges.entry((t[k], t[(k + 1) % 3])).or_insert(0) += 1;
        }
    }
    assert!(
        edges
            .iter()
            .all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1))
    );
}

fn read_text(name: &str, text: &str) -> bonebeam_files::Result<(Surface, Vec<String>)> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    read_mesh(&path, 1e-3)
}

/// A tetrahedron of 6 mm edges along the axes, as corners of its faces, seen from outside anticlockwise.
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

const CORNERS: [[f64; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [6.0, 0.0, 0.0],
    [0.0, 6.0, 0.0],
    [0.0, 0.0, 6.0],
];

fn stl(scale: f64, faces: &[[usize; 3]]) -> String {
    let mut text = String::from("solid bone\n");
    for face in faces {
        text += "facet normal 0 0 0\nouter loop\n";
        for corner in face {
            let [x, y, z] = CORNERS[*corner].map(|v| v * scale);
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid bone\n"
}

#[test]
fn stl_and_obj_have_the_same_surface_as_ply() {
    let mut obj = String::new();
    let mut ply = String::from(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
         element face 4\nproperty list uchar int vertex_indices\nend_header\n",
    );
    for [x, y, z] in CORNERS {
        obj += &format!("v {x} {y} {z}\n");
        ply += &format!("{x} {y} {z}\n");
    }
    for [a, b, c] in FACES {
        obj += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
        ply += &format!("3 {a} {b} {c}\n");
    }
    let [(a, none), (b, _), (c, _)] = [
        read_text("bone.stl", &stl(1.0, &FACES)),
        read_text("bone.obj", &obj),
        read_text("bone.ply", &ply),
    ]
    .map(Result::unwrap);
    assert!(none.is_empty());
    // 36 mm³, the height 1 mm at elevation 0, the mesh's x as depth.
    for surface in [&a, &b, &c] {
        assert!((surface.volume() - 36e-9).abs() < 1e-15);
        let mut corners: Vec<_> = surface.vertices().to_vec();
        corners.sort_by(|p, q| p.partial_cmp(q).unwrap());
        let expected = [
            [0.0, -1e-3, 0.0],
            [0.0, -1e-3, 6e-3],
            [0.0, 5e-3, 0.0],
            [6e-3, -1e-3, 0.0],
        ];
        for (found, expected) in corners.iter().zip(expected) {
            assert!(
                (0..3).all(|k| (found[k] - expected[k]).abs() < 1e-9),
                "{found:?}"
            );
        }
    }
}

#[test]
fn meshes_that_are_no_bone_are_reported() {
    let fails = |name: &str, text: &str| {
        let message = read_text(name, text).expect_err(name).to_string();
        assert!(!message.contains('\n'), "{message}");
        message
    };
    assert!(fails("open.stl", &stl(1.0, &FACES[1..])).contains("open: 3 edges"));
    assert!(fails("metres.stl", &stl(1e-3, &FACES)).contains("metres"));
    assert!(fails("empty.stl", &stl(1.0, &[])).contains("triangles"));
    assert!(fails("empty.obj", "# nothing\n").contains("triangles"));
    assert!(fails("wrong.obj", "v 0 0 0\nf 1 2 9\n").contains("wrong.obj"));
    assert!(fails("far.stl", &stl(1e3, &FACES)).contains("1000 mm"));
    let inverted = FACES.map(|[a, b, c]| [a, c, b]);
    let (surface, warnings) = read_text("inverted.stl", &stl(1.0, &inverted)).unwrap();
    assert!(
        surface.volume() > 0.0 && warnings[0].contains("inside out"),
        "{warnings:?}"
    );
    let mut mixed = FACES;
    mixed[0].swap(0, 1);
    let (_, warnings) = read_text("mixed.stl", &stl(1.0, &mixed)).unwrap();
    assert!(
        warnings.iter().any(|d| d.contains("opposite winding")),
        "{warnings:?}"
    );
    let missing = read_mesh(Path::new("/nowhere/bone.stl"), 0.0).unwrap_err();
    assert!(missing.to_string().contains("/nowhere/bone.stl"));
}

#[test]
fn parts_that_overlap_in_one_surface_are_one_solid() {
    let joined = ball([0.0; 3], 1e-3).joined(&ball([0.8e-3, 0.0, 0.0], 1e-3));
    let sharp = CtScanner { blur: 0.0, ..CT };
    let scan = CtVolume::scan(&[(&joined, 1200.0)], &sharp).unwrap();
    let most = scan.hu.iter().max().unwrap();
    assert_eq!(*most, 1200);
    // Two balls of 1 mm at 0.8 mm, less the lens: 2·4π/3 − π(4 + 0.8)(2 − 0.8)²/12, mm³. The surfaces' chords
    // and the lines through the voxels each take a hundredth at the most.
    let lens = std::f64::consts::PI * 4.8 * 1.2f64.powi(2) / 12.0;
    let exact = 8.0 / 3.0 * std::f64::consts::PI - lens;
    let voxel: f64 = CT.voxel.iter().map(|v| 1e3 * v).product();
    let sum: f64 = scan
        .hu
        .iter()
        .map(|&hu| (f64::from(hu) + 1000.0) / 2200.0)
        .sum();
    assert!((sum * voxel / exact - 1.0).abs() < 0.02, "{}", sum * voxel);
}

#[test]
fn the_shallowest_point_of_a_ball_has_its_normal() {
    let ball = bonebeam_simulate::ball([1e-3, 2e-3, 20e-3], 5e-3);
    let (point, normal) = ball.shallowest(4e-3, 2e-3).unwrap();
    assert!((point[2] - 16e-3).abs() < 0.05e-3, "{point:?}");
    for (found, expected) in normal.into_iter().zip([0.6, 0.0, -0.8]) {
        assert!((found - expected).abs() < 0.1, "{normal:?}");
    }
    assert!(ball.shallowest(6.5e-3, 2e-3).is_none());
}
