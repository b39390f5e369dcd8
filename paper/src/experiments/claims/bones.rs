//! Pictures of the first bones: one disturbed scene each in water and in tissue.

use super::condition::Condition;
use super::parameters::{Claims, SHOWN};
use super::pose::one;
use crate::experiments::study::*;

/// Pictures of the first bones with the paper's time windows.
pub fn shown(claims: &Claims, context: &Context<'_>) -> Result<Vec<Section>> {
    let mut parts = Vec::new();
    let first = claims.simulation.seed;
    let wanted = [Condition::WaterDisturbed, Condition::TissueDisturbed];
    let wanted = wanted.into_iter().filter(|c| claims.wants(*c));
    let bones = first..first.saturating_add(claims.bones.min(SHOWN));
    for (condition, number) in wanted.flat_map(|c| bones.clone().map(move |n| (c, n))) {
        let medium = condition.medium();
        let (image, filter) = claims.display(medium);
        let window = claims.window(medium);
        let made = one(claims, context, number, condition, window, "claims: bones")?;
        let id = format!("claims-{number}-{medium}");
        let range = image.dynamic_range;
        let views = made.images.into_iter().map(|beamformed| {
            let Variant { key, name, .. } = beamformed.variant;
            let map = ridges(&beamformed.pixels, filter)?;
            let what = format!("bone {number}, {}, {name}: ", condition.title());
            let images = [beamformed.pixels, map];
            let pictures = pair(
                &format!("{id}-{key}"),
                &what,
                range,
                images,
                &made.view.grid,
            );
            Ok((name, pictures.to_vec()))
        });
        let views = views.collect::<Result<Vec<_>>>()?;
        let outline = beside(&made.view.hits, &made.view.grid);
        parts.extend(SideBySide::of(id, views, 0, outline, scales(range)));
    }
    Ok(parts)
}
