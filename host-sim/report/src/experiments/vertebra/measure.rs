//! Measures of the vertebra's pictures against its known surface.

use ndarray::{Array2, Axis};
use serde::Serialize;

use crate::experiments::common::pictures::Pair;
use crate::experiments::outcome::Picture;
use crate::measure::profile::{largest, width};
use crate::measure::signed_distance::{
    Region, SurfaceMeasure, distribution, measure, uniform_baseline,
};
use bonebeam_drive::image::PixelGrid;
use bonebeam_simulate::Outline;

/// Width of a bin of signed distance, m.
const BIN: f64 = 0.1e-3;
/// Region with the same reach on both sides of the surface, m.
///
/// The known surface has no bias that the paper's regions would allow for.
const NEAR: Region = Region {
    outer: -1e-3,
    inner: 1e-3,
};
/// Search range for a line's peak around the surface, to either side, m.
const SEARCH: f64 = 2.1e-3;
/// Depths of the noise inside the bone on the axial line, m (the paper's).
const NOISE_DEPTHS: [f64; 2] = [30e-3, 40e-3];
/// Grey levels of the paper's widths, axial and lateral.
const AXIAL_LEVEL: f64 = 200.0;
const LATERAL_LEVELS: [f64; 2] = [150.0, 100.0];

/// Results of the vertebra.
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
    /// The pictures.
    pub pictures: Vec<Pair>,
    /// The true outer surface: closed loops of points (x, depth).
    #[serde(skip)]
    pub outline_mm: Vec<Vec<(f64, f64)>>,
}

impl<T> ByImage<T> {
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

/// One line of an image.
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

/// Geometry of the image relative to the bone.
pub struct View<'a> {
    bone: &'a Outline,
    grid: PixelGrid,
    distance: Array2<f64>,
    /// Column of the axial line, row of the lateral one.
    column: usize,
    row: usize,
}

impl<'a> View<'a> {
    /// The view of `bone` on `grid`, with its lateral line at this depth, m.
    pub fn new(bone: &'a Outline, grid: PixelGrid, lateral_line: f64) -> Self {
        let top = bone.loops().iter().flatten().copied();
        let top = top.reduce(|a, b| if b[1] < a[1] { b } else { a });
        let nearest = |from: f64, count: usize| {
            let index = (from / grid.pixel).round().max(0.0) as usize;
            index.min(count - 1)
        };
        View {
            bone,
            grid,
            distance: bone.distance_map(&grid),
            column: nearest(top.map_or(0.0, |p| p[0]) - grid.x0, grid.columns),
            row: nearest(lateral_line - grid.z0, grid.rows),
        }
    }

    fn depth_mm(&self, row: usize) -> f64 {
        1e3 * (self.grid.z0 + row as f64 * self.grid.pixel)
    }

    fn x_mm(&self, column: usize) -> f64 {
        1e3 * (self.grid.x0 + column as f64 * self.grid.pixel)
    }

    /// All measures of the pictures, which must lie on the grid.
    pub fn result(&self, pictures: Vec<Pair>) -> VertebraResult {
        let regions = [Region::B_MODE, Region::PHASE_SYMMETRY];
        let [b_mode, phase_symmetry] = regions.map(|region| {
            uniform(surface(
                |r| uniform_baseline(self.distance.view(), r),
                region,
            ))
        });
        let bins = distribution(
            self.distance.mapv(|_| 0.0).view(),
            self.distance.view(),
            BIN,
        );
        let axial_depth_mm: Vec<f64> = (0..self.grid.rows).map(|k| self.depth_mm(k)).collect();
        let lateral_x_mm: Vec<f64> = (0..self.grid.columns).map(|k| self.x_mm(k)).collect();
        let down = self.distance.index_axis(Axis(1), self.column).to_vec();
        let across = self.distance.index_axis(Axis(0), self.row).to_vec();
        let axial_surface_mm = crossings(&axial_depth_mm, &down);
        let lateral_surface_mm = crossings(&lateral_x_mm, &across);
        let right = self.facing_on_the_right(&lateral_x_mm, &lateral_surface_mm);
        let beamformers = pictures.iter().map(|pair| {
            let both = |f: &dyn Fn(&Picture, usize) -> ImageLine| ByImage {
                b_mode: f(&pair.b_mode, 0),
                phase_symmetry: f(&pair.phase_symmetry, 1),
            };
            VertebraMeasure {
                beamformer: pair.beamformer,
                surface: ByImage {
                    b_mode: self.surface(&pair.b_mode, Region::B_MODE),
                    phase_symmetry: self.surface(&pair.phase_symmetry, Region::PHASE_SYMMETRY),
                },
                axial: both(&|picture, _| {
                    self.axial(picture, &axial_depth_mm, axial_surface_mm.first().copied())
                }),
                lateral: both(&|picture, image| {
                    let level = LATERAL_LEVELS[image];
                    self.lateral(picture, &lateral_x_mm, right, level)
                }),
                intensity_by_distance: ByImage {
                    b_mode: self.by_distance(&pair.b_mode),
                    phase_symmetry: self.by_distance(&pair.phase_symmetry),
                },
            }
        });
        let beamformers = beamformers.collect();
        VertebraResult {
            uniform: ByImage {
                b_mode,
                phase_symmetry,
            },
            beamformers,
            axial_x_mm: self.x_mm(self.column),
            lateral_depth_mm: self.depth_mm(self.row),
            axial_depth_mm,
            lateral_x_mm,
            axial_surface_mm,
            lateral_surface_mm,
            distance_mm: bins.distance.iter().map(|s| 1e3 * s).collect(),
            outline_mm: self.outline_mm(),
            pictures,
        }
    }

    /// The surface crossing in the right half of the lateral line that faces the array.
    ///
    /// There the signed distance grows fastest with depth.
    fn facing_on_the_right(&self, x: &[f64], crossings: &[f64]) -> Option<f64> {
        let (above, below) = (
            self.row.saturating_sub(1),
            (self.row + 1).min(self.grid.rows - 1),
        );
        let facing = |at: f64| {
            let column = x.partition_point(|&x| x < at).min(x.len() - 1);
            self.distance[[below, column]] - self.distance[[above, column]]
        };
        let right = crossings.iter().copied().filter(|&at| at > 0.0);
        right.max_by(|&a, &b| facing(a).total_cmp(&facing(b)))
    }

    fn outline_mm(&self) -> Vec<Vec<(f64, f64)>> {
        let closed = |points: &Vec<[f64; 2]>| {
            let around = points.iter().chain(points.first());
            around.map(|p| (1e3 * p[0], 1e3 * p[1])).collect()
        };
        self.bone.loops().iter().map(closed).collect()
    }

    fn surface(&self, picture: &Picture, region: Region) -> Surface {
        let measured = |region| measure(picture.pixels.view(), self.distance.view(), region);
        surface(measured, region)
    }

    fn by_distance(&self, picture: &Picture) -> Vec<Option<f64>> {
        distribution(picture.pixels.view(), self.distance.view(), BIN).intensity
    }

    fn axial(&self, picture: &Picture, depth: &[f64], surface: Option<f64>) -> ImageLine {
        let intensity = picture.pixels.index_axis(Axis(1), self.column).to_vec();
        let noise: Vec<f64> = depth
            .iter()
            .zip(&intensity)
            .filter(|(z, _)| (NOISE_DEPTHS[0]..=NOISE_DEPTHS[1]).contains(&(**z * 1e-3)))
            .map(|(_, &v)| f64::from(v))
            .collect();
        let mean = noise.iter().sum::<f64>() / noise.len() as f64;
        ImageLine {
            noise: (!noise.is_empty()).then_some(mean),
            ..line(intensity, depth, surface, AXIAL_LEVEL)
        }
    }

    fn lateral(&self, picture: &Picture, x: &[f64], surface: Option<f64>, level: f64) -> ImageLine {
        let intensity = picture.pixels.index_axis(Axis(0), self.row).to_vec();
        line(intensity, x, surface, level)
    }
}

fn surface(measure: impl Fn(Region) -> SurfaceMeasure, region: Region) -> Surface {
    let (measured, near) = (measure(region), measure(NEAR));
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

/// The baseline without its intensities, which have no meaning.
fn uniform(surface: Surface) -> Surface {
    Surface {
        intensity_a: None,
        intensity_b: None,
        intensity_c: None,
        ..surface
    }
}

/// The peak nearest to a crossing of the surface, and its width.
fn line(intensity: Vec<f32>, at: &[f64], surface: Option<f64>, level: f64) -> ImageLine {
    let values: Vec<f64> = intensity.iter().map(|&v| f64::from(v)).collect();
    let peak = surface.and_then(|surface| {
        let near = |k: &usize| (at[*k] - surface).abs() <= 1e3 * SEARCH;
        let range: Vec<usize> = (0..at.len()).filter(near).collect();
        let first = *range.first()?;
        let strip: Vec<f64> = range.iter().map(|&k| values[k]).collect();
        largest(&strip).map(|k| first + k)
    });
    ImageLine {
        peak_bias_mm: peak.zip(surface).map(|(peak, surface)| at[peak] - surface),
        width_mm: peak.and_then(|peak| width(at, &values, peak, level)),
        width_level: level,
        half_width_mm: peak.and_then(|peak| width(at, &values, peak, 0.5 * values[peak])),
        noise: None,
        intensity,
    }
}

/// Positions at which the signed distance changes sign, interpolated.
fn crossings(at: &[f64], distance: &[f64]) -> Vec<f64> {
    let mut found = Vec::new();
    for k in 1..at.len() {
        let (a, b) = (distance[k - 1], distance[k]);
        if (a < 0.0) != (b < 0.0) {
            found.push(at[k - 1] + (at[k] - at[k - 1]) * a / (a - b));
        }
    }
    found
}
