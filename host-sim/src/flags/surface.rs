//! The flags of the bone surface.

use bonebeam::surface::Settings;
use bonebeam_drive::config::Surface;
use bonebeam_drive::surface::PictureFan;
use bonebeam_files::terminal::short;
use clap::Args;

/// Flags that override the section of the bone surface.
#[derive(Debug, Args)]
pub struct SurfaceFlags {
    /// Dynamic range of the lines' grey levels, dB [default: 60]
    ///
    /// Black is this far below the largest envelope. A picture has its own grey levels.
    #[arg(long, value_name = "DB", help_heading = "Surface")]
    grey_range: Option<f64>,

    /// Depth at which the search begins, m [default: 0.005]
    #[arg(long, value_name = "M", help_heading = "Surface")]
    search_start: Option<f64>,

    /// Depth at which the search ends, m [default: 6 mm above the end of the lines]
    #[arg(long, value_name = "M", help_heading = "Surface")]
    search_end: Option<f64>,

    #[arg(long, value_name = "NATS", help_heading = "Surface", help = usual("Score of a line without bone, nats; a larger score finds less bone", |s| s.absence))]
    absence: Option<f64>,

    #[arg(long, value_name = "NATS", help_heading = "Surface", help = usual("Price of each start and of each end of a surface, nats", |s| s.end))]
    end_price: Option<f64>,

    #[arg(long, value_name = "NATS", help_heading = "Surface", help = usual("Price of a jump to another depth, nats", |s| s.jump))]
    jump_price: Option<f64>,

    #[arg(long, value_name = "NATS", help_heading = "Surface", help = usual("Price of a change in depth from line to line, nats per mm", |s| 1e-3 * s.slope))]
    slope_price: Option<f64>,

    #[arg(long, value_name = "NATS", help_heading = "Surface", help = usual("Weight of the contrast of the echo to the tissue above, nats", |s| s.contrast.weight))]
    contrast: Option<f64>,

    #[arg(long, value_name = "NATS", help_heading = "Surface", help = usual("Weight of the drop in level from tissue above to shadow below, nats", |s| s.level.weight))]
    level: Option<f64>,

    #[arg(long, value_name = "NATS", help_heading = "Surface", help = usual("Weight of the brightest level below, relative to the tissue above, nats", |s| s.rest.weight))]
    rest: Option<f64>,

    #[arg(long, value_name = "NATS", help_heading = "Surface", help = usual("Weight of the shadow to the end of the line, nats", |s| -s.shadow.weight))]
    shadow: Option<f64>,

    #[arg(long, value_name = "X", help_heading = "Surface", help = usual(
        "Shadow reference below an echo brighter than the tissue, as a share of white; 1: the tissue alone",
        |s| s.margin,
    ))]
    margin: Option<f64>,

    /// Minimum confidence of a point, 0 to 1 [default: 0]
    #[arg(long, value_name = "P", help_heading = "Surface")]
    min_confidence: Option<f64>,

    /// Distance in elevation between the frames of a sweep, m
    ///
    /// Frame 0 is at elevation 0. Points then have y as well, and a .ply file has triangles between the surfaces of
    /// neighbouring frames.
    #[arg(long, value_name = "M", help_heading = "Surface")]
    sweep_step: Option<f64>,
}

/// A help text with the core's defaults.
fn usual(help: &str, of: fn(&Settings) -> f64) -> String {
    let [lines, picture] = [Settings::DEFAULT, Settings::PICTURE].map(|s| short(of(&s)));
    format!("{help} [default: {lines}; {picture} for a picture]")
}

/// Flags of pictures that override the section of the bone surface.
#[derive(Debug, Args)]
pub struct SurfacePictureFlags {
    /// Fan of the beams of a curved array or a sector [default: found by black corners]
    ///
    /// X and Z are the apex, in m from the centre of the picture's top left pixel. BEGIN and END are the distances from
    /// the apex at which the beams begin and end, in m. FIRST and LAST are the angles of the first and the last beam,
    /// in rad.
    #[arg(long, value_name = "X,Z,BEGIN,END,FIRST,LAST", value_parser = parse_fan, help_heading = "Picture")]
    fan: Option<PictureFan>,

    /// Use columns as lines, even if the picture looks like a fan
    #[arg(long, help_heading = "Picture")]
    columns_as_lines: bool,
}

fn parse_fan(text: &str) -> Result<PictureFan, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, z, begin, end, first, last]) => Ok(PictureFan {
            x,
            z,
            radii: [begin, end],
            angles: [first, last],
        }),
        _ => Err("expected six numbers, such as 0.032,-0.04,0.05,0.13,-0.5,0.5".into()),
    }
}

impl SurfacePictureFlags {
    /// The name of the flag that was given, if any.
    pub fn given(&self) -> Option<&'static str> {
        match (self.fan, self.columns_as_lines) {
            (Some(_), _) => Some("--fan"),
            (None, true) => Some("--columns-as-lines"),
            (None, false) => None,
        }
    }

    /// Replaces the section's values by those of the flags.
    pub fn apply(&self, section: &mut Surface) {
        section.fan = self.fan.or(section.fan);
        section.columns_as_lines |= self.columns_as_lines;
    }
}

impl SurfaceFlags {
    /// Replaces the section's values by those of the flags.
    pub fn apply(&self, section: &mut Surface) {
        section.grey_range = self.grey_range.unwrap_or(section.grey_range);
        section.search_start = self.search_start.unwrap_or(section.search_start);
        section.min_confidence = self.min_confidence.unwrap_or(section.min_confidence);
        let over = |flag: Option<f64>, value: &mut Option<f64>| *value = flag.or(*value);
        over(self.search_end, &mut section.search_end);
        over(self.absence, &mut section.absence);
        over(self.end_price, &mut section.end_price);
        over(self.jump_price, &mut section.jump_price);
        over(self.slope_price, &mut section.slope_price);
        over(self.contrast, &mut section.contrast);
        over(self.level, &mut section.level);
        over(self.rest, &mut section.rest);
        over(self.shadow, &mut section.shadow);
        over(self.margin, &mut section.margin);
        over(self.sweep_step, &mut section.sweep_step);
    }
}
