//! A colour bar beside a picture.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::axes::{DrawResult, tick};

/// Steps of colour in a bar.
const STEPS: u32 = 64;

/// A bar, its margins and its letters, in pixels.
pub struct Bar<'a> {
    /// Values of its ends, the lower one first.
    pub range: [f64; 2],
    /// Name of the quantity, with its unit.
    pub name: &'a str,
    /// Margins above, left, below, and right of its labels.
    pub margins: [u32; 4],
    /// Width of its labels.
    pub labels: u32,
    /// Heights of its name and of its labels.
    pub text: [u32; 2],
    /// Width of lines.
    pub line: u32,
}

impl Bar<'_> {
    /// Draws it over the whole area.
    ///
    /// `colour` gives the colour of a share, from 0 (lower end) to 1.
    pub fn draw<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        colour: impl Fn(f64) -> RGBColor,
    ) -> DrawResult
    where
        DB::ErrorType: 'static,
    {
        let [low, high] = self.range;
        let [above, left, below, right] = self.margins;
        let mut chart = ChartBuilder::on(area)
            .margin_top(above)
            .margin_left(left)
            .margin_right(right)
            .margin_bottom(below)
            .right_y_label_area_size(self.labels)
            .build_cartesian_2d(0.0..1.0, low..high)?;
        let step = (high - low) / f64::from(STEPS);
        chart.draw_series((0..STEPS).map(|k| {
            let from = low + f64::from(k) * step;
            let colour = colour(f64::from(k) / f64::from(STEPS - 1));
            Rectangle::new([(0.0, from), (1.0, from + step)], colour.filled())
        }))?;
        let style = BLACK.stroke_width(self.line);
        chart.draw_series([Rectangle::new([(0.0, low), (1.0, high)], style)])?;
        chart
            .configure_mesh()
            .disable_mesh()
            .disable_x_axis()
            .y_desc(self.name)
            .y_labels(7)
            .y_label_formatter(&tick)
            .axis_style(style)
            .axis_desc_style(("sans-serif", self.text[0]))
            .label_style(("sans-serif", self.text[1]))
            .draw()?;
        Ok(())
    }
}
