//! Refraction at the face of a lens before the elements.
//!
//! The path of least time from an element through a lens of thickness `h` and speed `c₁` into tissue of speed `c` takes
//! `h/c₁ + z/c + x²/(2(h·c₁ + z·c))` to a point `z` before the face and a small `x` beside the element. That is the time
//! from a place `h·c₁/c` behind the face, later by a constant: the elements are moved there, and the time straight
//! through the lens stays the recording's.

use bonebeam::geometry::{Element, Ray};

use crate::config::Beamform;

/// How far behind the face the elements seem to lie, m; 0 without a lens.
#[derive(Clone, Copy)]
pub(super) struct Lens(f64);

impl Lens {
    /// The lens of the parameters before tissue of a sound speed, m/s.
    pub fn new(parameters: &Beamform, c: f64) -> Self {
        Lens(parameters.lens_thickness.unwrap_or(0.0) * parameters.lens_speed / c)
    }

    /// How far behind the face the elements seem to lie, m.
    pub fn behind(self) -> f64 {
        self.0
    }

    /// Elements of a curved array, moved back along their normals.
    ///
    /// The coordinates move with the middle, so those of a straight array stay where they are.
    pub fn moved(self, elements: Vec<Element>) -> Vec<Element> {
        let moved = |e: Element| {
            let (sin, cos) = e.angle.sin_cos();
            Element {
                x: e.x - self.0 * sin,
                z: e.z + self.0 * (1.0 - cos),
                angle: e.angle,
            }
        };
        elements.into_iter().map(moved).collect()
    }

    /// A line from moved elements as one that begins at the face.
    pub fn at_face(self, ray: Ray) -> Ray {
        let [x, z] = ray.point(self.0);
        Ray::new(x, z - self.0, ray.angle())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const C: f64 = 1540.0;

    /// The least time over all places where a path can leave the lens, straight from Fermat's principle.
    fn fermat(thickness: f64, speed: f64, x: f64, z: f64) -> f64 {
        let time = |at: f64| thickness.hypot(at) / speed + z.hypot(x - at) / C;
        let (mut low, mut high) = (0.0, x);
        for _ in 0..200 {
            let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
            if time(a) < time(b) {
                high = b;
            } else {
                low = a;
            }
        }
        time((low + high) / 2.0)
    }

    #[test]
    fn delays_are_those_of_the_shortest_path() {
        let mut straight = 0.0f64;
        // Silicone, and a hard lens.
        for (thickness, speed, within) in [
            (0.5e-3, 1000.0, 1.5e-9),
            (1e-3, 1000.0, 1.5e-9),
            (1e-3, 2400.0, 10e-9),
        ] {
            let parameters = Beamform {
                lens_thickness: Some(thickness),
                lens_speed: speed,
                ..Beamform::default()
            };
            let lens = Lens::new(&parameters, C);
            for z in [4e-3, 10e-3, 30e-3] {
                // As far aside as apertures of f-number 1 reach.
                for k in 0..=10 {
                    let x = 0.05 * f64::from(k) * z;
                    let exact = fermat(thickness, speed, x, z);
                    let constant = thickness / speed;
                    let moved = (z + lens.0).hypot(x) / C - lens.0 / C + constant;
                    assert!(
                        (moved - exact).abs() < within,
                        "{thickness} {speed} {x} {z}"
                    );
                    straight = straight.max((z.hypot(x) / C + constant - exact).abs());
                }
            }
        }
        // What a constant delay alone leaves.
        assert!(straight > 100e-9, "{straight}");
    }
}
