//! Pixel grids of images.

use crate::geometry::Axis;

/// A grid of isotropic pixels, row 0 shallowest.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PixelGrid {
    /// Lateral position of column 0, m.
    pub x0: f64,
    /// Depth of row 0, m.
    pub z0: f64,
    /// Distance of neighbouring pixels, m.
    pub pixel: f64,
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
}

impl PixelGrid {
    /// A grid from its first pixel (x, z) on, with its numbers of rows and columns.
    pub const fn new([x0, z0]: [f64; 2], pixel: f64, [rows, columns]: [usize; 2]) -> Self {
        PixelGrid {
            x0,
            z0,
            pixel,
            rows,
            columns,
        }
    }

    /// The smallest grid of `rows` × `columns` pixels that covers a region, in metres.
    ///
    /// The tighter of width and depth range sets the pixel size. The width is centred, and the first row is at the
    /// shallow end.
    ///
    /// ```
    /// use bonebeam::image::PixelGrid;
    ///
    /// let grid = PixelGrid::cover([-10e-3, 10e-3], [5e-3, 15e-3], 41, 41);
    /// assert_eq!((grid.pixel, grid.x0, grid.z0), (0.5e-3, -10e-3, 5e-3));
    /// ```
    pub const fn cover(x: [f64; 2], z: [f64; 2], rows: usize, columns: usize) -> Self {
        let across = (x[1] - x[0]) / steps(columns);
        let down = (z[1] - z[0]) / steps(rows);
        let pixel = if across > down { across } else { down };
        let x0 = (x[0] + x[1] - pixel * steps(columns)) / 2.0;
        Self::new([x0, z[0]], pixel, [rows, columns])
    }

    /// The smallest grid of `rows` × `columns` pixels that covers all lines.
    ///
    /// `lines` are the lateral positions, `samples` the depths.
    pub const fn of_lines(lines: &Axis, samples: &Axis, rows: usize, columns: usize) -> Self {
        let across = [lines.first, lines.last()];
        Self::cover(across, [samples.first, samples.last()], rows, columns)
    }

    /// Depths of the rows.
    pub const fn row_axis(&self) -> Axis {
        Axis::new(self.z0, self.pixel, self.rows)
    }

    /// Lateral positions of the columns.
    pub const fn column_axis(&self) -> Axis {
        Axis::new(self.x0, self.pixel, self.columns)
    }

    /// Number of pixels.
    pub const fn pixels(&self) -> usize {
        self.rows.saturating_mul(self.columns)
    }
}

/// Steps between `pixels` pixels, at least one.
const fn steps(pixels: usize) -> f64 {
    if pixels > 2 { (pixels - 1) as f64 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Powers of two, so that every number is exact.
    #[test]
    fn the_tighter_side_makes_the_pixel() {
        let grid = |x, z| PixelGrid::cover(x, z, 5, 9);
        let wide = grid([-1.0, 3.0], [2.0, 3.0]);
        assert_eq!((wide.pixel, wide.x0, wide.z0), (0.5, -1.0, 2.0));
        // Twice as wide as asked for, half of it on either side.
        let deep = grid([-1.0, 3.0], [2.0, 6.0]);
        assert_eq!((deep.pixel, deep.x0, deep.z0), (1.0, -3.0, 2.0));
        let both = grid([-1.0, 3.0], [2.0, 4.0]);
        assert_eq!((both.pixel, both.x0, both.z0), (0.5, -1.0, 2.0));
        assert_eq!((deep.rows, deep.columns, deep.pixels()), (5, 9, 45));
    }

    #[test]
    fn a_single_row_or_column_counts_one_step() {
        for few in [0, 1, 2] {
            assert_eq!(PixelGrid::cover([0.0, 4.0], [0.0, 1.0], 5, few).pixel, 4.0);
            assert_eq!(PixelGrid::cover([0.0, 4.0], [0.0, 8.0], few, 5).pixel, 8.0);
        }
        assert_eq!(PixelGrid::cover([0.0, 4.0], [0.0, 1.0], 5, 3).pixel, 2.0);
    }
}
