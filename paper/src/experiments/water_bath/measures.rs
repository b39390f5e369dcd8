//! Measures of the two slices.
//!
//! Table I under every combination of sources, curves by distance, image lines, and repeated registrations.

use crate::experiments::study::*;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;

use crate::experiments::common::pictures::outline_mm;
use crate::measure::line::Line;
use crate::measure::registration::{Point, Rigid, fiducial_error};
use crate::measure::signed_distance::distribution;
use bonebeam_simulate::complex_gaussian;

use super::contour::{self, Row, Sources};
use super::images::Images;
use super::parameters::{FEATURED, WaterBath};
use super::registration::{Ct, Registrations};
use super::specimen::Specimen;
use super::sweep::{self, Tip, Volume};

/// Number of draws of the picking error, and step of the measured pixels.
const DRAWS: usize = 40;
const THINNED: usize = 4;
/// Search range for a peak around the contour, mm.
pub const SEARCH: f64 = 2.5;
/// Width of a bin of the intensity by distance, m.
const BIN: f64 = 0.25e-3;

/// Measures of a slice.
#[derive(Serialize)]
pub struct Measured {
    /// By combination of sources: the image of one grey level, then [`FEATURED`].
    ///
    /// Each has B-mode, then phase symmetry.
    pub sources: Vec<SourcesMeasured>,
    /// With all sources on: the rows of [`METHODS`].
    pub table: Vec<[Row; 2]>,
    /// The image of one grey level there.
    pub uniform: [Row; 2],
    /// Grey levels by distance, by method; B-mode, then phase symmetry.
    pub by_distance: Vec<[ByDistance; 2]>,
    /// Centres of the bins, mm.
    pub distance_mm: Vec<f64>,
    pub down: Line,
    pub across: Line,
    /// Profiles of each method down and across; B-mode, then phase symmetry.
    pub profiles: Vec<[[Profile; 2]; 2]>,
    /// The contour with all sources on, mm.
    pub contour_mm: Vec<Vec<(f64, f64)>>,
    #[serde(skip)]
    pub distance: Array2<f64>,
}

/// A line of one image.
#[derive(Serialize)]
pub struct Profile {
    /// Grey levels.
    pub grey: Vec<f32>,
}

/// Grey levels of an image by distance from the contour.
#[derive(Serialize)]
pub struct ByDistance {
    /// Mean of all pixels.
    pub mean: Vec<Option<f64>>,
    /// Median and 90 % quantile of the pixels above 0.
    pub above_zero: Vec<Option<[f64; 2]>>,
}

/// A row of the table of sources.
#[derive(Serialize)]
pub struct SourcesMeasured {
    pub sources: String,
    pub uniform: [Row; 2],
    pub featured: Vec<[Row; 2]>,
    /// Depth of the B-mode peak below the contour on the line down (Fig. 8a), mm.
    ///
    /// One for each of [`FEATURED`].
    pub peak_mm: Vec<Option<f64>>,
}

/// Localisation errors over repeated registrations, mm.
///
/// By slice, then B-mode and phase symmetry of each of [`FEATURED`].
#[derive(Serialize)]
pub struct Draws {
    pub fre_mm: Vec<f64>,
    pub error_mm: Vec<[Vec<[f64; 2]>; 2]>,
}

impl WaterBath {
    pub fn measure(
        &self,
        k: usize,
        slice: &Images,
        ct: &Ct,
        registrations: &Registrations,
    ) -> Result<Measured> {
        let rows = |pair: &Pair, distance: &Array2<f64>| -> [Row; 2] {
            let pixels = pair.images().map(|picture| picture.pixels.view());
            [0, 1].map(|image| contour::row(pixels[image], distance, REGIONS[image]))
        };
        let baseline =
            |distance: &Array2<f64>| REGIONS.map(|region| contour::uniform(distance, region));
        let every = Sources::every();
        let sources = every.par_iter().map(|&sources| {
            let way = registrations.way(self, sources, self.slices[k]);
            let outline = self.outline(k, ct, &way, sources.threshold)?;
            let distance = outline.distance_map(&slice.grid);
            let pairs = match sources.sound_speed {
                true => &slice.pairs,
                false => &slice.true_speed,
            };
            let featured = pairs.iter().filter(|p| FEATURED.contains(&p.beamformer));
            let (down, column) = Line::down(&slice.grid, &distance, 0.0);
            let peak = |pair: &Pair| {
                let grey = pair.b_mode.pixels.column(column).to_vec();
                let first = down.first();
                Some(down.peak(&grey, first, SEARCH)?.at_mm - first?)
            };
            Ok(SourcesMeasured {
                sources: sources.name(),
                uniform: baseline(&distance),
                peak_mm: featured.clone().map(peak).collect(),
                featured: featured.map(|pair| rows(pair, &distance)).collect(),
            })
        });
        let sources = sources.collect::<Result<Vec<_>>>()?;
        let way = registrations.of(Sources::ALL).transform;
        let outline = self.outline(k, ct, &way, true)?;
        let distance = outline.distance_map(&slice.grid);
        let by = |pixels: &Array2<f32>| distribution(pixels.view(), distance.view(), BIN);
        let bins = by(&slice.pairs[0].b_mode.pixels);
        let (down, column) = Line::down(&slice.grid, &distance, 0.0);
        let (across, row) = Line::across(&slice.grid, &distance, self.lines[k]);
        let profiles = |picture: &Picture| {
            let lines = [picture.pixels.column(column), picture.pixels.row(row)];
            lines.map(|line| Profile {
                grey: line.to_vec(),
            })
        };
        let by_distance = |picture: &Picture| {
            let found = by(&picture.pixels);
            ByDistance {
                mean: found.intensity,
                above_zero: found.above_zero,
            }
        };
        let pairs = || slice.pairs.iter();
        Ok(Measured {
            sources,
            table: pairs().map(|pair| rows(pair, &distance)).collect(),
            uniform: baseline(&distance),
            by_distance: pairs().map(|pair| pair.images().map(by_distance)).collect(),
            distance_mm: bins.distance.iter().map(|s| 1e3 * s).collect(),
            profiles: pairs().map(|pair| pair.images().map(profiles)).collect(),
            down,
            across,
            contour_mm: outline_mm(&outline),
            distance,
        })
    }

    /// Repeats registrations with an extra error of every pick; Table I's errors each.
    pub fn draws(
        &self,
        slices: &[Images; 2],
        specimen: &Specimen,
        ct: &Ct,
        volume: &Volume,
    ) -> Result<Draws> {
        let tips = sweep::seen(&specimen.tips(), self.ratio(true));
        let picks = volume.pick(&tips, Tip::Brightest)?;
        let mut random = ChaCha8Rng::seed_from_u64(self.simulation.seed);
        let thinned = slices.each_ref().map(|slice| -> Vec<[Array2<f32>; 2]> {
            let pairs = slice.pairs.iter();
            let featured = pairs.filter(|p| FEATURED.contains(&p.beamformer));
            let thin = |picture: &Picture| contour::every(&picture.pixels, THINNED);
            featured.map(|pair| pair.images().map(thin)).collect()
        });
        let mut error = || self.picking_error * complex_gaussian(&mut random).re;
        let mut shifted = |p: &Point| p.map(|v| v + error());
        let noisy = (0..DRAWS).map(|_| picks.iter().map(&mut shifted).collect());
        let noisy: Vec<Vec<Point>> = noisy.collect();
        let results = noisy.par_iter().map(|us| {
            let way = Rigid::of_landmarks(&ct.picks, us)?;
            let mut errors = [Vec::new(), Vec::new()];
            for k in 0..2 {
                let grid = contour::thinned(&slices[k].grid, THINNED);
                let distance = self.outline(k, ct, &way, true)?.distance_map(&grid);
                for images in &thinned[k] {
                    let error = |image: usize| {
                        let found = measure(images[image].view(), distance.view(), REGIONS[image]);
                        1e3 * found.mean.unwrap_or(f64::NAN)
                    };
                    errors[k].push([error(0), error(1)]);
                }
            }
            Ok((1e3 * fiducial_error(&way, &ct.picks, us), errors))
        });
        let (fre_mm, error_mm) = results.collect::<Result<Vec<_>>>()?.into_iter().unzip();
        Ok(Draws { fre_mm, error_mm })
    }
}
