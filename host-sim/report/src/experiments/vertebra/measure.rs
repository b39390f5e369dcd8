//! Measures of the vertebra's pictures against its known surface.

use ndarray::Array2;
use serde::Serialize;

use crate::experiments::common::pictures::{Pair, outline_mm};
use crate::measure::line::Line;
use crate::measure::signed_distance::{REGIONS, Region, distribution, measure};
use bonebeam_drive::image::PixelGrid;
use bonebeam_simulate::Outline;

/// Width of a bin of signed distance, m.
const BIN: f64 = 0.1e-3;
/// Search range for a line's peak around the surface, to either side, mm.
const SEARCH: f64 = 2.1;
/// Grey levels of the paper's widths, axial and lateral.
const AXIAL_LEVEL: f64 = 200.0;
const LATERAL_LEVELS: [f64; 2] = [150.0, 100.0];

#[derive(Clone, Debug, Serialize)]
pub struct VertebraResult {
    /// Scores of an image of one grey level: B-mode and phase symmetry.
    pub uniform: ByImage<Surface>,
    /// One entry per beamformer.
    pub beamformers: Vec<VertebraMeasure>,
    /// Depths of the axial line's pixels.
    pub axial_depth_mm: Vec<f64>,
    /// Lateral position of the axial line.
    pub axial_x_mm: f64,
    /// Lateral positions of the lateral line's pixels.
    pub lateral_x_mm: Vec<f64>,
    /// Depth of the lateral line.
    pub lateral_depth_mm: f64,
    /// Crossings of the true surface and the axial line, shallowest first.
    pub axial_surface_mm: Vec<f64>,
    /// Crossings of the true surface and the lateral line, from the left.
    pub lateral_surface_mm: Vec<f64>,
    /// Centres of the bins of signed distance, inside the bone positive.
    pub distance_mm: Vec<f64>,
    pub pictures: Vec<Pair>,
    /// The true outer surface: closed loops of points (x, depth).
    #[serde(skip)]
    pub outline_mm: Vec<Vec<(f64, f64)>>,
}

impl<T> ByImage<T> {
    /// The values of image 0, B-mode, and 1, phase symmetry.
    fn of(value: impl Fn(usize) -> T) -> Self {
        ByImage {
            b_mode: value(0),
            phase_symmetry: value(1),
        }
    }

    /// Both values, with the paper's names and with full ones.
    pub fn named(&self) -> [(&'static str, &'static str, &T); 2] {
        [
            ("US", "B-mode (US)", &self.b_mode),
            ("PS", "Phase symmetry (PS)", &self.phase_symmetry),
        ]
    }
}

/// A value of the B-mode image and one of its phase symmetry.
#[derive(Clone, Debug, Serialize)]
pub struct ByImage<T> {
    /// The B-mode image ("US" in the paper).
    pub b_mode: T,
    /// The phase symmetry image ("PS" in the paper).
    pub phase_symmetry: T,
}

/// The signed-distance measures of one image (Table I).
#[derive(Clone, Debug, Serialize)]
pub struct Surface {
    /// Localization error: mean signed distance in region A, weighted by intensity.
    pub mean_mm: Option<f64>,
    /// Its weighted standard deviation.
    pub std_mm: Option<f64>,
    /// The same mean within 1 mm of the surface, on either side.
    pub near_mean_mm: Option<f64>,
    /// Standard deviation within 1 mm of the surface, on either side.
    pub near_std_mm: Option<f64>,
    /// Mean intensity 0..255 at the surface (A).
    pub intensity_a: Option<f64>,
    /// Mean intensity outside the bone (B).
    pub intensity_b: Option<f64>,
    /// Mean intensity inside the bone (C).
    pub intensity_c: Option<f64>,
}

/// The measures of one beamformer.
#[derive(Clone, Debug, Serialize)]
pub struct VertebraMeasure {
    /// The beamformer's key.
    pub beamformer: &'static str,
    /// Table I.
    pub surface: ByImage<Surface>,
    /// The line down through the tip of the spinous process (Fig. 8a, c).
    pub axial: ByImage<ImageLine>,
    /// The line across the laminae (Fig. 8b, d).
    pub lateral: ByImage<ImageLine>,
    /// Mean intensity by signed distance (Fig. 6, 7).
    pub intensity_by_distance: ByImage<Vec<Option<f64>>>,
}

#[derive(Clone, Debug, Serialize)]
pub struct ImageLine {
    /// Grey levels.
    pub intensity: Vec<f32>,
    /// Distance of the peak from the true surface, positive if deeper or to the right.
    pub peak_bias_mm: Option<f64>,
    /// Width of the peak at the paper's grey level.
    pub width_mm: Option<f64>,
    /// Grey level at which the width is measured.
    pub width_level: f64,
    /// Width of the peak at half its own grey level.
    pub half_width_mm: Option<f64>,
    /// Mean grey level between depths of 30 and 40 mm, on the axial line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<f64>,
}

/// All measures of pictures of a bone on `grid`.
///
/// The lateral line is at this depth, m.
pub fn measured(
    bone: &Outline,
    grid: &PixelGrid,
    lateral_line: f64,
    pictures: Vec<Pair>,
) -> VertebraResult {
    let distance = bone.distance_map(grid);
    let top = bone.loops().iter().flatten().copied();
    let top = top.reduce(|a, b| if b[1] < a[1] { b } else { a });
    let (down, column) = Line::down(grid, &distance, top.map_or(0.0, |p| p[0]));
    let (across, row) = Line::across(grid, &distance, lateral_line);
    let right = facing_on_the_right(&distance, row, &across);
    let even = Array2::ones(distance.dim());
    let uniform = ByImage::of(|image| Surface {
        // They have no meaning.
        intensity_a: None,
        intensity_b: None,
        intensity_c: None,
        ..surface(&even, &distance, REGIONS[image])
    });
    let beamformers = pictures.iter().map(|pair| {
        let pixels = pair.images().map(|picture| &picture.pixels);
        let by_distance = |image: usize| distribution(pixels[image].view(), distance.view(), BIN);
        VertebraMeasure {
            beamformer: pair.beamformer,
            surface: ByImage::of(|image| surface(pixels[image], &distance, REGIONS[image])),
            axial: ByImage::of(|image| {
                let grey = pixels[image].column(column).to_vec();
                ImageLine {
                    noise: down.noise(&grey),
                    ..line(&down, grey, down.first(), AXIAL_LEVEL)
                }
            }),
            lateral: ByImage::of(|image| {
                let grey = pixels[image].row(row).to_vec();
                line(&across, grey, right, LATERAL_LEVELS[image])
            }),
            intensity_by_distance: ByImage::of(|image| by_distance(image).intensity),
        }
    });
    let bins = distribution(even.view(), distance.view(), BIN).distance;
    VertebraResult {
        uniform,
        beamformers: beamformers.collect(),
        axial_x_mm: down.place_mm,
        lateral_depth_mm: across.place_mm,
        axial_depth_mm: down.at_mm,
        lateral_x_mm: across.at_mm,
        axial_surface_mm: down.contour_mm,
        lateral_surface_mm: across.contour_mm,
        distance_mm: bins.iter().map(|s| 1e3 * s).collect(),
        outline_mm: outline_mm(bone),
        pictures,
    }
}

/// The surface crossing in the right half of the lateral line that faces the array.
///
/// There the signed distance grows fastest with depth.
fn facing_on_the_right(distance: &Array2<f64>, row: usize, across: &Line) -> Option<f64> {
    let (above, below) = (row.saturating_sub(1), (row + 1).min(distance.nrows() - 1));
    let x = &across.at_mm;
    let facing = |at: f64| {
        let column = x.partition_point(|&x| x < at).min(x.len() - 1);
        distance[[below, column]] - distance[[above, column]]
    };
    let right = across.contour_mm.iter().copied().filter(|&at| at > 0.0);
    right.max_by(|&a, &b| facing(a).total_cmp(&facing(b)))
}

fn surface(pixels: &Array2<f32>, distance: &Array2<f64>, region: Region) -> Surface {
    let of = |region| measure(pixels.view(), distance.view(), region);
    let (measured, near) = (of(region), of(Region::NEAR));
    Surface {
        mean_mm: measured.mean.map(|v| 1e3 * v),
        std_mm: measured.std.map(|v| 1e3 * v),
        near_mean_mm: near.mean.map(|v| 1e3 * v),
        near_std_mm: near.std.map(|v| 1e3 * v),
        intensity_a: measured.at,
        intensity_b: measured.outside,
        intensity_c: measured.inside,
    }
}

/// The peak nearest to a crossing of the surface, and its width.
fn line(at: &Line, intensity: Vec<f32>, surface: Option<f64>, level: f64) -> ImageLine {
    let peak = at.peak(&intensity, surface, SEARCH);
    ImageLine {
        peak_bias_mm: peak
            .zip(surface)
            .map(|(peak, surface)| peak.at_mm - surface),
        width_mm: at.width(&intensity, peak, level),
        width_level: level,
        half_width_mm: peak.and_then(|p| at.width(&intensity, peak, 0.5 * p.grey)),
        noise: None,
        intensity,
    }
}
