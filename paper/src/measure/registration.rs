//! Rigid registration of fiducials, and its errors.
//!
//! Expected errors: J. M. Fitzpatrick, J. B. West, C. R. Maurer, IEEE Trans. Med. Imaging 17, 694–702, 1998. They hold
//! for errors of localisation that are small, independent, and alike in all directions.

pub use bonebeam_register::{Rigid, V3 as Point};

use super::mean;

/// Rotations about x, then y, then z, in radians, then a translation in m.
pub fn rotated(angles: [f64; 3], translation: Point) -> Rigid {
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let (s, c) = libm::sincos(angles[axis]);
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let mut turn = Rigid::IDENTITY;
        (turn.rotation[u][u], turn.rotation[u][v]) = (c, -s);
        (turn.rotation[v][u], turn.rotation[v][v]) = (s, c);
        turn
    });
    Rigid {
        translation,
        ..x.then(&y.then(&z))
    }
}

/// The fiducial registration error, m.
///
/// It is the root mean square of the remaining distances.
pub fn fiducial_error(found: &Rigid, from: &[Point], to: &[Point]) -> f64 {
    let squares = from.iter().zip(to).map(|(from, to)| {
        let there = found.apply(*from);
        (0..3).map(|k| (there[k] - to[k]).powi(2)).sum()
    });
    mean(squares).map_or(0.0, f64::sqrt)
}

/// Expected mean square FRE of `count` fiducials, m².
///
/// `localisation` is the mean square error of localisation.
pub fn expected_fiducial_error(count: usize, localisation: f64) -> f64 {
    (1.0 - 2.0 / count as f64) * localisation
}
