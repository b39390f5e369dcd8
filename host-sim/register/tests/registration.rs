//! Registration of simulated sweeps over a vertebra and a shaft, whose pose is known.

use bonebeam_register::{
    Bone, Cloud, Kind, Parameters, Registration, Rigid, Statistics, Stretch, V3, register,
    target_error,
};
use bonebeam_simulate::{Surface, VolumeGrid, isosurface};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

fn norm(v: V3) -> f64 {
    v.iter().map(|v| v * v).sum::<f64>().sqrt()
}

/// Signed distance to a rod between two points, mm.
fn rod(p: V3, from: V3, to: V3, radius: f64) -> f64 {
    let of = |k: usize| to[k] - from[k];
    let axis = [of(0), of(1), of(2)];
    let along: f64 = (0..3).map(|k| axis[k] * (p[k] - from[k])).sum();
    let at = (along / axis.iter().map(|v| v * v).sum::<f64>()).clamp(0.0, 1.0);
    norm([0, 1, 2].map(|k| p[k] - from[k] - at * axis[k])) - radius
}

/// About the signed distance to a vertebra: x to the left, y to the back, z to the head, mm.
fn vertebra(p: V3) -> f64 {
    let [x, y, z] = p;
    let round = (x / 1.35).hypot(y + 32.0) - 16.0 + 0.02 * z * z;
    let body = round.max(z.abs() - 13.0);
    let mut parts = vec![body, rod(p, [0.0, 14.0, -3.0], [0.0, 34.0, -8.0], 3.4)];
    for side in [-1.0, 1.0] {
        let at = |x: f64, y: f64, z: f64| [side * x, y, z];
        parts.extend([
            // Pedicle, lamina, transverse process and both articular processes.
            rod(p, at(11.0, -20.0, 4.0), at(13.0, 0.0, 3.0), 4.0),
            rod(p, at(13.0, 0.0, 3.0), at(0.0, 14.0, -4.0), 3.5),
            rod(p, at(13.0, 0.0, 3.0), at(38.0, 6.0, 6.0), 3.2),
            rod(p, at(13.0, 1.0, 3.0), at(15.0, 7.0, 15.0), 4.2),
            rod(p, at(11.0, 3.0, 0.0), at(11.0, 9.0, -17.0), 4.0),
        ]);
    }
    // Smoothly joined.
    let least = parts.iter().copied().fold(f64::INFINITY, f64::min);
    let sum: f64 = parts.iter().map(|d| (least - d).exp()).sum();
    least - sum.ln()
}

/// An oval shaft along an axis that is none of the coordinates'.
const AXIS: V3 = [0.0995, 0.0, 0.995];

fn shaft([x, y, z]: V3) -> f64 {
    let across = AXIS[2] * x - AXIS[0] * z;
    (across / 1.4).hypot(y) - 10.0
}

fn bone(distance: impl Fn(V3) -> f64 + Sync, half: V3) -> Bone {
    // The grid's unit does not matter; nodes are 0.8 mm apart, and the shape is closed at the grid's sides.
    let step = 0.8;
    let grid = VolumeGrid {
        corner: half.map(|h| -h - 2.0 * step),
        step: [step; 3],
        nodes: half.map(|h| (2.0 * h / step) as usize + 5),
    };
    let within = |p: V3| {
        (0..3)
            .map(|k| p[k].abs() - half[k])
            .fold(distance(p), f64::max)
    };
    let surface: Surface = isosurface(&grid, within);
    Bone::new(surface)
}

struct Noise {
    /// Standard deviations of each frame's position in mm and of its angles in degrees.
    pose: [f64; 2],
    /// Length of the calibration's error, mm.
    calibration: f64,
    /// Share of points that are no bone.
    wrong: f64,
}

const LITTLE: Noise = Noise {
    pose: [0.0; 2],
    calibration: 0.0,
    wrong: 0.1,
};

fn normal(random: &mut ChaCha8Rng) -> f64 {
    let radius = (-2.0 * (1.0 - random.random::<f64>()).ln()).sqrt();
    radius * (std::f64::consts::TAU * random.random::<f64>()).cos()
}

fn direction(random: &mut ChaCha8Rng) -> V3 {
    let v = [0; 3].map(|_| normal(random));
    v.map(|c| c / norm(v))
}

/// The first echo in each line of a freehand sweep along z, 60 mm behind the bone, in the bone's coordinates.
///
/// The probe rocks by 15° about its travel and by 5° across it. A part of the frames is missing.
fn sweep(distance: impl Fn(V3) -> f64, half: f64, noise: &Noise, random: &mut ChaCha8Rng) -> Cloud {
    let mut cloud = Cloud::default();
    let offset = direction(random).map(|v| noise.calibration * v);
    for frame in 0..=(2.0 * half) as i64 {
        let z = frame as f64 - half;
        if (0.1 * half..0.25 * half).contains(&z) {
            continue;
        }
        let rock = [0.09 * (0.05 * z).sin(), 0.0, 0.26 * (0.11 * z).sin()];
        let probe = Rigid::about([0.0, 0.0, z], rock, [0.0; 3]);
        let wrong = Rigid::about(
            probe.apply([0.0, 60.0, z]),
            [0; 3].map(|_| noise.pose[1].to_radians() * normal(random)),
            [0; 3].map(|_| noise.pose[0] * normal(random)),
        );
        for line in -38..=38 {
            let origin = probe.apply([f64::from(line), 60.0, z]);
            let beam = probe.turn([0.0, -1.0, 0.0]);
            let at = |depth: f64| [0, 1, 2].map(|k| origin[k] + depth * beam[k]);
            let mut depth = 0.0;
            while depth < 90.0 && distance(at(depth)) > 1e-3 {
                depth += 0.7 * distance(at(depth)).max(1e-3);
            }
            let slope = |k: usize| {
                let [mut low, mut high] = [at(depth); 2];
                (low[k], high[k]) = (low[k] - 1e-3, high[k] + 1e-3);
                distance(high) - distance(low)
            };
            let out = [slope(0), slope(1), slope(2)];
            let out = out.map(|v| v / norm(out));
            let facing = -(0..3).map(|k| out[k] * beam[k]).sum::<f64>();
            if depth >= 90.0 || facing < 0.5 {
                continue;
            }
            depth += 0.1 * normal(random);
            if random.random::<f64>() < noise.wrong {
                depth -= random.random_range(2.0..20.0);
            }
            let error = probe.turn(offset);
            let seen = [0, 1, 2].map(|k| at(depth)[k] + error[k]);
            cloud.points.push(wrong.apply(seen));
            cloud.normals.push(wrong.turn(out));
            cloud.paths.push(wrong.turn(beam.map(|v| depth * v)));
            cloud.frame.push(frame);
        }
    }
    cloud
}

/// The cloud in the coordinates of a tracker, from which `truth` leads to the bone.
fn moved(cloud: &Cloud, truth: &Rigid) -> Cloud {
    let back = truth.inverse();
    let turned = |values: &[V3]| values.iter().map(|v| back.turn(*v)).collect();
    Cloud {
        points: cloud.points.iter().map(|p| back.apply(*p)).collect(),
        normals: turned(&cloud.normals),
        paths: turned(&cloud.paths),
        ..cloud.clone()
    }
}

/// A start 10 mm and 10° from the truth, about the bone's middle.
fn off(truth: &Rigid, random: &mut ChaCha8Rng) -> Rigid {
    let turn = direction(random).map(|v| f64::to_radians(10.0) * v);
    let shift = direction(random).map(|v| 10.0 * v);
    truth.then(&Rigid::about([0.0; 3], turn, shift))
}

fn truth() -> Rigid {
    Rigid::about([0.0; 3], [0.4, -1.1, 0.7], [120.0, -40.0, 310.0])
}

fn from(start: Rigid) -> Parameters {
    Parameters {
        start: Some(start),
        ..Parameters::default()
    }
}

/// Errors of poses and of the calibration as freehand sweeps have them.
const MUCH: Noise = Noise {
    pose: [0.3, 0.3],
    calibration: 0.5,
    wrong: 0.1,
};

/// Checks that of `trials` registrations 95 % have a root mean square error of the vertices of at most `most`, mm.
fn assert_found(noise: &Noise, trials: usize, most: f64) {
    let bone = bone(vertebra, [44.0, 52.0, 24.0]);
    let mut random = ChaCha8Rng::seed_from_u64(59);
    let truth = truth();
    let mut cloud = Cloud::default();
    let run = |trial: usize| {
        // Four starts for each sweep.
        if trial.is_multiple_of(4) {
            cloud = moved(&sweep(vertebra, 24.0, noise, &mut random), &truth);
        }
        let start = off(&truth, &mut random);
        let found = register(&cloud, &bone, &from(start)).unwrap();
        let vertices = bone.surface().vertices();
        let there: Vec<V3> = vertices.iter().map(|v| truth.inverse().apply(*v)).collect();
        target_error(&found.pose, &truth, &there)[0]
    };
    let mut errors: Vec<f64> = (0..trials).map(run).collect();
    errors.sort_by(f64::total_cmp);
    assert!(errors[trials * 19 / 20 - 1] <= most, "{errors:?}");
    println!("largest {:.3} mm", errors[trials - 1]);
}

#[test]
fn a_vertebra_is_found_from_10_mm_and_10_degrees() {
    assert_found(&LITTLE, 20, 0.5);
}

#[test]
fn noise_of_poses_and_calibration_moves_a_vertebra_little() {
    assert_found(&MUCH, 20, 1.2);
}

#[test]
#[ignore = "a hundred starts each take minutes"]
fn a_vertebra_is_found_from_a_hundred_starts() {
    assert_found(&LITTLE, 100, 0.5);
    assert_found(&MUCH, 100, 1.2);
}

#[test]
fn a_vertebra_is_found_from_anywhere() {
    let bone = bone(vertebra, [44.0, 52.0, 24.0]);
    let mut random = ChaCha8Rng::seed_from_u64(60);
    for turn in [[0.0, 0.0, 3.0], [2.0, -1.0, 0.5], [-1.2, 1.4, 2.2]] {
        let truth = Rigid::about([0.0; 3], turn, [300.0, -50.0, 20.0]);
        let cloud = moved(&sweep(vertebra, 24.0, &LITTLE, &mut random), &truth);
        let found = register(&cloud, &bone, &Parameters::default()).unwrap();
        let there = bone
            .surface()
            .vertices()
            .iter()
            .map(|v| truth.inverse().apply(*v));
        let [rms, _] = target_error(&found.pose, &truth, &there.collect::<Vec<_>>());
        assert!(found.anywhere && rms < 0.5, "{turn:?}: {rms}");
        assert!(found.rival.is_none(), "{:?}", found.rival);
    }
}

fn shaft_found(truth: &Rigid, start: impl Fn(&mut ChaCha8Rng) -> Rigid) -> Registration {
    let bone = bone(shaft, [24.0, 20.0, 90.0]);
    let mut random = ChaCha8Rng::seed_from_u64(61);
    let cloud = moved(&sweep(shaft, 35.0, &LITTLE, &mut random), truth);
    register(&cloud, &bone, &from(start(&mut random))).unwrap()
}

#[test]
fn a_shaft_slides_along_itself_and_this_is_reported() {
    let truth = truth();
    let found = shaft_found(&truth, |random| off(&truth, random));
    let [slide, others @ ..] = &found.freedoms[..] else {
        panic!("no motions");
    };
    assert_eq!(slide.kind, Kind::Slide);
    let along: f64 = (0..3).map(|k| slide.direction[k] * AXIS[k]).sum();
    assert!(along > 0.999, "{slide}");
    assert!(slide.is_open() && slide.uncertainty > 10.0, "{slide}");
    assert!(
        slide.to_string().starts_with("sliding along (0.1"),
        "{slide}"
    );
    assert!(others.iter().all(|f| !f.is_open()), "{others:?}");
    // Across the axis the shaft is where it was.
    let error = |p: V3| {
        let there = truth.inverse().apply(p);
        let off: V3 = [0, 1, 2].map(|k| found.pose.apply(there)[k] - p[k]);
        let along: f64 = (0..3).map(|k| off[k] * AXIS[k]).sum();
        (norm(off).powi(2) - along * along).max(0.0).sqrt()
    };
    for z in [-30.0, 0.0, 30.0] {
        assert!(
            error([0.1 * z, 0.0, z]) < 0.3,
            "{}",
            error([0.1 * z, 0.0, z])
        );
    }
    let after = Statistics::of(&found.after);
    let before = Statistics::of(&found.before);
    assert!(
        after.median < 0.15 && before.median > 1.0,
        "{after:?} {before:?}"
    );
}

/// A slide of the start along the shaft stays: nothing moves it, and nothing hides it.
#[test]
fn a_slide_that_nothing_determines_is_not_made() {
    let truth = truth();
    let slid = Rigid::about([0.0; 3], [0.0; 3], AXIS.map(|v| 5.0 * v));
    let found = shaft_found(&truth, |_| truth.then(&slid));
    let by = found.pose.apply(truth.inverse().apply([0.0; 3]));
    let off = [0, 1, 2].map(|k| by[k] - 5.0 * AXIS[k]);
    assert!(norm(off) < 0.3, "{off:?}");
    assert!(found.freedoms[0].moved < 0.3);
}

#[test]
fn scale_and_sound_speed_are_found() {
    let bone = bone(vertebra, [44.0, 52.0, 24.0]);
    let mut random = ChaCha8Rng::seed_from_u64(62);
    let mut cloud = sweep(vertebra, 24.0, &LITTLE, &mut random);
    let parameters = Parameters {
        stretch: Stretch::SoundSpeed,
        ..from(Rigid::IDENTITY)
    };
    // The scanner's 1540 m/s were 1.5 % too many.
    for (p, path) in cloud.points.iter_mut().zip(&mut cloud.paths) {
        *p = [0, 1, 2].map(|k| p[k] + 0.015 * path[k]);
        *path = path.map(|v| 1.015 * v);
    }
    let found = register(&cloud, &bone, &parameters).unwrap();
    assert!(
        (found.factor * 1.015 - 1.0).abs() < 2e-3,
        "{}",
        found.factor
    );
    assert!(norm(found.pose.translation) < 0.3, "{:?}", found.pose);

    let mut cloud = sweep(vertebra, 24.0, &LITTLE, &mut random);
    cloud
        .points
        .iter_mut()
        .for_each(|p| *p = p.map(|v| 1.02 * v));
    cloud.paths.clear();
    let parameters = Parameters {
        stretch: Stretch::Scale,
        ..parameters
    };
    let found = register(&cloud, &bone, &parameters).unwrap();
    assert!((found.factor * 1.02 - 1.0).abs() < 2e-3, "{}", found.factor);
    let parameters = Parameters {
        stretch: Stretch::SoundSpeed,
        ..parameters
    };
    let message = register(&cloud, &bone, &parameters)
        .unwrap_err()
        .to_string();
    assert!(message.contains("px, py, pz"), "{message}");
}

/// A plate that hides another, both facing the probe.
#[test]
fn hidden_parts_and_far_sides_have_no_counterparts() {
    let plate = |z: f64| {
        [
            [-50.0, -50.0, z],
            [50.0, -50.0, z],
            [50.0, 50.0, z],
            [-50.0, 50.0, z],
        ]
    };
    let vertices = [plate(0.0), plate(-10.0)].concat();
    let faces = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
    let bone = Bone::new(Surface::new(vertices, faces));
    let grid =
        (-5..5).flat_map(|i| (-5..5).map(move |j| [3.0 * f64::from(i), 3.0 * f64::from(j), -9.0]));
    let mut cloud = Cloud {
        points: grid.collect(),
        ..Cloud::default()
    };
    let before = |cloud: &Cloud, both_sides: bool| {
        let parameters = Parameters {
            both_sides,
            ..from(Rigid::IDENTITY)
        };
        register(cloud, &bone, &parameters).map(|found| found.before[17])
    };
    assert!((before(&cloud, false).unwrap() - 1.0).abs() < 1e-9);
    cloud.normals = vec![[0.0, 0.0, 1.0]; cloud.points.len()];
    assert!((before(&cloud, false).unwrap() + 9.0).abs() < 1e-9);
    assert!((before(&cloud, true).unwrap() - 1.0).abs() < 1e-9);
    cloud.normals = vec![[0.0, 0.0, -1.0]; cloud.points.len()];
    let message = before(&cloud, false).unwrap_err().to_string();
    assert!(
        message.contains("normals must point to the probe"),
        "{message}"
    );
}

#[test]
fn clouds_that_are_not_valid_are_refused() {
    let valid = Cloud {
        points: (0..8)
            .map(|k| [f64::from(k), f64::from(k % 3), 0.0])
            .collect(),
        ..Cloud::default()
    };
    let message = |change: fn(&mut Cloud)| {
        let mut cloud = valid.clone();
        change(&mut cloud);
        cloud.check().unwrap_err().to_string()
    };
    assert!(valid.check().is_ok());
    assert!(message(|c| c.points.truncate(5)).contains("at least 6"));
    assert!(message(|c| c.normals = vec![[0.0; 3]]).contains("normals for 8 points"));
    assert!(message(|c| c.points[3][1] = f64::NAN).contains("entry 3"));
    assert!(message(|c| c.confidence = vec![1.5; 8]).contains("0 to 1"));
}
