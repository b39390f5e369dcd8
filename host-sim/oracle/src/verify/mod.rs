//! Comparison of the core's results with the two references.
//!
//! They have the same bits as the f32 reference, and are within the contract's bounds of the f64 one.

pub mod beamform;
pub mod delay;
pub mod image;
pub mod kernels;
pub mod phase_symmetry;
pub mod recording;
mod references;
pub mod tolerances;

pub use bonebeam_drive::check::{Bits, Bound, Check};
pub use references::REFERENCES;

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
