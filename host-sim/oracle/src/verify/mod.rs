//! Comparison of the core's results with the two references.
//!
//! They have the same bits as the f32 reference, and are within the contract's bounds of the f64 one.

pub mod beamform;
pub mod delay;
pub mod image;
pub mod kernels;
pub mod phase_symmetry;
pub mod recording;
pub mod tolerances;

pub use bonebeam_drive::check::{Bits, Bound, Check};

use bonebeam_drive::check::References;

/// The comparisons of this crate.
pub const REFERENCES: References = References {
    aligned: delay::check,
    lines: |aligned, lines| {
        let frame = beamform::AlignedFrame {
            x: aligned.x,
            active: aligned.active,
        };
        let errors = frame.errors(lines, aligned.every_f64)?;
        let bits = |&(z, parameters): &_| frame.bits(z, parameters, aligned.every_f32);
        Ok(lines.iter().map(bits).zip(errors).collect())
    },
    image: image::check,
    map: phase_symmetry::check,
};

/// The largest of some errors; a NaN counts as the largest.
fn largest(errors: impl Iterator<Item = f64>) -> f64 {
    let errors = errors.map(|e| if e.is_nan() { f64::INFINITY } else { e });
    errors.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_that_is_not_a_number_counts() {
        assert_eq!(largest([0.5, 2.0, 1.0].into_iter()), 2.0);
        assert_eq!(largest([0.5, f64::NAN, 1.0].into_iter()), f64::INFINITY);
    }
}
