//! The parameters of the image.

use serde::{Deserialize, Serialize};

use crate::Result;
use bonebeam_files::settings::{LENGTHS, check_positive, out_of_range};

const SECTION: &str = "image";
/// The dynamic ranges, dB, between a black-and-white picture and all that f32 holds.
const MIN_DYNAMIC_RANGE: f64 = 0.1;
const MAX_DYNAMIC_RANGE: f64 = 1000.0;
/// The longer side of an image, in pixels, where nothing else is asked for.
pub const LONGER_SIDE: usize = 512;
/// The longest side of an image, in pixels.
const MAX_SIDE: usize = 16_384;

/// Section `[image]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Image {
    /// What lies this far below the largest envelope is black, dB.
    pub dynamic_range: f64,
    /// Pixels down the image; without them, as many as square pixels need.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rows: Option<usize>,
    /// Pixels across the image; without them, as many as square pixels need.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub columns: Option<usize>,
    /// The depth of the image's bottom, m; without it, that of the lines. The top is where the
    /// lines begin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth: Option<f64>,
    /// How far the image reaches across, centred on the beams, m; without it, as far as the
    /// beams do.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width: Option<f64>,
    /// Whether a 3 × 3 median smooths the image.
    pub median: bool,
}

impl Default for Image {
    fn default() -> Self {
        Self {
            dynamic_range: 60.0,
            rows: None,
            columns: None,
            depth: None,
            width: None,
            median: false,
        }
    }
}

impl Image {
    /// Rows and columns of square pixels over `width` and `height`, m: those asked for, and where a side
    /// is not, as many pixels as fill it without a margin. Where neither is, the longer side has
    /// [`LONGER_SIDE`].
    pub fn sides(&self, width: f64, height: f64) -> [usize; 2] {
        // Pixels are at the ends of a side: one more than there are steps.
        let other = |side: usize, ratio: f64| {
            let steps = (side - 1) as f64 * ratio;
            (steps.round().clamp(1.0, (MAX_SIDE - 1) as f64) as usize) + 1
        };
        let by_columns = |columns| [other(columns, height / width), columns];
        let by_rows = |rows| [rows, other(rows, width / height)];
        match (self.rows, self.columns) {
            (Some(rows), Some(columns)) => [rows, columns],
            (Some(rows), None) => by_rows(rows),
            (None, Some(columns)) => by_columns(columns),
            (None, None) if width > height => by_columns(LONGER_SIDE),
            (None, None) => by_rows(LONGER_SIDE),
        }
    }

    /// The size of an experiment's pictures, where it tells none: a square, which phase symmetry takes.
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
        for (key, length) in [("depth", self.depth), ("width", self.width)] {
            if let Some(length) = length {
                check_positive(SECTION, key, length, LENGTHS, " (m)")?;
            }
        }
        Ok(())
    }
}
