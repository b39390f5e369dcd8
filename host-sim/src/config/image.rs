//! The parameters of the image: the section and its flags.

use clap::Args;
use serde::{Deserialize, Serialize};

use super::{LENGTHS, check_positive, out_of_range};
use crate::Result;

const SECTION: &str = "image";
/// The dynamic ranges, dB, between a black-and-white picture and all that f32 holds.
const MIN_DYNAMIC_RANGE: f64 = 0.1;
const MAX_DYNAMIC_RANGE: f64 = 1000.0;
/// The longest side of an image, in pixels.
const MAX_SIDE: usize = 16_384;

/// Section `[image]`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Image {
    /// What lies this far below the largest envelope is black, dB.
    pub dynamic_range: f64,
    /// Pixels down the image.
    pub rows: usize,
    /// Pixels across the image.
    pub columns: usize,
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

/// The flags that go over the section.
#[derive(Debug, Args)]
pub struct ImageFlags {
    /// Black lies this far below the largest envelope, dB [default: 60]
    #[arg(long, value_name = "DB", help_heading = "Image")]
    dynamic_range: Option<f64>,

    /// Depth of the image's bottom, m [default: the lines']
    #[arg(long, value_name = "M", help_heading = "Image")]
    depth: Option<f64>,

    /// Width of the image, centred on the beams, m [default: the beams']
    #[arg(long, value_name = "M", help_heading = "Image")]
    width: Option<f64>,

    /// Pixels down the image [default: 512]
    #[arg(long, value_name = "N", help_heading = "Image")]
    rows: Option<usize>,

    /// Pixels across the image [default: 512]
    #[arg(long, value_name = "N", help_heading = "Image")]
    columns: Option<usize>,

    /// Smooth the image with a 3 x 3 median
    #[arg(long, help_heading = "Image")]
    median: bool,
}

impl Default for Image {
    fn default() -> Self {
        Self {
            dynamic_range: 60.0,
            rows: 512,
            columns: 512,
            depth: None,
            width: None,
            median: false,
        }
    }
}

impl Image {
    /// What the flags say in place of the section's values.
    pub fn apply(&mut self, flags: &ImageFlags) {
        self.dynamic_range = flags.dynamic_range.unwrap_or(self.dynamic_range);
        self.depth = flags.depth.or(self.depth);
        self.width = flags.width.or(self.width);
        self.rows = flags.rows.unwrap_or(self.rows);
        self.columns = flags.columns.unwrap_or(self.columns);
        self.median |= flags.median;
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
            if !(2..=MAX_SIDE).contains(&side) {
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
