//! Scan lines of an image.

use super::{Axis, Ray};
use crate::Error;
use crate::error::{at_least_one, finite};

/// The scan lines of an image: straight down from z = 0, or rays.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Lines<'a> {
    /// Evenly spaced lines, as required for an image.
    Even(Axis),
    /// Lateral position of each line, m.
    At(&'a [f64]),
    /// Rays: of a sector, along the normals of a curved array, or steered.
    Rays(&'a [Ray]),
}

impl Lines<'_> {
    /// Number of lines.
    pub const fn count(&self) -> usize {
        match *self {
            Lines::Even(axis) => axis.count,
            Lines::At(x) => x.len(),
            Lines::Rays(rays) => rays.len(),
        }
    }

    /// Lateral position of a line's origin, m; NaN beyond the last.
    ///
    /// ```
    /// use bonebeam::geometry::{Axis, Lines};
    ///
    /// assert_eq!(Lines::Even(Axis::centred(3, 1e-3)).x(2), 1e-3);
    /// assert_eq!(Lines::At(&[0.0, 1e-3, 3e-3]).x(2), 3e-3);
    /// ```
    pub const fn x(&self, line: usize) -> f64 {
        match *self {
            Lines::Even(axis) if line < axis.count => axis.position(line),
            Lines::At(x) if line < x.len() => x[line],
            Lines::Rays(rays) if line < rays.len() => rays[line].x(),
            _ => f64::NAN,
        }
    }

    /// Line `line` as a ray; NaN beyond the last.
    pub const fn ray(&self, line: usize) -> Ray {
        match *self {
            Lines::Rays(rays) if line < rays.len() => rays[line],
            _ => Ray::down(self.x(line)),
        }
    }

    /// Refuses no lines, and positions that are not finite.
    pub(super) const fn check(&self) -> Result<(), Error> {
        if let Err(error) = at_least_one("lines", self.count()) {
            return Err(error);
        }
        match *self {
            Lines::Even(axis) => axis.check("line spacing"),
            Lines::At(x) => {
                let mut line = 0;
                while line < x.len() {
                    if let Err(error) = finite("line position", x[line]) {
                        return Err(error);
                    }
                    line += 1;
                }
                Ok(())
            }
            Lines::Rays(rays) => {
                let mut line = 0;
                while line < rays.len() {
                    if let Err(error) = rays[line].check() {
                        return Err(error);
                    }
                    line += 1;
                }
                Ok(())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beyond_the_last_line_there_is_none() {
        let rays = [Ray::down(1e-3), Ray::new(2e-3, 0.0, 0.3)];
        let all = [
            Lines::Even(Axis::centred(2, 1e-3)),
            Lines::At(&[1e-3, 2e-3]),
            Lines::Rays(&rays),
        ];
        for lines in all {
            assert_eq!(lines.count(), 2);
            assert_eq!(lines.ray(1).x().to_bits(), lines.x(1).to_bits());
            for beyond in [2, 3, usize::MAX] {
                assert!(lines.x(beyond).is_nan() && lines.ray(beyond).x().is_nan());
            }
        }
        assert_eq!(Lines::Rays(&rays).ray(1), rays[1]);
    }

    #[test]
    fn bad_rays_are_named() {
        let name = |bad: Ray| {
            let rays = [Ray::down(0.0), bad];
            match Lines::Rays(&rays).check() {
                Err(Error::Parameter { name, .. }) => name,
                Err(other) => panic!("{other:?}"),
                Ok(()) => "",
            }
        };
        assert_eq!(name(Ray::new(1e-3, 2e-3, 0.3)), "");
        for bad in [f64::NAN, f64::INFINITY] {
            assert_eq!(name(Ray::new(bad, 0.0, 0.3)), "line position");
            assert_eq!(name(Ray::new(0.0, bad, 0.3)), "line depth");
            assert_eq!(name(Ray::new(0.0, 0.0, bad)), "line angle");
        }
    }
}
