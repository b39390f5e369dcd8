//! Parts of an experiment's outcome, which the report shows.

use std::borrow::Cow;
use std::collections::BTreeSet;

use ndarray::Array2;
use serde::Serialize;

use crate::{Error, Result};
use bonebeam_drive::check::Check;

/// Outcome of an experiment.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Heading of its part of the page.
    pub title: &'static str,
    /// Answer to the paper's question in two sentences; empty if there is none.
    pub answer: String,
    /// Content of the page, from top to bottom.
    pub parts: Vec<Section>,
    /// All measures of all beamformers.
    pub tables: Vec<Table>,
    /// The paper's values beside those found.
    pub comparisons: Vec<Comparison>,
    /// Comparisons of the core with its references.
    pub checks: Vec<Check>,
    /// Verdicts on the paper's claims.
    pub verdicts: Vec<Verdict>,
    /// Other files, to be written beside the page.
    pub files: Vec<Attachment>,
    /// All numbers, for programs.
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
    /// Pictures of one method beside those of another that the reader selects.
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
    /// Closed lines (x, depth) in mm drawn over every picture: the known surface.
    pub outline: Vec<Vec<(f64, f64)>>,
    /// Whether the outline is hidden until the reader asks for it.
    pub outline_on_request: bool,
    /// Meaning of black and white.
    pub scales: Vec<Scale>,
}

/// The pictures of one method beside those of another.
#[derive(Clone, Debug)]
pub struct SideBySide {
    /// Its name in the page, of letters, digits and hyphens.
    pub id: String,
    /// The method that is always shown.
    pub reference: View,
    /// The other methods, one shown at a time.
    pub others: Vec<View>,
    /// Index of the one shown first.
    pub first: usize,
    /// Lines (x, depth) in mm over every picture, beside the echo so as not to hide it.
    pub outline: Vec<Vec<(f64, f64)>>,
    /// Meaning of black and white.
    pub scales: Vec<Scale>,
}

/// A picture coloured by another quantity: blue below zero, red above.
#[derive(Clone, Debug)]
pub struct Coloured {
    /// The grey levels.
    pub picture: Picture,
    /// The quantity at every pixel, `[row, column]`.
    pub values: Array2<f64>,
    /// The end of the colours on either side of zero.
    pub reach: f64,
    /// Name of the quantity, with its unit.
    pub quantity: &'static str,
}

/// The name of a method, and its pictures, which stay together.
pub type View = (String, Vec<Picture>);

/// A file beside the page: a volume, a surface, a table.
#[derive(Clone, Debug)]
pub struct Attachment {
    /// Its name in the folder of the outputs.
    pub file: String,
    /// Description of its content.
    pub description: String,
    /// Its contents.
    pub bytes: Vec<u8>,
}

/// Verdict on a claim of the paper.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// The claim in our words.
    pub claim: String,
    /// Place of the claim in the paper.
    pub place: String,
    /// The verdict.
    pub ruling: Ruling,
    /// The numbers behind the verdict.
    pub evidence: String,
}

/// A verdict.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ruling {
    /// Holds in every condition that was tried.
    Holds,
    /// Holds in no condition, and the opposite in some.
    DoesNotHold,
    /// Holds in some conditions, which are named.
    DependsOn(String),
    /// Not decided; with the reason.
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

/// A grey bar: its name, and the meaning of black, middle grey and white.
#[derive(Clone, Debug)]
pub struct Scale {
    /// The kind of picture.
    pub name: &'static str,
    /// Black, middle grey, white.
    pub levels: [String; 3],
}

/// A picture with grey levels 0 to 255 and its position.
#[derive(Clone, Debug, Serialize)]
pub struct Picture {
    /// Its file in the output folder.
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
    /// Name of the abscissa, with its unit.
    pub x: &'static str,
    /// Name of the ordinate, with its unit.
    pub y: &'static str,
    /// The range of the abscissa.
    pub x_range: [f64; 2],
    /// The range of the ordinate.
    pub y_range: [f64; 2],
    /// Abscissae marked by a vertical line: the known surface.
    pub marks: Vec<f64>,
    /// The curves; the index of each sets its colour.
    pub curves: Vec<Curve>,
}

/// One curve of a plot.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Name in the legend.
    pub name: Cow<'static, str>,
    /// Whether it is drawn wide and on top.
    pub featured: bool,
    /// Its points; it is broken where the ordinate is `None`.
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
    /// Whether it is left out on the terminal.
    pub page_only: bool,
}

/// A column of a table: its head, and its cell in the row of an item.
pub type Column<T> = (&'static str, fn(&T) -> String);

impl Table {
    /// A table with a row for each item and these columns.
    pub fn of<T>(
        title: impl Into<String>,
        items: impl IntoIterator<Item = T>,
        columns: &[Column<T>],
    ) -> Self {
        let row = |item: T| columns.iter().map(|(_, cell)| cell(&item)).collect();
        let head = columns.iter().map(|(head, _)| *head).collect();
        Table::new(title, head, items.into_iter().map(row))
    }

    /// A table of a head and rows.
    pub fn new(
        title: impl Into<String>,
        head: Vec<&'static str>,
        rows: impl IntoIterator<Item = Vec<String>>,
    ) -> Self {
        Table {
            title: title.into(),
            head,
            rows: rows.into_iter().collect(),
            page_only: false,
        }
    }

    /// The table, left out on the terminal.
    pub fn on_page(self) -> Self {
        Table {
            page_only: true,
            ..self
        }
    }
}

impl Outcome {
    /// Every picture of the page in grey, once.
    pub fn pictures(&self) -> Vec<&Picture> {
        let mut files = BTreeSet::new();
        let all = self.parts.iter().flat_map(Section::pictures);
        all.filter(|picture| files.insert(&picture.file)).collect()
    }
}

impl Section {
    fn pictures(&self) -> Vec<&Picture> {
        match self {
            Section::Gallery(gallery) => gallery.cards.iter().flatten().collect(),
            Section::SideBySide(beside) => {
                let views = std::iter::once(&beside.reference).chain(&beside.others);
                views.flat_map(|(_, pictures)| pictures).collect()
            }
            _ => Vec::new(),
        }
    }
}

impl Curve {
    /// A curve through points; `featured` ones are drawn wide and on top.
    pub fn new<Y: Into<Option<f64>>>(
        name: impl Into<Cow<'static, str>>,
        featured: bool,
        points: impl IntoIterator<Item = (f64, Y)>,
    ) -> Self {
        Curve {
            name: name.into(),
            featured,
            points: points.into_iter().map(|(x, y)| (x, y.into())).collect(),
        }
    }
}

impl Plot {
    /// Curves in a range of the abscissa and one of the ordinate.
    ///
    /// The names of both have their units.
    pub fn new(
        caption: impl Into<String>,
        [x, y]: [&'static str; 2],
        [x_range, y_range]: [[f64; 2]; 2],
        curves: impl IntoIterator<Item = Curve>,
    ) -> Self {
        Plot {
            caption: caption.into(),
            x,
            y,
            x_range,
            y_range,
            marks: Vec::new(),
            curves: curves.into_iter().collect(),
        }
    }
}

impl SideBySide {
    /// The first view beside the others; `None` without a view.
    ///
    /// At first the one of index `first` is shown.
    pub fn of(
        id: impl Into<String>,
        views: impl IntoIterator<Item = View>,
        first: usize,
        outline: Vec<Vec<(f64, f64)>>,
        scales: Vec<Scale>,
    ) -> Option<Section> {
        let mut views = views.into_iter();
        Some(Section::SideBySide(SideBySide {
            id: id.into(),
            reference: views.next()?,
            others: views.collect(),
            first,
            outline,
            scales,
        }))
    }
}

/// One quantity: the value found, and the paper's.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// Name of the comparison.
    pub group: String,
    /// The quantity, with its unit.
    pub quantity: String,
    /// One value per beamformer; the same beamformers throughout a group.
    pub values: Vec<PaperComparison>,
    /// Differences of the set-ups, and the reasons for other values.
    pub note: &'static str,
}

/// A value here and in the paper.
#[derive(Clone, Debug, Serialize)]
pub struct PaperComparison {
    /// The beamformer's key.
    pub beamformer: &'static str,
    /// Its name in tables.
    #[serde(skip)]
    pub name: &'static str,
    /// The value found here.
    pub here: Option<f64>,
    /// The paper's value: none, one, or one for each of its slices.
    pub paper: Vec<f64>,
}

/// An experiment's numbers, for programs.
///
/// # Errors
/// A value that JSON cannot hold.
pub fn data(result: &impl Serialize) -> Result<serde_json::Value> {
    let cannot = |e| Error::Data(format!("the numbers cannot be written: {e}"));
    serde_json::to_value(result).map_err(cannot)
}

/// A share as text, in per cent.
pub fn percent(share: Option<f64>) -> String {
    share.map_or("–".into(), |share| format!("{:.0} %", 100.0 * share))
}

/// A number as text, without a negative zero.
///
/// Small ones have two decimals, others one.
pub fn number(value: impl Into<Option<f64>>) -> String {
    match value.into() {
        None => "–".into(),
        Some(v) if v.abs() < 10.0 => format!("{:.2}", (100.0 * v).round() / 100.0 + 0.0),
        Some(v) => format!("{v:.1}"),
    }
}

/// A number and the ends of its range as text.
pub fn ranged(value: f64, ends: [f64; 2]) -> String {
    let [low, high] = ends.map(number);
    format!("{} ({low} to {high})", number(value))
}
