//! Curves, tables and comparisons with one entry per compared beamformer.

use crate::experiments::outcome::{Comparison, Curve, PaperComparison};
use bonebeam_drive::methods::COMPARED;

/// One curve per beamformer: `points` by its index in [`COMPARED`].
pub fn curves(points: impl Fn(usize) -> Vec<(f64, Option<f64>)>) -> Vec<Curve> {
    let rows = COMPARED.iter().enumerate();
    rows.map(|(k, row)| Curve::new(row.name, row.featured, points(k)))
        .collect()
}

/// The paper's values of the featured beamformers, in the order of [`COMPARED`].
pub type Paper = [&'static [f64]; 2];

/// Table I of the paper: error and STD in mm, mean grey level in B and in C.
///
/// By kind of image (B-mode, phase symmetry), column and beamformer (DAS, ESMV); then the two slices.
#[rustfmt::skip]
pub static TABLE_ONE: [[[[f64; 2]; 2]; 4]; 2] = [
    [
        [[0.70, 0.90], [0.66, 0.79]],
        [[0.72, 0.85], [0.65, 0.77]],
        [[27.18, 63.06], [4.71, 10.17]],
        [[92.41, 125.52], [16.81, 15.80]],
    ],
    [
        [[0.94, 0.97], [0.84, 0.95]],
        [[0.53, 0.57], [0.42, 0.45]],
        [[32.20, 32.24], [6.60, 3.93]],
        [[3.06, 5.16], [1.24, 1.88]],
    ],
];

/// Comparison of a quantity: `here` by the beamformer's index in [`COMPARED`].
pub fn comparison(
    group: &str,
    quantity: &str,
    here: impl Fn(usize) -> Option<f64>,
    paper: Paper,
    note: &'static str,
) -> Comparison {
    let featured = COMPARED.iter().enumerate().filter(|(_, row)| row.featured);
    let values = featured
        .zip(paper)
        .map(|((k, row), paper)| PaperComparison {
            beamformer: row.key,
            name: row.name,
            here: here(k),
            paper: paper.to_vec(),
        });
    Comparison {
        group: group.to_owned(),
        quantity: quantity.to_owned(),
        values: values.collect(),
        note,
    }
}
