//! The simulator in three dimensions: spreading, directivity, the elevation beam, shadows of triangles,
//! meshes, known levels, and runs that resume.

use crate::common;

use std::fs;
use std::path::Path;

use bonebeam::simd::InstructionSet;
use bonebeam_files::ChannelData;
use bonebeam_simulate::{
    Baffle, Block, Bone, Checkpoint, CtScanner, CtVolume, DynamicRange, Grid, Layers, Phantom,
    Scatterer, Settings, Summation, Surface, ball, channel_data, read_mesh, resumed_channel_data,
    zero_surface,
};
use common::tolerances;
use ndarray::Axis;

/// One element transmits in each beam: the record of beam i and element j is the pair's.
fn pairs() -> Settings {
    Settings {
        elements: 16,
        beams: 16,
        f_number: 1e4,
        depth_start: 8e-3,
        depth_end: 30e-3,
        ..Settings::default()
    }
}

fn with_lens() -> Settings {
    Settings {
        element_height: 4e-3,
        elevation_focus: Some(19e-3),
        ..pairs()
    }
}

fn point(x: f64, y: f64, z: f64) -> Phantom {
    Phantom {
        scatterers: vec![Scatterer {
            x,
            y,
            z,
            amplitude: 1.0,
        }],
        ..Phantom::default()
    }
}

fn simulate(settings: &Settings, phantom: &Phantom, summation: Summation) -> ChannelData {
    channel_data(settings, phantom, summation, &|_| ()).unwrap()
}

fn row_of(data: &ChannelData, beam: usize, element: usize) -> Vec<f32> {
    let rf = data.samples.rf(0).unwrap();
    rf.index_axis(Axis(0), beam).row(element).to_vec()
}

/// The root of the energy of a row.
fn strength(data: &ChannelData, beam: usize, element: usize) -> f64 {
    let row = row_of(data, beam, element);
    row.iter()
        .map(|&v| f64::from(v).powi(2))
        .sum::<f64>()
        .sqrt()
}

#[test]
fn an_echo_falls_with_the_square_of_its_distance() {
    let settings = pairs();
    let x = settings.array().x(8.0);
    for summation in [Summation::Direct, Summation::Cells] {
        let [near, far] = [10e-3, 25e-3]
            .map(|z| strength(&simulate(&settings, &point(x, 0.0, z), summation), 8, 8));
        // Right before the element its directivity is 1 at every frequency.
        let ratio = near / far * (10.0f64 / 25.0).powi(2);
        assert!((ratio - 1.0).abs() < 1e-4, "{ratio}");
    }
}

#[test]
fn directivity_is_that_of_a_strip_at_every_angle_and_frequency() {
    // The spectrum of one element's echo, there and back, against that on the axis: sinc² at each frequency.
    let depth = 12e-3;
    for baffle in [Baffle::Rigid, Baffle::Soft] {
        let settings = Settings { baffle, ..pairs() };
        let x = settings.array().x(8.0);
        for degrees in [20.0f64, 40.0, 60.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let level = |phantom: &Phantom, f: f64| {
                let data = simulate(&settings, phantom, Summation::Cells);
                let row = row_of(&data, 8, 8);
                let mut sum = [0.0f64; 2];
                for (n, &v) in row.iter().enumerate() {
                    let phase = std::f64::consts::TAU * f * n as f64 / settings.fs;
                    sum[0] += f64::from(v) * phase.cos();
                    sum[1] += f64::from(v) * phase.sin();
                }
                sum[0].hypot(sum[1])
            };
            let aside = point(x + depth * sin, 0.0, depth * cos);
            for f in [3.5e6, 5.0e6, 6.5e6] {
                let u = std::f64::consts::PI * 0.28e-3 * f * sin / settings.c;
                let expected = (u.sin() / u).powi(2)
                    * match baffle {
                        Baffle::Rigid => 1.0,
                        Baffle::Soft => cos * cos,
                    };
                let found = level(&aside, f) / level(&point(x, 0.0, depth), f);
                assert!(
                    (found - expected).abs() < tolerances::DIRECTIVITY,
                    "{degrees} {f}: {found} {expected}"
                );
            }
        }
    }
}

/// At the focus a lens of height h makes sinc²(h·f·y/(F·c)) there and back; its −6 dB width at the pulse's
/// middle frequency is 0.886·λF/h each way's −3 dB.
#[test]
fn the_elevation_beam_is_narrow_at_the_focus_and_wide_off_it() {
    let settings = Settings {
        elements: 2,
        beams: 2,
        ..with_lens()
    };
    let x = settings.array().x(0.0);
    let width = |z: f64| {
        let level = |y: f64| {
            strength(
                &simulate(&settings, &point(x, y, z), Summation::Cells),
                0,
                0,
            )
        };
        let whole = level(0.0);
        let (mut inside, mut outside) = (0.0, 6e-3);
        for _ in 0..12 {
            let middle = 0.5 * (inside + outside);
            *(if level(middle) > 0.5 * whole {
                &mut inside
            } else {
                &mut outside
            }) = middle;
        }
        inside + outside
    };
    let at_focus = width(19e-3);
    // The pulse's mean square frequency is near 4.87 MHz; sinc² = 1/2 at 0.443 of λF/h.
    let expected = 2.0 * 0.443 * 1540.0 / 4.87e6 * 19e-3 / 4e-3;
    assert!(
        (at_focus / expected - 1.0).abs() < 0.03,
        "{at_focus} {expected}"
    );
    // Off it, from Huygens' sum over the element at that frequency, there and back.
    let sum = |y: f64, z: f64| {
        let mut sum = [0.0f64; 2];
        for k in 0..400 {
            let strip = ((f64::from(k) + 0.5) / 400.0 - 0.5) * 4e-3;
            let path = z.hypot(y - strip) - strip.hypot(19e-3);
            let phase = std::f64::consts::TAU * 4.87e6 * path / 1540.0;
            sum = [sum[0] + phase.cos(), sum[1] + phase.sin()];
        }
        sum[0] * sum[0] + sum[1] * sum[1]
    };
    for z in [10e-3, 29e-3] {
        let edge = (1..6000).map(|k| f64::from(k) * 1e-6);
        let edge = edge
            .take_while(|&y| sum(y, z) > 0.5 * sum(0.0, z))
            .last()
            .unwrap();
        let found = width(z);
        // A pulse has not one frequency: its beam's ripples are smoothed.
        assert!(
            (found / (2.0 * edge) - 1.0).abs() < 0.1,
            "{z}: {found} {edge}"
        );
    }
}

/// A plate at 10 mm from x = −1 to 1 and y = −4 to 0.5 mm, 0.2 mm thick.
fn plate() -> Surface {
    let box_distance = |[x, y, z]: [f64; 3]| {
        let d = [
            x.abs() - 1e-3,
            (y + 1.75e-3).abs() - 2.25e-3,
            (z - 10e-3).abs() - 0.1e-3,
        ];
        d[0].max(d[1]).max(d[2])
    };
    let grid = Grid {
        corner: [-1.52e-3, -4.51e-3, 9.63e-3],
        step: [0.05e-3; 3],
        nodes: [62, 112, 16],
    };
    zero_surface(&grid, box_distance)
}

#[test]
fn a_plates_shadow_ends_where_geometry_puts_it() {
    let settings = Settings {
        elements: 128,
        beams: 1,
        first_beam: 64.0,
        ..pairs()
    };
    let heard = |x: f64, y: f64| {
        let mut phantom = point(x, y, 20e-3);
        phantom.surface = Some(plate());
        match channel_data(&settings, &phantom, Summation::Cells, &|_| ()) {
            Ok(data) => (0..128).map(|j| strength(&data, 0, j) > 0.0).collect(),
            Err(_) => vec![false; 128],
        }
    };
    let element_x = settings.array().element_x();
    // The transmitting element at 0.154 mm sees the point past the plate's side; the others each for itself.
    let x = 3.0e-3;
    for (element, heard) in heard(x, 0.0).into_iter().enumerate() {
        // The straight line crosses the plate's lower and upper face at these places.
        let crossings = [9.9e-3, 10.1e-3]
            .map(|z: f64| element_x[element] + (x - element_x[element]) * z / 20e-3);
        let hidden = crossings.iter().any(|x| x.abs() < 1e-3);
        let near = crossings.iter().any(|x| (x.abs() - 1e-3).abs() < 0.03e-3);
        assert!(near || heard != hidden, "element {element}: {crossings:?}");
    }
    // In elevation the plate ends at 0.5 mm at 10 mm of depth: 1.0 mm at 20 mm, as seen from y = 0.
    let all_hidden = |y: f64| !heard(0.0, y)[64];
    assert!(all_hidden(0.95e-3) && !all_hidden(1.05e-3));
}

#[test]
fn a_surface_from_a_function_is_closed_and_has_its_volume() {
    let sphere = |[x, y, z]: [f64; 3]| (x * x + y * y + (z - 10e-3).powi(2)).sqrt() - 3e-3;
    let grid = Grid {
        corner: [-3.5e-3, -3.5e-3, 6.5e-3],
        step: [0.1e-3; 3],
        nodes: [71, 71, 71],
    };
    let surface = zero_surface(&grid, sphere);
    let exact = 4.0 / 3.0 * std::f64::consts::PI * 27e-9;
    // Chords lie h²/8r inside: 0.04 % of the radius, three times that of the volume.
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

#[test]
fn bits_depend_neither_on_instruction_sets_nor_threads_nor_interruptions() {
    let settings = Settings {
        noise: Some(-50.0),
        beams: 4,
        ..with_lens()
    };
    let mut phantom = point(0.1e-3, 0.4e-3, 12e-3);
    phantom.surface = Some(plate());
    let block = Block {
        x: [-3e-3, 3e-3],
        thickness: 4e-3,
        z: [11e-3, 16e-3],
        density: 4e9,
        seed: 5,
    };
    block.fill(&mut phantom, Layers::Anatomy).unwrap();
    let run = |set: InstructionSet, checkpoint: &mut Checkpoint| {
        resumed_channel_data(
            &settings,
            &phantom,
            Summation::Cells,
            set,
            &|_| (),
            checkpoint,
        )
        .unwrap()
        .samples
    };
    let whole = run(InstructionSet::Scalar, &mut Checkpoint::none());
    for set in InstructionSet::available() {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(3)
            .build()
            .unwrap();
        let found = pool.install(|| run(set, &mut Checkpoint::none()));
        assert!(found == whole, "{}", set.name());
    }
    // A run that is stopped in the middle leaves its file; the next goes on from there.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("data.npz.partial");
    let checkpoint = || Checkpoint::new(&path, &settings, &phantom).unwrap();
    let stopped = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
        let stop = |done: f64| assert!(done < 0.45, "stopped");
        let set = InstructionSet::detect();
        let mut checkpoint = checkpoint().eager();
        resumed_channel_data(
            &settings,
            &phantom,
            Summation::Cells,
            set,
            &stop,
            &mut checkpoint,
        )
    }));
    assert!(stopped.is_err() && path.exists());
    let first = std::sync::Mutex::new(f64::INFINITY);
    let progress = |done: f64| {
        let mut first = first.lock().unwrap();
        if done > 0.0 {
            *first = first.min(done);
        }
    };
    let mut resumed = checkpoint();
    let set = InstructionSet::detect();
    let found = resumed_channel_data(
        &settings,
        &phantom,
        Summation::Cells,
        set,
        &progress,
        &mut resumed,
    );
    assert!(found.unwrap().samples == whole);
    assert!(*first.lock().unwrap() > 0.3, "it began anew");
    resumed.finish();
    assert!(!path.exists());
    // Of another simulation it is of no use, and is told.
    fs::write(&path, b"nothing").unwrap();
    assert!(run(set, &mut checkpoint()) == whole);
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
fn meshes_that_are_no_bone_are_told() {
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
    let (surface, doubts) = read_text("inverted.stl", &stl(1.0, &inverted)).unwrap();
    assert!(
        surface.volume() > 0.0 && doubts[0].contains("inside out"),
        "{doubts:?}"
    );
    let mut mixed = FACES;
    mixed[0].swap(0, 1);
    let (_, doubts) = read_text("mixed.stl", &stl(1.0, &mixed)).unwrap();
    assert!(
        doubts.iter().any(|d| d.contains("against each other")),
        "{doubts:?}"
    );
    let missing = read_mesh(Path::new("/nowhere/bone.stl"), 0.0).unwrap_err();
    assert!(missing.to_string().contains("/nowhere/bone.stl"));
}

#[test]
fn bones_of_a_volume_have_their_scatterers_and_their_outline() {
    for bone in [
        Bone::Vertebra {
            mesh: None,
            slice: -4e-3,
        },
        Bone::SpinousProcesses,
        Bone::Laminae,
        Bone::FacetJoint,
    ] {
        let (phantom, doubts) = bone.phantom(15e-3, 6e-3).unwrap();
        assert!(doubts.is_empty());
        let outline = phantom.bone.as_ref().expect("the plane cuts it");
        let all = &phantom.scatterers;
        assert!(
            phantom.on_bone == all.len() && all.len() > 50_000,
            "{bone:?}: {}",
            all.len()
        );
        assert!(all.iter().all(|s| s.y.abs() <= 3e-3 && s.z > 14.9e-3));
        // Those in the plane lie on the outline: as far as the surface bends within 0.01 mm.
        let plane = all.iter().filter(|s| s.y.abs() < 0.01e-3);
        for s in plane.step_by(29) {
            assert!(
                outline.signed_distance(s.x, s.z).abs() < 0.2e-3,
                "{bone:?} {s:?}"
            );
        }
        // Tissue keeps out of the bone.
        let mut filled = phantom.clone();
        let block = Block {
            x: [-15e-3, 15e-3],
            thickness: 2e-6,
            z: [12e-3, 37e-3],
            density: 5e12,
            seed: 2,
        };
        block.fill(&mut filled, Layers::Uniform).unwrap();
        let tissue = &filled.scatterers[phantom.on_bone..];
        assert!(tissue.len() > 1000);
        for s in tissue {
            assert!(
                outline.signed_distance(s.x, s.z) < 0.15e-3,
                "{bone:?} {s:?}"
            );
        }
        assert!(tissue.iter().any(|s| s.z > 30e-3));
    }
}

#[test]
fn the_density_of_scatterers_on_bone_is_the_papers() {
    let (phantom, _) = Bone::Vertebra {
        mesh: None,
        slice: 0.0,
    }
    .phantom(15e-3, 6e-3)
    .unwrap();
    let surface = phantom.surface.as_ref().unwrap();
    let within = surface
        .corners()
        .filter(|t| t.iter().all(|v| v[1].abs() <= 2e-3 && v[0].abs() <= 20e-3));
    let area: f64 = within
        .map(|[a, b, c]| {
            let (p, q) = (
                [0, 1, 2].map(|k| b[k] - a[k]),
                [0, 1, 2].map(|k| c[k] - a[k]),
            );
            let n = [
                p[1] * q[2] - p[2] * q[1],
                p[2] * q[0] - p[0] * q[2],
                p[0] * q[1] - p[1] * q[0],
            ];
            0.5 * n.iter().map(|v| v * v).sum::<f64>().sqrt()
        })
        .sum();
    let count = phantom
        .scatterers
        .iter()
        .filter(|s| s.y.abs() <= 2e-3 && s.x.abs() <= 20e-3)
        .count();
    // Triangles across the rim are not counted: one of eleven rows of 0.35 mm at the most.
    let density = count as f64 / area * 1e-6;
    assert!((200.0..225.0).contains(&density), "{density} per mm²");
}

#[test]
fn levels_are_those_of_the_phantom() {
    let block = Block {
        x: [-20e-3, 20e-3],
        thickness: 2e-3,
        z: [1e-3, 46e-3],
        density: 20e9,
        seed: 1,
    };
    let phantom = DynamicRange::phantom(&block).unwrap();
    let mean = |x: [f64; 2], z: [f64; 2]| {
        let within = |s: &&Scatterer| (x[0]..x[1]).contains(&s.x) && (z[0]..z[1]).contains(&s.z);
        let found: Vec<f64> = phantom
            .scatterers
            .iter()
            .filter(within)
            .map(|s| s.amplitude)
            .collect();
        20.0 * (found.iter().sum::<f64>() / found.len() as f64).log10()
    };
    assert!((mean([3e-3, 4e-3], [12e-3, 15e-3]) + 20.0).abs() < 1e-9);
    assert!((mean([7e-3, 9e-3], [29e-3, 31e-3]) + 10.0).abs() < 1e-9);
    // 1 mm of the lateral gradient holds 1.4 dB.
    assert!((mean([-0.5e-3, 0.5e-3], [39e-3, 44e-3]) + 25.0).abs() < 0.3);
    assert!(mean([-4e-3, -2e-3], [18e-3, 20e-3]).is_nan());
    assert_eq!(DynamicRange::level(8e-3, 19e-3), -40.0);
}

#[test]
fn reverberation_shows_the_bone_at_twice_its_depth_and_clutter_in_its_shadow() {
    let settings = Settings {
        depth_end: 26e-3,
        beams: 1,
        first_beam: 8.0,
        ..pairs()
    };
    let mut phantom = point(settings.array().x(8.0), 0.0, 10.2e-3);
    phantom.surface = Some(plate());
    let silent = channel_data(&settings, &phantom, Summation::Cells, &|_| ());
    assert!(silent.is_err(), "behind the plate");
    phantom.clutter = phantom.scatterers.clone();
    let heard = simulate(&settings, &phantom, Summation::Cells);
    assert!(strength(&heard, 0, 8) > 0.0);
    phantom.clutter.clear();
    phantom.scatterers[0].z = 9.9e-3;
    phantom.on_bone = 1;
    phantom.reverberation = 0.25;
    let data = simulate(&settings, &phantom, Summation::Cells);
    let row = row_of(&data, 0, 8);
    let peak = |z: f64| {
        let n = ((2.0 * z / settings.c - data.t0[0]) * settings.fs).round() as usize;
        row.iter()
            .skip(n - 30)
            .take(60)
            .fold(0.0f32, |m, v| m.max(v.abs()))
    };
    // A quarter, and a quarter again by the distance.
    let ratio = f64::from(peak(19.8e-3) / peak(9.9e-3));
    assert!((ratio * 16.0 - 1.0).abs() < 0.02, "{ratio}");
}

/// The paper's CT, with a point spread of 0.8 mm.
const CT: CtScanner = CtScanner {
    voxel: [0.19e-3, 0.19e-3, 0.3e-3],
    blur: 0.8e-3,
    air: -1000.0,
};

/// Standard deviation of the point spread along an axis, with the mean over a voxel, mm.
fn blurred(axis: usize) -> f64 {
    let voxel = 1e3 * CT.voxel[axis];
    let sigma = 1e3 * CT.sigma();
    (sigma * sigma + voxel * voxel / 12.0).sqrt()
}

#[test]
fn a_threshold_below_the_middle_of_a_blurred_step_lies_outside_it() {
    let distance = |p: [f64; 3]| p.map(|v| v.abs() - 4e-3).into_iter().fold(-1.0, f64::max);
    let grid = Grid {
        corner: [-4.51e-3; 3],
        step: [0.22e-3; 3],
        nodes: [42; 3],
    };
    let cube = zero_surface(&grid, distance);
    let scan = CtVolume::scan(&[(&cube, 1200.0)], &CT).unwrap();
    // −524 HU is 0.2164 of the step: 0.7846 standard deviations outside. 100 HU is its middle.
    for (level, sigmas) in [(-524.0, 0.7846), (100.0, 0.0)] {
        let surface = scan.surface(level);
        for axis in 0..3 {
            let near =
                |v: &&[f64; 3]| (0..3).all(|k| k == axis || v[k].abs() < 2e-3) && v[axis] > 2e-3;
            let face: Vec<f64> = (surface.vertices().iter().filter(near))
                .map(|v| 1e3 * v[axis])
                .collect();
            assert!(face.len() > 100);
            let expected = 4.0 + sigmas * blurred(axis);
            for found in face {
                // Between voxels the step is taken for straight: that costs h²/8 times its bend, which is
                // sigmas/σ, and about h³/σ²/30 where the bend changes. A micrometre is rounding to 1 HU.
                let (h, sigma) = (1e3 * CT.voxel[axis], blurred(axis));
                let bend = h * h / 8.0 * sigmas / sigma + h.powi(3) / (sigma * sigma) / 25.0;
                // Across x a face along the voxels is known to half the distance of five lines.
                let lines = if axis == 0 { 0.0 } else { h / 10.0 };
                assert!(
                    (found - expected).abs() < 1.1 * bend + lines + 1e-3,
                    "{level} HU, axis {axis}: {found}, not {expected}"
                );
            }
        }
    }
}

#[test]
fn a_scanned_ball_has_the_radius_that_its_blur_leaves() {
    // Of a ball in a Gaussian blur, by radius: ½(erf((R−r)/√2σ) + erf((R+r)/√2σ)) − (σ/r√2π)·(e^… − e^…).
    let (radius, sigma) = (1.0, 1e3 * CT.sigma());
    let phi = |x: f64| 0.5 * libm::erf(x / 2f64.sqrt());
    let bell = |x: f64| (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt();
    let share = |r: f64| {
        let (near, far) = ((radius - r) / sigma, (radius + r) / sigma);
        phi(near) + phi(far) - sigma / r * (bell(near) - bell(far))
    };
    let (mut low, mut high) = (0.1, 2.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        match share(middle) > 476.0 / 1100.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    let scanner = CtScanner {
        voxel: [0.1e-3; 3],
        ..CT
    };
    let centre = [3.017e-3, -1.01e-3, 20.04e-3];
    let ball = bonebeam_simulate::ball(centre, 1e-3);
    let scan = CtVolume::scan(&[(&ball, 100.0)], &scanner).unwrap();
    let surface = scan.surface(-524.0);
    let radii = surface.vertices().iter().map(|v| {
        let d: f64 = (0..3).map(|k| (v[k] - centre[k]).powi(2)).sum();
        1e3 * d.sqrt()
    });
    let (mut sum, mut count) = (0.0, 0.0);
    for r in radii {
        // The ball's chords and the voxels' means: a hundredth of the radius.
        assert!((r - low).abs() < 0.01, "{r}, not {low}");
        (sum, count) = (sum + r, count + 1.0);
    }
    assert!(
        (sum / count - low).abs() < 0.005,
        "{}, not {low}",
        sum / count
    );
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
