//! Registration of points whose transform is known.

use std::f64::consts::PI;

use bonebeam_paper::measure::registration::{
    Point, Rigid, expected_fiducial_error, fiducial_error, rotated,
};
use nalgebra::{Matrix3, Vector3};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Two fiducials on a ridge and two beside it, as on a vertebra.
const FIDUCIALS: [Point; 4] = [
    [0.0, 3.5e-3, 15e-3],
    [0.3e-3, -8.5e-3, 15.6e-3],
    [11e-3, 4e-3, 27e-3],
    [-11.4e-3, -9e-3, 28e-3],
];

fn distance(a: Point, b: Point) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Normal numbers, by Box and Muller.
fn normal(random: &mut ChaCha8Rng) -> f64 {
    let radius = (-2.0 * (1.0 - random.random::<f64>()).ln()).sqrt();
    radius * (2.0 * PI * random.random::<f64>()).cos()
}

/// Expected mean square error at `target` of a registration by these fiducials, m².
///
/// `localisation` is the mean square error of their localisation.
fn expected_target_error(fiducials: &[Point], target: Point, localisation: f64) -> f64 {
    let points = || fiducials.iter().map(|p| Vector3::from(*p));
    let centre = points().sum::<Vector3<f64>>() / fiducials.len() as f64;
    let scatter: Matrix3<f64> = points()
        .map(|p| (p - centre) * (p - centre).transpose())
        .sum();
    let axes = scatter.symmetric_eigen().eigenvectors;
    let from_axis = |p: Vector3<f64>, k: usize| {
        let along = (p - centre).dot(&axes.column(k));
        (p - centre).norm_squared() - along * along
    };
    let fraction = |k: usize| {
        let spread: f64 = points().map(|p| from_axis(p, k)).sum();
        from_axis(target.into(), k) / (spread / fiducials.len() as f64)
    };
    localisation / fiducials.len() as f64 * (1.0 + (0..3).map(fraction).sum::<f64>() / 3.0)
}

#[test]
fn angles_turn_about_x_then_y_then_z() {
    let found = rotated([PI / 2.0, 0.0, PI / 2.0], [0.0, 0.0, 2.0]);
    // About x: y to z; about z: x to y, and what was y stays along z.
    assert!(distance(found.apply([0.0, 1.0, 0.0]), [0.0, 0.0, 3.0]) < 1e-15);
    assert!(distance(found.apply([1.0, 0.0, 0.0]), [0.0, 1.0, 2.0]) < 1e-15);
    let moved = FIDUCIALS.map(|p| found.apply(p));
    assert!(fiducial_error(&found, &FIDUCIALS, &moved) < 1e-15);
    assert!(fiducial_error(&found, &moved, &FIDUCIALS) > 1e-3);
}

#[test]
fn a_mirror_image_is_not_taken_for_a_rotation() {
    let mirrored = FIDUCIALS.map(|[x, y, z]| [-x, y, z]);
    let found = Rigid::of_landmarks(&FIDUCIALS, &mirrored).unwrap();
    let [o, x, y, z] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        .map(|p| Vector3::from(found.apply(p)));
    let handed = (x - o).cross(&(y - o)).dot(&(z - o));
    assert!((handed - 1.0).abs() < 1e-12, "{handed}");
    // Points in one plane do not distinguish the two by themselves.
    let flat = FIDUCIALS.map(|[x, y, _]| [x, y, 0.0]);
    let known = rotated([0.1, 0.2, 0.3], [0.01, 0.02, 0.03]);
    let found = Rigid::of_landmarks(&flat, &flat.map(|p| known.apply(p))).unwrap();
    let above = [0.0, 0.0, 0.05];
    assert!(distance(found.apply(above), known.apply(above)) < 1e-12);
}

#[test]
fn the_fiducial_error_has_the_distribution_of_its_theory() {
    // Errors of σ along each axis of one side: N·FRE²/σ² is χ² with 3N − 6 = 6 degrees of freedom, whose mean
    // is 6, its variance 12 and its median 5.348.
    let (sigma, trials) = (0.1e-3, 4000);
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let target = [2e-3, 0.0, 40e-3];
    let (mut squares, mut at_target) = (Vec::new(), 0.0);
    for _ in 0..trials {
        let picked = FIDUCIALS.map(|p| p.map(|v| v + sigma * normal(&mut random)));
        let found = Rigid::of_landmarks(&FIDUCIALS, &picked).unwrap();
        squares.push(4.0 * (fiducial_error(&found, &FIDUCIALS, &picked) / sigma).powi(2));
        at_target += distance(found.apply(target), target).powi(2) / f64::from(trials);
    }
    let n = f64::from(trials);
    let mean = squares.iter().sum::<f64>() / n;
    let variance = squares.iter().map(|s| (s - mean) * (s - mean)).sum::<f64>() / n;
    let below = squares.iter().filter(|s| **s < 5.348).count() as f64 / n;
    // Four standard errors: √(12/n) of the mean, √((3 + 2 − 1)·144/n) of the variance, ½/√n of the share.
    assert!((mean - 6.0).abs() < 4.0 * (12.0 / n).sqrt(), "{mean}");
    assert!(
        (variance - 12.0).abs() < 4.0 * (4.0 * 144.0 / n).sqrt(),
        "{variance}"
    );
    assert!((below - 0.5).abs() < 4.0 * 0.5 / n.sqrt(), "{below}");
    let localisation = 3.0 * sigma * sigma;
    let expected = expected_fiducial_error(4, localisation) * 4.0 / (sigma * sigma);
    assert!((expected - 6.0).abs() < 1e-12);
    // The target's squares spread about as widely as χ² with two degrees of freedom: twice their mean at the
    // most, so that four standard errors are 8/√n.
    let expected = expected_target_error(&FIDUCIALS, target, localisation);
    assert!(
        (at_target / expected - 1.0).abs() < 8.0 / n.sqrt(),
        "{at_target} {expected}"
    );
}
