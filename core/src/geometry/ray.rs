//! A scan line as a ray.

use crate::Error;
use crate::error::finite;

/// A scan line by its origin and its direction.
///
/// The depth along it is the distance from its origin, which should be on the array.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Ray {
    x: f64,
    z: f64,
    angle: f64,
    sine: f64,
    cosine: f64,
}

impl Ray {
    /// A ray straight down from z = 0, at the lateral position `x` m.
    pub const fn down(x: f64) -> Self {
        Ray {
            x,
            z: 0.0,
            angle: 0.0,
            sine: 0.0,
            cosine: 1.0,
        }
    }

    /// A ray from (`x`, `z`) m at `angle` rad from the z axis.
    ///
    /// A positive angle goes towards positive x.
    pub fn new(x: f64, z: f64, angle: f64) -> Self {
        Ray {
            x,
            z,
            angle,
            sine: libm::sin(angle),
            cosine: libm::cos(angle),
        }
    }

    /// Lateral position of the origin, m.
    pub const fn x(&self) -> f64 {
        self.x
    }

    /// Depth of the origin, m.
    pub const fn z(&self) -> f64 {
        self.z
    }

    /// Angle from the z axis, rad.
    pub const fn angle(&self) -> f64 {
        self.angle
    }

    /// Position (x, z) at the distance `r` m along the ray.
    pub const fn point(&self, r: f64) -> [f64; 2] {
        [self.x + r * self.sine, self.z + r * self.cosine]
    }

    /// Coordinates of a position across and along the ray, m.
    ///
    /// The first is the distance to the right of the ray's line, the second the distance along it from the origin:
    /// (Δx·cos θ − Δz·sin θ, Δx·sin θ + Δz·cos θ).
    pub const fn coordinates(&self, [x, z]: [f64; 2]) -> [f64; 2] {
        let (dx, dz) = (x - self.x, z - self.z);
        [
            dx * self.cosine - dz * self.sine,
            dx * self.sine + dz * self.cosine,
        ]
    }

    /// The direction (sin θ, cos θ).
    pub(crate) const fn direction(&self) -> [f64; 2] {
        [self.sine, self.cosine]
    }

    /// Whether it goes straight down from z = 0.
    pub(crate) const fn is_down(&self) -> bool {
        self.sine == 0.0 && self.cosine == 1.0 && self.z == 0.0
    }

    pub(crate) const fn check(&self) -> Result<(), Error> {
        let values = [
            ("line position", self.x),
            ("line depth", self.z),
            ("line angle", self.sine),
        ];
        let mut k = 0;
        while k < values.len() {
            if let Err(error) = finite(values[k].0, values[k].1) {
                return Err(error);
            }
            k += 1;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_those_of_the_point() {
        let ray = Ray::new(-2e-3, 1e-3, 0.4);
        for r in [-1e-3, 0.0, 30e-3] {
            let [across, along] = ray.coordinates(ray.point(r));
            assert!(libm::fabs(across) < 1e-17 && libm::fabs(along - r) < 1e-17);
        }
        // A position to the right of a ray that goes down to the right.
        let [across, along] = ray.coordinates([5e-3, 1e-3]);
        assert!(libm::fabs(across - 7e-3 * libm::cos(0.4)) < 1e-17);
        assert!(libm::fabs(along - 7e-3 * libm::sin(0.4)) < 1e-17);
        // Straight down they are the differences themselves, to the bit.
        assert_eq!(
            Ray::down(0.3e-3).coordinates([1.1e-3, 0.0]),
            [1.1e-3 - 0.3e-3, 0.0]
        );
    }

    #[test]
    fn only_straight_down_from_0_is_down() {
        assert!(Ray::down(1e-3).is_down() && Ray::new(1e-3, -0.0, 0.0).is_down());
        // So slight an angle has the cosine 1.
        for (z, angle) in [(0.0, 1e-9), (1e-3, 0.0), (-1e-3, 0.0), (0.0, 3.0)] {
            assert!(!Ray::new(1e-3, z, angle).is_down(), "{z} {angle}");
        }
    }
}
