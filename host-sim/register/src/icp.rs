//! Iterative closest points, from point to plane, with weights.
//!
//! Y. Chen, G. Medioni, Object modelling by registration of multiple range images, Image and Vision Computing 10,
//! 145–155, 1992. The weights are Tukey's, whose width follows the median distance. Directions of motion that the
//! normals do not determine stay as they are (J. Zhang, M. Kaess, S. Singh, On degeneracy of optimization-based state
//! estimation problems, ICRA 2016).

use crate::algebra::{V3, add, cross, dot, mean, scale, sub, symmetric_eigen};
use crate::pose::Rigid;
use crate::scene::{Match, Pose, Scene, View};

/// Parameters: rotation about the centre, translation, factor.
pub(crate) const FREEDOMS: usize = 7;
/// Root mean square slope of the surface along a motion below which the motion is not made: 2.3°.
const LEAST_SLOPE: f64 = 0.04;
/// Width of the weights, in medians of the distance, and its limits, mm.
const WIDTH: f64 = 3.5;
const NARROWEST: f64 = 0.8;
const WIDEST: f64 = 15.0;
/// Largest step, mm.
const STEP: f64 = 8.0;
/// A step that ends the iteration, mm: of a start, and of the result.
pub(crate) const ROUGH: f64 = 0.03;
pub(crate) const FINE: f64 = 5e-4;

/// Tukey's weight of a distance.
pub(crate) fn tukey(distance: f64, width: f64) -> f64 {
    let share = distance / width;
    if share < 1.0 {
        (1.0 - share * share).powi(2)
    } else {
        0.0
    }
}

/// Width of the weights for these distances, mm.
pub(crate) fn width(matches: &[Option<Match>]) -> f64 {
    let mut distances: Vec<f64> = matches.iter().flatten().map(|m| m.distance).collect();
    let half = distances.len() / 2;
    if distances.is_empty() {
        return NARROWEST;
    }
    let (_, median, _) = distances.select_nth_unstable_by(half, f64::total_cmp);
    (WIDTH * *median).clamp(NARROWEST, WIDEST)
}

/// The least squares of matched points.
pub(crate) struct Normal {
    /// Weighted mean square change of distances by motions of 1 mm.
    pub matrix: [[f64; FREEDOMS]; FREEDOMS],
    /// Weighted mean product of the change and the distance.
    right: [f64; FREEDOMS],
    /// Rows: parameters of motions that are independent, and 1 mm in the root mean square of the points.
    basis: [[f64; FREEDOMS]; FREEDOMS],
    pub centre: V3,
    /// Root mean square distance of the points from the centre, mm.
    pub radius: f64,
    /// Root mean square change of positions by a change of the factor by 1, mm.
    pub stretch: f64,
}

impl Normal {
    pub(crate) fn of(
        scene: &Scene,
        chosen: &[usize],
        pose: &Pose,
        matches: &[Option<Match>],
    ) -> Self {
        let width = width(matches);
        let pairs = || {
            let pairs = chosen.iter().zip(matches);
            pairs.filter_map(|(&k, m)| m.map(|m| (k, m)))
        };
        let centre = mean(pairs().map(|(_, m)| m.point));
        let count = pairs().count().max(1) as f64;
        let root = |squares: f64| (squares / count).sqrt().max(1e-9);
        let stretch_of = |k: usize| {
            let stretch = scene.stretches.get(k);
            stretch.map_or([0.0; 3], |s| pose.rigid.turn(*s))
        };
        let square = |v: V3| dot(v, v);
        let radius = root(pairs().map(|(_, m)| square(sub(m.point, centre))).sum());
        let stretch = root(pairs().map(|(k, _)| square(stretch_of(k))).sum());
        let mut changes = [[0.0; FREEDOMS]; FREEDOMS];
        let mut motions = changes;
        let mut products = [0.0; FREEDOMS];
        let mut sum = 1e-9;
        for (k, m) in pairs() {
            let weight = scene.cloud.weight(k) * tukey(m.distance, width);
            let [x, y, z] = scale(sub(m.point, centre), 1.0 / radius);
            // Motion of the point by each parameter, and the change of its distance.
            let by = [
                [0.0, -z, y],
                [z, 0.0, -x],
                [-y, x, 0.0],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [0.0, 0.0, 1.0],
                scale(stretch_of(k), 1.0 / stretch),
            ];
            let row = by.map(|by| dot(m.normal, by));
            for i in 0..FREEDOMS {
                for j in 0..FREEDOMS {
                    changes[i][j] += weight * row[i] * row[j];
                    motions[i][j] += weight * dot(by[i], by[j]);
                }
                products[i] -= weight * row[i] * m.along;
            }
            sum += weight;
        }
        let (values, mut basis) = symmetric_eigen(motions);
        for (row, value) in basis.iter_mut().zip(values) {
            // A parameter that moves nothing has no motion.
            let by = if value > 1e-6 * sum {
                (sum / value).sqrt()
            } else {
                0.0
            };
            row.iter_mut().for_each(|v| *v *= by);
        }
        let product = |a: &[f64; FREEDOMS], b: &[f64; FREEDOMS]| -> f64 {
            a.iter().zip(b).map(|(a, b)| a * b).sum()
        };
        let images = basis.map(|row| changes.map(|change| product(&change, &row)));
        Normal {
            matrix: basis.map(|row| images.map(|image| product(&row, &image) / sum)),
            right: basis.map(|row| product(&row, &products) / sum),
            basis,
            centre,
            radius,
            stretch,
        }
    }

    /// The parameters of a motion, mm.
    pub(crate) fn parameters(&self, motion: &[f64; FREEDOMS]) -> [f64; FREEDOMS] {
        std::array::from_fn(|k| {
            self.basis
                .iter()
                .zip(motion)
                .map(|(row, by)| by * row[k])
                .sum()
        })
    }

    /// The parameters of the step of least squares in the determined directions, and its length, mm.
    fn step(&self) -> ([f64; FREEDOMS], f64) {
        let (values, vectors) = symmetric_eigen(self.matrix);
        let mut step = [0.0; FREEDOMS];
        for (value, vector) in values.iter().zip(vectors) {
            if *value > LEAST_SLOPE * LEAST_SLOPE {
                let along: f64 = (0..FREEDOMS).map(|k| vector[k] * self.right[k]).sum();
                for k in 0..FREEDOMS {
                    step[k] += vector[k] * along / value;
                }
            }
        }
        let length = step.iter().map(|v| v * v).sum::<f64>().sqrt();
        (self.parameters(&step), length)
    }

    /// A pose moved by the parameters `step`.
    pub(crate) fn moved(&self, pose: &Pose, step: &[f64; FREEDOMS]) -> Pose {
        let [a, b, c, d, e, f, longer] = *step;
        let turn = scale([a, b, c], 1.0 / self.radius);
        let motion = Rigid::about(self.centre, turn, [d, e, f]);
        Pose {
            rigid: pose.rigid.then(&motion),
            change: pose.change + longer / self.stretch,
        }
    }

    /// Motion of a point by the parameters `step` without their stretch, mm.
    pub(crate) fn motion(&self, point: V3, step: &[f64; FREEDOMS]) -> V3 {
        let turn = scale([step[0], step[1], step[2]], 1.0 / self.radius);
        let by = cross(turn, sub(point, self.centre));
        add(by, [step[3], step[4], step[5]])
    }
}

/// Moves a pose until it stays, by steps of `still` mm, at most `most` times.
pub(crate) fn icp(
    scene: &Scene,
    chosen: &[usize],
    mut pose: Pose,
    view: Option<&View>,
    (most, still): (usize, f64),
) -> Pose {
    let farthest = 1.5 * WIDEST;
    let mut reach = farthest;
    for _ in 0..most {
        let matches = scene.matches(chosen, &pose, view, reach);
        let normal = Normal::of(scene, chosen, &pose, &matches);
        let (step, length) = normal.step();
        let factor = (STEP / length.max(1e-300)).min(1.0);
        pose = normal.moved(&pose, &step.map(|v| factor * v));
        if length < still {
            break;
        }
        // Pairs farther than the weights' width have no weight.
        reach = (2.0 * width(&matches) + 2.0 * length).min(farthest);
    }
    pose
}

/// Distances beyond this cost no more, mm.
const COST_LIMIT: f64 = 3.0;

/// Mean square distance of the points, mm², each at most 3 mm.
///
/// Points without a counterpart count as 3 mm.
pub(crate) fn cost(scene: &Scene, chosen: &[usize], pose: &Pose, view: Option<&View>) -> f64 {
    let matches = scene.matches(chosen, pose, view, COST_LIMIT);
    let limit = COST_LIMIT * COST_LIMIT;
    let sum = chosen
        .iter()
        .zip(&matches)
        .fold([0.0; 2], |[sum, weights], (&k, m)| {
            let square = m.map_or(limit, |m| m.distance * m.distance);
            let weight = scene.cloud.weight(k);
            [sum + weight * square, weights + weight]
        });
    sum[0] / sum[1].max(1e-9)
}
