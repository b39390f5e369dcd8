//! Axes in mm around a picture: on the page, alone, and in print.

use std::fmt::Display;

use plotters::coord::Shift;
use plotters::prelude::*;

use crate::experiments::outcome::Picture;
use crate::{Error, Result};

/// Width of a picture on the page, and its margins, in pixels.
const PICTURE_WIDTH: u32 = 300;
const LEFT: u32 = 50;
const BOTTOM: u32 = 42;
pub(super) const MARGIN: u32 = 10;

/// The colour of the known surface.
pub(super) const SURFACE: RGBColor = RGBColor(255, 176, 0);

/// Axes of a picture, and its place within them.
pub struct PictureAxes {
    /// The axes, and the true surface if there is one.
    pub svg: String,
    /// Left, top, width and height of the picture, per cent of the axes' size.
    pub position: [f64; 4],
}

/// The axes of a picture, with the closed lines of `outline` over it.
///
/// # Errors
/// The drawing library fails.
pub fn frame(picture: &Picture, outline: &[Vec<(f64, f64)>]) -> Result<PictureAxes> {
    let (rows, columns) = picture.pixels.dim();
    let height = (PICTURE_WIDTH as f64 * rows as f64 / columns as f64).round() as u32;
    let (width_all, height_all) = (LEFT + PICTURE_WIDTH + MARGIN, MARGIN + height + BOTTOM);

    let svg = draw((width_all, height_all), |root| {
        axes(root, &Extent::of(picture), outline, &PAGE)
    })?;
    let percent = |a: u32, of: u32| 100.0 * f64::from(a) / f64::from(of);
    Ok(PictureAxes {
        svg,
        position: [
            percent(LEFT, width_all),
            percent(MARGIN, height_all),
            percent(PICTURE_WIDTH, width_all),
            percent(height, height_all),
        ],
    })
}

/// Space around a picture, in pixels.
pub struct Margins {
    /// Left of it, for depths.
    pub left: u32,
    /// Part of the left space that stays free at the edge.
    pub edge: u32,
    /// Below it, for lateral positions.
    pub bottom: u32,
    /// Above it, and to the right.
    pub margin: [u32; 2],
    /// Heights of the axes' names and labels.
    pub text: [u32; 2],
    /// Approximate numbers of labels across and down.
    pub labels: [usize; 2],
    /// Width of lines.
    pub line: u32,
}

/// The outer edges of a picture's pixels, mm; across degrees on a polar grid.
pub struct Extent {
    /// Left and right.
    pub across: [f64; 2],
    /// Top and bottom.
    pub down: [f64; 2],
    /// Name of the axis across.
    pub name: &'static str,
}

impl Extent {
    /// The extent of rows and columns of pixels of these distances across and down, mm.
    ///
    /// The centre of the first pixel is at `left` and `top`, mm. A pixel is as wide as the distance between pixels.
    pub fn new(
        (rows, columns): (usize, usize),
        [across, down]: [f64; 2],
        [left, top]: [f64; 2],
    ) -> Self {
        let edges = |first: f64, pixel: f64, count: usize| {
            let start = first - 0.5 * pixel;
            [start, start + count as f64 * pixel]
        };
        Extent {
            across: edges(left, across, columns),
            down: edges(top, down, rows),
            name: "lateral, mm",
        }
    }

    /// The extent of a picture.
    pub fn of(picture: &Picture) -> Self {
        let corner = [picture.left_mm, picture.top_mm];
        Extent::new(picture.pixels.dim(), [picture.pixel_mm; 2], corner)
    }
}

const PAGE: Margins = Margins {
    left: LEFT,
    edge: 0,
    bottom: BOTTOM,
    margin: [MARGIN; 2],
    text: [15, 14],
    labels: [6, 6],
    line: 1,
};

/// Draws the axes of a picture, with the lines of `outline` over it.
pub fn axes<DB: DrawingBackend>(
    root: &DrawingArea<DB, Shift>,
    extent: &Extent,
    outline: &[Vec<(f64, f64)>],
    margins: &Margins,
) -> DrawResult
where
    DB::ErrorType: 'static,
{
    let ([left, right], [top, bottom]) = (extent.across, extent.down);
    let mut chart = ChartBuilder::on(root)
        .margin_top(margins.margin[0])
        .margin_right(margins.margin[1])
        .margin_left(margins.edge)
        .x_label_area_size(margins.bottom)
        .y_label_area_size(margins.left - margins.edge)
        .build_cartesian_2d(left..right, bottom..top)?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_desc(extent.name)
        .y_desc("depth, mm")
        .x_labels(margins.labels[0])
        .y_labels(margins.labels[1])
        .x_label_formatter(&tick)
        .y_label_formatter(&tick)
        .axis_style(BLACK.stroke_width(margins.line))
        .axis_desc_style(("sans-serif", margins.text[0]))
        .label_style(("sans-serif", margins.text[1]))
        .draw()?;
    let inside = |p: &(f64, f64)| (left..=right).contains(&p.0) && (top..=bottom).contains(&p.1);
    for points in outline {
        for part in points.split(|p| !inside(p)).filter(|part| part.len() > 1) {
            let style = SURFACE.stroke_width(margins.line);
            chart.draw_series(LineSeries::new(part.iter().copied(), style))?;
        }
    }
    Ok(())
}

/// A tick's label: at most two decimals, and no negative zero.
pub fn tick(value: &f64) -> String {
    format!("{}", (100.0 * value).round() / 100.0 + 0.0)
}

/// The result of drawing.
pub type DrawResult = std::result::Result<(), Box<dyn std::error::Error>>;

/// Draws an SVG of a size in pixels.
///
/// # Errors
/// The drawing library fails.
pub(super) fn draw<F>(size: (u32, u32), contents: F) -> Result<String>
where
    F: FnOnce(&DrawingArea<SVGBackend<'_>, Shift>) -> DrawResult,
{
    let failed = |e: &dyn Display| Error::Data(format!("the report's plot cannot be drawn: {e}"));
    let mut svg = String::new();
    let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
    contents(&root).map_err(|e| failed(&e))?;
    root.present().map_err(|e| failed(&e))?;
    drop(root);
    Ok(svg)
}
