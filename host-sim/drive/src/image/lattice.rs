//! Beams of any directions and distances, ordered from left to right.
//!
//! Finds the two beams around a position, and the share of the way between them.

use bonebeam::geometry::{Axis, Ray};
use ndarray::{ArrayBase, Data, Ix2};
use num_complex::Complex;

use crate::{Error, Result};
use bonebeam_files::BeamformedLines;

/// Beams that differ by less than this angle count as parallel, rad.
const PARALLEL: f64 = 1e-9;
/// Distance beyond an edge, in steps, that still counts as on it.
const EDGE: f64 = 1e-6;

/// Neighbouring beams with their samples.
pub(crate) struct Lattice {
    rays: Vec<Ray>,
    /// Intersection of each beam's line with the next beam's; `None` if parallel.
    apexes: Vec<Option<Apex>>,
    samples: Axis,
}

/// Intersection of the lines of two beams.
struct Apex {
    position: [f64; 2],
    /// Distance from there at which each begins, m; negative before it.
    begins: [f64; 2],
}

/// Left one of two beams, and the share of the way to the second.
type Between = (usize, f64);

impl Lattice {
    /// The beams of lines.
    ///
    /// # Errors
    /// Fewer than two beams, beams that are not ordered from left to right, or beams that cross within the depths
    /// of their samples.
    pub(super) fn new<S: Data<Elem = Complex<f32>>>(
        lines: &BeamformedLines<ArrayBase<S, Ix2>>,
    ) -> Result<Self> {
        let samples = sample_axis(lines);
        let rays: Vec<Ray> = match &lines.rays {
            None => lines.beam_x.iter().map(|&x| Ray::down(x)).collect(),
            Some(rays) => lines
                .beam_x
                .iter()
                .zip(rays.z.iter().zip(&rays.angle))
                .map(|(&x, (&z, &angle))| Ray::new(x, z, angle))
                .collect(),
        };
        if rays.len() < 2 || samples.count < 2 {
            return Err(Error::Data(format!(
                "an image needs at least 2 beams of 2 samples; the lines have {} of {}",
                rays.len(),
                samples.count
            )));
        }
        for (beam, pair) in rays.windows(2).enumerate() {
            let beside = |r: f64| pair[1].coordinates(pair[0].point(r))[0];
            if let Some(r) = [samples.first, samples.last()]
                .into_iter()
                .find(|&r| beside(r).is_nan() || beside(r) > 0.0)
            {
                return Err(Error::Data(format!(
                    "an image needs beams from left to right that do not cross; beam {beam} is right of the next one, {r} m \
                     along it"
                )));
            }
            if beside(samples.first) == 0.0 && beside(samples.last()) == 0.0 {
                return Err(Error::Data(format!(
                    "an image needs beams from left to right; beam {beam} has the position of the next one"
                )));
            }
        }
        let apexes = rays.windows(2).map(|pair| Apex::of(&pair[0], &pair[1]));
        Ok(Lattice {
            apexes: apexes.collect(),
            rays,
            samples,
        })
    }

    /// The beams.
    pub(crate) fn rays(&self) -> &[Ray] {
        &self.rays
    }

    /// Mean distance between neighbouring beams, at the middle depth, m.
    pub(crate) fn width(&self) -> f64 {
        let middle = (self.samples.first + self.samples.last()) / 2.0;
        let distance = |pair: &[Ray]| {
            let [[ax, az], [bx, bz]] = [pair[0].point(middle), pair[1].point(middle)];
            (bx - ax).hypot(bz - az)
        };
        self.rays.windows(2).map(distance).sum()
    }

    /// The value of `levels` [beam, sample] at a position (x, z); 0 outside.
    pub(super) fn at(&self, levels: &[f32], position: [f64; 2]) -> f32 {
        let found = self.locate(position);
        found.map_or(0.0, |(between, depth)| self.value(levels, between, depth))
    }

    /// The value at an angle and a depth along the beams; 0 outside.
    ///
    /// The angles of the beams must ascend.
    pub(super) fn at_angle(&self, levels: &[f32], angle: f64, depth: f64) -> f32 {
        let next = self.rays.partition_point(|ray| ray.angle() <= angle);
        let beam = next.saturating_sub(1).min(self.rays.len() - 2);
        let [a, b] = [self.rays[beam].angle(), self.rays[beam + 1].angle()];
        self.value(levels, (beam, (angle - a) / (b - a)), depth)
    }

    /// The two beams around a position, the share of the way, and the depth.
    fn locate(&self, position: [f64; 2]) -> Option<(Between, f64)> {
        let right_of = |ray: &Ray| ray.coordinates(position)[0] >= 0.0;
        let next = self.rays.partition_point(right_of);
        let beam = next.saturating_sub(1).min(self.rays.len() - 2);
        let pair = [&self.rays[beam], &self.rays[beam + 1]];
        let Some(apex) = &self.apexes[beam] else {
            let [[a, along_a], [b, along_b]] = pair.map(|ray| ray.coordinates(position));
            let fraction = a / (a - b);
            return Some(((beam, fraction), along_a + fraction * (along_b - along_a)));
        };
        let [u, v] = [0, 1].map(|axis| position[axis] - apex.position[axis]);
        let middle = (pair[0].angle() + pair[1].angle()) / 2.0;
        // Before the apex the beams come towards it.
        let side = (u * middle.sin() + v * middle.cos()).signum();
        let angle = (side * u).atan2(side * v);
        let fraction = (angle - pair[0].angle()) / (pair[1].angle() - pair[0].angle());
        let begin = apex.begins[0] + fraction * (apex.begins[1] - apex.begins[0]);
        Some(((beam, fraction), side * u.hypot(v) - begin))
    }

    /// Bilinear interpolation, as in the core's `resample`.
    fn value(&self, levels: &[f32], (beam, fraction): Between, depth: f64) -> f32 {
        let last = (self.samples.count - 1) as f64;
        let at = (depth - self.samples.first) / self.samples.step;
        let inside = |at: f64, last: f64| at >= -EDGE && at <= last + EDGE;
        if !(inside(at, last) && inside(fraction, 1.0)) {
            return 0.0;
        }
        let at = at.clamp(0.0, last);
        let sample = at.floor().min(last - 1.0);
        let (p, q) = (fraction.clamp(0.0, 1.0) as f32, (at - sample) as f32);
        let along = |beam: usize| {
            let corner = beam * self.samples.count + sample as usize;
            (1.0 - q) * levels[corner] + q * levels[corner + 1]
        };
        // Rounding beyond white is clipped.
        ((1.0 - p) * along(beam) + p * along(beam + 1)).min(255.0)
    }
}

impl Apex {
    fn of(a: &Ray, b: &Ray) -> Option<Self> {
        let turn = b.angle() - a.angle();
        if turn.abs() < PARALLEL {
            return None;
        }
        // Along `a` until `b`'s line: `a`'s beginning lies `beside` it, and nears it by the sine of the turn.
        let [beside, _] = b.coordinates([a.x(), a.z()]);
        let to_apex = beside / turn.sin();
        let position = a.point(to_apex);
        let [_, along_b] = b.coordinates(position);
        Some(Apex {
            position,
            begins: [-to_apex, -along_b],
        })
    }
}

/// The depths of the samples: half the two-way time times the speed of sound.
pub(crate) fn sample_axis<S: Data<Elem = Complex<f32>>>(
    lines: &BeamformedLines<ArrayBase<S, Ix2>>,
) -> Axis {
    Axis::new(
        lines.c * lines.t0 / 2.0,
        lines.c / lines.fs / 2.0,
        lines.z.ncols(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use bonebeam_files::BeamRays;
    use ndarray::Array2;

    /// Samples every 0.5 mm from 2 mm on.
    const SAMPLES: usize = 60;

    fn lines(rays: &[[f64; 3]]) -> BeamformedLines {
        let part = |k: usize| rays.iter().map(|ray| ray[k]).collect::<Vec<f64>>();
        let z = Array2::zeros((rays.len(), SAMPLES));
        let axis = [1500.0 / 2.0 / 0.5e-3, 2.0 * 2e-3 / 1500.0, 1500.0];
        BeamformedLines {
            rays: BeamRays::of(rays.len(), Some(part(1)), Some(part(2))),
            ..BeamformedLines::straight(z, part(0), axis)
        }
    }

    fn depth(sample: usize) -> f64 {
        2e-3 + sample as f64 * 0.5e-3
    }

    fn levels(beams: usize, field: impl Fn(usize, f64) -> f64) -> Vec<f32> {
        let value = |k: usize| field(k / SAMPLES, depth(k % SAMPLES)) as f32;
        (0..beams * SAMPLES).map(value).collect()
    }

    /// Beams from an arc around (1 mm, −40 mm), at uneven angles.
    #[test]
    fn a_field_that_is_linear_in_angle_and_distance_is_found_again() {
        let angles = [-0.5, -0.31, -0.3, -0.05, 0.1, 0.4, 0.41];
        let on_arc = |angle: f64| {
            [
                1e-3 + 40e-3 * angle.sin(),
                40e-3 * angle.cos() - 40e-3,
                angle,
            ]
        };
        let lines = lines(&angles.map(on_arc));
        let lattice = Lattice::new(&lines).unwrap();
        let field = |angle: f64, depth: f64| 3.0 * angle + 50.0 * depth + 2.0;
        let levels = levels(angles.len(), |beam, depth| field(angles[beam], depth));
        let (mut inside, mut outside) = (0, 0);
        for (x, z) in
            (-40..40).flat_map(|x| (0..50).map(move |z| (x as f64 * 0.9e-3, z as f64 * 0.8e-3)))
        {
            let from = (x - 1e-3).hypot(z + 40e-3);
            // By another way than the code's: asin.
            let (angle, depth) = (((x - 1e-3) / from).asin(), from - 40e-3);
            let value = f64::from(lattice.at(&levels, [x, z]));
            if (-0.4999..0.4099).contains(&angle) && (2.001e-3..31.499e-3).contains(&depth) {
                inside += 1;
                assert!(
                    (value - field(angle, depth)).abs() < 2e-6,
                    "{x} {z}: {value}"
                );
            } else if !(-0.5001..0.4101).contains(&angle) || !(1.999e-3..31.501e-3).contains(&depth)
            {
                outside += 1;
                assert_eq!(value, 0.0, "{x} {z}");
            }
        }
        assert!(inside > 1000 && outside > 500, "{inside} {outside}");
    }

    /// Parallel and aslant, from a concave array, from elements at any depths: along a beam are its own samples, and midway
    /// between two positions of one depth is their mean where the beams are parallel.
    #[test]
    fn beams_of_any_kind_keep_their_samples() {
        let slanted = [
            [-3e-3, 0.0, 0.3],
            [-2e-3, 0.0, 0.3],
            [1e-3, 0.0, 0.3],
            [1.5e-3, 0.0, 0.3],
        ];
        // Towards (0, 60 mm).
        let concave = [0.1, 0.04, 0.0, -0.1]
            .map(|angle: f64| [-60e-3 * angle.sin(), 60e-3 - 60e-3 * angle.cos(), angle]);
        let uneven = [
            [-3e-3, 0.0, -0.2],
            [-2e-3, 0.4e-3, -0.15],
            [1e-3, 0.1e-3, 0.0],
            [1.5e-3, 0.0, 0.3],
        ];
        for rays in [slanted, concave, uneven] {
            let lines = lines(&rays);
            let lattice = Lattice::new(&lines).unwrap();
            let levels = levels(4, |beam, depth| (beam * beam) as f64 + 100.0 * depth);
            for (beam, ray) in lattice.rays().iter().enumerate() {
                for sample in 0..SAMPLES {
                    let value = lattice.at(&levels, ray.point(depth(sample)));
                    let expected = levels[beam * SAMPLES + sample];
                    assert!(
                        (value - expected).abs() < 2e-5,
                        "{rays:?} {beam} {sample}: {value}"
                    );
                }
            }
        }
        let lines = lines(&slanted);
        let lattice = Lattice::new(&lines).unwrap();
        let levels = levels(4, |beam, depth| (beam * beam) as f64 + 100.0 * depth);
        let [a, b] = [1, 2].map(|beam| lattice.rays()[beam].point(10e-3));
        let value = lattice.at(&levels, [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0]);
        assert!((value - 3.5).abs() < 1e-5, "{value}");
    }

    #[test]
    fn beams_that_cross_or_lie_on_each_other_are_named() {
        let refused = |rays: &[[f64; 3]]| match Lattice::new(&lines(rays)) {
            Err(error) => error.to_string(),
            Ok(_) => panic!("taken: {rays:?}"),
        };
        let first = [-2e-3, 0.0, 0.0];
        let crossing = refused(&[first, [-1e-3, 0.0, 0.2], [1e-3, 0.0, 0.0]]);
        assert!(crossing.contains("beam 1 is right of"), "{crossing}");
        let twice = refused(&[first, first]);
        assert!(twice.contains("beam 0 has the position"), "{twice}");
        assert!(refused(&[first]).contains("at least 2 beams"));
    }
}
