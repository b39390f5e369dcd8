//! The page's pictures, with their axes and grey bars.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, PreEscaped, html};

use crate::Result;
use crate::experiments::outcome::{Beside, Gallery, Picture, Scale, View};
use crate::files::image::png;

use super::plot;

/// Where the page has its pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Files beside it.
    Beside,
    /// Itself.
    Within,
}

/// Pictures side by side, with an outline that the reader can show where it is not always there.
///
/// # Errors
/// The axes cannot be drawn, or a picture not encoded.
pub fn gallery(gallery: &Gallery, source: Source) -> Result<Markup> {
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

/// The pictures of one method beside those of another, which the reader chooses by a switch. The page
/// needs no script for it.
///
/// # Errors
/// As [`gallery`].
pub fn beside(beside: &Beside, source: Source) -> Result<Markup> {
    let column = |view: &View| {
        let figures = view.pictures.iter();
        let figures = figures.map(|shown| picture(shown, &beside.outline, source));
        figures.collect::<Result<Vec<_>>>()
    };
    let reference = column(&beside.reference)?;
    let others = beside.others.iter().map(column);
    let others = others.collect::<Result<Vec<_>>>()?;
    Ok(html! {
        div .beside role="group" aria-label="Two methods side by side" {
            @for (k, view) in beside.others.iter().enumerate() {
                @let id = format!("{}-{k}", beside.id);
                input .choose type="radio" name=(beside.id) id=(id) checked[k == beside.first];
                label for=(id) { (view.name) }
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

fn scales(scales: &[Scale]) -> Markup {
    html! {
        @if !scales.is_empty() {
            div .scales { @for bar in scales { (scale(bar)) } }
        }
    }
}

fn picture(picture: &Picture, outline: &[Vec<(f64, f64)>], source: Source) -> Result<Markup> {
    let frame = plot::frame(picture, outline)?;
    let [left, top, width, height] = frame.place;
    let place = format!("left:{left:.3}%;top:{top:.3}%;width:{width:.3}%;height:{height:.3}%");
    let address = match source {
        Source::Beside => picture.file.clone(),
        Source::Within => format!(
            "data:image/png;base64,{}",
            STANDARD.encode(png(&picture.pixels)?)
        ),
    };
    Ok(html! {
        figure {
            div .frame {
                img src=(address) alt=(picture.caption) style=(place);
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
