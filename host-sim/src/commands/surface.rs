//! `host-sim surface`: a recording, lines or a picture → the bone surface.

use std::path::PathBuf;

use clap::Args;

use super::check::EstimateArgument;
use super::frames::{FrameRange, parse_frames};
use super::surface_files::Overlay;
use super::surface_inputs::{Crop, Found, Source, parse_crop};
use super::{ConfigArgument, VariableArguments, command_line, load_config};
use crate::config::Config;
use crate::flags::Flags;
use crate::provenance::Snapshot;
use crate::{Error, Result};
use bonebeam_drive::config::{Beamform, Grid, Image, Surface};
use bonebeam_drive::methods::MethodName;
use bonebeam_drive::surface::{Kind, add_surfaces_to};
use bonebeam_files::atomic::{Outputs, check_outputs};
use bonebeam_files::image;
use bonebeam_files::terminal::print;

/// Find the bone surface: a depth in each line, or none.
///
/// FILE is a recording, lines, or pictures. A recording is beamformed first, by das unless --method or --config names
/// another method. Lines are an .npz file with `z`. Pictures are a PNG, JPEG or .npy file, or the frames of a DICOM, .mha
/// or .nrrd file; their lines are their columns, or the beams of the fan of a curved array or a sector. Bone is a bright
/// echo with a shadow below it, continuous from line to line. In a recording, coherence between neighbouring elements
/// tells clutter in a shadow from tissue. The configuration used is written beside the surface as SURFACE.csv.config.toml.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, allow_negative_numbers = true)]
pub struct Arguments {
    /// Recording, lines, or picture
    #[arg(value_name = "FILE")]
    input: PathBuf,

    /// Points of the surface, written as .csv, .json, .ply or .vtp
    ///
    /// .csv: line, x and z in m, confidence, piece. .json: the same, grouped by piece. .ply: x, 0, z in mm with
    /// confidence, and edges between neighbours. For several frames, points have the frame as well. With --sweep-step,
    /// points have y, and .ply has triangles.
    #[arg(short, long, value_name = "SURFACE.csv")]
    output: PathBuf,

    /// Also write the picture of the first frame with the surface drawn over it
    #[arg(long, value_name = "OVERLAY.png")]
    image: Option<PathBuf>,

    /// Part of the picture to use, in pixels from the top left [default: all]
    ///
    /// It leaves out the text and rulers of a screen.
    #[arg(long, value_name = "X,Y,WIDTH,HEIGHT", value_parser = parse_crop, help_heading = "Picture")]
    crop: Option<Crop>,

    /// Frames A to B−1, or frame A alone: A..B or A [default: all]
    ///
    /// For a recording, or for lines of several frames.
    #[arg(long, value_name = "A..B", value_parser = parse_frames)]
    frames: Option<FrameRange>,

    #[command(flatten)]
    surface: Flags<Surface>,

    #[command(flatten)]
    variables: VariableArguments,

    #[command(flatten)]
    estimate: EstimateArgument,

    #[command(flatten)]
    beamform: Flags<Beamform>,

    #[command(flatten)]
    image_flags: Flags<Image>,

    #[command(flatten)]
    config: ConfigArgument,
}

const EXAMPLES: &str = "\
Examples:
  host-sim surface channels.npz -o surface.csv --image surface.png
  host-sim surface channels.npz --method das --search-end 0.04 -o surface.ply
  host-sim surface lines.npz -o surface.json --image surface.png --dynamic-range 60
  host-sim surface scan.png --pixel-size 0.0001 -o surface.csv --image surface.png
  host-sim surface cine.dcm --frames 0..10 -o surface.csv --image surface.png
  host-sim surface frames.hdf5 --frames 0..10 -o surface.csv
  host-sim surface sweep.npz --sweep-step 0.0005 -o surface.ply
  host-sim surface sector.png --pixel-size 0.0002 --fan 0.032,0.004,0.006,0.15,-0.78,0.78 -o surface.csv
  host-sim surface screen.png --pixel-size 0.00012 --crop 80,40,512,480 -o surface.csv --image surface.png";

/// Runs the command.
///
/// # Errors
/// A parameter out of range, a file that is not valid, or an output that cannot be written.
pub fn run(arguments: Arguments) -> Result<()> {
    let mut config = load_config(arguments.config.path.as_deref())?;
    if arguments.config.path.is_none() {
        config.beamform.method = MethodName::Das;
    }
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

    Kind::of("--output", &arguments.output)?;
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
    let hashing = snapshot.hashing();
    arguments.estimate.apply(&arguments.input, &mut config)?;
    let picture = arguments
        .surface
        .given()
        .find(|(_, heading)| *heading == "Picture");
    let source = Source {
        path: &arguments.input,
        crop: arguments.crop,
        frames: arguments.frames.as_ref(),
        hash: hashing.shared(),
        every: 1,
        drawn: arguments.image.is_some(),
        of_picture: match arguments.crop {
            Some(_) => Some("crop"),
            None => picture.map(|(flag, _)| flag),
        },
    };
    let found = Found::of(&source, &config, &snapshot)?;
    let mut outputs = Outputs::new();
    let (path, lines, step) = (&arguments.output, found.lines, config.surface.sweep_step);
    add_surfaces_to(&found.frames, lines, step, path, &mut outputs)?;
    if let (Some(path), Some(picture)) = (&arguments.image, &found.picture) {
        let points = found.frames.first().map_or(&[][..], |frame| &frame.points);
        Overlay::of(picture, found.fan.as_ref(), points, Overlay::colour)
            .add_to(path, &mut outputs)?;
    }
    // The written configuration has the fan that was found, so that it repeats the run.
    config.surface.fan = found.fan;
    let inputs = [hashing.finish()?];
    config.add_to(&command_line(), &inputs, &config_path, &mut outputs)?;
    outputs.commit()?;
    print(&format!("{}\n", summary(&found)))
}

/// One line for the terminal: the share of the lines with bone, and the fan.
fn summary(found: &Found) -> String {
    let fan = found.fan.map_or(String::new(), |fan| {
        let degrees = fan.angles.map(f64::to_degrees);
        let mm = [fan.x, fan.z, fan.radii[0], fan.radii[1]].map(|length| 1e3 * length);
        format!(
            "; lines are the beams of a fan from {:.1}, {:.1} mm, between {:.1} and {:.1} mm, {:.1} to {:.1} degrees",
            mm[0], mm[1], mm[2], mm[3], degrees[0], degrees[1]
        )
    });
    if let [one] = &found.frames[..] {
        return one.summary(found.lines) + &fan;
    }
    let with = found.frames.iter().filter(|frame| !frame.points.is_empty());
    let points: usize = found.frames.iter().map(|frame| frame.points.len()).sum();
    format!(
        "bone surface in {} of {} frames, in {:.0} of {} lines on average",
        with.count(),
        found.frames.len(),
        points as f64 / found.frames.len().max(1) as f64,
        found.lines
    )
}
