//! Pictures and plots of the water bath's slices.

use crate::experiments::common::pictures::{Pair, scales};
use crate::experiments::outcome::{Coloured, Curve, Picture, Plot, SideBySide, View};
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
pub fn beside(k: usize, slice: &Images, measured: &Measured, bath: &WaterBath) -> SideBySide {
    let view = |pair: &Pair| View {
        name: name(pair.beamformer).into(),
        pictures: pair.card(),
    };
    let mut views = slice.pairs.iter().map(view).collect::<Vec<_>>();
    let reference = views.remove(0);
    SideBySide {
        id: format!("water-bath-{}", k + 1),
        reference,
        first: views.len() - 1,
        others: views,
        outline: measured.contour_mm.clone(),
        scales: scales(bath.image.dynamic_range),
    }
}

/// Grey levels by signed distance, B-mode and phase symmetry.
pub fn distance_plots(k: usize, measured: &Measured) -> Vec<Plot> {
    let plot = |image: usize| {
        let curves = METHODS.iter().zip(&measured.by_distance);
        let featured = curves.filter(|(key, _)| FEATURED.contains(key));
        let curve = |key: &str, what: &str, featured: bool, levels: Vec<Option<f64>>| Curve {
            name: format!("{}, {what}", name(key)).into(),
            featured,
            points: measured.distance_mm.iter().copied().zip(levels).collect(),
        };
        Plot {
            caption: format!("Grey level by distance, {}, slice {}", KINDS[image], k + 1),
            x: "signed distance, mm",
            y: "grey level",
            x_range: [-REACH, REACH],
            y_range: [0.0, 255.0],
            marks: vec![0.0],
            curves: featured
                .flat_map(|(key, levels)| {
                    let ByDistance { mean, above_zero } = &levels[image];
                    let quantile = |k: usize| above_zero.iter().map(|q| Some((*q)?[k])).collect();
                    [
                        curve(key, "mean", true, mean.clone()),
                        curve(key, "median", false, quantile(0)),
                        curve(key, "90 %", false, quantile(1)),
                    ]
                })
                .collect(),
        }
    };
    vec![plot(0), plot(1)]
}

/// Grey levels along the lines of Figs. 8 and 9.
pub fn line_plots(k: usize, measured: &Measured) -> Vec<Plot> {
    let mut plots = Vec::new();
    for (way, line) in [&measured.down, &measured.across].into_iter().enumerate() {
        for image in 0..2 {
            let curves = METHODS.iter().zip(&measured.profiles);
            plots.push(Plot {
                caption: format!(
                    "{}, slice {}, {} {:.1} mm",
                    KINDS[image],
                    k + 1,
                    ["down at x =", "across at a depth of"][way],
                    line.place_mm
                ),
                x: if way == 0 { "depth, mm" } else { "lateral, mm" },
                y: "grey level",
                x_range: [line.at_mm[0], line.at_mm[line.at_mm.len() - 1]],
                y_range: [0.0, 255.0],
                marks: line.contour_mm.clone(),
                curves: curves
                    .map(|(key, profiles)| Curve {
                        name: name(key).into(),
                        featured: FEATURED.contains(key),
                        points: (line.at_mm.iter().copied())
                            .zip(
                                profiles[image][way]
                                    .grey
                                    .iter()
                                    .map(|&v| Some(f64::from(v))),
                            )
                            .collect(),
                    })
                    .collect(),
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
            let of = [&pair.b_mode, &pair.phase_symmetry][image];
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
