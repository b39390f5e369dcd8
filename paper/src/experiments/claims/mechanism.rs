//! Why phase symmetry finds less bone in tissue with rank-1 ESMV than with DAS.
//!
//! Parts of the rank-1 ESMV image replace those of the DAS image. The levels of the tissue are compared.

use crate::experiments::common::pair::pair as pictures;
use crate::experiments::study::*;
use crate::measure::contrast::moments;

use super::condition::{Condition, Medium};
use super::parameters::Claims;
use super::pose::{Beamformed, one};

/// Range of signed distances of the surface's echo, m.
const ECHO: [f64; 2] = [-0.5e-3, 1.5e-3];
/// Lateral reach of the halos beside an echo, m.
const SIDEWAYS: f64 = 4e-3;
/// Tolerance of the same depth, m.
const SAME_DEPTH: f64 = 0.5e-3;

/// Average precision of phase symmetry in mixed images.
///
/// Parts of the image come from rank-1 ESMV, the others from DAS.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Zones {
    pub das: Option<f64>,
    /// The echo of the surface from rank-1 ESMV.
    pub echo: Option<f64>,
    /// The halos from rank-1 ESMV: beside the echo at the same depth.
    pub halo: Option<f64>,
    /// The rest from rank-1 ESMV.
    pub rest: Option<f64>,
    /// All from rank-1 ESMV.
    pub all: Option<f64>,
    /// Mean level beside echoes relative to other tissue, dB: DAS, rank-1 ESMV.
    pub halo_db: [Option<f64>; 2],
    /// Standard deviation of the level of other tissue, dB: DAS, rank-1 ESMV.
    pub spread_db: [Option<f64>; 2],
}

/// Part of the image that a pixel belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Zone {
    Echo,
    Halo,
    Rest,
}

fn zone_map(view: &View) -> Array2<Zone> {
    let pixel = view.grid.pixel;
    let (rows, columns) = view.distance.dim();
    let reach = (SIDEWAYS / pixel).round() as usize;
    let mut map = Array2::from_elem((rows, columns), Zone::Rest);
    for (column, hit) in view.hits.iter().enumerate() {
        let Some(hit) = hit else { continue };
        for row in view.near(*hit, SAME_DEPTH) {
            for c in column.saturating_sub(reach)..=(column + reach).min(columns - 1) {
                map[[row, c]] = Zone::Halo;
            }
        }
    }
    for (pixel, &s) in view.distance.indexed_iter() {
        if (ECHO[0]..=ECHO[1]).contains(&s) {
            map[pixel] = Zone::Echo;
        }
    }
    map
}

/// The image of `das` with one zone from that of `esmv`.
fn mixed(das: &Array2<f32>, esmv: &Array2<f32>, map: &Array2<Zone>, zone: Zone) -> Array2<f32> {
    let mut image = das.clone();
    for (pixel, &there) in map.indexed_iter() {
        if there == zone {
            image[pixel] = esmv[pixel];
        }
    }
    image
}

/// The images of DAS and of forward rank-1 ESMV with the longest time window.
fn pair(images: &[Beamformed]) -> Option<[&Array2<f32>; 2]> {
    let das = &images.first()?.pixels;
    let forward = images
        .iter()
        .skip(1)
        .filter(|made| !made.variant.key.contains("-fb"));
    let esmv = forward.max_by_key(|made| made.variant.half_window)?;
    Some([das, &esmv.pixels])
}

/// Grey levels of a zone's pixels in tissue in front of the bone.
fn levels(image: &Array2<f32>, view: &View, map: &Array2<Zone>, zone: Zone) -> Vec<f64> {
    let depth = |row: usize| view.grid.z0 + row as f64 * view.grid.pixel;
    let mut found = Vec::new();
    for ((row, column), &s) in view.distance.indexed_iter() {
        let in_front = view.hits[column].is_none_or(|hit| (row as f64) < hit);
        let inside = view.grid.x0 + column as f64 * view.grid.pixel;
        let tissue = (13e-3..=36e-3).contains(&depth(row)) && inside.abs() < 14e-3;
        if map[[row, column]] == zone && in_front && tissue && s < -1e-3 {
            found.push(f64::from(image[[row, column]]));
        }
    }
    found
}

/// Scores of the mixed images of a scene; grey levels span `range` dB.
pub fn zones(
    view: &View,
    images: &[Beamformed],
    filter: &PhaseSymmetry,
    range: f64,
) -> Result<Option<Zones>> {
    let Some([das, esmv]) = pair(images) else {
        return Ok(None);
    };
    let map = zone_map(view);
    let score = |image: &Array2<f32>| {
        let ridges = ridges(image, filter)?;
        Ok::<_, crate::Error>(precision(&ridges, &view.hits, &view.grid))
    };
    let with = |zone: Zone| score(&mixed(das, esmv, &map, zone));
    let decibels = |grey: f64| range * grey / 255.0;
    let halo = |image: &Array2<f32>| {
        let beside = moments(&levels(image, view, &map, Zone::Halo))?.0;
        let rest = moments(&levels(image, view, &map, Zone::Rest))?.0;
        Some(decibels(beside - rest))
    };
    let spread = |image: &Array2<f32>| {
        let (_, spread) = moments(&levels(image, view, &map, Zone::Rest))?;
        Some(decibels(spread))
    };
    Ok(Some(Zones {
        das: score(das)?,
        echo: with(Zone::Echo)?,
        halo: with(Zone::Halo)?,
        rest: with(Zone::Rest)?,
        all: score(esmv)?,
        halo_db: [halo(das), halo(esmv)],
        spread_db: [spread(das), spread(esmv)],
    }))
}

/// The figure of the first bone: one quiet scene in tissue.
///
/// Nothing if quiet scenes in tissue are not selected.
pub fn shown(claims: &Claims, context: &Context<'_>) -> Result<Vec<Section>> {
    let condition = Condition::TissueQuiet;
    if !claims.wants(condition) {
        return Ok(Vec::new());
    }
    let longest = claims.window(Medium::Tissue);
    let what = "claims: mechanism";
    let made = one(
        claims,
        context,
        claims.simulation.seed,
        condition,
        longest,
        what,
    )?;
    let Some([das, esmv]) = pair(&made.images) else {
        return Ok(Vec::new());
    };
    let view = &made.view;
    let map = zone_map(view);
    let (image, filter) = claims.display(Medium::Tissue);
    let range = image.dynamic_range;
    let with = |zone| mixed(das, esmv, &map, zone);
    let views = [
        ("das", "DAS", das.clone()),
        ("rank1", "ESMV rank 1", esmv.clone()),
        ("echo", "DAS, echo of rank 1", with(Zone::Echo)),
        ("halo", "DAS, halo of rank 1", with(Zone::Halo)),
        ("rest", "DAS, rest of rank 1", with(Zone::Rest)),
    ]
    .map(|(key, name, pixels)| {
        let ridges = ridges(&pixels, filter)?;
        let score = precision(&ridges, &view.hits, &view.grid);
        let (stem, what) = (format!("mechanism-{key}"), format!("{name}: "));
        let mut pictures = pictures(&stem, &what, range, [pixels, ridges], &view.grid);
        if let Some(score) = score {
            pictures[1].caption += &format!(", average precision {score:.2}");
        }
        Ok((name.to_owned(), pictures.to_vec()))
    });
    let views = views.into_iter().collect::<Result<Vec<_>>>()?;
    let outline = beside(&view.hits, &view.grid);
    let mut parts = Vec::from_iter(SideBySide::of(
        "mechanism",
        views,
        0,
        outline,
        scales(range),
    ));
    parts.push(Section::Plots(plots([das, esmv], view, &map, range)));
    Ok(parts)
}

/// Levels of the tissue in the images of DAS and of rank-1 ESMV.
fn plots(images: [&Array2<f32>; 2], view: &View, map: &Array2<Zone>, range: f64) -> Vec<Plot> {
    type Points = Vec<(f64, Option<f64>)>;
    let curves = |points: &dyn Fn(&Array2<f32>) -> Points| {
        let names = ["DAS", "ESMV rank 1"].into_iter().zip(images);
        let curves = names.map(|(name, image)| Curve::new(name, true, points(image)));
        curves.collect::<Vec<_>>()
    };
    let level = "dB re the image's peak";
    vec![
        Plot::new(
            "Levels of the tissue away from echoes",
            [level, "share of pixels in 2 dB, %"],
            [[-range, 0.0], [0.0, 20.0]],
            curves(&|image| histogram(&levels(image, view, map, Zone::Rest), range)),
        ),
        Plot::new(
            "Mean level beside the strongest echo, at its depth",
            ["lateral, mm from the echo", level],
            [[-10.0, 10.0], [-range, 0.0]],
            curves(&|image| lateral_profile(image, view, range)),
        ),
    ]
}

/// Histogram of the grey levels in bins of 2 dB.
fn histogram(grey: &[f64], range: f64) -> Vec<(f64, Option<f64>)> {
    let bins = (range / 2.0).round() as usize;
    let mut counts = vec![0usize; bins];
    for g in grey {
        counts[((g / 255.0 * bins as f64) as usize).min(bins - 1)] += 1;
    }
    let percent = |n: usize| 100.0 * n as f64 / grey.len().max(1) as f64;
    let points = counts.iter().enumerate();
    points
        .map(|(k, &n)| (-range + 2.0 * (k as f64 + 0.5), Some(percent(n))))
        .collect()
}

/// Mean level at the depth of the strongest surface echo, by lateral distance.
fn lateral_profile(image: &Array2<f32>, view: &View, range: f64) -> Vec<(f64, Option<f64>)> {
    let at = |(column, hit): (usize, &Option<f64>)| {
        let row = (hit.as_ref()?.round() as usize).min(image.nrows() - 1);
        Some((row, column, image[[row, column]]))
    };
    let echoes = view.hits.iter().enumerate().filter_map(at);
    let Some((row, column, _)) = echoes.max_by(|a, b| a.2.total_cmp(&b.2)) else {
        return Vec::new();
    };
    let half = (SAME_DEPTH / view.grid.pixel).round() as usize;
    let rows = row.saturating_sub(half)..(row + half + 1).min(image.nrows());
    let at = |c: usize| {
        let grey = mean(rows.clone().map(|r| f64::from(image[[r, c]])))?;
        Some(range * (grey / 255.0 - 1.0))
    };
    let x = |c: usize| 1e3 * view.grid.pixel * (c as f64 - column as f64);
    (0..image.ncols()).map(|c| (x(c), at(c))).collect()
}
