//! Pictures of a bone under layers of tissue, as clinical scanners show them.
//!
//! Echoes are drawn on the pixels: speckle of each layer, fasciae and bone as lines of reflectors with their phases, the
//! bone's reverberation, noise. The beam blurs them, and the scanner's display turns their envelope into grey. Lengths
//! are in millimetres in this file.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use ndarray::{Array2, Axis};
use num_complex::Complex;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use crate::experiments::common::drawn_bone::DrawnBone;
use crate::{Error, Result};
use bonebeam_drive::image::PixelGrid;
use bonebeam_simulate::complex_gaussian;

/// The pixels, which begin at the skin.
pub const GRID: PixelGrid = PixelGrid {
    x0: -19e-3,
    z0: 0.0,
    pixel: 1e-3 * PIXEL,
    columns: 381,
    rows: 461,
};
/// Side of a pixel.
const PIXEL: f64 = 0.1;
/// Half the wavelength, over which the phase of an echo turns once.
const TURN: f64 = 0.154;
/// Full widths of a point's echo at half its maximum, in depth and across.
const POINT: [f64; 2] = [0.28, 0.5];
/// Tangents of the aperture's rays; the aperture is half as wide as the depth.
const RAYS: [f64; 7] = [-0.25, -0.17, -0.08, 0.0, 0.08, 0.17, 0.25];
/// Reflectors of a surface in each column.
const PER_COLUMN: u32 = 2;
/// Width of the blur by which edges are enhanced.
const EDGE: f64 = 0.7;
/// Largest step of the bone from column to column; beyond it, another part begins.
const STEP: f64 = 0.6;
/// RMS roughness of a surface.
const ROUGHNESS: f64 = 0.03;
/// Thickness of the slab of a drawn bone, m.
const SLAB: f64 = 2e-3;

/// Ranges of the parameters that make bone clear or faint, dB and dB per mm.
#[derive(Debug)]
pub struct Kind {
    /// Name in the tables.
    pub name: &'static str,
    /// Bone where it is flat, over the speckle of skin.
    bone: [f64; 2],
    /// Noise at the skin.
    noise: [f64; 2],
    /// Increase of the noise with depth.
    rise: [f64; 2],
    /// Fall of all echoes with depth.
    fall: [f64; 2],
}

/// The kinds of pictures; fasciae have 10 to 22 dB in both.
pub const KINDS: [Kind; 2] = [
    Kind {
        name: "clear bone",
        bone: [14.0, 28.0],
        noise: [-48.0, -32.0],
        rise: [0.0, 0.25],
        fall: [0.0, 0.0],
    },
    Kind {
        name: "faint bone",
        bone: [6.0, 26.0],
        noise: [-45.0, -28.0],
        rise: [0.0, 0.2],
        fall: [0.0, 0.25],
    },
];

/// A picture with its bone.
pub struct Scene {
    /// Grey levels 0 to 255, `[row, column]`.
    pub pixels: Array2<f32>,
    /// The depth at which each column first meets the bone, m.
    pub surface: Vec<Option<f64>>,
}

/// Uniform random values.
struct Draw(ChaCha8Rng);

impl Draw {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    fn of(&mut self, [low, high]: [f64; 2]) -> f64 {
        self.within(low, high)
    }
}

/// A layer, from its upper boundary on.
struct Layer {
    /// Depth of the boundary in the middle.
    depth: f64,
    slope: f64,
    /// Phase of the boundary's wave.
    phase: f64,
    /// Level of its speckle, dB.
    level: f64,
    /// Level of sheaths within it, dB more.
    sheaths: f64,
    /// Thickness of the fascia on it; 0 if there is none.
    fascia: f64,
}

impl Layer {
    fn boundary(&self, x: f64) -> f64 {
        self.depth + self.slope * x + 0.4 * libm::sin(2.0 * PI * x / 26.0 + self.phase)
    }

    /// Skin, fat and three muscles, with fasciae on the muscles.
    ///
    /// The first and the last muscle are 10 to 20 dB below fat, the second 0 to 10 dB.
    fn all(draw: &mut Draw) -> Vec<Layer> {
        let mut below = 0.0;
        let depths = [[0.0, 0.0], [1.2, 2.2], [3.0, 6.0], [5.0, 9.0], [5.0, 9.0]];
        let fat = draw.within(-6.0, 0.0);
        let muscles = [
            fat - draw.within(10.0, 20.0),
            fat - draw.within(0.0, 10.0),
            fat - draw.within(10.0, 20.0),
        ];
        let levels = [0.0, fat, muscles[0], muscles[1], muscles[2]];
        let layers = depths.into_iter().zip(levels).enumerate();
        let layer = |(index, ([thin, thick], level)): (usize, ([f64; 2], f64))| {
            below += draw.within(thin, thick);
            let steep = if index < 2 { 0.03 } else { 0.2 };
            let muscle = index > 1;
            Layer {
                depth: below,
                slope: draw.within(-steep, steep),
                phase: draw.within(0.0, 2.0 * PI),
                level,
                sheaths: if muscle { draw.within(4.0, 10.0) } else { 0.0 },
                fascia: if muscle { draw.within(0.2, 0.7) } else { 0.0 },
            }
        };
        layers.map(layer).collect()
    }
}

/// Echoes of a frame before the beam blurs them.
struct Echoes {
    /// `[row, column]`.
    points: Array2<Complex<f64>>,
    /// Gain of each pixel: the share of the aperture that sees it, and the fall with depth.
    gain: Array2<f64>,
}

impl Echoes {
    /// Echoes that fall by a number of dB per mm.
    fn of(bone: &[Option<f64>], fall: f64) -> Self {
        let shape = (GRID.rows, GRID.columns);
        Echoes {
            points: Array2::zeros(shape),
            gain: Array2::from_shape_fn(shape, |position| {
                seen(bone, position) * amplitude(-fall * PIXEL * position.0 as f64)
            }),
        }
    }

    /// Adds speckle of the layers, with fasciae of a level in dB, and noise.
    ///
    /// The noise has its level at the skin, dB, and its rise, dB per mm.
    fn speckle(&mut self, draw: &mut Draw, layers: &[Layer], fascia: f64, noise: [f64; 2]) {
        for ((row, column), point) in self.points.indexed_iter_mut() {
            let (x, z) = (x_of(column), PIXEL * row as f64);
            let layer = layers.iter().rfind(|layer| z >= layer.boundary(x));
            let level = layer.map_or(0.0, |layer| {
                let sheath = libm::sin(2.0 * PI * (z - layer.slope * x) / 1.9 + layer.phase);
                match z < layer.boundary(x) + layer.fascia {
                    true => fascia,
                    false if sheath > 0.9 => layer.level + layer.sheaths,
                    false => layer.level,
                }
            });
            let tissue = amplitude(level) * self.gain[[row, column]];
            let noise = amplitude(noise[0] + noise[1] * z);
            *point += complex_gaussian(&mut draw.0) * (tissue.hypot(noise) * FRAC_1_SQRT_2);
        }
    }

    /// Adds a rough surface: a reflector at `depth` of each position across.
    ///
    /// `level` is the level of a smooth flat surface, dB. `times` is the number of times that sound travels down to it.
    fn surface(
        &mut self,
        draw: &mut Draw,
        level: f64,
        times: f64,
        depth: impl Fn(f64) -> Option<f64>,
    ) {
        let kernels = POINT.map(kernel);
        let peaks = kernels[0].iter().copied().fold(0.0, f64::max);
        let flat = peaks * kernels[1].iter().sum::<f64>() * f64::from(PER_COLUMN);
        for step in 0..=PER_COLUMN as usize * (GRID.columns - 1) {
            let column = step as f64 / f64::from(PER_COLUMN);
            let rough = complex_gaussian(&mut draw.0).re * ROUGHNESS;
            let Some(z) = depth(column) else { continue };
            let column = column as usize;
            // It is seen as the tissue just above it.
            let above = ((z / PIXEL).ceil() as usize).saturating_sub(1);
            let gain = self.gain.get([above, column]).copied().unwrap_or(0.0);
            let turns = times * (z + rough) / TURN;
            let echo = Complex::from_polar(amplitude(level) / flat * gain, -2.0 * PI * turns);
            let row = times * z / PIXEL;
            let part = row - row.floor();
            for (row, part) in [(row as usize, 1.0 - part), (row as usize + 1, part)] {
                if let Some(point) = self.points.get_mut([row, column]) {
                    *point += echo * part;
                }
            }
        }
    }

    /// The envelope in dB; speckle of 0 dB has the RMS 0 dB.
    fn decibels(&self) -> Array2<f64> {
        let part =
            |part: fn(&Complex<f64>) -> f64| blurred(&self.points.map(part), POINT.map(kernel));
        let (mut re, im) = (part(|z| z.re), part(|z| z.im));
        re.zip_mut_with(&im, |re, im| {
            *re = 20.0 * libm::log10(re.hypot(*im).max(1e-9));
        });
        re
    }
}

/// A scanner's display: gain, saturation, a curve of grey and enhanced edges.
fn displayed(decibels: &Array2<f64>, draw: &mut Draw) -> Array2<f32> {
    let (white, range) = (draw.within(8.0, 20.0), draw.within(45.0, 65.0));
    let (curve, edges) = (draw.within(0.8, 1.4), draw.within(0.0, 1.5));
    let grey = decibels.mapv(|db| libm::pow((1.0 + (db - white) / range).clamp(0.0, 1.0), curve));
    let smooth = blurred(&grey, [EDGE; 2].map(kernel).map(mean));
    let mut grey = grey;
    grey.zip_mut_with(&smooth, |grey, smooth| *grey += edges * (*grey - smooth));
    grey.mapv(|grey| (255.0 * grey.clamp(0.0, 1.0)).round() as f32)
}

impl Scene {
    /// The picture of the bone of a number, or of the layers alone.
    ///
    /// # Errors
    /// A bone without an outline.
    pub fn of(kind: &Kind, bone: Option<u64>, seed: u64) -> Result<Scene> {
        let bone = bone.map_or(Ok(vec![None; GRID.columns]), depths)?;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(2);
        let draw = &mut Draw(random);
        let layers = Layer::all(draw);
        let mut echoes = Echoes::of(&bone, draw.of(kind.fall));
        let fascia = draw.within(10.0, 22.0);
        let noise = [draw.of(kind.noise), draw.of(kind.rise)];
        echoes.speckle(draw, &layers, fascia - 8.0, noise);
        let bone_at = |column: f64| {
            let [before, after] = [bone[column as usize]?, bone[column.ceil() as usize]?];
            let near = (after - before).abs() < STEP;
            near.then_some(before + (column - column.floor()) * (after - before))
        };
        for layer in layers.iter().filter(|layer| layer.fascia > 0.0) {
            echoes.surface(draw, fascia, 1.0, |column| {
                let z = layer.boundary(PIXEL * column + 1e3 * GRID.x0);
                let hidden = bone[column as usize].is_some_and(|bone| bone < z);
                (!hidden).then_some(z)
            });
        }
        let level = draw.of(kind.bone);
        echoes.surface(draw, level, 1.0, bone_at);
        let again = level - draw.within(28.0, 45.0);
        echoes.surface(draw, again, 2.0, bone_at);
        Ok(Scene {
            pixels: displayed(&echoes.decibels(), draw),
            surface: bone.iter().map(|z| z.map(|z| 1e-3 * z)).collect(),
        })
    }
}

/// The depth at which each column first meets a bone.
fn depths(number: u64) -> Result<Vec<Option<f64>>> {
    let drawn = DrawnBone::of(number);
    let (surface, _) = drawn.bone().surface(drawn.depth, SLAB)?;
    let outline = surface.outline().map_err(Error::Data)?;
    let hit = |column: usize| {
        let z = outline
            .as_ref()?
            .first_hit(GRID.x0 + GRID.pixel * column as f64)?;
        Some(1e3 * z)
    };
    Ok((0..GRID.columns).map(hit).collect())
}

fn x_of(column: usize) -> f64 {
    1e3 * GRID.x0 + PIXEL * column as f64
}

fn amplitude(decibels: f64) -> f64 {
    libm::pow(10.0, decibels / 20.0)
}

/// The square of the share of the aperture that sees a pixel past the bone.
///
/// Nothing is seen below bone.
fn seen(bone: &[Option<f64>], (row, column): (usize, usize)) -> f64 {
    let z = PIXEL * row as f64;
    if bone[column].is_some_and(|bone| bone < z) {
        return 0.0;
    }
    let free = |slope: &&f64| {
        let reach = (row as f64 * slope.abs()) as usize;
        (1..=reach).all(|step| {
            let beside = match **slope < 0.0 {
                true => column.checked_sub(step),
                false => Some(column + step),
            };
            let bone = beside.and_then(|beside| *bone.get(beside)?);
            bone.is_none_or(|bone| bone > z - PIXEL * step as f64 / slope.abs())
        })
    };
    let fraction = RAYS.iter().filter(free).count() as f64 / RAYS.len() as f64;
    fraction * fraction
}

/// A Gaussian of a full width at half maximum, whose squares sum to 1.
fn kernel(width: f64) -> Vec<f64> {
    let sigma = width / PIXEL / 2.3548;
    let reach = (3.5 * sigma).ceil() as i32;
    let weights = (-reach..=reach).map(|k| libm::exp(-0.5 * (f64::from(k) / sigma).powi(2)));
    let weights: Vec<f64> = weights.collect();
    let norm = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
    weights.into_iter().map(|w| w / norm).collect()
}

/// The kernel whose weights sum to 1.
fn mean(kernel: Vec<f64>) -> Vec<f64> {
    let sum: f64 = kernel.iter().sum();
    kernel.into_iter().map(|w| w / sum).collect()
}

/// An image through a kernel down and one across.
///
/// Pixels at the borders are repeated outside.
fn blurred(image: &Array2<f64>, kernels: [Vec<f64>; 2]) -> Array2<f64> {
    let mut image = image.clone();
    for (axis, kernel) in kernels.iter().enumerate() {
        for mut lane in image.lanes_mut(Axis(axis)) {
            let old = lane.to_vec();
            let reach = kernel.len() / 2;
            for (n, value) in lane.iter_mut().enumerate() {
                let at = |k: usize| old[(n + k).saturating_sub(reach).min(old.len() - 1)];
                *value = kernel.iter().enumerate().map(|(k, w)| w * at(k)).sum();
            }
        }
    }
    image
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_of_the_aperture_are_free_or_meet_bone() {
        // Bone 10 mm deep at the right, from column 101 on.
        let bone: Vec<Option<f64>> = (0..200).map(|c| (c > 100).then_some(10.0)).collect();
        // Above it, below it, far beside it, at its wall: there the rays to the left and straight up are free.
        for (position, free) in [
            ((90, 150), 7.0),
            ((110, 150), 0.0),
            ((200, 20), 7.0),
            ((300, 100), 4.0),
        ] {
            let expected = (free / 7.0) * (free / 7.0);
            assert!(
                (seen(&bone, position) - expected).abs() < 1e-12,
                "{position:?}"
            );
        }
    }

    #[test]
    fn a_point_is_as_wide_as_the_beam_and_speckle_has_its_level() {
        let mut echoes = Echoes::of(&vec![None; GRID.columns], 0.0);
        echoes.points[[200, 100]] = Complex::new(1.0, 0.0);
        let point = echoes.decibels();
        let width = |values: Vec<f64>| {
            let peak = values.iter().copied().fold(f64::MIN, f64::max);
            values.iter().filter(|db| **db > peak - 6.0206).count() as f64 * PIXEL
        };
        assert!((width(point.row(200).to_vec()) - 0.5).abs() < 0.11);
        assert!((width(point.column(100).to_vec()) - 0.28).abs() < 0.11);
        // Speckle of -12 dB.
        let layer = Layer {
            depth: -1.0,
            slope: 0.0,
            phase: 0.0,
            level: -12.0,
            sheaths: 0.0,
            fascia: 0.0,
        };
        let mut echoes = Echoes::of(&vec![None; GRID.columns], 0.0);
        let draw = &mut Draw(ChaCha8Rng::seed_from_u64(1));
        echoes.speckle(draw, &[layer], 0.0, [-60.0, 0.0]);
        let db = echoes.decibels();
        let top = db.slice_axis(Axis(0), ndarray::Slice::from(0..100));
        let power = top.mapv(|db| libm::pow(10.0, db / 10.0)).mean().unwrap();
        let level = 10.0 * libm::log10(power);
        assert!((level + 12.0).abs() < 0.3, "{level}");
    }
}
