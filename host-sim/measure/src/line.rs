//! Lines of pixels through an image of a bone, and their peaks.
//!
//! The paper has them in its Figs. 8 and 9.

use ndarray::{Array2, ArrayView1};
use serde::Serialize;

use super::mean;
use super::profile::{largest, width};
use bonebeam::image::PixelGrid;

/// Depths of the paper's noise measure, mm.
const NOISE: [f64; 2] = [30.0, 40.0];
/// Distance below the peak at which the paper gives the decrease of the level, mm.
const DROP: f64 = 0.55;

/// A line through the images of a slice.
#[derive(Clone, Debug, Serialize)]
pub struct Line {
    /// Position of the line, mm.
    ///
    /// It is lateral for a line that goes down, and a depth for one that goes across.
    pub place_mm: f64,
    /// Positions of the pixels along the line, mm.
    pub at_mm: Vec<f64>,
    /// Positions at which the contour crosses the line, mm.
    pub contour_mm: Vec<f64>,
}

/// The peak nearest to a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    index: usize,
    /// Its position, mm.
    pub at_mm: f64,
    /// Its grey level.
    pub grey: f64,
}

impl Line {
    /// The column nearest to lateral position `x`, m, down the image.
    pub fn down(grid: &PixelGrid, distance: &Array2<f64>, x: f64) -> (Self, usize) {
        let column = nearest((x - grid.x0) / grid.pixel, grid.columns);
        let position = grid.x0 + column as f64 * grid.pixel;
        let distance = distance.column(column);
        (Self::new(position, grid.z0, grid.pixel, distance), column)
    }

    /// The row nearest to depth `z`, m, across the image.
    pub fn across(grid: &PixelGrid, distance: &Array2<f64>, z: f64) -> (Self, usize) {
        let row = nearest((z - grid.z0) / grid.pixel, grid.rows);
        let position = grid.z0 + row as f64 * grid.pixel;
        let distance = distance.row(row);
        (Self::new(position, grid.x0, grid.pixel, distance), row)
    }

    /// The line at a position, from its pixels' distances; the first is at `first`, m.
    fn new(position: f64, first: f64, pixel: f64, distance: ArrayView1<f64>) -> Self {
        let at_mm: Vec<f64> = (0..distance.len())
            .map(|k| 1e3 * (first + k as f64 * pixel))
            .collect();
        Line {
            place_mm: 1e3 * position,
            contour_mm: crossings(&at_mm, &distance.to_vec()),
            at_mm,
        }
    }

    /// The contour's first crossing: the surface that the line meets from above.
    pub fn first(&self) -> Option<f64> {
        self.contour_mm.first().copied()
    }

    /// The crossings nearest to the middle on the left and on the right: the sidewalls.
    pub fn sidewalls(&self) -> [Option<f64>; 2] {
        let all = || self.contour_mm.iter().copied();
        [
            all().filter(|x| *x < 0.0).max_by(f64::total_cmp),
            all().filter(|x| *x > 0.0).min_by(f64::total_cmp),
        ]
    }

    /// The brightest of the grey levels within `reach` of a position, mm.
    pub fn peak(&self, grey: &[f32], near: Option<f64>, reach: f64) -> Option<Peak> {
        let near = near?;
        let within = |k: &usize| (self.at_mm[*k] - near).abs() <= reach;
        let range: Vec<usize> = (0..self.at_mm.len()).filter(within).collect();
        let values: Vec<f64> = range.iter().map(|&k| f64::from(grey[k])).collect();
        let index = range[largest(&values)?];
        Some(Peak {
            index,
            at_mm: self.at_mm[index],
            grey: f64::from(grey[index]),
        })
    }

    /// The peak's width at a grey level, mm.
    pub fn width(&self, grey: &[f32], peak: Option<Peak>, level: f64) -> Option<f64> {
        let values: Vec<f64> = grey.iter().map(|&v| f64::from(v)).collect();
        width(&self.at_mm, &values, peak?.index, level)
    }

    /// Decrease of the grey level from the peak to 0.55 mm below it.
    pub fn drop_below(&self, grey: &[f32], peak: Option<Peak>) -> Option<f64> {
        let peak = peak?;
        let k = self.at_mm.partition_point(|&at| at < peak.at_mm + DROP);
        grey.get(k).map(|&grey| peak.grey - f64::from(grey))
    }

    /// Mean grey level between depths of 30 and 40 mm.
    pub fn noise(&self, grey: &[f32]) -> Option<f64> {
        let all = self.at_mm.iter().zip(grey);
        let inside = all.filter(|(at, _)| (NOISE[0]..=NOISE[1]).contains(*at));
        mean(inside.map(|(_, &v)| f64::from(v)))
    }
}

fn nearest(position: f64, count: usize) -> usize {
    (position.round().max(0.0) as usize).min(count - 1)
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Bone below 12 mm within 3 mm of the middle, pixels of 0.5 mm.
    fn post() -> (PixelGrid, Array2<f64>) {
        let grid = PixelGrid::new([-5e-3, 10e-3], 0.5e-3, [61, 21]);
        let distance = Array2::from_shape_fn((61, 21), |(row, column)| {
            let (x, z) = (-5e-3 + 0.5e-3 * column as f64, 10e-3 + 0.5e-3 * row as f64);
            (3.1e-3 - x.abs()).min(z - 12.2e-3)
        });
        (grid, distance)
    }

    #[test]
    fn lines_meet_the_contour_and_their_peaks_have_the_width_drawn() {
        let (grid, distance) = post();
        let (down, column) = Line::down(&grid, &distance, 0.1e-3);
        assert_eq!((column, down.place_mm), (10, 0.0));
        assert!((down.first().unwrap() - 12.2).abs() < 1e-9);
        let (across, row) = Line::across(&grid, &distance, 20e-3);
        assert_eq!(row, 20);
        let [left, right] = across.sidewalls();
        assert!((left.unwrap() + 3.1).abs() < 1e-9 && (right.unwrap() - 3.1).abs() < 1e-9);
        // A triangle of half-width 1 mm at its foot, its top 200 at 13 mm; 40 from 30 mm on.
        let grey = down.at_mm.iter().map(|&z| {
            let ridge = 200.0 * (1.0 - (z - 13.0).abs());
            ridge.max(if z >= 30.0 { 40.0 } else { 0.0 }) as f32
        });
        let grey: Vec<f32> = grey.collect();
        let peak = down.peak(&grey, down.first(), 2.5);
        assert!((peak.unwrap().at_mm - 13.0).abs() < 1e-9);
        assert!((down.width(&grey, peak, 100.0).unwrap() - 1.0).abs() < 1e-9);
        assert_eq!(down.width(&grey, peak, 201.0), None);
        assert_eq!(down.drop_below(&grey, peak), Some(200.0));
        assert_eq!(down.noise(&grey), Some(40.0));
    }
}
