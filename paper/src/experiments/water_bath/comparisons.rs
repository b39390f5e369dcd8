//! Table I and the image lines of Figs. 8 and 9 beside the paper's figures.

use crate::experiments::common::beamformers::{Paper, TABLE_ONE, comparison};
use crate::experiments::study::*;
use crate::measure::line::Line;
use bonebeam_drive::methods::COMPARED;

use super::contour::Row;
use super::measures::{Measured, SEARCH};
use super::parameters::{KINDS, METHODS};

const BATH: &str = "All sources of error are on; fiducials are picked at their brightest voxel. Bone and bath \
     differ from the paper's, the array is of the same kind, and the noise is assumed.";
const LINES: &str = "Another bone. A dash: the peak does not reach the level, or merges with what is above it. \
     The paper's text on Fig. 9 repeats two numbers of Fig. 8.";

/// Table I beside the paper's.
pub fn table_one(measured: &[Measured]) -> Vec<Comparison> {
    // A quantity, and its column in the paper's table, which has its means over the pixels above 0.
    let quantities = [
        ("localisation error, mm", 0),
        ("STD, mm", 1),
        ("mean grey in B, all pixels", 2),
        ("mean grey in B, pixels above 0", 2),
        ("mean grey in C, all pixels", 3),
        ("mean grey in C, pixels above 0", 3),
    ];
    let mut all = Vec::new();
    for (image, kind) in KINDS.iter().enumerate() {
        for (k, slice) in measured.iter().enumerate() {
            for (q, (quantity, column)) in quantities.into_iter().enumerate() {
                let here = |index: usize| {
                    let row = row_of(slice, index)?[image];
                    let [b, c] = [[row.b, row.b_above_zero], [row.c, row.c_above_zero]];
                    [row.error_mm, row.std_mm, b[0], b[1], c[0], c[1]][q]
                };
                let paper = TABLE_ONE[image][column]
                    .each_ref()
                    .map(|slices| &slices[k..=k]);
                let quantity = format!("{kind}, slice {}: {quantity}", k + 1);
                all.push(comparison("Table I", &quantity, here, paper, BATH));
            }
        }
    }
    all
}

/// The row of a beamformer by its index in [`COMPARED`].
fn row_of(slice: &Measured, index: usize) -> Option<&[Row; 2]> {
    slice.table.get(distance_index(index)?)
}

/// The index in [`METHODS`] of a beamformer by its index in [`COMPARED`].
fn distance_index(index: usize) -> Option<usize> {
    METHODS.iter().position(|key| *key == COMPARED[index].key)
}

/// A value of one profile.
#[derive(Clone, Copy)]
enum Quantity {
    /// Depth of the peak below the contour, mm.
    Bias,
    /// Decrease of the grey level within 0.55 mm below the peak.
    Fall,
    /// Mean grey level from 30 to 40 mm.
    Noise,
    /// Width of the peak at a grey level, mm.
    Width(f64),
    /// Grey level of the left or the right sidewall.
    Sidewall(usize),
    /// Width of a sidewall at a grey level, mm.
    SidewallWidth(usize, f64),
}

const LEFT: usize = 0;
const RIGHT: usize = 1;

/// A value of Figs. 8 and 9: figure, name, quantity, and the paper's two values.
///
/// Fig. 8 is the first slice, Fig. 9 the second; a and b are of the first kind of image, c and d of the second; b
/// and d go across.
type Entry = (&'static str, &'static str, Quantity, Paper);

#[rustfmt::skip]
const FIGURES: [Entry; 14] = {
    use Quantity::{Bias, Fall, Noise, Sidewall, SidewallWidth, Width};
    [
        ("8a", "peak below the contour, mm", Bias, [&[1.12], &[1.12]]),
        ("8a", "grey from 30 to 40 mm", Noise, [&[69.01], &[14.33]]),
        ("8a", "width at 200, mm", Width(200.0), [&[1.03], &[0.73]]),
        ("8b", "right sidewall's width at 150, mm", SidewallWidth(RIGHT, 150.0), [&[1.39], &[0.75]]),
        ("8c", "width at 200, mm", Width(200.0), [&[0.44], &[0.30]]),
        ("8c", "fall within 0.55 mm below the peak", Fall, [&[129.0], &[218.0]]),
        ("8c", "grey from 30 to 40 mm", Noise, [&[24.50], &[4.67]]),
        ("8d", "right sidewall's width at 100, mm", SidewallWidth(RIGHT, 100.0), [&[0.51], &[0.34]]),
        ("9a", "grey from 30 to 40 mm", Noise, [&[69.01], &[14.33]]),
        ("9b", "grey of the left sidewall", Sidewall(LEFT), [&[81.0], &[136.0]]),
        ("9b", "grey of the right sidewall", Sidewall(RIGHT), [&[55.0], &[126.0]]),
        ("9c", "width at 150, mm", Width(150.0), [&[0.59], &[0.29]]),
        ("9c", "grey from 30 to 40 mm", Noise, [&[20.35], &[4.62]]),
        ("9d", "left sidewall's width at 50, mm", SidewallWidth(LEFT, 50.0), [&[0.71], &[0.45]]),
    ]
};

impl Quantity {
    fn of(self, line: &Line, p: &[f32]) -> Option<f64> {
        let first = line.peak(p, line.first(), SEARCH);
        let sidewall = |side: usize| line.peak(p, line.sidewalls()[side], SEARCH);
        match self {
            Quantity::Bias => Some(first?.at_mm - line.first()?),
            Quantity::Fall => line.drop_below(p, first),
            Quantity::Noise => line.noise(p),
            Quantity::Width(level) => line.width(p, first, level),
            Quantity::Sidewall(side) => Some(sidewall(side)?.grey),
            Quantity::SidewallWidth(side, level) => line.width(p, sidewall(side), level),
        }
    }
}

/// Values of Figs. 8 and 9 beside the paper's.
pub fn line_comparisons(measured: &[Measured]) -> Vec<Comparison> {
    let compared = FIGURES.iter().map(|(figure, name, quantity, paper)| {
        let slice = &measured[usize::from(figure.starts_with('9'))];
        let image = usize::from(figure.ends_with(['c', 'd']));
        let way = usize::from(figure.ends_with(['b', 'd']));
        let line = [&slice.down, &slice.across][way];
        let here = |index: usize| {
            quantity.of(
                line,
                &slice.profiles[distance_index(index)?][image][way].grey,
            )
        };
        let name = format!("Fig. {figure}: {name}");
        comparison("Image lines (Figs. 8 and 9)", &name, here, *paper, LINES)
    });
    compared.collect()
}
