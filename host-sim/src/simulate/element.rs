//! One element's response to a point.

use std::f64::consts::PI;

/// Far-field amplitude of an element of `width` at a point `dx` beside and `z` below its centre:
/// sinc(w·sin θ/λ)/r, with the rigid baffle's obliquity of 1. Amplitude 1 is that at 1 m on the
/// axis; in m, and finite for z > 0.
pub fn response(width: f64, wavelength: f64, dx: f64, z: f64) -> f64 {
    let r = (dx * dx + z * z).sqrt();
    let u = PI * width * dx / (r * wavelength);
    let directivity = if u == 0.0 { 1.0 } else { u.sin() / u };
    directivity / r
}
