//! Registration of points whose transform is known.

use std::f64::consts::PI;

use bonebeam_paper::measure::registration::{
    Point, Rigid, expected_fiducial_error, expected_target_error,
};
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

#[test]
fn registration_finds_the_transform_that_was_applied() {
    let known = Rigid::new([0.3, -0.7, 2.5], [0.04, -0.11, 0.02]);
    let moved = FIDUCIALS.map(|p| known.apply(p));
    let found = Rigid::register(&FIDUCIALS, &moved).unwrap();
    for p in [[0.0; 3], [0.1, 0.0, 0.0], [0.0, -0.1, 0.3], FIDUCIALS[2]] {
        // The requested tolerance is 10⁻⁹ m; a rotation of ten roundings at 0.3 m is 10⁻¹⁵ m.
        assert!(distance(found.apply(p), known.apply(p)) < 1e-12);
        assert!(distance(found.inverse().apply(known.apply(p)), p) < 1e-12);
    }
    assert!(found.fiducial_error(&FIDUCIALS, &moved) < 1e-14);
    // A quarter turn about x takes y to z, and lengths stay.
    let quarter = Rigid::new([PI / 2.0, 0.0, 0.0], [0.0; 3]);
    assert!(distance(quarter.apply([0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]) < 1e-15);
}

#[test]
fn a_mirror_image_is_not_taken_for_a_rotation() {
    let mirrored = FIDUCIALS.map(|[x, y, z]| [-x, y, z]);
    let found = Rigid::register(&FIDUCIALS, &mirrored).unwrap();
    let [o, x, y, z] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        .map(|p| nalgebra::Vector3::from(found.apply(p)));
    let handed = (x - o).cross(&(y - o)).dot(&(z - o));
    assert!((handed - 1.0).abs() < 1e-12, "{handed}");
    // Points in one plane do not distinguish the two by themselves.
    let flat = FIDUCIALS.map(|[x, y, _]| [x, y, 0.0]);
    let known = Rigid::new([0.1, 0.2, 0.3], [0.01, 0.02, 0.03]);
    let found = Rigid::register(&flat, &flat.map(|p| known.apply(p))).unwrap();
    let above = [0.0, 0.0, 0.05];
    assert!(distance(found.apply(above), known.apply(above)) < 1e-12);
}

#[test]
fn registrations_that_no_points_determine_are_refused() {
    let line = [1.0, 2.0, 4.0].map(|t| [t, 2.0 * t, 0.5 - t]);
    let mut broken = FIDUCIALS;
    broken[1][2] = f64::NAN;
    let message = |from: &[Point], to: &[Point]| Rigid::register(from, to).unwrap_err().to_string();
    assert!(message(&line, &line).contains("one line"));
    assert!(message(&FIDUCIALS[..2], &FIDUCIALS[..2]).contains("at least 3"));
    assert!(message(&FIDUCIALS, &FIDUCIALS[..3]).contains("4 points to 3"));
    assert!(message(&FIDUCIALS, &broken).contains("point 1 is not finite"));
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
        let found = Rigid::register(&FIDUCIALS, &picked).unwrap();
        squares.push(4.0 * (found.fiducial_error(&FIDUCIALS, &picked) / sigma).powi(2));
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
