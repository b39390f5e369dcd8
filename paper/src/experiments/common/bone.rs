//! Measures of a bone's image against its known surface.

use ndarray::Array2;
use serde::{Deserialize, Serialize};

use crate::measure::signed_distance::{Region, measure};
use crate::{Error, Result};
use bonebeam_drive::config::Image;
use bonebeam_drive::image::{PixelGrid, grid_of_picture};
use bonebeam_files::BeamformedLines;
use bonebeam_simulate::Outline;

use super::truth::{TOLERANCE, first_hits, precision};

/// Grey level from which a ridge counts as found.
pub const FOUND: f32 = 64.0;

/// A bone and the pixels of its image.
pub struct View {
    /// The pixels.
    pub grid: PixelGrid,
    /// Signed distance to the outer surface, inside positive, m.
    pub distance: Array2<f64>,
    /// Row of the surface in every column, where a beam meets it first.
    pub hits: Vec<Option<f64>>,
}

/// The measures of one image, lengths in mm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoneMeasure {
    /// Localization error: mean signed distance in region A, weighted by intensity.
    pub mean_mm: Option<f64>,
    /// Its weighted standard deviation.
    pub std_mm: Option<f64>,
    /// The same standard deviation within 1 mm of the surface, on either side.
    pub near_std_mm: Option<f64>,
    /// Mean grey level outside the bone.
    pub intensity_b: Option<f64>,
    /// Mean grey level inside it.
    pub intensity_c: Option<f64>,
    /// Average precision of axial maxima within 0.5 mm of the surface hit first.
    ///
    /// It is the area under precision over recall.
    pub average_precision: Option<f64>,
    /// Share of the columns with a surface in which it is found.
    ///
    /// Found: the largest grey level within 0.5 mm of the surface is at least 64.
    pub found: Option<f64>,
    /// Mean axial extent of those ridges at half their own grey level.
    pub thickness_mm: Option<f64>,
}

impl View {
    /// The view of a bone on a grid; the canal counts as bone.
    ///
    /// # Errors
    /// A phantom without a bone.
    pub fn new(bone: Option<&Outline>, grid: PixelGrid) -> Result<Self> {
        let none = || Error::Data("the phantom has no bone in the image plane".into());
        let bone = bone.ok_or_else(none)?.without_holes()?;
        Ok(View {
            distance: bone.distance_map(&grid),
            hits: first_hits(&bone, &grid),
            grid,
        })
    }

    /// The view of a bone on the pixels of a picture of `lines`.
    ///
    /// # Errors
    /// A phantom without a bone, or lines that do not make an image.
    pub fn of_lines(
        bone: Option<&Outline>,
        lines: &BeamformedLines,
        image: &Image,
    ) -> Result<Self> {
        View::new(bone, grid_of_picture(lines, image)?)
    }

    /// Measures an image with the paper's region A of its kind.
    pub fn measure(&self, pixels: &Array2<f32>, region: Region) -> BoneMeasure {
        let found = measure(pixels.view(), self.distance.view(), region);
        let near = measure(pixels.view(), self.distance.view(), Region::NEAR);
        let millimetres = |v: Option<f64>| v.map(|v| 1e3 * v);
        let (fraction, thickness) = self.found(pixels, |_, _| true);
        BoneMeasure {
            mean_mm: millimetres(found.mean),
            std_mm: millimetres(found.std),
            near_std_mm: millimetres(near.std),
            intensity_b: found.outside,
            intensity_c: found.inside,
            average_precision: precision(pixels, &self.hits, &self.grid),
            found: fraction,
            thickness_mm: thickness,
        }
    }

    /// Scores of an image of one grey level.
    pub fn uniform(&self, region: Region) -> BoneMeasure {
        let even = Array2::from_elem(self.distance.dim(), 255.0);
        BoneMeasure {
            intensity_b: None,
            intensity_c: None,
            found: None,
            thickness_mm: None,
            ..self.measure(&even, region)
        }
    }

    /// Rows within a distance of a row with fractions, m.
    pub fn near(&self, row: f64, distance: f64) -> std::ops::RangeInclusive<usize> {
        let reach = distance / self.grid.pixel;
        let first = (row - reach).ceil().max(0.0) as usize;
        first..=((row + reach).floor() as usize).min(self.grid.rows - 1)
    }

    /// Share of the selected columns whose surface is found, and mean extent there, mm.
    ///
    /// `wanted` selects a column by its surface (x, depth), m. The extent is that of the ridges along the axis.
    pub fn found(
        &self,
        pixels: &Array2<f32>,
        wanted: impl Fn(f64, f64) -> bool,
    ) -> (Option<f64>, Option<f64>) {
        let (mut columns, mut found, mut extent) = (0usize, 0usize, 0.0);
        for (column, hit) in self.hits.iter().enumerate() {
            let Some(row) = *hit else { continue };
            let x = self.grid.x0 + column as f64 * self.grid.pixel;
            if !wanted(x, self.grid.z0 + row * self.grid.pixel) {
                continue;
            }
            columns += 1;
            let values = pixels.column(column);
            let near = self.near(row, TOLERANCE);
            let Some(peak) = near.max_by(|&a, &b| values[a].total_cmp(&values[b])) else {
                continue;
            };
            if values[peak] < FOUND {
                continue;
            }
            found += 1;
            let half = 0.5 * values[peak];
            let up = (0..peak).rev().take_while(|&k| values[k] >= half).count();
            let down = (peak + 1..values.len()).take_while(|&k| values[k] >= half);
            extent += 1e3 * self.grid.pixel * (1 + up + down.count()) as f64;
        }
        let fraction = (columns > 0).then(|| found as f64 / columns as f64);
        (fraction, (found > 0).then(|| extent / found as f64))
    }

    /// Grey levels of the pixels of tissue and of shadow.
    ///
    /// Tissue: in front of the bone, farther from it than 2 mm, within a lateral range and a depth range, m.
    /// Shadow: inside the bone, 2.1 to 10 mm from its surface.
    pub fn tissue_and_shadow(
        &self,
        pixels: &Array2<f32>,
        lateral: [f64; 2],
        depths: [f64; 2],
    ) -> [Vec<f64>; 2] {
        let [mut tissue, mut shadow] = [Vec::new(), Vec::new()];
        for ((row, column), &s) in self.distance.indexed_iter() {
            let x = self.grid.x0 + column as f64 * self.grid.pixel;
            let z = self.grid.z0 + row as f64 * self.grid.pixel;
            let in_front = self.hits[column].is_none_or(|hit| (row as f64) < hit);
            let in_range =
                (lateral[0]..=lateral[1]).contains(&x) && (depths[0]..=depths[1]).contains(&z);
            let level = f64::from(pixels[[row, column]]);
            if s < -2e-3 && in_front && in_range {
                tissue.push(level);
            } else if s > 2.1e-3 && s <= 10e-3 {
                shadow.push(level);
            }
        }
        [tissue, shadow]
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A slab of bone from 20 mm on, and pixels of 0.1 mm from 10 mm on.
    pub fn slab() -> View {
        let (x, top, bottom) = (10e-3, 20e-3, 60e-3);
        let corners = vec![[-x, top], [x, top], [x, bottom], [-x, bottom]];
        let slab = Outline::new(vec![corners]).unwrap();
        let grid = PixelGrid::new([-5e-3, 10e-3], 0.1e-3, [201, 101]);
        View::new(Some(&slab), grid).unwrap()
    }

    #[test]
    fn a_ridge_on_the_surface_is_found_with_its_thickness() {
        let view = slab();
        let mut image = Array2::zeros((201, 101));
        // Left of the middle a ridge of 0.5 mm on the surface, right of it one too deep.
        for column in 0..101 {
            let first = if column <= 50 { 98 } else { 110 };
            for row in first..first + 5 {
                image[[row, column]] = 200.0;
            }
        }
        let (fraction, thickness) = view.found(&image, |_, _| true);
        assert_eq!(fraction, Some(51.0 / 101.0));
        assert!((thickness.unwrap() - 0.5).abs() < 1e-9);
        assert_eq!(view.found(&image, |x, _| x > 0.01e-3), (Some(0.0), None));
        assert_eq!(view.found(&image, |_, _| false), (None, None));

        let measured = view.measure(&image, Region::B_MODE);
        assert!((measured.average_precision.unwrap() - 51.0 / 101.0 * 51.0 / 101.0).abs() < 1e-9);
        // Half the ridges are centred on the surface, half 1.2 mm behind it.
        assert!((measured.mean_mm.unwrap() - 1.2 * 50.0 / 101.0).abs() < 1e-6);
        // A uniform image over a flat surface.
        let even = view.uniform(Region::B_MODE);
        assert!((even.mean_mm.unwrap() - 0.8).abs() < 0.01);
        assert!((even.std_mm.unwrap() - 0.75).abs() < 0.03);
    }

    #[test]
    fn tissue_and_shadow_are_distinguished() {
        let view = slab();
        let levels = |(row, _): (usize, usize)| if row < 100 { 100.0 } else { 10.0 };
        let image = Array2::from_shape_fn((201, 101), levels);
        let [tissue, shadow] = view.tissue_and_shadow(&image, [-4e-3, 10e-3], [12e-3, 40e-3]);
        // 12 to 18 mm in front, right of 4 mm left of the middle, and 22.1 to 30 mm behind.
        assert!(tissue.iter().all(|v| *v == 100.0) && shadow.iter().all(|v| *v == 10.0));
        assert!(tissue.len().abs_diff(60 * 91) <= 151, "{}", tissue.len());
        assert!(shadow.len().abs_diff(79 * 101) <= 202, "{}", shadow.len());
    }
}
