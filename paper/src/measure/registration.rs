//! Rigid registration of corresponding points, and its errors.
//!
//! The rotation and translation with the least mean square distance, by the singular values of the points'
//! covariance (K. S. Arun, T. S. Huang, S. D. Blostein, IEEE PAMI 9, 698–700, 1987), with the sign that keeps
//! a rotation from being a reflection (S. Umeyama, IEEE PAMI 13, 376–380, 1991). Expected errors: J. M.
//! Fitzpatrick, J. B. West, C. R. Maurer, IEEE Trans. Med. Imaging 17, 694–702, 1998. They hold for errors of
//! localisation that are small, independent, and alike in all directions.

use nalgebra::{Matrix3, Vector3};

use crate::{Error, Result};

/// A point, m.
pub type Point = [f64; 3];

/// A rotation, then a translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rigid {
    rotation: Matrix3<f64>,
    translation: Vector3<f64>,
}

/// Relative second singular value below which points lie on a line.
const ON_A_LINE: f64 = 1e-9;

impl Rigid {
    /// Rotations about x, then y, then z, in radians, then a translation in m.
    pub fn new(angles: [f64; 3], translation: Point) -> Self {
        let turn = |axis: usize, angle: f64| {
            let (s, c) = (libm::sin(angle), libm::cos(angle));
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
            let mut m = Matrix3::identity();
            (m[(u, u)], m[(u, v)], m[(v, u)], m[(v, v)]) = (c, -s, s, c);
            m
        };
        Rigid {
            rotation: turn(2, angles[2]) * turn(1, angles[1]) * turn(0, angles[0]),
            translation: translation.into(),
        }
    }

    /// The transformed point.
    pub fn apply(&self, point: Point) -> Point {
        (self.rotation * Vector3::from(point) + self.translation).into()
    }

    /// The transform followed by a translation, m.
    pub fn moved(&self, by: Point) -> Self {
        Rigid {
            translation: self.translation + Vector3::from(by),
            ..*self
        }
    }

    /// The inverse transform.
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Rigid {
            rotation,
            translation: -(rotation * self.translation),
        }
    }

    /// The rigid transform of the points `from` that is closest to `to`.
    ///
    /// It has the least mean square distance.
    ///
    /// # Errors
    /// Fewer than three points, different numbers of points, a point that is not finite, or points on one line.
    pub fn register(from: &[Point], to: &[Point]) -> Result<Self> {
        if from.len() != to.len() || from.len() < 3 {
            return Err(Error::Data(format!(
                "registration of {} points to {}; expected equal numbers, at least 3",
                from.len(),
                to.len()
            )));
        }
        let all = from.iter().chain(to);
        if let Some(index) = all.clone().position(|p| p.iter().any(|v| !v.is_finite())) {
            return Err(Error::Data(format!(
                "registration: point {} is not finite",
                index % from.len()
            )));
        }
        let (a, b) = (centroid(from), centroid(to));
        let mut covariance = Matrix3::zeros();
        for (p, q) in from.iter().zip(to) {
            covariance += (Vector3::from(*q) - b) * (Vector3::from(*p) - a).transpose();
        }
        let svd = covariance.svd(true, true);
        let values = svd.singular_values;
        let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
            return Err(Error::Data("registration: no singular vectors".into()));
        };
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| values[b].total_cmp(&values[a]));
        if values[order[1]] <= ON_A_LINE * values[order[0]] {
            return Err(Error::Data(
                "registration: the points lie on one line; expected three that do not".into(),
            ));
        }
        let mut sign = Matrix3::identity();
        sign[(order[2], order[2])] = (u * v_t).determinant().signum();
        let rotation = u * sign * v_t;
        Ok(Rigid {
            rotation,
            translation: b - rotation * a,
        })
    }

    /// The fiducial registration error, m.
    ///
    /// It is the root mean square of the remaining distances.
    pub fn fiducial_error(&self, from: &[Point], to: &[Point]) -> f64 {
        let square = |(p, q): (&Point, &Point)| {
            (Vector3::from(self.apply(*p)) - Vector3::from(*q)).norm_squared()
        };
        let sum: f64 = from.iter().zip(to).map(square).sum();
        (sum / from.len() as f64).sqrt()
    }
}

/// Expected mean square FRE of `count` fiducials, m².
///
/// `localisation` is the mean square error of localisation.
pub fn expected_fiducial_error(count: usize, localisation: f64) -> f64 {
    (1.0 - 2.0 / count as f64) * localisation
}

/// Expected mean square error at `target` of a registration by these fiducials, m².
///
/// `localisation` is the mean square error of their localisation.
pub fn expected_target_error(fiducials: &[Point], target: Point, localisation: f64) -> f64 {
    let centre = centroid(fiducials);
    let centred: Vec<Vector3<f64>> = (fiducials.iter())
        .map(|p| Vector3::from(*p) - centre)
        .collect();
    let scatter: Matrix3<f64> = centred.iter().map(|p| p * p.transpose()).sum();
    let axes = scatter.symmetric_eigen().eigenvectors;
    let target = Vector3::from(target) - centre;
    let from_axis = |p: &Vector3<f64>, k: usize| {
        let along = p.dot(&axes.column(k));
        p.norm_squared() - along * along
    };
    let fraction = |k: usize| {
        let spread: f64 = centred.iter().map(|p| from_axis(p, k)).sum();
        from_axis(&target, k) / (spread / centred.len() as f64)
    };
    localisation / fiducials.len() as f64 * (1.0 + (0..3).map(fraction).sum::<f64>() / 3.0)
}

fn centroid(points: &[Point]) -> Vector3<f64> {
    let sum: Vector3<f64> = points.iter().map(|p| Vector3::from(*p)).sum();
    sum / points.len() as f64
}
