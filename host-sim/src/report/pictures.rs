//! The page's pictures, with their axes and grey bars.

use maud::{Markup, PreEscaped, html};

use crate::Result;
use crate::experiments::outcome::{Gallery, Picture, Scale};

use super::plot;

/// Pictures side by side, with an outline that the reader can show where it is not always there.
///
/// # Errors
/// The axes cannot be drawn.
pub fn gallery(gallery: &Gallery) -> Result<Markup> {
    let card = |card: &Vec<Picture>| {
        let figures = card.iter().map(|shown| picture(shown, &gallery.outline));
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
        @if !gallery.scales.is_empty() {
            div .scales { @for bar in &gallery.scales { (scale(bar)) } }
        }
    })
}

fn picture(picture: &Picture, outline: &[Vec<(f64, f64)>]) -> Result<Markup> {
    let frame = plot::frame(picture, outline)?;
    let [left, top, width, height] = frame.place;
    let place = format!("left:{left:.3}%;top:{top:.3}%;width:{width:.3}%;height:{height:.3}%");
    Ok(html! {
        figure {
            div .frame {
                img src=(picture.file) alt=(picture.caption) style=(place);
                (PreEscaped(frame.svg))
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
