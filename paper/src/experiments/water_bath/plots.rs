//! Pictures and plots of the water bath's slices.

use crate::experiments::outcome::Coloured;
use crate::experiments::study::*;
use bonebeam_drive::methods::COMPARED;

use super::images::Images;
use super::measures::{ByDistance, Measured};
use super::parameters::{FEATURED, KINDS, METHODS, WaterBath};

/// Reach of colour maps and curves from the contour, mm.
const REACH: f64 = 10.0;

pub fn name(key: &str) -> &'static str {
    let row = COMPARED.iter().find(|row| row.key == key);
    row.map_or("", |row| row.name)
}

/// The images of a slice beside each other.
pub fn beside(k: usize, slice: &Images, measured: &Measured, bath: &WaterBath) -> Option<Section> {
    let views = slice.pairs.iter();
    let views = views.map(|pair| (name(pair.beamformer).to_owned(), pair.card()));
    let id = format!("water-bath-{}", k + 1);
    let (outline, scales) = (
        measured.contour_mm.clone(),
        scales(bath.image.dynamic_range),
    );
    SideBySide::of(id, views, slice.pairs.len() - 2, outline, scales)
}

/// Grey levels by signed distance, B-mode and phase symmetry.
pub fn distance_plots(k: usize, measured: &Measured) -> Vec<Plot> {
    let plot = |image: usize| {
        let curves = METHODS.iter().zip(&measured.by_distance);
        let featured = curves.filter(|(key, _)| FEATURED.contains(key));
        let curves = featured.flat_map(|(key, levels)| {
            let ByDistance { mean, above_zero } = &levels[image];
            let quantile = |k: usize| above_zero.iter().map(|q| Some((*q)?[k])).collect();
            let curve = |what: &str, levels: Vec<Option<f64>>| {
                let points = measured.distance_mm.iter().copied().zip(levels);
                Curve::new(format!("{}, {what}", name(key)), what == "mean", points)
            };
            [
                curve("mean", mean.clone()),
                curve("median", quantile(0)),
                curve("90 %", quantile(1)),
            ]
        });
        let names = ["signed distance, mm", "grey level"];
        let caption = format!("Grey level by distance, {}, slice {}", KINDS[image], k + 1);
        Plot {
            marks: vec![0.0],
            ..Plot::new(caption, names, [[-REACH, REACH], [0.0, 255.0]], curves)
        }
    };
    vec![plot(0), plot(1)]
}

/// Grey levels along the lines of Figs. 8 and 9.
pub fn line_plots(k: usize, measured: &Measured) -> Vec<Plot> {
    let ways = [
        (&measured.down, "down at x =", "depth, mm"),
        (&measured.across, "across at a depth of", "lateral, mm"),
    ];
    let mut plots = Vec::new();
    for (way, (line, place, x)) in ways.into_iter().enumerate() {
        for image in 0..2 {
            let curves = METHODS
                .iter()
                .zip(&measured.profiles)
                .map(|(key, profiles)| {
                    let grey = profiles[image][way].grey.iter();
                    let points = line
                        .at_mm
                        .iter()
                        .zip(grey)
                        .map(|(&x, &v)| (x, f64::from(v)));
                    Curve::new(name(key), FEATURED.contains(key), points)
                });
            let (kind, slice, at) = (KINDS[image], k + 1, line.place_mm);
            let caption = format!("{kind}, slice {slice}, {place} {at:.1} mm");
            let ranges = [
                [line.at_mm[0], line.at_mm[line.at_mm.len() - 1]],
                [0.0, 255.0],
            ];
            plots.push(Plot {
                marks: line.contour_mm.clone(),
                ..Plot::new(caption, [x, "grey level"], ranges, curves)
            });
        }
    }
    plots
}

/// Images of a slice coloured by the signed distance; B-mode, then phase symmetry.
pub fn distance_maps(k: usize, slice: &Images, measured: &Measured) -> Vec<Coloured> {
    let mut all = Vec::new();
    for image in 0..2 {
        let featured = |p: &&Pair| FEATURED.contains(&p.beamformer);
        for pair in slice.pairs.iter().filter(featured) {
            let kind = KINDS[image];
            let of = pair.images()[image];
            let key = pair.beamformer;
            all.push(Coloured {
                picture: Picture {
                    file: format!(
                        "water-bath-{}-{key}-{}-distance.png",
                        k + 1,
                        kind.to_lowercase()
                    ),
                    caption: format!("{}, {kind}, slice {}, by signed distance", name(key), k + 1),
                    ..of.clone()
                },
                values: measured.distance.mapv(|s| 1e3 * s),
                reach: REACH,
                quantity: "signed distance, mm",
            });
        }
    }
    all
}
