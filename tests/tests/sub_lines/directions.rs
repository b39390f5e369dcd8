//! Positions and directions of a line's sub-lines.

use super::{PITCH, parameters};
use crate::common::kit::*;
use bonebeam::geometry::SteeringTable;
use bonebeam_oracle::reference::f64::steering::direction;

/// Arrays with their lines: linear, a sector, curved.
fn geometries(check: impl Fn(&Scan<'_>)) {
    let arc: Vec<Element> = (0..32)
        .map(|m| Element::convex(32, 0.4e-3, 40e-3, m))
        .collect();
    let curved = Array::at(&arc, 0.4e-3);
    let phased = Array::linear(32, 0.15e-3);
    let sector: Vec<Ray> = (0..31)
        .map(|line| Ray::new(0.0, 0.0, -0.7 + 1.4 / 30.0 * f64::from(line)))
        .collect();
    let normals: Vec<Ray> = (0..63)
        .map(|line| curved.normal(f64::from(line) / 2.0))
        .collect();
    let uneven = [-2e-3, -1e-3, 0.5e-3, 0.7e-3];
    for (array, lines) in [
        (
            Array::linear(32, PITCH),
            Lines::Even(Axis::centred(32, PITCH)),
        ),
        (Array::linear(32, PITCH), Lines::At(&uneven)),
        (phased, Lines::Rays(&sector)),
        (curved, Lines::Rays(&normals)),
    ] {
        check(&Scan::new(parameters(array, lines, 300)).expect("a valid scan"));
    }
}

#[test]
fn directions_are_those_of_the_definition() {
    geometries(|scan| {
        for sub_lines in [2, 4, 16] {
            assert_directions(scan, sub_lines);
        }
    });
}

/// For more than four sub-lines within the error of the polynomial.
fn assert_directions(scan: &Scan<'_>, sub_lines: usize) {
    let need = SteeringTable::need(scan.lines(), scan.samples(), sub_lines);
    let mut memory = vec![Complex::ZERO; need.complex];
    let table = SteeringTable::new(scan, sub_lines, &mut memory).expect("memory that fits");
    let p = scan.parameters();
    let wave = TAU * p.centre_frequency / p.sound_speed;
    for line in [0, 1, scan.lines() / 2, scan.lines() - 1] {
        let steering = table.line(line).expect("a line of the scan");
        assert_eq!((steering.samples(), steering.sub_lines()), (300, sub_lines));
        for n in [0, 17, 299] {
            let depth = scan.depth(n);
            let point = |ray: Ray| ray.point(depth);
            let ends = [0, sub_lines - 1].map(|k| point(p.lines.sub_line(line, k, sub_lines)));
            let half = (ends[1][0] - ends[0][0]).hypot(ends[1][1] - ends[0][1]) / 2.0;
            let bound = match sub_lines {
                2 | 4 => 1e-7,
                _ => 1e-7 + wave * half * (half / depth).powi(4) / 5.0,
            };
            for k in 0..sub_lines {
                let sub_line = p.lines.sub_line(line, k, sub_lines);
                let points = [scan.ray(line), sub_line].map(point);
                let active = scan.active(line, n);
                let [slope, constant] = direction(&p.array, active, points, wave);
                let expected = [Complex::cis(slope / 2.0), Complex::cis(-constant)];
                for (found, expected) in steering.direction(n, k).into_iter().zip(expected) {
                    let error = (widen(found) - expected).norm();
                    assert!(error < bound, "{line} {n} {k}: {error:e}, {bound:e}");
                }
            }
        }
    }
    assert!(table.line(scan.lines()).is_none());
}

/// Half way between two lines, the outermost sub-lines of both are half a sub-line away.
#[test]
fn sub_lines_divide_the_lines_cells_evenly() {
    geometries(|scan| {
        let lines = scan.parameters().lines;
        if let Lines::At(x) = lines {
            // From -1.5 to -0.25 mm.
            assert_eq!(x[1], -1e-3);
            for (k, x) in [-1.34375e-3, -1.03125e-3, -0.71875e-3, -0.40625e-3]
                .iter()
                .enumerate()
            {
                assert!((lines.sub_line(1, k, 4).x() - x).abs() < 1e-15);
            }
            return;
        }
        let all: Vec<Ray> = (0..scan.lines())
            .flat_map(|line| (0..4).map(move |k| lines.sub_line(line, k, 4)))
            .collect();
        let steps = |along: fn(&Ray) -> f64| {
            let steps: Vec<f64> = all
                .windows(2)
                .map(|ray| along(&ray[1]) - along(&ray[0]))
                .collect();
            steps
        };
        for step in steps(Ray::angle) {
            assert!((step - steps(Ray::angle)[0]).abs() < 1e-9);
        }
        // Along an arc the lateral steps change slowly.
        for pair in steps(Ray::x).windows(2) {
            assert!((pair[1] - pair[0]).abs() < 1e-3 * pair[0].abs() + 1e-15);
        }
        assert_eq!(Lines::At(&[1e-3]).sub_line(0, 1, 4), Ray::down(1e-3));
    });
}
