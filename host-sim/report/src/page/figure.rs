//! A picture alone, with axes in mm and a bar of decibels, as SVG with its pixels.

use ndarray::Array2;
use plotters::style::RGBColor;

use crate::Result;
use bonebeam_drive::image::BModeImage;
use bonebeam_files::image::png;

use super::axes::{Extent, Margins, axes, draw};
use super::bar::Bar;
use super::embedded::embedded;

/// Longer side of the picture within its axes, and space around it, in pixels.
const LONGER_SIDE: f64 = 560.0;
const LEFT: u32 = 62;
const BOTTOM: u32 = 48;
const MARGIN: u32 = 14;
/// The bar: distance from the picture, width, and labels, in pixels.
const GAP: u32 = 18;
const BAR: u32 = 16;
const LABELS: u32 = 62;
/// Least space for the axes of a narrow picture, pixels.
const LEAST: u32 = 90;

/// The figure of an image.
///
/// White is the largest envelope; black is `dynamic_range` dB below it.
///
/// # Errors
/// The picture cannot be encoded, or the drawing library fails.
pub fn figure(image: &BModeImage, dynamic_range: f64) -> Result<String> {
    let (rows, columns) = image.pixels.dim();
    let [wide, high] = image.pixel;
    let (across, down) = (columns as f64 * (wide / high), rows as f64);
    let scale = LONGER_SIDE / down.max(across);
    let side = |count: f64| ((count * scale).round() as u32).max(LEAST);
    let (width, height) = (side(across), side(down));
    let size = (
        LEFT + width + GAP + BAR + LABELS + MARGIN,
        MARGIN + height + BOTTOM,
    );
    let margins = Margins {
        left: LEFT,
        edge: 0,
        bottom: BOTTOM,
        margin: [MARGIN, 0],
        text: [16, 14],
        labels: [labels(width), labels(height)],
        line: 1,
    };
    let bar = Bar {
        range: [-dynamic_range, 0.0],
        name: "dB",
        margins: [MARGIN, GAP, BOTTOM, MARGIN],
        labels: LABELS,
        text: margins.text,
        line: margins.line,
    };
    let corner = [1e3 * image.x0, 1e3 * image.z0];
    let mut extent = Extent::new((rows, columns), image.pixel.map(|side| 1e3 * side), corner);
    if let Some(angles) = image.angles {
        let half = angles.step / 2.0;
        extent.across = [angles.first - half, angles.last() + half].map(f64::to_degrees);
        extent.name = "angle, degrees";
    }
    let svg = draw(size, |root| {
        let (left, right) = root.split_horizontally(LEFT + width);
        axes(&left, &extent, &[], &margins)?;
        bar.draw(&right, |fraction| {
            let level = (255.0 * fraction) as u8;
            RGBColor(level, level, level)
        })
    })?;
    with_pixels(&svg, &image.pixels, [LEFT, MARGIN, width, height])
}

/// Number of labels: about one every fifty pixels.
fn labels(pixels: u32) -> usize {
    (pixels / 50).clamp(3, 9) as usize
}

/// The drawing on white, with the pixels under the axes.
fn with_pixels(svg: &str, pixels: &Array2<f32>, position: [u32; 4]) -> Result<String> {
    let [x, y, width, height] = position;
    let address = embedded(&png(pixels)?);
    let begin = svg.find('>').map_or(0, |at| at + 1);
    let (head, rest) = svg.split_at(begin);
    Ok(format!(
        "{head}\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<image x=\"{x}\" y=\"{y}\" \
         width=\"{width}\" height=\"{height}\" preserveAspectRatio=\"none\" \
         href=\"{address}\"/>{rest}"
    ))
}
