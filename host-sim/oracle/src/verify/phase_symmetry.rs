//! A phase symmetry map, whole, against the f32 and the f64 reference.

use ndarray::Array2;

use crate::reference::{f32 as plain, f64 as equations};
use bonebeam_drive::phase_symmetry::Parameters;

use super::tolerances::PHASE_SYMMETRY;
use super::{Bits, Bound, largest};

/// Compares `map`, made of `image`, with both references.
pub fn check(map: &Array2<f32>, image: &Array2<f32>, parameters: &Parameters) -> (Bits, Bound) {
    let (rows, columns) = image.dim();
    let (map, image) = (map.as_standard_layout(), image.as_standard_layout());
    let expected = plain::phase_symmetry::phase_symmetry(
        image.as_slice().unwrap_or_default(),
        rows,
        columns,
        &parameters.scales,
        parameters.threshold,
    );
    let bits = Bits::real(map.as_slice().unwrap_or_default(), &expected);

    let exact = equations::phase_symmetry::phase_symmetry(
        image.mapv(f64::from).view(),
        &parameters.scales,
        f64::from(parameters.threshold),
    );
    let errors = map.iter().zip(&exact);
    let error = Bound {
        compared: exact.len(),
        largest_error: largest(errors.map(|(a, b)| (f64::from(*a) - b).abs())),
        bound: PHASE_SYMMETRY,
        ..Bound::default()
    };
    (bits, error)
}
