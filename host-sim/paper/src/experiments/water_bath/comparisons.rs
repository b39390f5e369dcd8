//! Table I and the image lines of Figs. 8 and 9 beside the paper's figures.

use crate::experiments::common::beamformers::{Paper, comparison};
use crate::experiments::outcome::Comparison;
use bonebeam_drive::methods::COMPARED;

use super::contour::Row;
use super::measures::Measured;
use super::parameters::{KINDS, METHODS};
use super::profiles::{Line, Profile};

const BATH: &str = "With all sources of error on, the fiducials picked at their brightest voxel. Another \
     bone, with another array of the same kind, in a bath whose noise is assumed.";
const LINES: &str = "Another bone. A dash: the peak does not reach the level, or merges with what is above \
     it. The paper's text on Fig. 9 repeats two figures of Fig. 8.";

/// Table I of the paper: of a kind of image and a slice DAS and ESMV, each with error, STD, B and C.
const PAPER: [[[[f64; 4]; 2]; 2]; 2] = [
    [
        [[0.70, 0.72, 27.18, 92.41], [0.66, 0.65, 4.71, 16.81]],
        [[0.90, 0.85, 63.06, 125.52], [0.79, 0.77, 10.17, 15.80]],
    ],
    [
        [[0.94, 0.53, 32.20, 3.06], [0.84, 0.42, 6.60, 1.24]],
        [[0.97, 0.57, 32.24, 5.16], [0.95, 0.45, 3.93, 1.88]],
    ],
];

/// Table I beside the paper's.
pub fn table_one(measured: &[Measured]) -> Vec<Comparison> {
    let quantities = [
        "localisation error, mm",
        "STD, mm",
        "mean grey in B",
        "mean grey in C",
    ];
    let mut all = Vec::new();
    for (image, kind) in KINDS.iter().enumerate() {
        for (k, slice) in measured.iter().enumerate() {
            for (q, quantity) in quantities.iter().enumerate() {
                let here = |index: usize| {
                    let row = row_of(slice, index)?[image];
                    [row.error_mm, row.std_mm, row.b, row.c][q]
                };
                let [das, esmv] = &PAPER[image][k];
                all.push(comparison(
                    "Table I",
                    &format!("{kind}, slice {}: {quantity}", k + 1),
                    here,
                    [&das[q..=q], &esmv[q..=q]],
                    BATH,
                ));
            }
        }
    }
    all
}

/// The row of a beamformer by its place in [`COMPARED`].
fn row_of(slice: &Measured, index: usize) -> Option<&[Row; 2]> {
    let place = METHODS.iter().position(|key| *key == COMPARED[index].key)?;
    slice.table.get(place)
}

/// A figure of one profile.
type Pick = fn(&Line, &Profile) -> Option<f64>;

/// The figures of Figs. 8 and 9 beside the paper's.
pub fn line_comparisons(measured: &[Measured]) -> Vec<Comparison> {
    let down: Pick = |line, p| line.noise(p);
    let bias: Pick = |line, p| Some(line.peak(p, line.first())?.at_mm - line.first()?);
    let fall: Pick = |line, p| line.drop_below(p, line.peak(p, line.first()));
    let right: fn(&Line, &Profile, f64) -> Option<f64> =
        |line, p, level| line.width(p, line.peak(p, line.sidewalls()[1]), level);
    let left: fn(&Line, &Profile, f64) -> Option<f64> =
        |line, p, level| line.width(p, line.peak(p, line.sidewalls()[0]), level);
    let tip: fn(&Line, &Profile, f64) -> Option<f64> =
        |line, p, level| line.width(p, line.peak(p, line.first()), level);
    // Slice, kind of image, way of the line (0 down), quantity, how, the paper's two.
    type Entry = (
        usize,
        usize,
        usize,
        &'static str,
        Box<dyn Fn(&Line, &Profile) -> Option<f64>>,
        Paper,
    );
    let entries: Vec<Entry> = vec![
        (
            0,
            0,
            0,
            "Fig. 8a: peak below the contour, mm",
            Box::new(bias),
            [&[1.12], &[1.12]],
        ),
        (
            0,
            0,
            0,
            "Fig. 8a: grey from 30 to 40 mm",
            Box::new(down),
            [&[69.01], &[14.33]],
        ),
        (
            0,
            0,
            0,
            "Fig. 8a: width at 200, mm",
            Box::new(move |l, p| tip(l, p, 200.0)),
            [&[1.03], &[0.73]],
        ),
        (
            0,
            0,
            1,
            "Fig. 8b: right sidewall's width at 150, mm",
            Box::new(move |l, p| right(l, p, 150.0)),
            [&[1.39], &[0.75]],
        ),
        (
            0,
            1,
            0,
            "Fig. 8c: width at 200, mm",
            Box::new(move |l, p| tip(l, p, 200.0)),
            [&[0.44], &[0.30]],
        ),
        (
            0,
            1,
            0,
            "Fig. 8c: fall within 0.55 mm below the peak",
            Box::new(fall),
            [&[129.0], &[218.0]],
        ),
        (
            0,
            1,
            0,
            "Fig. 8c: grey from 30 to 40 mm",
            Box::new(down),
            [&[24.50], &[4.67]],
        ),
        (
            0,
            1,
            1,
            "Fig. 8d: right sidewall's width at 100, mm",
            Box::new(move |l, p| right(l, p, 100.0)),
            [&[0.51], &[0.34]],
        ),
        (
            1,
            0,
            0,
            "Fig. 9a: grey from 30 to 40 mm",
            Box::new(down),
            [&[69.01], &[14.33]],
        ),
        (
            1,
            0,
            1,
            "Fig. 9b: grey of the left sidewall",
            Box::new(|l, p| Some(l.peak(p, l.sidewalls()[0])?.grey)),
            [&[81.0], &[136.0]],
        ),
        (
            1,
            0,
            1,
            "Fig. 9b: grey of the right sidewall",
            Box::new(|l, p| Some(l.peak(p, l.sidewalls()[1])?.grey)),
            [&[55.0], &[126.0]],
        ),
        (
            1,
            1,
            0,
            "Fig. 9c: width at 150, mm",
            Box::new(move |l, p| tip(l, p, 150.0)),
            [&[0.59], &[0.29]],
        ),
        (
            1,
            1,
            0,
            "Fig. 9c: grey from 30 to 40 mm",
            Box::new(down),
            [&[20.35], &[4.62]],
        ),
        (
            1,
            1,
            1,
            "Fig. 9d: left sidewall's width at 50, mm",
            Box::new(move |l, p| left(l, p, 50.0)),
            [&[0.71], &[0.45]],
        ),
    ];
    let compared = entries
        .into_iter()
        .map(|(slice, image, way, quantity, pick, paper)| {
            let slice = &measured[slice];
            let line = [&slice.down, &slice.across][way];
            let here = |index: usize| {
                let place = METHODS.iter().position(|key| *key == COMPARED[index].key)?;
                pick(line, &slice.profiles[place][image][way])
            };
            comparison("Image lines (Figs. 8 and 9)", quantity, here, paper, LINES)
        });
    compared.collect()
}
