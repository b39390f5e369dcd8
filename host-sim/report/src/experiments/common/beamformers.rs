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
