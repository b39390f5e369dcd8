//! The page's plots: image lines, intensity by distance, beam profiles.

use maud::{Markup, PreEscaped, html};
use plotters::prelude::RGBColor;

use crate::Result;
use crate::experiments::{BEAMFORMERS, ByImage, ImageLine, Outcome, VertebraResult};

use super::comparison::images;
use super::plot::{self, Curve, Plot};

/// The curves' colours, one a beamformer.
const COLOURS: [RGBColor; 7] = [
    RGBColor(59, 130, 246),
    RGBColor(139, 139, 150),
    RGBColor(190, 160, 40),
    RGBColor(222, 120, 40),
    RGBColor(180, 80, 190),
    RGBColor(222, 50, 70),
    RGBColor(50, 160, 120),
];

/// The curves' colours by the beamformers' names.
pub fn legend() -> Markup {
    html! {
        ul .legend {
            @for (beamformer, colour) in BEAMFORMERS.iter().zip(COLOURS) {
                li {
                    span .chip style=(format!("background:rgb({},{},{})", colour.0, colour.1, colour.2)) {}
                    (beamformer.name)
                }
            }
        }
    }
}

/// The curves of every beamformer; that of rank 1 is the widest.
fn all_curves(curve: impl Fn(usize) -> Vec<(f64, Option<f64>)>) -> Vec<Curve> {
    let width = |k: usize| match BEAMFORMERS[k].key {
        "das" | "esmv-rank1" => 3,
        _ => 1,
    };
    // The two that matter are drawn last, over the others.
    let mut order: Vec<usize> = (0..BEAMFORMERS.len()).collect();
    order.sort_by_key(|&k| width(k));
    order
        .into_iter()
        .map(|k| Curve {
            points: curve(k),
            colour: COLOURS[k],
            width: width(k),
        })
        .collect()
}

fn figure(svg: String, caption: &str) -> Markup {
    html! { figure .plot { (PreEscaped(svg)) figcaption { (caption) } } }
}

/// The plots of the axial and the lateral line, B-mode and phase symmetry.
///
/// # Errors
/// A plot cannot be drawn.
pub fn lines(vertebra: &VertebraResult) -> Result<Markup> {
    let axial = (&vertebra.axial_depth_mm[..], &vertebra.axial_surface_mm[..]);
    let lateral = (&vertebra.lateral_x_mm[..], &vertebra.lateral_surface_mm[..]);
    let mut plots = line_plots("Axial line", "depth, mm", axial, |k| {
        &vertebra.beamformers[k].axial
    })?;
    plots.extend(line_plots("Lateral line", "lateral, mm", lateral, |k| {
        &vertebra.beamformers[k].lateral
    })?);
    Ok(html! { @for plot in plots { (plot) } })
}

fn line_plots<'a>(
    direction: &str,
    x: &str,
    (at, marks): (&[f64], &[f64]),
    line: impl Fn(usize) -> &'a ByImage<ImageLine>,
) -> Result<Vec<Markup>> {
    let mut plots = Vec::new();
    for (image, pick) in images::<ImageLine>() {
        let curves = all_curves(|k| {
            let points = at.iter().zip(&pick(line(k)).intensity);
            points.map(|(&x, &v)| (x, Some(f64::from(v)))).collect()
        });
        let plot = Plot {
            x,
            y: "grey level",
            x_range: [at[0], at[at.len() - 1]],
            y_range: [0.0, 255.0],
            marks,
        };
        let svg = plot::curves(&plot, &curves)?;
        plots.push(figure(svg, &format!("{direction}, {}", full_name(image))));
    }
    Ok(plots)
}

/// The plots of intensity by signed distance.
///
/// # Errors
/// A plot cannot be drawn.
pub fn distances(vertebra: &VertebraResult) -> Result<Markup> {
    let mut plots = Vec::new();
    for (image, pick) in images::<Vec<Option<f64>>>() {
        let curves = all_curves(|k| {
            let values = pick(&vertebra.beamformers[k].intensity_by_distance);
            let points = vertebra.distance_mm.iter().zip(values);
            points.map(|(&x, &v)| (x, v)).collect()
        });
        let highest = curves.iter().flat_map(|curve| &curve.points);
        let highest = highest.filter_map(|(_, y)| *y).fold(1.0, f64::max);
        let inside = curves.iter().flat_map(|curve| &curve.points);
        let inside = inside.filter(|(_, y)| y.is_some()).map(|(x, _)| *x);
        let plot = Plot {
            x: "signed distance, mm (inside the bone positive)",
            y: "mean grey level",
            x_range: [-10.0, inside.fold(1.0, f64::max).ceil()],
            y_range: [0.0, 1.05 * highest],
            marks: &[0.0],
        };
        plots.push(figure(plot::curves(&plot, &curves)?, full_name(image)));
    }
    Ok(html! { @for plot in plots { (plot) } })
}

/// The point's beam profiles, the finest sampling first.
///
/// # Errors
/// A plot cannot be drawn.
pub fn point_plots(outcome: &Outcome) -> Result<Markup> {
    let mut plots = Vec::new();
    for sampling in &outcome.point.samplings {
        let curves = all_curves(|k| {
            let levels = &sampling.beamformers[k].profile_re_das_db;
            let points = sampling.x_mm.iter().zip(levels);
            points.map(|(&x, &level)| (x, Some(level))).collect()
        });
        let plot = Plot {
            x: "lateral, mm from the middle beam",
            y: "dB re DAS peak",
            x_range: [-2.5, 2.5],
            y_range: [-120.0, 0.0],
            marks: &[],
        };
        let caption = format!(
            "Two-way beam profiles, beams {:.3} mm apart, point {:.3} mm off the middle beam",
            sampling.beam_spacing_mm, sampling.point_offset_mm
        );
        plots.push(figure(plot::curves(&plot, &curves)?, &caption));
    }
    // The finest first.
    plots.reverse();
    Ok(html! { @for plot in plots { (plot) } })
}

fn full_name(image: &str) -> &'static str {
    if image == "US" {
        "B-mode (US)"
    } else {
        "Phase symmetry (PS)"
    }
}
