//! The flags of the image.

use bonebeam_drive::config::{Grid, Image, SubLines};
use clap::Args;

/// Flags that override the section of the image.
#[derive(Debug, Args)]
pub struct ImageFlags {
    /// Dynamic range: black is this far below the largest envelope, dB [default: 60]
    #[arg(long, value_name = "DB", help_heading = "Image")]
    dynamic_range: Option<f64>,

    /// Depth of the image's bottom, m [default: the end of the lines]
    #[arg(long, value_name = "M", help_heading = "Image")]
    depth: Option<f64>,

    /// Width of the image, centred on the beams, m [default: the beams' width]
    #[arg(long, value_name = "M", help_heading = "Image")]
    width: Option<f64>,

    /// Rows of pixels [default: square pixels, 512 along the longer side]
    #[arg(long, value_name = "N", help_heading = "Image")]
    rows: Option<usize>,

    /// Columns of pixels [default: square pixels, 512 along the longer side]
    #[arg(long, value_name = "N", help_heading = "Image")]
    columns: Option<usize>,

    /// Pixel size of an image that is written or read, m [default: 512 pixels along the longer side]
    #[arg(long, value_name = "M", help_heading = "Image")]
    pixel_size: Option<f64>,

    /// Grid of the pixels [default: cartesian]
    #[arg(long, value_enum, help_heading = "Image")]
    grid: Option<Grid>,

    /// Smooth the image with a 3 x 3 median
    #[arg(long, help_heading = "Image")]
    median: bool,

    /// Value of a line's sub-lines that the image shows [default: largest]
    #[arg(long, value_enum, help_heading = "Image")]
    pooling: Option<SubLines>,
}

impl ImageFlags {
    /// Replaces the section's values by those of the flags.
    pub fn apply(&self, section: &mut Image) {
        section.dynamic_range = self.dynamic_range.unwrap_or(section.dynamic_range);
        section.depth = self.depth.or(section.depth);
        section.width = self.width.or(section.width);
        section.rows = self.rows.or(section.rows);
        section.columns = self.columns.or(section.columns);
        section.pixel_size = self.pixel_size.or(section.pixel_size);
        section.grid = self.grid.unwrap_or(section.grid);
        section.median |= self.median;
        section.pooling = self.pooling.unwrap_or(section.pooling);
    }
}
