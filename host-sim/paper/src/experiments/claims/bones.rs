//! Pictures of either bone: one disturbed scene in water.

use crate::Result;
use crate::experiments::Context;
use crate::experiments::common::pictures::{picture, ridges, scales};
use crate::experiments::common::truth::beside;
use crate::experiments::outcome::{Section, SideBySide, View};

use super::geometry::Geometries;
use super::mechanism::Figure;
use super::medium::Medium;
use super::parameters::{Claims, GEOMETRIES};
use super::pose::one;

/// The pictures of the first seed with the shortest time window, the paper's in water.
///
/// # Errors
/// A scene that cannot be simulated.
pub fn shown(claims: &Claims, context: &Context<'_>, geometries: &Geometries) -> Result<Figure> {
    let (image, filter) = claims.display(Medium::Water);
    let shortest = claims.half_windows.iter().copied().min().unwrap_or(0);
    let wanted = GEOMETRIES
        .into_iter()
        .filter(|geometry| claims.wants(geometry, Medium::Water, true));
    let mut figure = Figure {
        parts: Vec::new(),
        pictures: Vec::new(),
    };
    for geometry in wanted {
        let scene = (geometry, Medium::Water, true);
        let made = one(
            claims,
            context,
            geometries,
            scene,
            shortest,
            "claims: bones",
        )?;
        let mut views = Vec::new();
        for (variant, pixels) in made.images {
            let map = ridges(&pixels, filter)?;
            let name = format!("{geometry} bone, {}", variant.name);
            let grid = &made.view.grid;
            let pictures = vec![
                picture(
                    format!("claims-{geometry}-{}.png", variant.key),
                    format!("{name}: B-mode over {} dB", image.dynamic_range),
                    pixels,
                    grid,
                ),
                picture(
                    format!("claims-{geometry}-{}-ps.png", variant.key),
                    format!("{name}: phase symmetry"),
                    map,
                    grid,
                ),
            ];
            figure.pictures.extend(pictures.clone());
            views.push(View {
                name: variant.name,
                pictures,
            });
        }
        let reference = views.remove(0);
        figure.parts.push(Section::SideBySide(SideBySide {
            id: format!("claims-{geometry}"),
            reference,
            others: views,
            first: 0,
            outline: beside(&made.view.hits, &made.view.grid),
            scales: scales(image.dynamic_range),
        }));
    }
    Ok(figure)
}
