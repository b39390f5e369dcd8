//! The simulator in three dimensions.
//!
//! Spreading, directivity, the elevation beam, shadows of triangles, meshes, known levels, and runs that resume.

mod bones;
mod meshes;
mod scanner;

use crate::common::kit::*;
use bonebeam_simulate::{
    Baffle, Block, Bone, Checkpoint, CtScanner, CtVolume, DynamicRange, Layers, Phantom, Scatterer,
    Settings, Summation, Surface, VolumeGrid, ball, channel_data, isosurface, read_mesh,
    resumed_channel_data,
};
use ndarray::Axis;

/// One element transmits in each beam: row j of beam i is the pair (i, j).
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
    changed(pairs(), |s| {
        (s.element_height, s.elevation_focus) = (4e-3, Some(19e-3))
    })
}

fn point(x: f64, y: f64, z: f64) -> Phantom {
    Phantom {
        scatterers: vec![Scatterer::new([x, y, z], 1.0)],
        ..Phantom::default()
    }
}

/// The paper's CT, with a point spread of 0.8 mm.
const CT: CtScanner = CtScanner {
    voxel: [0.19e-3, 0.19e-3, 0.3e-3],
    blur: 0.8e-3,
    air: -1000.0,
};

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
        // Directly in front of the element its directivity is 1 at every frequency.
        let ratio = near / far * (10.0f64 / 25.0).powi(2);
        assert!((ratio - 1.0).abs() < 1e-4, "{ratio}");
    }
}

#[test]
fn directivity_is_that_of_a_patch_at_every_angle_and_frequency() {
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
    let settings = changed(with_lens(), |s| (s.elements, s.beams) = (2, 2));
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
        // A pulse has many frequencies: its beam's ripples are smoothed.
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
    let grid = VolumeGrid {
        corner: [-1.52e-3, -4.51e-3, 9.63e-3],
        step: [0.05e-3; 3],
        nodes: [62, 112, 16],
    };
    isosurface(&grid, box_distance)
}

#[test]
fn a_plates_shadow_ends_where_geometry_puts_it() {
    let settings = changed(pairs(), |s| {
        (s.elements, s.beams, s.first_beam) = (128, 1, 64.0)
    });
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
        // The straight line crosses the plate's lower and upper face at these positions.
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
fn bits_depend_neither_on_instruction_sets_nor_threads_nor_interruptions() {
    let settings = changed(with_lens(), |s| (s.noise, s.beams) = (Some(-50.0), 4));
    let mut phantom = point(0.1e-3, 0.4e-3, 12e-3);
    phantom.surface = Some(plate());
    let block = Block {
        x: [-3e-3, 3e-3],
        thickness: 4e-3,
        z: [11e-3, 16e-3],
        density: 4e9,
        seed: 5,
    };
    block.fill(&mut phantom, Layers::Anatomy, &|| ()).unwrap();
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
    // A run that is stopped in the middle leaves its file; the next resumes from it.
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
    // The file of another simulation is not used, and is reported.
    fs::write(&path, b"nothing").unwrap();
    assert!(run(set, &mut checkpoint()) == whole);
}
