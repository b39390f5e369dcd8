//! Plots of profiles, as SVG whose text has the page's colour.

use maud::{Markup, PreEscaped, html};
use plotters::prelude::*;

use super::axes::{MARGIN, SURFACE, draw, tick};
use crate::Result;
use crate::experiments::outcome::{Curve, Plot};

/// Colours of the curves by index; they repeat after the last.
const PALETTE: [RGBColor; 10] = [
    RGBColor(59, 130, 246),
    RGBColor(139, 139, 150),
    RGBColor(190, 160, 40),
    RGBColor(222, 120, 40),
    RGBColor(180, 80, 190),
    RGBColor(222, 50, 70),
    RGBColor(50, 160, 120),
    RGBColor(120, 100, 220),
    RGBColor(0, 160, 190),
    RGBColor(150, 100, 60),
];
/// Plot size, width of names at the curves' ends, height of one name; pixels.
const PLOT: [u32; 2] = [680, 360];
const NAMES: u32 = 160;
const NAME: i32 = 18;
/// The width of a curve, and of a featured one, in pixels.
const WIDTHS: [u32; 2] = [1, 3];

/// Plots of the same curves, under their legend.
///
/// # Errors
/// The drawing library fails.
pub fn plots(plots: &[Plot]) -> Result<Markup> {
    let curves = plots.first().map_or(&[][..], |plot| &plot.curves);
    let drawn = plots.iter().map(curves_of).collect::<Result<Vec<_>>>()?;
    Ok(html! {
        ul .legend {
            @for (k, curve) in curves.iter().enumerate() {
                li {
                    @let RGBColor(r, g, b) = colour(k);
                    span .chip style=(format!("background:rgb({r},{g},{b})")) {}
                    (curve.name)
                }
            }
        }
        div .plots {
            @for (plot, svg) in plots.iter().zip(drawn) {
                figure .plot role="img" aria-label=(in_words(plot)) {
                    div aria-hidden="true" { (PreEscaped(svg)) }
                    figcaption { (plot.caption) }
                }
            }
        }
    })
}

/// Text alternative of a plot: begin, largest value and end of each curve.
fn in_words(plot: &Plot) -> String {
    let mut text = format!("{}. {} over {}.", plot.caption, plot.y, plot.x);
    for curve in &plot.curves {
        let points = || curve.points.iter().filter_map(|&(x, y)| Some((x, y?)));
        let labelled = |point: Option<(f64, f64)>| {
            point.map_or("nothing".into(), |(x, y)| format!("{y:.1} at {x:.1}"))
        };
        let largest = points().max_by(|a, b| a.1.total_cmp(&b.1));
        text += &format!(
            " {}: from {} to {}, at most {}.",
            curve.name,
            labelled(points().next()),
            labelled(points().next_back()),
            labelled(largest)
        );
    }
    text
}

fn colour(index: usize) -> RGBColor {
    PALETTE[index % PALETTE.len()]
}

/// The curves with their axes, as SVG.
fn curves_of(plot: &Plot) -> Result<String> {
    let ([x0, x1], [y0, y1]) = (plot.x_range, plot.y_range);
    draw((PLOT[0], PLOT[1]), |root| {
        let mut chart = ChartBuilder::on(root)
            .margin(MARGIN)
            .margin_right(NAMES)
            .x_label_area_size(48)
            .y_label_area_size(64)
            .build_cartesian_2d(x0..x1, y0..y1)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(RGBColor(128, 128, 128).mix(0.25))
            .x_desc(plot.x)
            .y_desc(plot.y)
            .x_labels(11)
            .y_labels(8)
            .x_label_formatter(&tick)
            .y_label_formatter(&tick)
            .axis_desc_style(("sans-serif", 18))
            .label_style(("sans-serif", 17))
            .draw()?;
        for &x in &plot.marks {
            let line = [(x, y0), (x, y1)];
            chart.draw_series(DashedLineSeries::new(line, 6, 4, SURFACE.stroke_width(2)))?;
        }
        // The featured ones are drawn last, over the others.
        let mut curves: Vec<(usize, &Curve)> = plot.curves.iter().enumerate().collect();
        curves.sort_by_key(|(_, curve)| curve.featured);
        for (k, curve) in curves {
            let style = colour(k).stroke_width(WIDTHS[usize::from(curve.featured)]);
            for part in curve
                .points
                .split(|(x, y)| y.is_none() || *x < x0 || *x > x1)
            {
                // What leaves the plot runs along its edge.
                let part = part
                    .iter()
                    .filter_map(|&(x, y)| Some((x, y?.clamp(y0, y1))));
                chart.draw_series(LineSeries::new(part, style))?;
            }
        }
        // Their names at their ends, moved apart where they would lie over each other.
        let mut ends: Vec<(usize, i32)> = Vec::new();
        for (k, curve) in plot.curves.iter().enumerate() {
            let inside =
                |(x, y): &(f64, Option<f64>)| Some(((x0..=x1).contains(x).then_some(*x)?, (*y)?));
            // Points may run either way.
            let shown = curve.points.iter().filter_map(inside);
            if let Some((x, y)) = shown.max_by(|a, b| a.0.total_cmp(&b.0)) {
                ends.push((k, chart.backend_coord(&(x, y.clamp(y0, y1))).1));
            }
        }
        ends.sort_by_key(|&(k, y)| (y, k));
        let lowest = PLOT[1] as i32 - NAME * ends.len() as i32;
        let mut next = 0;
        for (rank, (k, y)) in ends.into_iter().enumerate() {
            next = next.max(y - NAME / 2).min(lowest + NAME * rank as i32);
            let position = (chart.backend_coord(&(x1, y0)).0 + 6, next);
            let name = plot.curves[k].name.to_string();
            root.draw(&Text::new(
                name,
                position,
                ("sans-serif", 17).into_font().color(&colour(k)),
            ))?;
            next += NAME;
        }
        Ok(())
    })
}
