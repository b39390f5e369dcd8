//! Pictures of lines: B-mode and phase symmetry.

use bonebeam::phase_symmetry::scale_for_display;
use fnv::FnvHasher;
use ndarray::{Array2, Axis};
use rayon::prelude::*;
use serde::Serialize;
use std::hash::Hasher;

use crate::Result;
use crate::experiments::outcome::{Picture, Scale};
use bonebeam_drive::check::{Check, References};
use bonebeam_drive::config;
use bonebeam_drive::image::{PixelGrid, b_mode};
use bonebeam_drive::methods::COMPARED;
use bonebeam_drive::phase_symmetry::{Parameters, phase_symmetry};
use bonebeam_files::BeamformedLines;
use bonebeam_simulate::Outline;

/// The two pictures of one method.
#[derive(Clone, Debug, Serialize)]
pub struct Pair {
    /// The beamformer's key.
    pub beamformer: &'static str,
    /// The B-mode image.
    pub b_mode: Picture,
    /// Its phase symmetry, as 255·PS/max PS.
    pub phase_symmetry: Picture,
}

impl Pair {
    /// Both pictures, which stay together.
    pub fn card(&self) -> Vec<Picture> {
        self.images().map(Picture::clone).to_vec()
    }

    /// The B-mode image, and its phase symmetry.
    pub fn images(&self) -> [&Picture; 2] {
        [&self.b_mode, &self.phase_symmetry]
    }
}

/// The closed lines (x, depth) of an outline, mm.
pub fn outline_mm(bone: &Outline) -> Vec<Vec<(f64, f64)>> {
    let closed = |points: &Vec<[f64; 2]>| {
        let around = points.iter().chain(points.first());
        around.map(|p| (1e3 * p[0], 1e3 * p[1])).collect()
    };
    bone.loops().iter().map(closed).collect()
}

/// Grey bars of both pictures, with B-mode over `range` dB.
pub fn scales(range: f64) -> Vec<Scale> {
    let half = range / 2.0;
    let b_mode = [format!("−{range} dB"), format!("−{half} dB"), "0 dB".into()];
    let symmetry = ["0", "127", "255 (max)"].map(String::from);
    let scale = |(name, levels)| Scale { name, levels };
    [("B-mode", b_mode), ("Phase symmetry", symmetry)]
        .map(scale)
        .into()
}

/// Parameters of the pictures of lines.
pub struct Studio<'a> {
    /// Beginning of the names of files and checks.
    pub what: &'a str,
    /// The pixels.
    pub grid: PixelGrid,
    /// Dynamic range and median.
    pub image: &'a config::Image,
    /// Scales and threshold.
    pub phase_symmetry: &'a config::PhaseSymmetry,
    /// Rows kept of both pictures.
    pub rows: std::ops::Range<usize>,
    /// Value subtracted from lateral positions, m.
    pub centre: f64,
    /// What the pictures are compared with, if anything.
    pub references: Option<&'a References>,
}

impl Studio<'_> {
    /// The pictures of the lines of every beamformer, and their checks.
    ///
    /// # Errors
    /// Lines that do not make an image.
    pub fn pictures(&self, lines: &[BeamformedLines]) -> Result<(Vec<Pair>, Vec<Check>)> {
        let made: Vec<(Pair, Vec<Check>)> = COMPARED
            .par_iter()
            .zip(lines)
            .map(|(beamformer, lines)| self.pair(beamformer.key, beamformer.name, lines))
            .collect::<Result<_>>()?;
        let (pairs, checks): (Vec<_>, Vec<_>) = made.into_iter().unzip();
        Ok((pairs, checks.concat()))
    }

    /// The pictures of one beamformer's lines, and their checks if selected.
    ///
    /// # Errors
    /// Lines that do not make an image.
    pub fn pair(
        &self,
        key: &'static str,
        name: &str,
        lines: &BeamformedLines,
    ) -> Result<(Pair, Vec<Check>)> {
        let range = self.image.dynamic_range;
        let median = self.image.median;
        let image = b_mode(lines, range as f32, &self.grid, median)?;
        let parameters = filter(self.phase_symmetry);
        let map = phase_symmetry(image.pixels.view(), &parameters, &mut |_, _| {})?;
        let mut checks = Vec::new();
        if let Some(references) = self.references {
            let (bits, error) = (references.image)(&image, lines, range, &self.grid, median);
            checks.push(Check {
                what: format!("{}: B-mode, {name}", self.what),
                bits,
                error: Some(error),
            });
            let (bits, error) = (references.map)(&map, &image.pixels, &parameters);
            checks.push(Check {
                what: format!("{}: phase symmetry, {name}", self.what),
                bits,
                error: Some(error),
            });
        }
        let levels = shown(map)?;
        let pair = Pair {
            beamformer: key,
            b_mode: self.picture(
                format!("{}-{key}.png", self.what),
                format!("{name}, B-mode, {range} dB"),
                &image.pixels,
            ),
            phase_symmetry: self.picture(
                format!("{}-{key}-ps.png", self.what),
                format!("{name}, phase symmetry"),
                &levels,
            ),
        };
        Ok((pair, checks))
    }

    fn picture(&self, file: String, caption: String, pixels: &Array2<f32>) -> Picture {
        let rows = ndarray::Slice::from(self.rows.clone());
        let placed = PixelGrid {
            x0: self.grid.x0 - self.centre,
            z0: self.grid.z0 + self.rows.start as f64 * self.grid.pixel,
            ..self.grid
        };
        let pixels = pixels.slice_axis(Axis(0), rows).to_owned();
        picture(file, caption, pixels, &placed)
    }
}

/// A picture on the pixels of a grid.
pub fn picture(file: String, caption: String, pixels: Array2<f32>, grid: &PixelGrid) -> Picture {
    let mut hasher = FnvHasher::default();
    for pixel in &pixels {
        hasher.write(&pixel.to_le_bytes());
    }
    Picture {
        file,
        caption,
        fnv1a_64: format!("{:016x}", hasher.finish()),
        left_mm: 1e3 * grid.x0,
        top_mm: 1e3 * grid.z0,
        pixel_mm: 1e3 * grid.pixel,
        pixels,
    }
}

/// The phase symmetry of an image, as 255·PS/max PS.
///
/// # Errors
/// An image whose sides the transform does not accept.
pub fn ridges(pixels: &Array2<f32>, section: &config::PhaseSymmetry) -> Result<Array2<f32>> {
    shown(phase_symmetry(
        pixels.view(),
        &filter(section),
        &mut |_, _| {},
    )?)
}

fn filter(section: &config::PhaseSymmetry) -> Parameters {
    Parameters {
        scales: section.scales.clone(),
        threshold: section.threshold as f32,
        strip: section.strip,
    }
}

/// A map as 255·PS/max PS.
///
/// # Errors
/// A map with a value that is not finite.
pub fn shown(mut map: Array2<f32>) -> Result<Array2<f32>> {
    scale_for_display(map.as_slice_memory_order_mut().unwrap_or_default())?;
    Ok(map)
}
