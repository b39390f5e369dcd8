//! Iterative closest points, from point to plane, with weights.
//!
//! Y. Chen, G. Medioni, Object modelling by registration of multiple range images, Image and Vision Computing 10,
//! 145–155, 1992. The weights are Tukey's, whose width follows the median distance. Directions of motion that the
//! normals do not determine stay as they are (J. Zhang, M. Kaess, S. Singh, On degeneracy of optimization-based state
//! estimation problems, ICRA 2016). Points of a frame share the error of its pose, a small random motion: least squares
//! are those of this covariance (C. R. Henderson, Biometrics 31, 423–447, 1975).

use std::collections::BTreeMap;

use crate::algebra::{V3, add, congruent, cross, dot, image, mean, scale, sub, symmetric_eigen};
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
/// Standard deviations of a frame's pose, mm and radians about its points' middle, and of a point in its frame, mm.
const SHIFT: f64 = 0.3;
const TURN: f64 = 0.3f64.to_radians();
/// A point's is wide: neighbours share errors, and a sound speed 2 % off moves a sweep by 1.0 mm, by 3.5 mm with 0.2.
const POINT: f64 = 1.0;
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

/// Sums over the points of a frame.
#[derive(Clone, Copy, Default)]
struct Sums {
    changes: [[f64; FREEDOMS]; FREEDOMS],
    products: [f64; FREEDOMS],
    middle: V3,
    weight: f64,
}

impl Sums {
    /// The sums in units of a point's variance, if the frame has a random motion besides.
    ///
    /// With H the changes, g the products and S the root of the motion's covariance: H − H·S·(1 + Sᵀ·H·S)⁻¹·Sᵀ·H, and g
    /// likewise. A single frame moves as without.
    fn less_its_motion(&self, radius: f64) -> ([[f64; FREEDOMS]; FREEDOMS], [f64; FREEDOMS]) {
        let unit = |row: [f64; FREEDOMS]| row.map(|v| v / (POINT * POINT));
        let (changes, products) = (self.changes.map(unit), unit(self.products));
        let back = scale(self.middle, -1.0 / self.weight.max(1e-300));
        // Rows: the parameters of the motion's independent parts.
        let mut motion = [[0.0; FREEDOMS]; FREEDOMS];
        for k in 0..3 {
            let mut axis = [0.0; 3];
            axis[k] = TURN;
            motion[k][k] = radius * TURN;
            motion[k][3..6].copy_from_slice(&cross(axis, back));
            motion[3 + k][3 + k] = SHIFT;
        }
        let mut inner = congruent(&changes, &motion);
        (0..FREEDOMS).for_each(|k| inner[k][k] += 1.0);
        let (values, vectors) = symmetric_eigen(inner);
        // Rows: H·S·v of the eigenvectors v of what is inverted.
        let moved = vectors.map(|vector| {
            let mut parameters = [0.0; FREEDOMS];
            for (row, part) in motion.iter().zip(vector) {
                (0..FREEDOMS).for_each(|k| parameters[k] += part * row[k]);
            }
            (parameters, image(&changes, &parameters))
        });
        let (mut cost, mut gain) = (changes, products);
        for (value, (parameters, change)) in values.iter().zip(moved) {
            let by = parameters
                .iter()
                .zip(products)
                .map(|(a, b)| a * b)
                .sum::<f64>()
                / value;
            for i in 0..FREEDOMS {
                (0..FREEDOMS).for_each(|j| cost[i][j] -= change[i] * change[j] / value);
                gain[i] -= change[i] * by;
            }
        }
        (cost, gain)
    }
}

/// The least squares of matched points.
pub(crate) struct Normal {
    /// Weighted mean square change of distances by motions of 1 mm.
    pub matrix: [[f64; FREEDOMS]; FREEDOMS],
    /// The least squares if frames have errors of their own: what motions of 1 mm cost, and gain.
    cost: [[f64; FREEDOMS]; FREEDOMS],
    gain: [f64; FREEDOMS],
    /// Rows: parameters of motions that are independent, and 1 mm in the root mean square of the points.
    basis: [[f64; FREEDOMS]; FREEDOMS],
    pub centre: V3,
    /// Root mean square distance of the points from the centre, mm.
    pub radius: f64,
    /// Root mean square change of positions by a change of the factor by 1, mm.
    pub stretch: f64,
}

impl Normal {
    /// The least squares of some points' matches; all of one frame, or by their frames.
    pub(crate) fn of(
        scene: &Scene,
        chosen: &[usize],
        pose: &Pose,
        matches: &[Option<Match>],
        by_frames: bool,
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
        let mut frames: BTreeMap<i64, Sums> = BTreeMap::new();
        let mut motions = [[0.0; FREEDOMS]; FREEDOMS];
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
            let frame = scene.cloud.frame.get(k).filter(|_| by_frames);
            let frame = frame.copied().unwrap_or(0);
            let frame = frames.entry(frame).or_default();
            for i in 0..FREEDOMS {
                for j in 0..FREEDOMS {
                    frame.changes[i][j] += weight * row[i] * row[j];
                    motions[i][j] += weight * dot(by[i], by[j]);
                }
                frame.products[i] -= weight * row[i] * m.along;
            }
            frame.middle = add(frame.middle, scale(sub(m.point, centre), weight));
            frame.weight += weight;
            sum += weight;
        }
        let mut changes = [[0.0; FREEDOMS]; FREEDOMS];
        let (mut cost, mut gain) = (changes, [0.0; FREEDOMS]);
        for frame in frames.values() {
            let (own_cost, own_gain) = frame.less_its_motion(radius);
            for i in 0..FREEDOMS {
                for j in 0..FREEDOMS {
                    changes[i][j] += frame.changes[i][j];
                    cost[i][j] += own_cost[i][j];
                }
                gain[i] += own_gain[i];
            }
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
        Normal {
            matrix: congruent(&changes, &basis).map(|row| row.map(|v| v / sum)),
            cost: congruent(&cost, &basis),
            gain: image(&basis, &gain),
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
        let (values, mut vectors) = symmetric_eigen(self.matrix);
        for (value, vector) in values.iter().zip(&mut vectors) {
            if *value <= LEAST_SLOPE * LEAST_SLOPE {
                *vector = [0.0; FREEDOMS];
            }
        }
        let (costs, rows) = symmetric_eigen(congruent(&self.cost, &vectors));
        let gain = image(&vectors, &self.gain);
        let mut step = [0.0; FREEDOMS];
        for (cost, row) in costs.iter().zip(rows) {
            if *cost > 1e-9 * costs[FREEDOMS - 1] {
                let along = row.iter().zip(gain).map(|(a, b)| a * b).sum::<f64>() / cost;
                for (vector, part) in vectors.iter().zip(row) {
                    (0..FREEDOMS).for_each(|k| step[k] += along * part * vector[k]);
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
        // Far from the bone the distances are no errors of frames.
        let normal = Normal::of(scene, chosen, &pose, &matches, still < ROUGH);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A frame whose points show each motion alike.
    fn frame(changes: f64) -> Sums {
        let mut frame = Sums {
            weight: 1.0,
            ..Sums::default()
        };
        for k in 0..FREEDOMS {
            frame.changes[k][k] = changes;
            frame.products[k] = changes * (k as f64 - 2.5);
        }
        frame
    }

    #[test]
    fn few_points_count_each_and_many_no_more_than_the_pose_allows() {
        let radius = 20.0;
        let (few, _) = frame(1e-6).less_its_motion(radius);
        let (many, _) = frame(1e6).less_its_motion(radius);
        for k in 0..6 {
            let deviation = if k < 3 { radius * TURN } else { SHIFT };
            assert!(
                (few[k][k] * POINT * POINT * 1e6 - 1.0).abs() < 1e-3,
                "{few:?}"
            );
            assert!(
                (many[k][k] * deviation * deviation - 1.0).abs() < 1e-3,
                "{many:?}"
            );
        }
        // The factor is the same for all frames.
        assert_eq!(many[6][6], 1e6 / (POINT * POINT));
    }

    #[test]
    fn a_single_frame_moves_as_its_points_do() {
        let mut frame = frame(3.0);
        frame.middle = [10.0, -4.0, 25.0];
        let (cost, gain) = frame.less_its_motion(20.0);
        let motion = std::array::from_fn(|k| k as f64 - 2.5);
        for (found, expected) in image(&cost, &motion).iter().zip(gain) {
            assert!(
                (found - expected).abs() < 1e-9 * expected.abs().max(1.0),
                "{found} {expected}"
            );
        }
    }
}
