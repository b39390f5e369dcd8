//! Bilinear scan conversion: lines of a fan to isotropic pixels.

use super::finite_largest;
use super::resample::{check_axes, interpolate};
use crate::Error;
use crate::error::{check_length, finite};
use crate::geometry::Axis;

/// Lines that fan out from one point: a sector, or the normals of a convex array.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Fan {
    /// Lateral position of the apex, m.
    pub x: f64,
    /// Depth of the apex, m; above a convex array.
    pub z: f64,
    /// Distance of the lines' beginning from the apex, m.
    ///
    /// 0 for a sector, the radius of a convex array.
    pub radius: f64,
}

impl Fan {
    pub(super) fn check(&self) -> Result<(), Error> {
        finite("fan x", self.x)?;
        finite("fan z", self.z)?;
        if self.radius >= 0.0 && self.radius.is_finite() {
            return Ok(());
        }
        let expected = "a finite number of at least 0";
        Err(Error::parameter("fan radius", self.radius, expected))
    }
}

/// Bilinear interpolation of `data[line][sample]` at the pixels of an image.
///
/// All arrays are row-major; the image is `[row][column]` with row 0 shallowest. The lines are at `angles` (rad,
/// from the z axis) of a `fan`, and their samples at the distances `samples` from the lines' beginnings.
///
/// A pixel `u = x − x₀`, `v = z − z₀` from the fan's apex has the angle `atan2(u, v)` and the distance `√(u² + v²)
/// − radius`, in f64. The value is interpolated between four data points as in [`resample()`](super::resample()).
/// Outside the data it is 0.
///
/// Per pixel 6 f32 multiplications and, in f64, a root, an arctangent and two divisions.
///
/// ```
/// use bonebeam::geometry::Axis;
/// use bonebeam::image::{Fan, scan_convert};
///
/// // Two lines, a right angle apart, of two samples: 1 and 2 on the left one, 3 and 4 on the right.
/// let quarter = core::f64::consts::FRAC_PI_4;
/// let angles = Axis { first: -quarter, step: 2.0 * quarter, count: 2 };
/// let samples = Axis { first: 1.0, step: 1.0, count: 2 };
/// let fan = Fan { x: 0.0, z: 0.0, radius: 0.0 };
/// // Straight below, 1.5 deep.
/// let (row, column) = (Axis { first: 1.5, step: 1.0, count: 1 }, Axis { first: 0.0, step: 1.0, count: 1 });
/// let mut pixel = [0.0];
/// scan_convert(&[1.0, 2.0, 3.0, 4.0], fan, [angles, samples], [row, column], &mut pixel)?;
/// assert_eq!(pixel, [2.5]);
/// # Ok::<(), bonebeam::Error>(())
/// ```
///
/// # Errors
/// As [`resample()`](super::resample()), and [`Error::Parameter`] for a fan that is not finite or has a negative
/// radius. `out` is then unchanged.
pub fn scan_convert(
    data: &[f32],
    fan: Fan,
    [angles, samples]: [Axis; 2],
    [rows, columns]: [Axis; 2],
    out: &mut [f32],
) -> Result<(), Error> {
    check_axes(&angles, &samples, &rows, &columns)?;
    fan.check()?;
    let lines = angles.count.saturating_mul(samples.count);
    check_length("lines to convert", data.len(), lines)?;
    let pixels = rows.count.saturating_mul(columns.count);
    check_length("converted image", out.len(), pixels)?;
    let most = finite_largest("lines to convert", data)?;
    for (row, pixels) in out.chunks_exact_mut(columns.count.max(1)).enumerate() {
        let v = rows.position(row) - fan.z;
        for (column, pixel) in pixels.iter_mut().enumerate() {
            let u = columns.position(column) - fan.x;
            let position = angles.locate(libm::atan2(u, v));
            let distance = libm::sqrt(u * u + v * v) - fan.radius;
            let value = position
                .zip(samples.locate(distance))
                .and_then(|(line, sample)| interpolate((data, most), samples.count, line, sample));
            *pixel = value.unwrap_or(0.0);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_that_is_linear_in_angle_and_distance_is_found_again() {
        let fan = Fan {
            x: 1e-3,
            z: -40e-3,
            radius: 40e-3,
        };
        let angles = Axis::centred(41, 0.02);
        let samples = Axis::new(2e-3, 0.5e-3, 60);
        let field = |angle: f64, distance: f64| (3.0 * angle + 50.0 * distance + 2.0) as f32;
        let data: [f32; 41 * 60] =
            core::array::from_fn(|k| field(angles.position(k / 60), samples.position(k % 60)));
        let every = crate::step(2);
        let rows = Axis::new(-3e-3, 0.7e-3 * every as f64, 60 / every);
        let columns = Axis::centred(80 / every, 0.9e-3 * every as f64);
        let mut out = [f32::NAN; 60 * 80];
        let out = &mut out[..rows.count * columns.count];
        scan_convert(&data, fan, [angles, samples], [rows, columns], out).unwrap();
        let mut inside = 0;
        for (k, &pixel) in out.iter().enumerate() {
            let (x, z) = (
                columns.position(k % columns.count),
                rows.position(k / columns.count),
            );
            // The polar coordinates by another way: asin instead of atan2.
            let from = libm::hypot(x - fan.x, z - fan.z);
            let (angle, distance) = (libm::asin((x - fan.x) / from), from - fan.radius);
            let within = angle.abs() <= 0.4 && (2e-3..=31.5e-3).contains(&distance);
            if within {
                inside += 1;
                assert!((pixel - field(angle, distance)).abs() < 2e-6, "{x} {z}");
            } else {
                assert_eq!(pixel, 0.0, "{x} {z}");
            }
        }
        assert!(inside * every * every > 1000, "{inside}");
    }

    #[test]
    fn bad_fans_are_named() {
        let axis = Axis::centred(2, 1.0);
        let name = |x, z, radius| {
            let fan = Fan { x, z, radius };
            match scan_convert(&[0.0; 4], fan, [axis, axis], [axis, axis], &mut [0.0; 4]) {
                Err(Error::Parameter { name, .. }) => name,
                other => panic!("{other:?}"),
            }
        };
        assert_eq!(name(f64::NAN, 0.0, 0.0), "fan x");
        assert_eq!(name(0.0, f64::INFINITY, 0.0), "fan z");
        assert_eq!(name(0.0, 0.0, -1.0), "fan radius");
    }
}
