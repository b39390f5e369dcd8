//! What an experiment leaves behind, in parts that the report can show without knowing it.

use ndarray::Array2;
use serde::Serialize;

use crate::validate::Check;
use crate::{Error, Result};

/// What came out of an experiment.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The heading of its part of the page.
    pub title: &'static str,
    /// The page, from top to bottom.
    pub parts: Vec<Part>,
    /// Every picture, to be written beside the page.
    pub pictures: Vec<Picture>,
    /// All measures of all beamformers.
    pub tables: Vec<Table>,
    /// The paper's figures beside those found.
    pub comparisons: Vec<Comparison>,
    /// The core against its references.
    pub checks: Vec<Check>,
    /// Every number, for programs.
    pub data: serde_json::Value,
}

/// A part of the page.
#[derive(Clone, Debug)]
pub enum Part {
    /// A heading within the experiment's.
    Heading(&'static str),
    /// A paragraph.
    Text(String),
    /// Pictures.
    Gallery(Gallery),
    /// Plots of the same curves, with one legend.
    Plots(Vec<Plot>),
}

/// Pictures side by side.
#[derive(Clone, Debug)]
pub struct Gallery {
    /// Pictures that stay together.
    pub cards: Vec<Vec<Picture>>,
    /// Closed lines (x, depth) in mm that are drawn over every picture: the known surface.
    pub outline: Vec<Vec<(f64, f64)>>,
    /// Whether the outline is shown only where the reader asks for it.
    pub outline_on_request: bool,
    /// What black and white stand for.
    pub scales: Vec<Scale>,
}

/// A grey bar: its name, and what black, the middle grey and white stand for.
#[derive(Clone, Debug)]
pub struct Scale {
    /// The kind of picture.
    pub name: &'static str,
    /// Black, middle grey, white.
    pub levels: [String; 3],
}

/// A picture 0..255 and where it lies.
#[derive(Clone, Debug, Serialize)]
pub struct Picture {
    /// Its file, in the folder of the outputs.
    pub file: String,
    /// What it shows.
    #[serde(skip)]
    pub caption: String,
    /// Hash of the pixels' 32-bit floats, row by row, little-endian.
    pub fnv1a_64: String,
    /// The lateral position of column 0, mm.
    pub left_mm: f64,
    /// The depth of row 0, mm.
    pub top_mm: f64,
    /// The distance from one pixel to the next, mm.
    pub pixel_mm: f64,
    /// Grey levels, `[row, column]`.
    #[serde(skip)]
    pub pixels: Array2<f32>,
}

/// A plot of several curves.
#[derive(Clone, Debug)]
pub struct Plot {
    /// What it shows.
    pub caption: String,
    /// What the abscissa is, with its unit.
    pub x: &'static str,
    /// What the ordinate is, with its unit.
    pub y: &'static str,
    /// The range of the abscissa.
    pub x_range: [f64; 2],
    /// The range of the ordinate.
    pub y_range: [f64; 2],
    /// Places on the abscissa that are marked by a vertical line: the known surface.
    pub marks: Vec<f64>,
    /// The curves; the colour of each goes by its place.
    pub curves: Vec<Curve>,
}

/// One curve of a plot.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Its name in the legend.
    pub name: &'static str,
    /// Whether it is drawn wide and over the others.
    pub featured: bool,
    /// Its points; it is broken where the ordinate is none.
    pub points: Vec<(f64, Option<f64>)>,
}

/// A table: its head and its rows.
#[derive(Clone, Debug)]
pub struct Table {
    /// What it shows.
    pub title: String,
    /// The names of the columns.
    pub head: Vec<&'static str>,
    /// The cells; the first of a row is its name.
    pub rows: Vec<Vec<String>>,
    /// Whether it is for the page alone and not for the terminal.
    pub page_only: bool,
}

/// One quantity: what was found, and what the paper has.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// What is compared.
    pub group: String,
    /// The quantity, with its unit.
    pub quantity: String,
    /// A value a beamformer; the same beamformers throughout a group.
    pub values: Vec<BesidePaper>,
    /// Where the set-ups differ, and why the figures do.
    pub note: &'static str,
}

/// A figure here and in the paper.
#[derive(Clone, Debug, Serialize)]
pub struct BesidePaper {
    /// The beamformer's key.
    pub beamformer: &'static str,
    /// Its name for people.
    #[serde(skip)]
    pub name: &'static str,
    /// What was found here.
    pub here: Option<f64>,
    /// What the paper gives: none, one, or one for each of its slices.
    pub paper: Vec<f64>,
}

/// An experiment's numbers, for programs.
///
/// # Errors
/// What JSON cannot hold.
pub fn data(result: &impl Serialize) -> Result<serde_json::Value> {
    let cannot = |e| Error::Data(format!("the numbers cannot be written: {e}"));
    serde_json::to_value(result).map_err(cannot)
}

/// A number for people: two decimals for small ones, one for others, and no negative zero.
pub fn number(value: Option<f64>) -> String {
    match value {
        None => "–".into(),
        Some(v) if v.abs() < 10.0 => format!("{:.2}", (100.0 * v).round() / 100.0 + 0.0),
        Some(v) => format!("{v:.1}"),
    }
}
