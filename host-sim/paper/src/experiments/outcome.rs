//! What an experiment leaves behind, in parts that the report can show without knowing it.

use std::borrow::Cow;

use ndarray::Array2;
use serde::Serialize;

use crate::{Error, Result};
use bonebeam_oracle::verify::Check;

/// What came out of an experiment.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// The heading of its part of the page.
    pub title: &'static str,
    /// The answer to the paper's question in two sentences; empty where the experiment has none.
    pub answer: String,
    /// The page, from top to bottom.
    pub parts: Vec<Section>,
    /// Every picture, to be written beside the page.
    pub pictures: Vec<Picture>,
    /// All measures of all beamformers.
    pub tables: Vec<Table>,
    /// The paper's figures beside those found.
    pub comparisons: Vec<Comparison>,
    /// The core against its references.
    pub checks: Vec<Check>,
    /// What became of the paper's claims.
    pub verdicts: Vec<Verdict>,
    /// Other files, to be written beside the page.
    pub files: Vec<Attachment>,
    /// Every number, for programs.
    pub data: serde_json::Value,
}

/// A part of the page.
#[derive(Clone, Debug)]
pub enum Section {
    /// A heading within the experiment's.
    Heading(&'static str),
    /// A paragraph.
    Text(String),
    /// Pictures.
    Gallery(Gallery),
    /// Pictures of one method beside those of another, which the reader chooses.
    SideBySide(SideBySide),
    /// Pictures in the colours of the same quantity, side by side.
    Coloured(Vec<Coloured>),
    /// A table at this place of the page.
    Table(Table),
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

/// The pictures of one method beside those of another.
#[derive(Clone, Debug)]
pub struct SideBySide {
    /// Its name in the page, of letters, digits and hyphens.
    pub id: String,
    /// The method that stays.
    pub reference: View,
    /// The others, of which one is shown.
    pub others: Vec<View>,
    /// The one that is shown first.
    pub first: usize,
    /// Lines (x, depth) in mm over every picture. They stand beside the echo, so that they do not hide it.
    pub outline: Vec<Vec<(f64, f64)>>,
    /// What black and white stand for.
    pub scales: Vec<Scale>,
}

/// A picture whose grey levels have the colour of another quantity: blue below zero, red above.
#[derive(Clone, Debug)]
pub struct Coloured {
    /// The grey levels.
    pub picture: Picture,
    /// The quantity at every pixel, `[row, column]`.
    pub values: Array2<f64>,
    /// Where the colours end, on either side of zero.
    pub reach: f64,
    /// What the quantity is, with its unit.
    pub quantity: &'static str,
}

/// The pictures of a method.
#[derive(Clone, Debug)]
pub struct View {
    /// The method's name.
    pub name: String,
    /// Its pictures, which stay together.
    pub pictures: Vec<Picture>,
}

/// A file beside the page: a volume, a surface, a table.
#[derive(Clone, Debug)]
pub struct Attachment {
    /// Its name in the folder of the outputs.
    pub file: String,
    /// What it holds, for people.
    pub description: String,
    /// Its contents.
    pub bytes: Vec<u8>,
}

/// What became of a claim of the paper.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// The claim, in own words.
    pub claim: String,
    /// Where the paper makes it.
    pub place: String,
    /// The verdict.
    pub ruling: Ruling,
    /// The figures that it rests on.
    pub evidence: String,
}

/// A verdict.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ruling {
    /// In every condition that was tried.
    Holds,
    /// In none.
    DoesNotHold,
    /// In some, which are told.
    DependsOn(String),
    /// The figures do not decide it.
    Open(String),
}

impl std::fmt::Display for Ruling {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Ruling::Holds => f.write_str("holds"),
            Ruling::DoesNotHold => f.write_str("does not hold"),
            Ruling::DependsOn(what) => write!(f, "depends on {what}"),
            Ruling::Open(why) => write!(f, "open: {why}"),
        }
    }
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
    pub name: Cow<'static, str>,
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
    pub values: Vec<PaperComparison>,
    /// Where the set-ups differ, and why the figures do.
    pub note: &'static str,
}

/// A figure here and in the paper.
#[derive(Clone, Debug, Serialize)]
pub struct PaperComparison {
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
