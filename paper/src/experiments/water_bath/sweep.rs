//! The ultrasound volume: images stacked in elevation, and fiducials picked in it.

use crate::experiments::study::*;
use ndarray::Array3;
use rayon::prelude::*;

use crate::measure::registration::Point;

/// Voxel of a ball's echo that is picked as its tip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tip {
    /// The brightest voxel.
    Brightest,
    /// The first voxel of half its grey level, above it: the beginning of the echo.
    Front,
}

/// Search range for a ball around its true position, m: across and along, depth.
///
/// The bone begins a diameter below the tip.
const SEARCH: [f64; 2] = [1.0e-3, 0.8e-3];

/// Grey levels of a volume.
pub struct Volume {
    /// The pixels of every slice.
    pub grid: PixelGrid,
    /// The slices' elevations, m, evenly spaced.
    pub elevations: Vec<f64>,
    /// Grey levels of the slices; 255 is the volume's brightest voxel.
    pub slices: Vec<Array2<f32>>,
}

impl Volume {
    /// The volume of images whose brightest pixels are 255 each.
    ///
    /// `peaks` are their peaks; `range` dB lie between 0 and 255.
    pub fn new(
        grid: PixelGrid,
        elevations: Vec<f64>,
        mut slices: Vec<Array2<f32>>,
        peaks: &[f64],
        range: f64,
    ) -> Self {
        let brightest = peaks.iter().copied().fold(0.0, f64::max);
        slices.par_iter_mut().zip(peaks).for_each(|(slice, peak)| {
            let below = (255.0 * 20.0 * (peak / brightest).log10() / range) as f32;
            slice.mapv_inplace(|v| if v + below > 0.0 { v + below } else { 0.0 });
        });
        Volume {
            grid,
            elevations,
            slices,
        }
    }

    /// Tips of the balls, as picked, to the voxel.
    ///
    /// `tips` are their apparent positions.
    ///
    /// # Errors
    /// A ball outside the volume, or one that is black.
    pub fn pick(&self, tips: &[Point], tip: Tip) -> Result<Vec<Point>> {
        let grid = &self.grid;
        let mut picks = Vec::new();
        for (index, at) in tips.iter().enumerate() {
            let range = |centre: f64, first: f64, reach: f64, count: usize| {
                let position = |v: f64| ((v - first) / grid.pixel).max(0.0);
                position(centre - reach).ceil() as usize
                    ..(position(centre + reach).floor() as usize + 1).min(count)
            };
            let columns = range(at[0], grid.x0, SEARCH[0], grid.columns);
            let rows = range(at[2], grid.z0, SEARCH[1], grid.rows);
            let mut best: Option<(f32, [usize; 3])> = None;
            for (k, y) in self.elevations.iter().enumerate() {
                if (y - at[1]).abs() > SEARCH[0] {
                    continue;
                }
                for row in rows.clone() {
                    for column in columns.clone() {
                        let grey = self.slices[k][[row, column]];
                        if best.is_none_or(|(most, _)| grey > most) {
                            best = Some((grey, [k, row, column]));
                        }
                    }
                }
            }
            let (grey, [slice, mut row, column]) = best
                .filter(|(grey, _)| *grey > 0.0)
                .ok_or_else(|| Error::Data(format!("the volume does not show fiducial {index}")))?;
            if tip == Tip::Front {
                let least = 0.5 * grey;
                while row > 0 && self.slices[slice][[row - 1, column]] >= least {
                    row -= 1;
                }
            }
            picks.push([
                grid.x0 + column as f64 * grid.pixel,
                self.elevations[slice],
                grid.z0 + row as f64 * grid.pixel,
            ]);
        }
        Ok(picks)
    }

    /// The voxels, `[x, y, z]`.
    pub fn voxels(&self) -> Array3<i16> {
        let shape = (self.grid.columns, self.slices.len(), self.grid.rows);
        Array3::from_shape_fn(shape, |(x, y, z)| self.slices[y][[z, x]].round() as i16)
    }
}

/// Apparent positions of the tips if the scanner assumes `ratio` times the speed.
pub fn seen(tips: &[Point], ratio: f64) -> Vec<Point> {
    tips.iter().map(|[x, y, z]| [*x, *y, z * ratio]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tip_is_the_brightest_voxel_or_the_front_of_its_echo() {
        let grid = PixelGrid::new([-1e-3, 10e-3], 0.1e-3, [40, 21]);
        let blank = Array2::zeros((40, 21));
        let mut echo = blank.clone();
        for (row, grey) in [
            (16, 90.0),
            (17, 101.0),
            (18, 160.0),
            (19, 200.0),
            (20, 120.0),
        ] {
            echo[[row, 12]] = grey;
        }
        // The second slice's own brightest is 20 dB below the first's: of 60 dB a third of 255.
        let volume = Volume::new(
            grid,
            vec![-0.5e-3, 0.0, 0.5e-3],
            vec![echo.clone(), echo, blank],
            &[1.0, 0.1, 0.1],
            60.0,
        );
        assert_eq!(volume.slices[1][[19, 12]], 200.0 - 85.0);
        assert_eq!(volume.slices[1][[3, 3]], 0.0);
        let near = |found: &[Point], expected: Point| {
            (0..3).all(|k| (found[0][k] - expected[k]).abs() < 1e-12)
        };
        let at = [[0.0, 0.0, 11.8e-3]];
        let brightest = volume.pick(&at, Tip::Brightest).unwrap();
        assert!(
            near(&brightest, [0.2e-3, -0.5e-3, 11.9e-3]),
            "{brightest:?}"
        );
        // Half of 200 is met by 101, and not by 90.
        let front = volume.pick(&at, Tip::Front).unwrap();
        assert!(near(&front, [0.2e-3, -0.5e-3, 11.7e-3]), "{front:?}");
        assert!(volume.pick(&[[0.0, 2e-3, 11.8e-3]], Tip::Front).is_err());
        assert_eq!(volume.voxels()[[12, 0, 19]], 200);
    }
}
