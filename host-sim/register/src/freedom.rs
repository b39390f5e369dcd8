//! The motions that the points determine least.
//!
//! Eigenvectors of the normal matrix are motions; an eigenvalue is the mean square change of distances by a motion of
//! 1 mm. How far a motion may go is read from the distances themselves, so that a rough mesh does not seem to hold.

use serde::Serialize;

use crate::algebra::{V3, add, cross, dot, norm, scale, symmetric_eigen};
use crate::icp::{FREEDOMS, Normal, tukey, width};
use crate::scene::{Pose, Scene, View};

/// A motion is not determined if it may go this far, mm: the clinic's bar.
pub const BAR: f64 = 2.0;
/// Side of the cubes whose points count as one observation, mm.
const PATCH: f64 = 20.0;
/// Least standard deviation of distances, mm: no surface is known better.
const LEAST_ERROR: f64 = 0.1;
/// The largest motion that is tried, mm.
const FARTHEST: f64 = 16.0;
/// Root mean square slope below which motions are sorted into slides and turns.
const WEAK: f64 = 0.12;

/// A motion and how well it is determined.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Freedom {
    /// Sliding, turning or stretching.
    pub kind: Kind,
    /// Direction of the slide or axis of the turn, in the bone's coordinates.
    pub direction: V3,
    /// A point on the axis of a turn, mm.
    pub through: V3,
    /// Root mean square change of the distances by this motion of 1 mm.
    pub slope: f64,
    /// Twice the standard deviation, mm; 16 stands for 16 or more.
    pub uncertainty: f64,
    /// The same of a turn, degrees; of a stretch, as a share.
    pub amount: Option<f64>,
    /// Motion from the start to the result along it, mm.
    pub moved: f64,
}

/// The kind of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A translation along a direction.
    Slide,
    /// A rotation about an axis.
    Turn,
    /// A change of scale or of the sound speed.
    Stretch,
}

impl Freedom {
    /// Whether the motion may exceed 2 mm.
    pub fn is_open(&self) -> bool {
        self.uncertainty > BAR
    }
}

impl std::fmt::Display for Freedom {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let text = |v: V3, digits: usize| v.map(|v| format!("{v:.digits$}")).join(", ");
        let amount = self.amount.unwrap_or_default();
        match self.kind {
            Kind::Slide => write!(f, "sliding along ({})", text(self.direction, 2))?,
            Kind::Turn => write!(
                f,
                "turning about ({}) through ({}) mm",
                text(self.direction, 2),
                text(self.through, 0)
            )?,
            Kind::Stretch => f.write_str("stretching")?,
        }
        let state = if self.is_open() {
            ": not determined"
        } else {
            ": determined"
        };
        let more = if self.uncertainty >= FARTHEST {
            " or more"
        } else {
            ""
        };
        write!(f, "{state}, ±{:.1} mm", self.uncertainty)?;
        match self.kind {
            Kind::Slide => {}
            Kind::Turn => write!(f, " (±{amount:.1}°)")?,
            Kind::Stretch => write!(f, " (±{:.1} %)", 100.0 * amount)?,
        }
        write!(f, "{more}; moved by {:.1} mm", self.moved)
    }
}

/// All motions, the least determined first.
pub(crate) fn freedoms(
    scene: &Scene,
    chosen: &[usize],
    start: &Pose,
    pose: &Pose,
    view: Option<&View>,
) -> Vec<Freedom> {
    let matches = scene.matches(chosen, pose, view, FARTHEST);
    let normal = Normal::of(scene, chosen, pose, &matches, false);
    let (values, mut vectors) = symmetric_eigen(normal.matrix);
    let weak = values.partition_point(|value| *value < WEAK * WEAK);
    sort_turns(&mut vectors[..weak], |v| normal.parameters(v));

    let width = width(&matches);
    let weights: Vec<f64> = (chosen.iter().zip(&matches))
        .map(|(&k, m)| m.map_or(0.0, |m| scene.cloud.weight(k) * tukey(m.distance, width)))
        .collect();
    let weight: f64 = weights.iter().sum::<f64>().max(1e-9);
    // Mean square distance of the weighted points.
    let square = |pose: &Pose| {
        let matches = scene.matches(chosen, pose, view, FARTHEST);
        let squares = matches.iter().zip(&weights).map(|(m, w)| {
            let distance = m.map_or(width, |m| m.distance.min(width));
            w * distance * distance
        });
        squares.sum::<f64>() / weight
    };
    let least = square(pose);
    let error = least.max(LEAST_ERROR * LEAST_ERROR);
    let patches = scene.cloud.cells(PATCH).len().max(6) as f64;
    let of = |vector: &[f64; FREEDOMS]| {
        let step = normal.parameters(vector);
        let open = |by: f64| {
            // Two standard deviations raise χ² by 4.
            [-1.0, 1.0].into_iter().any(|sign| {
                let moved = normal.moved(pose, &step.map(|v| sign * by * v));
                patches * (square(&moved) - least) / error < 4.0
            })
        };
        let ladder = (0..).map(|k| 0.05 * f64::powf(2.0, 0.5 * f64::from(k)));
        let mut ladder = ladder.take_while(|by| *by < FARTHEST);
        let uncertainty = ladder.find(|by| !open(*by)).unwrap_or(FARTHEST);
        let [a, b, c, d, e, f, longer] = step;
        let (turn, slide) = ([a, b, c], [d, e, f]);
        let rate = norm(turn) / normal.radius;
        let lengths = [norm(slide), norm(turn), longer.abs()];
        let (kind, direction, amount) = match lengths {
            [_, turned, longer] if longer > turned && longer > lengths[0] => {
                (Kind::Stretch, [0.0; 3], Some(longer / normal.stretch))
            }
            [slid, turned, _] if turned > slid => (
                Kind::Turn,
                scale(turn, 1.0 / norm(turn)),
                Some(rate.to_degrees()),
            ),
            _ => (Kind::Slide, scale(slide, 1.0 / lengths[0]), None),
        };
        // The axis is where the slide across it vanishes.
        let beside = scale(
            cross(turn, slide),
            normal.radius / dot(turn, turn).max(1e-12),
        );
        let sign = if direction.iter().sum::<f64>() < 0.0 {
            -1.0
        } else {
            1.0
        };
        let moved = chosen.iter().map(|&k| {
            let (from, to) = (scene.moved(k, start), scene.moved(k, pose));
            let by = normal.motion(to, &step);
            (0..3).map(|i| by[i] * (to[i] - from[i])).sum::<f64>()
        });
        Freedom {
            kind,
            direction: scale(direction, sign),
            through: if kind == Kind::Turn {
                add(normal.centre, beside)
            } else {
                normal.centre
            },
            slope: form(&normal.matrix, vector).sqrt(),
            uncertainty,
            amount: amount.map(|amount| amount * uncertainty),
            moved: (moved.sum::<f64>() / chosen.len() as f64).abs(),
        }
    };
    let mut freedoms: Vec<Freedom> = (vectors.iter())
        // The factor that is no parameter moves nothing.
        .filter(|v| normal.parameters(v) != [0.0; FREEDOMS])
        .map(of)
        .collect();
    freedoms.sort_by(|a, b| b.uncertainty.total_cmp(&a.uncertainty));
    freedoms
}

/// vᵀ·A·v, at least 0.
fn form(a: &[[f64; FREEDOMS]; FREEDOMS], v: &[f64; FREEDOMS]) -> f64 {
    let row = |i: usize| v[i] * (0..FREEDOMS).map(|j| a[i][j] * v[j]).sum::<f64>();
    (0..FREEDOMS).map(row).sum::<f64>().max(0.0)
}

/// Turns alike eigenvectors into ones with as little and as much rotation as they allow.
///
/// A round shaft slides and turns freely, and its eigenvectors are any mixture of the two.
fn sort_turns(
    vectors: &mut [[f64; FREEDOMS]],
    parameters: impl Fn(&[f64; FREEDOMS]) -> [f64; FREEDOMS],
) {
    let mut shares = [[0.0; FREEDOMS]; FREEDOMS];
    let turns: Vec<_> = vectors.iter().map(parameters).collect();
    for (i, v) in turns.iter().enumerate() {
        for (j, w) in turns.iter().enumerate() {
            shares[i][j] = (0..3).map(|k| v[k] * w[k]).sum();
        }
    }
    for k in vectors.len()..FREEDOMS {
        // Keeps the unused rows last.
        shares[k][k] = 1e9;
    }
    let mixtures = symmetric_eigen(shares).1;
    let old = vectors.to_vec();
    for (vector, mixture) in vectors.iter_mut().zip(mixtures) {
        *vector = std::array::from_fn(|k| old.iter().zip(mixture).map(|(v, by)| by * v[k]).sum());
    }
}
