//! The flags of the image.

use bonebeam_drive::config::{Grid, Image, SubLines};
use clap::Args;

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

    /// Pixels down the image [default: as many as square pixels need, 512 the longer way]
    #[arg(long, value_name = "N", help_heading = "Image")]
    rows: Option<usize>,

    /// Pixels across the image [default: as many as square pixels need, 512 the longer way]
    #[arg(long, value_name = "N", help_heading = "Image")]
    columns: Option<usize>,

    /// Distance from one pixel to the next, m: of an image that is made, or of one that is read [default: 512 pixels the
    /// longer way]
    #[arg(long, value_name = "M", help_heading = "Image")]
    pixel_size: Option<f64>,

    /// Where the pixels lie [default: cartesian]
    #[arg(long, value_enum, help_heading = "Image")]
    grid: Option<Grid>,

    /// Smooth the image with a 3 x 3 median
    #[arg(long, help_heading = "Image")]
    median: bool,

    /// What the image shows of a line's sub-lines [default: largest]
    #[arg(long, value_enum, help_heading = "Image")]
    pooling: Option<SubLines>,
}

impl ImageFlags {
    /// What the flags say in place of the section's values.
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
