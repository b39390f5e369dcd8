//! The parameters of the image.

use crate::{Error, Result};
use bonebeam_files::section::{Range, Section, Value, row};
use bonebeam_files::settings::LENGTHS;
use bonebeam_files::terminal::short;
use bonebeam_files::{choice, section};

/// Default of an image's longer side, pixels.
pub const LONGER_SIDE: usize = 512;
/// Longest side of an image, pixels.
const MAX_SIDE: usize = 16_384;
/// Sides of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(untagged)]
pub enum PixelSize {
    /// The side of a square, m.
    Square(f64),
    /// Across and down, m.
    Sides([f64; 2]),
}

impl PixelSize {
    /// Across and down, m.
    pub fn sides(self) -> [f64; 2] {
        match self {
            PixelSize::Square(side) => [side; 2],
            PixelSize::Sides(sides) => sides,
        }
    }
}

impl From<[f64; 2]> for PixelSize {
    fn from([across, down]: [f64; 2]) -> Self {
        match across == down {
            true => PixelSize::Square(down),
            false => PixelSize::Sides([across, down]),
        }
    }
}

impl Value for PixelSize {
    fn python() -> String {
        "float | tuple[float, float]".into()
    }

    fn read(text: &str) -> std::result::Result<Self, String> {
        let sides: Option<Vec<f64>> = text
            .split(',')
            .map(|side| side.trim().parse().ok())
            .collect();
        match sides.as_deref() {
            Some(&[side]) => Ok(PixelSize::Square(side)),
            Some(&[across, down]) => Ok(PixelSize::Sides([across, down])),
            _ => Err("expected one side in m, or two as ACROSS,DOWN".into()),
        }
    }

    fn outside(&self, range: &Range) -> Option<String> {
        self.sides().iter().find_map(|side| side.outside(range))
    }
}

choice! {
    /// Grid of an image's pixels.
    Grid = Cartesian {
        /// Square pixels
        Cartesian = "cartesian",
        /// Columns at even angles and rows at even depths, without scan conversion
        Polar = "polar",
    }
}

choice! {
    /// Value of a line's sub-lines that an image shows.
    SubLines = Largest {
        /// The largest envelope
        Largest = "largest",
        /// The root mean square of the envelopes
        Rms = "rms",
        /// Each sub-line as a line of its own
        Each = "each",
    }
}

section! {
    /// Section `[image]`.
    Image "image" {
        "Image" {
            /// Dynamic range: black is this far below the largest envelope, dB
            dynamic_range: f64 = 60.0, row("DB").within([0.1, 1000.0], " dB");
            /// Depth of the image's bottom, m [default: the end of the lines]
            depth: Option<f64> = None, row("M").positive(LENGTHS, " (m)");
            /// Width of the image, centred on the beams, m [default: the beams' width]
            width: Option<f64> = None, row("M").positive(LENGTHS, " (m)");
            /// Rows of pixels [default: square pixels, 512 along the longer side]
            rows: Option<usize> = None, row("N").within([2.0, MAX_SIDE as f64], "");
            /// Columns of pixels [default: square pixels, 512 along the longer side]
            columns: Option<usize> = None, row("N").within([2.0, MAX_SIDE as f64], "");
            /// Pixel size of an image that is written or read, m [default: 512 pixels along the longer side]
            ///
            /// One side, or two as ACROSS,DOWN.
            pixel_size: Option<PixelSize> = None, row("M").positive([1e-6, 1.0], " (m)");
            /// Grid of the pixels
            grid: Grid = Grid::default(), row("");
            /// Smooth the image with a 3 x 3 median
            median: bool = false, row("");
            /// Value of a line's sub-lines that the image shows
            pooling: SubLines = SubLines::default(), row("");
        }
    }
}

impl Image {
    /// Rows and columns of pixels over `width` and `height`, m.
    ///
    /// A side that is not given has as many pixels as fill it without a margin. If neither is given, the longer
    /// side has [`LONGER_SIDE`] pixels, or as many as pixels of the given size make.
    ///
    /// # Errors
    /// [`Error::Usage`] for more pixels per side than are allowed.
    pub fn sides(&self, width: f64, height: f64) -> Result<[usize; 2]> {
        if let Some(pixel) = self.pixel_size {
            let [across, down] = pixel.sides();
            if down > height {
                return Err(Error::Usage(format!(
                    "--pixel-size is {} m, more than the image's height of {} m",
                    short(down),
                    short(height)
                )));
            }
            // The cast saturates.
            let count = |ratio: f64| ((ratio + 1e-6) as usize).saturating_add(1).max(2);
            let sides = [
                self.rows.unwrap_or_else(|| count(height / down)),
                self.columns.unwrap_or_else(|| count(width / across)),
            ];
            return match sides.into_iter().find(|&side| side > MAX_SIDE) {
                None => Ok(sides),
                Some(side) => Err(Error::Usage(format!(
                    "--pixel-size is {} m, which makes {side} pixels per side; expected at most {MAX_SIDE}",
                    short(if across < down { across } else { down })
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
        self.check_ranges()
    }
}
