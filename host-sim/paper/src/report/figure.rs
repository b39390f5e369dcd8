//! A picture by itself, with axes in mm and a bar of decibels, as SVG that holds its pixels.

use std::fmt::Display;

use ndarray::Array2;
use plotters::prelude::*;

use crate::{Error, Result};
use bonebeam_drive::image::Image;
use bonebeam_files::image::png;

use super::bar::Bar;
use super::embedded::embedded;
use super::plot::{register_font, tick};

/// The longer side of the picture within its axes, and what stands around it, in pixels.
const LONGER_SIDE: f64 = 560.0;
const LEFT: u32 = 62;
const BOTTOM: u32 = 48;
const MARGIN: u32 = 14;
/// The bar: what stands between it and the picture, its width, and its labels, in pixels.
const GAP: u32 = 18;
const BAR: u32 = 16;
const LABELS: u32 = 62;
/// The least that a narrow picture's axes have room in, pixels.
const LEAST: u32 = 90;

/// The figure of an image whose white is the largest envelope and whose black lies `dynamic_range` dB
/// below it.
///
/// # Errors
/// The picture cannot be encoded, or the drawing library fails.
pub fn figure(image: &Image, dynamic_range: f64) -> Result<String> {
    register_font()?;
    let (rows, columns) = image.pixels.dim();
    let scale = LONGER_SIDE / rows.max(columns) as f64;
    let side = |count: usize| ((count as f64 * scale).round() as u32).max(LEAST);
    let (width, height) = (side(columns), side(rows));
    let size = (
        LEFT + width + GAP + BAR + LABELS + MARGIN,
        MARGIN + height + BOTTOM,
    );
    let mut svg = String::new();
    let failed = |e: &dyn Display| Error::Data(format!("the figure cannot be drawn: {e}"));
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        let draw = || -> std::result::Result<(), Box<dyn std::error::Error>> {
            let (picture, bar) = root.split_horizontally(LEFT + width);
            // Pixels are as wide around their centres as they are apart.
            let edges = |first: f64, count: usize| {
                let start = 1e3 * (first - 0.5 * image.pixel);
                start..start + 1e3 * image.pixel * count as f64
            };
            let down = edges(image.z0, rows);
            let mut chart = ChartBuilder::on(&picture)
                .margin_top(MARGIN)
                .x_label_area_size(BOTTOM)
                .y_label_area_size(LEFT)
                .build_cartesian_2d(edges(image.x0, columns), down.end..down.start)?;
            chart
                .configure_mesh()
                .disable_mesh()
                .x_desc("lateral, mm")
                .y_desc("depth, mm")
                .x_labels(labels(width))
                .y_labels(labels(height))
                .x_label_formatter(&tick)
                .y_label_formatter(&tick)
                .axis_desc_style(("sans-serif", 16))
                .label_style(("sans-serif", 14))
                .draw()?;
            let bar_beside = Bar {
                range: [-dynamic_range, 0.0],
                name: "dB",
                margins: [MARGIN, GAP, BOTTOM, MARGIN],
                labels: LABELS,
                text: [16, 14],
                line: 1,
            };
            let grey = |share: f64| {
                let level = (255.0 * share) as u8;
                RGBColor(level, level, level)
            };
            bar_beside.draw(&bar, grey)?;
            Ok(())
        };
        draw().map_err(|e| failed(&e))?;
        root.present().map_err(|e| failed(&e))?;
    }
    with_pixels(&svg, &image.pixels, [LEFT, MARGIN, width, height])
}

/// About a label every fifty pixels.
fn labels(pixels: u32) -> usize {
    (pixels / 50).clamp(3, 9) as usize
}

/// The drawing on white, with the pixels under the axes.
fn with_pixels(svg: &str, pixels: &Array2<f32>, place: [u32; 4]) -> Result<String> {
    let [x, y, width, height] = place;
    let address = embedded(&png(pixels)?);
    let begin = svg.find('>').map_or(0, |at| at + 1);
    let (head, rest) = svg.split_at(begin);
    Ok(format!(
        "{head}\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n<image x=\"{x}\" y=\"{y}\" \
         width=\"{width}\" height=\"{height}\" preserveAspectRatio=\"none\" \
         href=\"{address}\"/>{rest}"
    ))
}
