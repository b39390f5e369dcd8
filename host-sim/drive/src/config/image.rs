//! The parameters of the image.

use serde::{Deserialize, Serialize};

use crate::{Error, Result};
use bonebeam_files::settings::{LENGTHS, check_positive, out_of_range};
use bonebeam_files::terminal::short;

const SECTION: &str = "image";
/// Accepted dynamic ranges, dB: from a black-and-white picture to the range of f32.
const MIN_DYNAMIC_RANGE: f64 = 0.1;
const MAX_DYNAMIC_RANGE: f64 = 1000.0;
/// Default of an image's longer side, pixels.
pub const LONGER_SIDE: usize = 512;
/// Longest side of an image, pixels.
const MAX_SIDE: usize = 16_384;
/// Range of pixel sizes, m.
const PIXELS: [f64; 2] = [1e-6, 1.0];

/// Grid of an image's pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum Grid {
    /// Square pixels
    #[default]
    Cartesian,
    /// Columns at even angles and rows at even depths, without scan conversion
    Polar,
}

/// Section `[image]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Image {
    /// Dynamic range: black is this far below the largest envelope, dB.
    pub dynamic_range: f64,
    /// Pixels down the image; by default as many as square pixels need.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rows: Option<usize>,
    /// Pixels across the image; by default as many as square pixels need.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub columns: Option<usize>,
    /// Pixel size, m; of a polar grid, the distance of rows.
    ///
    /// By default the longer side has [`LONGER_SIDE`] pixels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pixel_size: Option<f64>,
    /// Grid of the pixels.
    pub grid: Grid,
    /// Depth of the image's bottom, m; by default that of the lines.
    ///
    /// The top is at the beginning of the lines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth: Option<f64>,
    /// Width of the image, centred on the beams, m; by default that of the beams.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width: Option<f64>,
    /// Whether a 3 × 3 median smooths the image.
    pub median: bool,
    /// Envelope of a line from those of its sub-lines, if it has any.
    pub pooling: SubLines,
}

/// Value of a line's sub-lines that an image shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum SubLines {
    /// The largest envelope
    #[default]
    Largest,
    /// The root mean square of the envelopes
    Rms,
    /// Each sub-line as a line of its own
    Each,
}

impl Default for Image {
    fn default() -> Self {
        Self {
            dynamic_range: 60.0,
            rows: None,
            columns: None,
            pixel_size: None,
            grid: Grid::Cartesian,
            depth: None,
            width: None,
            median: false,
            pooling: SubLines::default(),
        }
    }
}

impl Image {
    /// Rows and columns of square pixels over `width` and `height`, m.
    ///
    /// A side that is not given has as many pixels as fill it without a margin. If neither is given, the longer
    /// side has [`LONGER_SIDE`] pixels, or as many as pixels of the given size make.
    ///
    /// # Errors
    /// [`Error::Usage`] for more pixels per side than are allowed.
    pub fn sides(&self, width: f64, height: f64) -> Result<[usize; 2]> {
        if let Some(pixel) = self.pixel_size {
            // The cast saturates.
            let count = |length: f64| ((length / pixel + 1e-6) as usize).saturating_add(1).max(2);
            let sides = [
                self.rows.unwrap_or_else(|| count(height)),
                self.columns.unwrap_or_else(|| count(width)),
            ];
            return match sides.into_iter().find(|&side| side > MAX_SIDE) {
                None => Ok(sides),
                Some(side) => Err(Error::Usage(format!(
                    "--pixel-size is {} m, which makes {side} pixels per side; expected at most {MAX_SIDE}",
                    short(pixel)
                ))),
            };
        }
        // Pixels are at the ends of a side: one more than there are steps.
        let other = |side: usize, ratio: f64| {
            let steps = (side - 1) as f64 * ratio;
            (steps.round().clamp(1.0, (MAX_SIDE - 1) as f64) as usize) + 1
        };
        let by_columns = |columns| [other(columns, height / width), columns];
        let by_rows = |rows| [rows, other(rows, width / height)];
        Ok(match (self.rows, self.columns) {
            (Some(rows), Some(columns)) => [rows, columns],
            (Some(rows), None) => by_rows(rows),
            (None, Some(columns)) => by_columns(columns),
            (None, None) if width > height => by_columns(LONGER_SIDE),
            (None, None) => by_rows(LONGER_SIDE),
        })
    }

    /// Depth of the image's bottom, m, for lines between two depths.
    ///
    /// # Errors
    /// [`Error::Usage`] for a depth above the lines.
    pub fn bottom(&self, first: f64, last: f64) -> Result<f64> {
        match self.depth {
            Some(depth) if depth <= first => Err(Error::Usage(format!(
                "--depth is {} m; expected more than {first} m, the beginning of the lines",
                short(depth)
            ))),
            depth => Ok(depth.unwrap_or(last)),
        }
    }

    /// Default size of an experiment's pictures: a square, as phase symmetry needs.
    pub fn resolve_square(&mut self) {
        self.rows.get_or_insert(LONGER_SIDE);
        self.columns.get_or_insert(LONGER_SIDE);
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::Usage`] naming the flag, the key, the value and the range.
    pub fn validate(&self) -> Result<()> {
        if !(MIN_DYNAMIC_RANGE..=MAX_DYNAMIC_RANGE).contains(&self.dynamic_range) {
            let expected = format!("{MIN_DYNAMIC_RANGE} to {MAX_DYNAMIC_RANGE} dB");
            return Err(out_of_range(
                SECTION,
                "dynamic_range",
                self.dynamic_range,
                &expected,
            ));
        }
        for (key, side) in [("rows", self.rows), ("columns", self.columns)] {
            if let Some(side) = side
                && !(2..=MAX_SIDE).contains(&side)
            {
                return Err(out_of_range(SECTION, key, side, "2 to 16384"));
            }
        }
        if let Some(pixel) = self.pixel_size {
            check_positive(SECTION, "pixel_size", pixel, PIXELS, " (m)")?;
        }
        for (key, length) in [("depth", self.depth), ("width", self.width)] {
            if let Some(length) = length {
                check_positive(SECTION, key, length, LENGTHS, " (m)")?;
            }
        }
        Ok(())
    }
}
