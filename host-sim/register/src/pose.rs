//! Rigid transforms, and the one that maps landmarks to landmarks.

use crate::algebra::{V3, add, cross, dot, mean, norm, scale, sub, symmetric_eigen};
use crate::{Error, Result};

/// A rotation, then a translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rigid {
    /// Rows of the rotation.
    pub rotation: [V3; 3],
    /// In the unit of the points.
    pub translation: V3,
}

/// Largest deviation of a given rotation from an orthonormal one.
const ORTHONORMAL: f64 = 1e-3;

impl Rigid {
    /// No motion.
    pub const IDENTITY: Self = Rigid {
        rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        translation: [0.0; 3],
    };

    /// The transformed point.
    pub fn apply(&self, point: V3) -> V3 {
        add(self.turn(point), self.translation)
    }

    /// The rotated direction.
    pub fn turn(&self, direction: V3) -> V3 {
        self.rotation.map(|row| dot(row, direction))
    }

    /// This transform, then `next`.
    pub fn then(&self, next: &Rigid) -> Rigid {
        let columns = [0, 1, 2].map(|k| next.turn(self.rotation.map(|row| row[k])));
        Rigid {
            rotation: [0, 1, 2].map(|i| columns.map(|column| column[i])),
            translation: next.apply(self.translation),
        }
    }

    /// The inverse transform.
    pub fn inverse(&self) -> Rigid {
        let rotation = [0, 1, 2].map(|k| self.rotation.map(|row| row[k]));
        let back = rotation.map(|row| -dot(row, self.translation));
        Rigid {
            rotation,
            translation: back,
        }
    }

    /// A rotation about `centre` by the vector `turn`, rad, then a translation.
    pub fn about(centre: V3, turn: V3, translation: V3) -> Rigid {
        let angle = norm(turn);
        let (s, c) = (0.5 * angle).sin_cos();
        let axis = scale(turn, if angle > 0.0 { s / angle } else { 0.0 });
        let mut pose = Rigid {
            rotation: of_quaternion([c, axis[0], axis[1], axis[2]]),
            translation: [0.0; 3],
        };
        pose.translation = add(translation, sub(centre, pose.turn(centre)));
        pose
    }

    /// The angle of the rotation, rad.
    pub fn angle(&self) -> f64 {
        let [x, y, z] = self.rotation;
        // Accurate near 0, unlike the arc cosine of the trace.
        let axis = [z[1] - y[2], x[2] - z[0], y[0] - x[1]];
        norm(axis).atan2(x[0] + y[1] + z[2] - 1.0)
    }

    /// Rows of the 4 × 4 matrix.
    pub fn rows(&self) -> [[f64; 4]; 4] {
        let row = |k: usize| {
            let [a, b, c] = self.rotation[k];
            [a, b, c, self.translation[k]]
        };
        [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
    }

    /// The transform of a 4 × 4 matrix, row by row.
    ///
    /// # Errors
    /// A number that is not finite, or a matrix that is no rotation with a translation.
    pub fn of_rows(matrix: &[f64]) -> std::result::Result<Rigid, String> {
        let [rows @ .., last] = matrix.as_chunks::<4>().0 else {
            return Err("needs 16 numbers, row by row".into());
        };
        let [x, y, z] = rows else {
            return Err(format!("has {} numbers; expected 16", matrix.len()));
        };
        if matrix.len() != 16 || matrix.iter().any(|v| !v.is_finite()) {
            return Err("needs 16 finite numbers".into());
        }
        let pose = Rigid {
            rotation: [x, y, z].map(|row| [row[0], row[1], row[2]]),
            translation: [x, y, z].map(|row| row[3]),
        };
        let [a, b, c] = pose.rotation;
        let off = sub(cross(a, b), c);
        let lengths = [a, b, c].map(|row| (norm(row) - 1.0).abs());
        let worst = lengths.into_iter().fold(norm(off), f64::max);
        if worst > ORTHONORMAL || *last != [0.0, 0.0, 0.0, 1.0] {
            return Err(
                "is not a rotation with a translation; expected orthonormal rows without scale or mirror, \
                 row by row, and 0 0 0 1 at the end"
                    .into(),
            );
        }
        Ok(pose)
    }

    /// The transform of the points `from` with the least mean square distance to `to`.
    ///
    /// B. K. P. Horn, Closed-form solution of absolute orientation using unit quaternions, J. Opt. Soc. Am. A 4,
    /// 629–642, 1987.
    ///
    /// # Errors
    /// Fewer than three points, different numbers of points, or points on one line.
    pub fn of_landmarks(from: &[V3], to: &[V3]) -> Result<Rigid> {
        if from.len() != to.len() || from.len() < 3 {
            return Err(Error::Data(format!(
                "{} landmarks of the points and {} of the mesh; expected equal numbers, at least 3",
                from.len(),
                to.len()
            )));
        }
        if let Some(k) = (from.iter().chain(to)).position(|p| p.iter().any(|v| !v.is_finite())) {
            let message = format!("landmark {} is not finite", k % from.len());
            return Err(Error::Data(message));
        }
        let (a, b) = (mean(from.iter().copied()), mean(to.iter().copied()));
        // Sums of products of coordinates.
        let mut s = [[0.0; 3]; 3];
        for (p, q) in from.iter().zip(to) {
            let (p, q) = (sub(*p, a), sub(*q, b));
            for i in 0..3 {
                for j in 0..3 {
                    s[i][j] += p[i] * q[j];
                }
            }
        }
        let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = s;
        let (values, vectors) = symmetric_eigen([
            [xx + yy + zz, yz - zy, zx - xz, xy - yx],
            [yz - zy, xx - yy - zz, xy + yx, zx + xz],
            [zx - xz, xy + yx, yy - xx - zz, yz + zy],
            [xy - yx, zx + xz, yz + zy, zz - xx - yy],
        ]);
        // On a line, turning about it changes nothing: the two largest are equal.
        if values[3] - values[2] <= 1e-9 * values[3] {
            return Err(Error::Data(
                "the landmarks lie on one line; expected three that do not".into(),
            ));
        }
        let rotation = of_quaternion(vectors[3]);
        let mut pose = Rigid {
            rotation,
            translation: [0.0; 3],
        };
        pose.translation = sub(b, pose.turn(a));
        Ok(pose)
    }
}

/// Rows of the rotation of a unit quaternion, scalar first.
pub(crate) fn of_quaternion([w, x, y, z]: [f64; 4]) -> [V3; 3] {
    [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - w * z),
            2.0 * (x * z + w * y),
        ],
        [
            2.0 * (x * y + w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - w * x),
        ],
        [
            2.0 * (x * z - w * y),
            2.0 * (y * z + w * x),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    const LANDMARKS: [V3; 4] = [
        [0.0, 3.5, 15.0],
        [0.3, -8.5, 15.6],
        [11.0, 4.0, 27.0],
        [-11.4, -9.0, 28.0],
    ];

    #[test]
    fn landmarks_give_the_transform_that_was_applied() {
        let known = Rigid::about([3.0, 4.0, 5.0], [0.3, -0.7, 2.5], [40.0, -110.0, 20.0]);
        let moved = LANDMARKS.map(|p| known.apply(p));
        let found = Rigid::of_landmarks(&LANDMARKS, &moved).unwrap();
        for p in [[0.0; 3], [100.0, 0.0, 0.0], LANDMARKS[2]] {
            assert!(norm(sub(found.apply(p), known.apply(p))) < 1e-10);
            assert!(norm(sub(found.inverse().apply(known.apply(p)), p)) < 1e-10);
            let twice = known.apply(known.apply(p));
            assert!(norm(sub(known.then(&known).apply(p), twice)) < 1e-10);
        }
        assert!(known.then(&found.inverse()).angle() < 1e-12);
        let angle = norm([0.3, -0.7, 2.5]);
        assert!((known.angle() - angle).abs() < 1e-12);
        let rows = known.rows();
        assert_eq!(Rigid::of_rows(rows.as_flattened()), Ok(known));
        // A quarter turn about x takes y to z.
        let quarter = Rigid::about([0.0; 3], [std::f64::consts::FRAC_PI_2, 0.0, 0.0], [0.0; 3]);
        assert!(norm(sub(quarter.apply([0.0, 1.0, 0.0]), [0.0, 0.0, 1.0])) < 1e-15);
    }

    #[test]
    fn transforms_and_landmarks_that_determine_nothing_are_refused() {
        let line = [1.0, 2.0, 4.0].map(|t| [t, 2.0 * t, 0.5 - t]);
        let message = |from: &[V3], to: &[V3]| {
            let refused = Rigid::of_landmarks(from, to);
            refused.unwrap_err().to_string()
        };
        assert!(message(&line, &line).contains("one line"));
        assert!(message(&LANDMARKS[..2], &LANDMARKS[..2]).contains("at least 3"));
        assert!(message(&LANDMARKS, &LANDMARKS[..3]).contains("4 landmarks"));
        let mut broken = LANDMARKS;
        broken[1][2] = f64::NAN;
        assert!(message(&LANDMARKS, &broken).contains("landmark 1 is not finite"));
        let mut rows = Rigid::IDENTITY.rows();
        rows[0][0] = -1.0;
        let mirrored = Rigid::of_rows(rows.as_flattened()).unwrap_err();
        assert!(mirrored.contains("mirror"), "{mirrored}");
        assert!(Rigid::of_rows(&[1.0; 15]).unwrap_err().contains("16"));
        assert!(
            Rigid::of_rows(&[f64::NAN; 16])
                .unwrap_err()
                .contains("finite")
        );
    }
}
