//! Pictures of the first bones: one disturbed scene each in water and in tissue.

use crate::Result;
use crate::experiments::Context;
use crate::experiments::common::pair::pair;
use crate::experiments::common::pictures::{ridges, scales};
use crate::experiments::common::truth::beside;
use crate::experiments::outcome::{SideBySide, View};

use super::condition::{Condition, Medium};
use super::mechanism::Figure;
use super::parameters::Claims;
use super::pose::{Beamformed, one};

/// Number of bones shown.
const SHOWN: u64 = 2;

/// Pictures of the first bones with the paper's time windows.
///
/// # Errors
/// A scene that cannot be simulated.
pub fn shown(claims: &Claims, context: &Context<'_>) -> Result<Figure> {
    let mut figure = Figure {
        parts: Vec::new(),
        pictures: Vec::new(),
    };
    let first = claims.simulation.seed;
    let wanted = [Condition::WaterDisturbed, Condition::TissueDisturbed];
    let wanted = wanted.into_iter().filter(|c| claims.wants(*c));
    let bones = first..first.saturating_add(claims.bones.min(SHOWN));
    for (condition, number) in wanted.flat_map(|c| bones.clone().map(move |n| (c, n))) {
        let (image, filter) = claims.display(condition.medium());
        let windows = claims.half_windows.iter().copied();
        let window = match condition.medium() {
            Medium::Water => windows.min(),
            Medium::Tissue => windows.max(),
        };
        let window = window.unwrap_or(0);
        let made = one(claims, context, number, condition, window, "claims: bones")?;
        let medium = condition.medium().name();
        let mut views = Vec::new();
        for Beamformed {
            variant, pixels, ..
        } in made.images
        {
            let map = ridges(&pixels, filter)?;
            let name = format!("bone {number}, {}, {}", condition.name(), variant.name);
            let pictures = pair(
                &format!("claims-{number}-{medium}-{}", variant.key),
                &format!("{name}: "),
                image.dynamic_range,
                [pixels, map],
                &made.view.grid,
            );
            figure.pictures.extend(pictures.clone());
            views.push(View {
                name: variant.name,
                pictures: pictures.to_vec(),
            });
        }
        figure.parts.extend(SideBySide::of(
            format!("claims-{number}-{medium}"),
            views,
            0,
            beside(&made.view.hits, &made.view.grid),
            scales(image.dynamic_range),
        ));
    }
    Ok(figure)
}
