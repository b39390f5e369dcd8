//! The page's pictures, with their axes and grey bars.

use maud::{Markup, PreEscaped, html};

use crate::Result;
use crate::experiments::{BEAMFORMERS, Pair, Picture, VertebraResult};

use super::plot;

/// Some beamformers' pairs.
///
/// # Errors
/// The axes cannot be drawn.
pub fn pairs(
    vertebra: &VertebraResult,
    keys: &[&str],
    range: f64,
    outline: bool,
) -> Result<Markup> {
    let chosen: Vec<Pair> = vertebra
        .pictures
        .iter()
        .filter(|pair| keys.contains(&pair.beamformer))
        .cloned()
        .collect();
    let outline = if outline {
        &vertebra.outline_mm[..]
    } else {
        &[]
    };
    let shown = chosen
        .iter()
        .map(|pair| pair_figure(pair, range, outline))
        .collect::<Result<Vec<_>>>()?;
    Ok(html! { div .pairs { @for figure in shown { (figure) } } })
}

/// Every pair, with an outline that the reader can show.
///
/// # Errors
/// The axes cannot be drawn.
pub fn all_pairs(all: &[Pair], range: f64, outline: &[Vec<(f64, f64)>]) -> Result<Markup> {
    let shown = all
        .iter()
        .map(|pair| pair_figure(pair, range, outline))
        .collect::<Result<Vec<_>>>()?;
    Ok(html! { div .pairs .optional-outline { @for figure in shown { (figure) } } })
}

fn pair_figure(pair: &Pair, range: f64, outline: &[Vec<(f64, f64)>]) -> Result<Markup> {
    let name = name(pair.beamformer);
    Ok(html! {
        div .pair {
            (picture(&pair.b_mode, &format!("{name}, B-mode, {range} dB"), outline)?)
            (picture(&pair.phase_symmetry, &format!("{name}, phase symmetry"), outline)?)
        }
    })
}

fn picture(picture: &Picture, caption: &str, outline: &[Vec<(f64, f64)>]) -> Result<Markup> {
    let frame = plot::frame(picture, outline)?;
    let [left, top, width, height] = frame.place;
    let place = format!("left:{left:.3}%;top:{top:.3}%;width:{width:.3}%;height:{height:.3}%");
    Ok(html! {
        figure {
            div .frame {
                img src=(picture.file) alt=(caption) style=(place);
                (PreEscaped(frame.svg))
            }
            figcaption { (caption) }
        }
    })
}

/// The grey bars of B-mode and of phase symmetry.
pub fn scales(range: f64) -> Markup {
    let bar = |name: &str, low: String, middle: String, high: String| {
        html! {
            div .scale {
                span { (name) }
                div {
                    div .bar {}
                    div .ticks { span { (low) } span { (middle) } span { (high) } }
                }
            }
        }
    };
    html! {
        div .scales {
            (bar("B-mode", format!("−{range} dB"), format!("−{} dB", range / 2.0), "0 dB".into()))
            (bar("Phase symmetry", "0".into(), "127".into(), "255 (max)".into()))
        }
    }
}

fn name(key: &str) -> &str {
    let known = BEAMFORMERS.iter().find(|b| b.key == key);
    known.map_or(key, |b| b.name)
}
