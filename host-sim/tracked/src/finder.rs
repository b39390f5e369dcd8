//! Pictures of a sweep → the points of bone in them.

use std::path::PathBuf;

use ndarray::{Array2, ArrayView2, Slice};

use bonebeam_drive::config::Surface;
use bonebeam_drive::image::BModeImage;
use bonebeam_drive::surface::{Picture, PictureFan, PictureSurface, SurfacePoint, of_picture};

use crate::cloud::{Axes, CloudPoint, unit};
use crate::sequence::Sequence;
use crate::track::Track;
use crate::transforms::{Matrix, apply};
use crate::{Error, Result};

/// Frames whose brightest levels show the fan.
const SHOWN: usize = 16;

/// The points of each surface in space, by the poses of a track, without normals.
pub(crate) fn placed(
    track: &Track,
    finder: &Finder,
    surfaces: &[(usize, Vec<SurfacePoint>)],
) -> Vec<Vec<CloudPoint>> {
    let of = |(frame, found): &(usize, Vec<SurfacePoint>)| match &track.poses[*frame] {
        Ok(pose) => finder.points(found, *frame, pose),
        Err(_) => Vec::new(),
    };
    surfaces.iter().map(of).collect()
}

/// Directions of a frame's picture; 0 without a pose.
pub(crate) fn axes(track: &Track, frame: usize) -> Axes {
    let column = |k: usize| match &track.poses[frame] {
        Ok(pose) => unit([0, 1, 2].map(|row| pose[row][k])),
        Err(_) => [0.0; 3],
    };
    Axes {
        across: column(0),
        down: column(1),
    }
}

/// A part of a picture: x, y, width, height.
fn cut(picture: &Array2<f32>, [x, y, width, height]: [usize; 4]) -> ArrayView2<'_, f32> {
    picture.slice_each_axis(|axis| match axis.axis.index() {
        0 => Slice::from(y..y + height),
        _ => Slice::from(x..x + width),
    })
}

/// Finds the surface in single pictures.
#[derive(Clone, Debug)]
pub struct Finder {
    /// The detector as asked for, and with the fan that the first pictures show.
    asked: Surface,
    surface: Surface,
    /// Columns and rows of the pictures.
    sides: [usize; 2],
    /// Mean confidence from which a piece is sure.
    pub(crate) sure: f32,
    /// First column and row, columns, rows.
    part: [usize; 4],
    /// Distances of columns and of rows, m.
    pixel: [f64; 2],
    /// Factor that makes the largest number 255.
    scale: f32,
    /// The brightest levels of the first pictures, and the number of these.
    brightest: Array2<f32>,
    shown: usize,
    /// The sequence, for errors.
    path: PathBuf,
}

impl Finder {
    /// Finds the fan in the brightest levels of some frames.
    ///
    /// # Errors
    /// No frame, a crop beyond the pictures, or levels that are none.
    pub fn new(
        sequence: &Sequence,
        track: &Track,
        (surface, crop): (&Surface, Option<[usize; 4]>),
        frames: &[(usize, Matrix)],
    ) -> Result<Self> {
        if frames.is_empty() {
            let message = "has no frame with a picture and a pose";
            return Err(bonebeam_files::file_error(&sequence.path, message));
        }
        let part = crop.or(sequence.part);
        let mut finder = Self::of(surface, part, sequence.sides, track.pixel)?;
        finder.path.clone_from(&sequence.path);
        let mut reader = sequence.reader()?;
        for (frame, _) in frames.iter().take(SHOWN) {
            finder.show(&sequence.picture(reader.frame(*frame)?)?);
        }
        finder.settle()?;
        sequence.check_levels(&(&finder.brightest * finder.scale))?;
        Ok(finder)
    }

    /// For pictures of `sides` pixels of the sides `pixel` in mm, or a part of them.
    ///
    /// # Errors
    /// A part beyond the pictures.
    pub fn of(
        surface: &Surface,
        part: Option<[usize; 4]>,
        [columns, rows]: [usize; 2],
        [x, y]: [f64; 2],
    ) -> Result<Self> {
        let part = part.unwrap_or([0, 0, columns, rows]);
        if part[0].saturating_add(part[2]) > columns || part[1].saturating_add(part[3]) > rows {
            let message =
                format!("--crop ends beyond the {columns} x {rows} pixels of the pictures");
            return Err(Error::Usage(message));
        }
        Ok(Self {
            asked: surface.clone(),
            surface: surface.clone(),
            sure: 0.0,
            sides: [columns, rows],
            part,
            // By matrices: sides that differ by rounding are one.
            pixel: match (x - y).abs() < 1e-3 * x {
                true => [1e-3 * (x * y).sqrt(); 2],
                false => [1e-3 * x, 1e-3 * y],
            },
            scale: 1.0,
            brightest: Array2::zeros((part[3], part[2])),
            shown: 0,
            path: "pictures".into(),
        })
    }

    /// Whether pictures have these sides, and pixels of these sides in mm, up to a hundredth.
    pub fn is_for(&self, sides: [usize; 2], pixel: [f64; 2]) -> bool {
        let mut own = self.pixel.iter().zip(pixel);
        let near = |(own, side): (&f64, f64)| (1e3 * own - side).abs() < 0.01 * side;
        self.sides == sides && own.all(near)
    }

    /// Adds one of the first pictures, and says whether it was one.
    pub fn show(&mut self, picture: &Array2<f32>) -> bool {
        let part = cut(picture, self.part);
        match self.shown {
            0 => self.brightest.assign(&part),
            _ => self
                .brightest
                .zip_mut_with(&part, |most, level| *most = most.max(*level)),
        }
        self.shown += 1;
        self.shown <= SHOWN
    }

    /// Finds the scale of the levels and the fan in the pictures shown.
    ///
    /// # Errors
    /// As [`of_picture`].
    pub fn settle(&mut self) -> Result<()> {
        let most = self.brightest.iter().copied().fold(255.0, f32::max);
        self.scale = 255.0 / most;
        self.surface.clone_from(&self.asked);
        if self.asked.fan.is_none() && !self.asked.columns_as_lines {
            let found = self.search(&(&self.brightest * self.scale))?;
            self.surface.fan = found.fan;
            self.surface.columns_as_lines = found.fan.is_none();
        }
        Ok(())
    }

    /// The fan, m from the first pixel's centre; `None` if columns are lines.
    pub(crate) fn fan(&self) -> Option<PictureFan> {
        self.surface.fan
    }

    /// A searched part as an image from its own top left.
    pub fn image(&self, pixels: Array2<f32>) -> BModeImage {
        BModeImage {
            pixels,
            x0: 0.0,
            z0: 0.0,
            pixel: self.pixel,
            angles: None,
        }
    }

    /// First column and row, columns and rows of the searched part.
    pub fn part(&self) -> [usize; 4] {
        self.part
    }

    /// The levels of a picture's part, 0 to 255.
    pub fn part_of(&self, mut picture: Array2<f32>) -> Array2<f32> {
        if picture.dim() != self.brightest.dim() {
            picture = cut(&picture, self.part).to_owned();
        }
        if self.scale != 1.0 {
            picture *= self.scale;
        }
        picture
    }

    /// The surface in the levels of a part.
    ///
    /// # Errors
    /// As [`of_picture`].
    pub fn search(&self, picture: &Array2<f32>) -> Result<PictureSurface> {
        let of = Picture {
            pixels: picture.view(),
            pixel: self.pixel,
            x0: 0.0,
            z0: 0.0,
            depth: 0.0,
        };
        let found = of_picture(&of, &self.surface);
        found.map_err(|e| match e {
            Error::Usage(message) => Error::Usage(message),
            e => bonebeam_files::file_error(&self.path, e.to_string()),
        })
    }

    /// The points of a surface in space, without normals.
    pub fn points(&self, found: &[SurfacePoint], frame: usize, pose: &Matrix) -> Vec<CloudPoint> {
        let fan = &self.surface.fan;
        let place = |[x, z]: [f64; 2]| {
            let [column, row] = [x / self.pixel[0], z / self.pixel[1]];
            apply(
                pose,
                [column + self.part[0] as f64, row + self.part[1] as f64, 0.0],
            )
        };
        let point = |point: &SurfacePoint| {
            let [x, z] = [point.x, point.z];
            let start = match fan {
                Some(fan) => fan.at(fan.radii[0], (x - fan.x).atan2(z - fan.z)),
                None => [x, 0.0],
            };
            let position = place([x, z]);
            let line = point.line + if fan.is_none() { self.part[0] } else { 0 };
            CloudPoint::new(position, place(start), point.confidence, [frame, line])
        };
        let of_piece = |piece: &[SurfacePoint]| -> Vec<CloudPoint> {
            let sum: f32 = piece.iter().map(|point| point.confidence).sum();
            let sure = sum >= self.sure * piece.len() as f32;
            let points = piece.iter().map(point);
            points.map(|point| CloudPoint { sure, ..point }).collect()
        };
        let pieces = found.chunk_by(|a, b| a.piece == b.piece);
        pieces.flat_map(of_piece).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_piece_is_sure_by_its_mean_confidence() {
        let finder = Finder::of(&Surface::default(), None, [8, 8], [0.1; 2]);
        let finder = Finder {
            sure: 0.5,
            ..finder.unwrap()
        };
        let confidences = [(0, 0.9), (0, 0.2), (1, 0.4), (2, 0.5)];
        let point = |(line, (piece, confidence))| SurfacePoint {
            line,
            x: 0.0,
            z: 0.0,
            confidence,
            piece,
        };
        let found: Vec<_> = confidences.into_iter().enumerate().map(point).collect();
        let pose = std::array::from_fn(|row| std::array::from_fn(|k| f64::from(row == k)));
        let points = finder.points(&found, 0, &pose);
        let sure: Vec<_> = points.iter().map(|point| point.sure).collect();
        assert_eq!(sure, [true, true, false, true]);
    }
}
