//! Pictures of the page, with axes and grey bars.

use maud::{Markup, PreEscaped, html};

use crate::Result;
use crate::experiments::outcome::{Coloured, Gallery, Picture, Scale, SideBySide, View};
use bonebeam_files::image::png;

use super::axes;
use super::colours::colour;
use super::embedded::embedded;

/// Place of the page's pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureLocation {
    /// In files beside the page.
    SeparateFile,
    /// In the page.
    Embedded,
}

/// Pictures side by side.
///
/// A hidden outline has a switch for the reader.
///
/// # Errors
/// The axes cannot be drawn, or a picture not encoded.
pub fn gallery(gallery: &Gallery, source: PictureLocation) -> Result<Markup> {
    let card = |card: &Vec<Picture>| {
        let figures = card
            .iter()
            .map(|shown| picture(shown, &gallery.outline, source));
        figures.collect::<Result<Vec<_>>>()
    };
    let cards = gallery.cards.iter().map(card).collect::<Result<Vec<_>>>()?;
    let cards = html! {
        div .pairs {
            @for figures in cards {
                div .pair { @for figure in figures { (figure) } }
            }
        }
    };
    Ok(html! {
        @if gallery.outline_on_request {
            div .optional-outline {
                label .toggle { input type="checkbox"; " show the known surface" }
                (cards)
            }
        } @else {
            (cards)
        }
        (scales(&gallery.scales))
    })
}

/// Pictures of one method beside those of another, which the reader selects.
///
/// The switch needs no script.
///
/// # Errors
/// As [`gallery`].
pub fn beside(beside: &SideBySide, source: PictureLocation) -> Result<Markup> {
    let column = |(_, pictures): &View| {
        let figures = pictures.iter();
        let figures = figures.map(|shown| picture(shown, &beside.outline, source));
        figures.collect::<Result<Vec<_>>>()
    };
    let reference = column(&beside.reference)?;
    let others = beside.others.iter().map(column);
    let others = others.collect::<Result<Vec<_>>>()?;
    Ok(html! {
        div .beside role="group" aria-label="Two methods side by side" {
            @for (k, (name, _)) in beside.others.iter().enumerate() {
                @let id = format!("{}-{k}", beside.id);
                input .choose type="radio" name=(beside.id) id=(id) checked[k == beside.first];
                label for=(id) { (name) }
            }
            div .columns {
                div .column {
                    @for figure in reference { (figure) }
                }
                @for figures in others {
                    div .column .chosen { @for figure in figures { (figure) } }
                }
            }
        }
        (scales(&beside.scales))
    })
}

/// Pictures coloured by the same quantity, over its bar.
///
/// The page always contains them.
///
/// # Errors
/// As [`gallery`].
pub fn coloured(all: &[Coloured]) -> Result<Markup> {
    let figures = all
        .iter()
        .map(|shown| framed(&shown.picture, &[], embedded(&shown.png()?)));
    let figures = figures.collect::<Result<Vec<_>>>()?;
    Ok(html! {
        div .pairs {
            @for pair in figures.chunks(2) {
                div .pair { @for figure in pair { (figure) } }
            }
        }
        @if let Some(first) = all.first() {
            div .scales {
                div .scale {
                    span { (first.quantity) }
                    div {
                        div .bar style=(gradient()) {}
                        div .ticks {
                            @for end in [-first.reach, 0.0, first.reach] {
                                span { (axes::tick(&end)) }
                            }
                        }
                    }
                }
            }
        }
    })
}

/// The bar of the colours, from one end to the other.
fn gradient() -> String {
    let stops = (-10..=10).map(|k| {
        let [r, g, b] = colour(f64::from(k) / 10.0).map(|v| (255.0 * v).round());
        format!("rgb({r},{g},{b})")
    });
    let stops: Vec<String> = stops.collect();
    format!("background:linear-gradient(to right,{})", stops.join(","))
}

fn scales(scales: &[Scale]) -> Markup {
    html! {
        @if !scales.is_empty() {
            div .scales { @for bar in scales { (scale(bar)) } }
        }
    }
}

fn picture(
    picture: &Picture,
    outline: &[Vec<(f64, f64)>],
    source: PictureLocation,
) -> Result<Markup> {
    let address = match source {
        PictureLocation::SeparateFile => picture.file.clone(),
        PictureLocation::Embedded => embedded(&png(&picture.pixels)?),
    };
    framed(picture, outline, address)
}

/// The picture at an address within its axes.
fn framed(picture: &Picture, outline: &[Vec<(f64, f64)>], address: String) -> Result<Markup> {
    let frame = axes::frame(picture, outline)?;
    let [left, top, width, height] = frame.position;
    let style = format!("left:{left:.3}%;top:{top:.3}%;width:{width:.3}%;height:{height:.3}%");
    Ok(html! {
        figure {
            div .frame {
                img src=(address) alt=(picture.caption) style=(style);
                div .axes aria-hidden="true" { (PreEscaped(frame.svg)) }
            }
            figcaption { (picture.caption) }
        }
    })
}

/// A grey bar.
fn scale(scale: &Scale) -> Markup {
    html! {
        div .scale {
            span { (scale.name) }
            div {
                div .bar {}
                div .ticks { @for level in &scale.levels { span { (level) } } }
            }
        }
    }
}
