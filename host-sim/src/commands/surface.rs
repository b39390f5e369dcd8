//! `host-sim surface`: a recording, lines or a picture → the bone surface.

use std::path::{Path, PathBuf};

use clap::Args;

use super::surface_files::{Kind, Overlay, add_to};
use super::{ConfigArgument, VariableArguments, about, command_line, load_config};
use crate::config::Config;
use crate::flags::{BeamformFlags, ImageFlags, SurfaceFlags};
use crate::progress::Progress;
use crate::provenance::Snapshot;
use crate::{Error, Result};
use bonebeam_drive::config::Grid;
use bonebeam_drive::frame::RecordingFrames;
use bonebeam_drive::image::{BModeImage, image_of};
use bonebeam_drive::policy::{Pictures, warnings, working_memory};
use bonebeam_drive::surface::{SurfacePoint, of_lines, of_picture};
use bonebeam_files::atomic::{Outputs, check_outputs};
use bonebeam_files::terminal::{print, warn};
use bonebeam_files::{BeamformedLines, Recording, image, memory, npz};
use bonebeam_formats::RecordingFile;
use ndarray::Slice;

/// Find the bone surface: a depth in each line, or none.
///
/// FILE is a recording, which is beamformed first; lines (`z` …) as .npz; or a picture, PNG or .npy, whose columns are
/// lines. Bone is a bright echo with a shadow below it, continuous from line to line. The configuration used is
/// written beside the surface as SURFACE.csv.config.toml.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, allow_negative_numbers = true)]
pub struct Arguments {
    /// The recording, the lines, or the picture
    #[arg(value_name = "FILE")]
    input: PathBuf,

    /// The points, .csv: line, x and z in m, confidence, piece; .json: the same by pieces; .ply: x, 0, z in mm with
    /// confidence, and edges between neighbours
    #[arg(short, long, value_name = "SURFACE.csv")]
    output: PathBuf,

    /// Also the picture with the surface drawn over it
    #[arg(long, value_name = "OVERLAY.png")]
    image: Option<PathBuf>,

    /// Of a picture: the part that is the image, without a screen's text and rulers, in pixels from the top left
    #[arg(long, value_name = "X,Y,WIDTH,HEIGHT", value_parser = parse_crop, help_heading = "Picture")]
    crop: Option<Crop>,

    /// Of a recording of many: the frame
    #[arg(long, value_name = "N", default_value_t = 0)]
    frame: usize,

    #[command(flatten)]
    surface: SurfaceFlags,

    #[command(flatten)]
    variables: VariableArguments,

    #[command(flatten)]
    beamform: BeamformFlags,

    #[command(flatten)]
    image_flags: ImageFlags,

    #[command(flatten)]
    config: ConfigArgument,
}

const EXAMPLES: &str = "\
Examples:
  host-sim surface channels.npz -o surface.csv --image surface.png
  host-sim surface channels.npz --method das --search-end 0.04 -o surface.ply
  host-sim surface lines.npz -o surface.json --image surface.png --dynamic-range 60
  host-sim surface scan.png --pixel-size 0.0001 -o surface.csv --image surface.png
  host-sim surface screen.png --pixel-size 0.00012 --crop 80,40,512,480 -o surface.csv --image surface.png";

/// A part of a picture, pixels.
#[derive(Clone, Copy, Debug)]
struct Crop {
    x: usize,
    y: usize,
    width: usize,
    height: usize,
}

fn parse_crop(text: &str) -> std::result::Result<Crop, String> {
    let numbers: Option<Vec<usize>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, width, height]) if width > 0 && height > 0 => Ok(Crop {
            x,
            y,
            width,
            height,
        }),
        _ => Err("expected four whole numbers of pixels, such as 80,40,512,480".into()),
    }
}

/// What FILE holds.
enum Input {
    Picture,
    Lines,
    Recording,
}

impl Input {
    fn of(path: &Path) -> Result<Self> {
        let extension = path.extension().and_then(|e| e.to_str());
        let is = |name: &str| extension.is_some_and(|e| e.eq_ignore_ascii_case(name));
        if is("png") || is("npy") {
            return Ok(Self::Picture);
        }
        let lines = is("npz") && {
            let file = npz::Reader::open(path)?;
            file.has("z") && file.has("beam_x")
        };
        Ok(if lines { Self::Lines } else { Self::Recording })
    }
}

/// A surface with the picture that it lies in.
struct Found {
    points: Vec<SurfacePoint>,
    lines: usize,
    picture: Option<BModeImage>,
}

/// Runs the command.
///
/// # Errors
/// A parameter out of range, a file that is not valid, or an output that cannot be written.
pub fn run(arguments: Arguments) -> Result<()> {
    let mut config = load_config(arguments.config.path.as_deref())?;
    arguments.surface.apply(&mut config.surface);
    arguments.beamform.apply(&mut config.beamform);
    arguments.variables.apply(&mut config.variables)?;
    arguments.image_flags.apply(&mut config.image);
    config.beamform.resolve();
    config.validate()?;
    if config.image.grid == Grid::Polar {
        let message =
            "--grid polar has no effect on the surface, which is drawn over square pixels";
        return Err(Error::Usage(message.into()));
    }

    let kind = Kind::of(&arguments.output)?;
    let config_path = Config::path_beside(&arguments.output);
    let mut outputs = vec![arguments.output.as_path(), &config_path];
    if let Some(overlay) = &arguments.image {
        if image::Format::of(overlay)? != image::Format::Png {
            return Err(Error::Usage(format!(
                "--image is {}; expected a name that ends in .png",
                overlay.display()
            )));
        }
        outputs.push(overlay);
    }
    check_outputs(&[&arguments.input], &outputs)?;

    let snapshot = Snapshot::of(&arguments.input)?;
    let found = match Input::of(&arguments.input)? {
        Input::Picture => of_file_of_picture(&arguments, &config)?,
        Input::Lines => {
            arguments.refuse_of_picture()?;
            let lines = BeamformedLines::read(&arguments.input)?;
            of_beams(&arguments, &config, &lines)?
        }
        Input::Recording => {
            arguments.refuse_of_picture()?;
            let lines = beamformed(&arguments, &config)?;
            of_beams(&arguments, &config, &lines)?
        }
    };

    let mut outputs = Outputs::new();
    add_to(
        &found.points,
        found.lines,
        kind,
        &arguments.output,
        &mut outputs,
    )?;
    if let (Some(path), Some(picture)) = (&arguments.image, &found.picture) {
        Overlay::of(picture, &found.points).add_to(path, &mut outputs)?;
    }
    let inputs = [snapshot.hashed(true)?];
    config.add_to(&command_line(), &inputs, &config_path, &mut outputs)?;
    outputs.commit()?;
    print(&format!("{}\n", summary(&found)))
}

impl Arguments {
    /// A part of a picture is no part of lines.
    fn refuse_of_picture(&self) -> Result<()> {
        if self.crop.is_none() {
            return Ok(());
        }
        Err(Error::Usage(format!(
            "--crop has no effect on {}, which is not a picture",
            self.input.display()
        )))
    }
}

fn of_file_of_picture(arguments: &Arguments, config: &Config) -> Result<Found> {
    let path = &arguments.input;
    let Some(pixel) = config.image.pixel_size else {
        return Err(Error::Usage(format!(
            "{} is a picture: give the side of its pixels by --pixel-size, in m, such as 0.0001",
            path.display()
        )));
    };
    if !(1e-6..=1e-2).contains(&pixel) {
        return Err(Error::Usage(format!(
            "--pixel-size is {pixel}; expected 1e-6 to 0.01 (m)"
        )));
    }
    let pixels = image::read(path)?;
    let (rows, columns) = pixels.dim();
    let Crop {
        x,
        y,
        width,
        height,
    } = arguments.crop.unwrap_or(Crop {
        x: 0,
        y: 0,
        width: columns,
        height: rows,
    });
    let ends = [x.saturating_add(width), y.saturating_add(height)];
    if ends[0] > columns || ends[1] > rows {
        return Err(Error::Usage(format!(
            "--crop reaches to {},{}; {} has {columns} x {rows} pixels",
            ends[0],
            ends[1],
            path.display()
        )));
    }
    let part = pixels.slice_each_axis(|axis| match axis.axis.index() {
        0 => Slice::from(y..ends[1]),
        _ => Slice::from(x..ends[0]),
    });
    let mut points = of_picture(part, pixel, &config.surface).map_err(|e| about(path, e))?;
    for point in &mut points {
        point.line += x;
        point.x += x as f64 * pixel;
        point.z += y as f64 * pixel;
    }
    Ok(Found {
        points,
        lines: width,
        picture: Some(BModeImage {
            pixels,
            x0: 0.0,
            z0: 0.0,
            pixel,
            angles: None,
        }),
    })
}

fn of_beams(arguments: &Arguments, config: &Config, lines: &BeamformedLines) -> Result<Found> {
    let points = of_lines(lines, &config.surface).map_err(|e| about(&arguments.input, e))?;
    let picture = match &arguments.image {
        None => None,
        Some(_) => {
            let picture = image_of(lines, &config.image);
            Some(picture.map_err(|e| about(&arguments.input, e))?)
        }
    };
    Ok(Found {
        points,
        lines: lines.beam_x.len(),
        picture,
    })
}

/// The lines of a recording's frame.
fn beamformed(arguments: &Arguments, config: &Config) -> Result<BeamformedLines> {
    let path = &arguments.input;
    let file = RecordingFile::open(path, &config.variables)?;
    let frame = arguments.frame;
    if frame >= file.frames() {
        return Err(Error::Usage(format!(
            "--frame is {frame}; the recording has frames 0 to {}",
            file.frames().saturating_sub(1)
        )));
    }
    let first = file.first();
    if let Recording::Channel(data) = first {
        for warning in warnings(data, &config.beamform)? {
            warn(&format!("{}: {warning}", path.display()));
        }
    }
    let pictures = arguments.image.as_ref().map(|_| Pictures {
        image: &config.image,
        bone_map: None,
        figure: false,
    });
    let bytes = working_memory(first, &config.beamform, pictures.as_ref(), 1);
    memory::check(bytes, "beamforming").map_err(|e| about(path, e))?;
    let beamformer = RecordingFrames::new(first, &config.beamform).map_err(|e| about(path, e))?;
    let (recording, own) = file.read(frame..frame + 1)?;
    let bar = Progress::new("beamforming", 1000);
    let progress = |part: f64| bar.set((1000.0 * part) as u64, 1000);
    let lines = beamformer.lines(&recording, own, &progress);
    let mut lines = lines.map_err(|e| about(path, e))?;
    bar.clear();
    Ok(lines.remove(0))
}

/// How much of the lines have bone, and where.
fn summary(found: &Found) -> String {
    let Found { points, lines, .. } = found;
    let pieces = points.last().map_or(0, |last| last.piece + 1);
    let depths = points.iter().map(|point| 1e3 * point.z);
    let least = depths.clone().fold(f64::INFINITY, f64::min);
    let most = depths.fold(f64::NEG_INFINITY, f64::max);
    if points.is_empty() {
        return format!("no bone surface in {lines} lines");
    }
    format!(
        "bone surface in {} of {lines} lines, in {pieces} piece{}, from {least:.2} to {most:.2} mm",
        points.len(),
        if pieces == 1 { "" } else { "s" }
    )
}
