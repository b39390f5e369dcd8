//! `host-sim phase-symmetry`: image → phase-symmetry map.

use std::path::PathBuf;

use bonebeam::phase_symmetry::scale_for_display;
use clap::Args;

use super::{ConfigArgument, about, command_line, load_config};
use crate::config::Config;
use crate::flags::Flags;
use crate::progress::Progress;
use crate::provenance::Snapshot;
use crate::{Error, Result};
use bonebeam_drive::config::{PhaseSymmetry, PixelSize};
use bonebeam_drive::image::{square_side, squared};
use bonebeam_drive::phase_symmetry::{of_image, with_scales};
use bonebeam_drive::policy::phase_symmetry_memory;
use bonebeam_files::atomic::{Outputs, check_outputs};
use bonebeam_files::image::{self, Format};
use bonebeam_files::memory;
use bonebeam_files::section::Value;
use bonebeam_files::terminal::print;

/// Filter an image for ridges: bright lines such as bone surfaces.
///
/// The filter is phase symmetry (Eq. 9 and 10). The map has the image's size and values from 0 to below 1. The
/// configuration used is written beside it as PS.npy.config.toml.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, allow_negative_numbers = true)]
pub struct Arguments {
    /// The image, 0 to 255: PNG, or .npy (float32 [row, column])
    image: PathBuf,

    /// The map, float32 [row, column]
    #[arg(short, long, value_name = "PS.npy")]
    output: PathBuf,

    /// Also write the map as 8-bit grey levels; its largest value becomes 255
    #[arg(long = "image", value_name = "PS.png")]
    picture: Option<PathBuf>,

    /// Size of the image's pixels, m: a side for --wavelengths, or two as ACROSS,DOWN
    ///
    /// An image of pixels that are not square is filtered on square ones.
    #[arg(long, value_name = "M", value_parser = PixelSize::read)]
    pixel_size: Option<PixelSize>,

    #[command(flatten)]
    phase_symmetry: Flags<PhaseSymmetry>,

    #[command(flatten)]
    config: ConfigArgument,
}

const EXAMPLES: &str = "\
Examples:
  host-sim phase-symmetry bone.png --pad --scales 2^-7,2^-8,2^-9 --threshold 15 -o ps.npy \\
      --image ps.png
  host-sim phase-symmetry scan.png --resize 512x512 --scales 2^-5,2^-6,2^-7,2^-8,2^-9 \\
      --threshold 10 -o ps.npy
  host-sim phase-symmetry bone.png --pad --pixel-size 0.0001 --wavelengths 0.002,0.004 \\
      --noise-deviations 2 -o ps.npy
  host-sim phase-symmetry bone.png --pad --scales-from-image -o ps.npy";

/// Runs the command.
///
/// # Errors
/// A parameter out of range, an image that is not valid, or an output that cannot be written.
pub fn run(arguments: Arguments) -> Result<()> {
    let mut config = load_config(arguments.config.path.as_deref())?;
    arguments.phase_symmetry.apply(&mut config.phase_symmetry);
    config.image.pixel_size = arguments.pixel_size.or(config.image.pixel_size);
    config.validate()?;

    if Format::of(&arguments.output)? != Format::Npy {
        return Err(Error::Usage(format!(
            "--output is {}; expected a name that ends in .npy (--image makes a PNG)",
            arguments.output.display()
        )));
    }
    let config_path = Config::path_beside(&arguments.output);
    let mut outputs = vec![arguments.output.as_path(), &config_path];
    if let Some(picture) = &arguments.picture {
        Format::of(picture)?;
        outputs.push(picture);
    }
    check_outputs(&[&arguments.image], &outputs)?;

    Format::of(&arguments.image)?;
    let snapshot = Snapshot::of(&arguments.image)?;
    let pixels = image::read_levels(&arguments.image)?;
    let pixel = config.image.pixel_size.map(PixelSize::sides);
    let square = pixel.map(|pixel| squared(pixels.view(), pixel)).transpose();
    let square = square.map_err(|e| about(&arguments.image, e))?.flatten();
    let sides = square.as_ref().unwrap_or(&pixels).dim();
    let bytes = phase_symmetry_memory(sides.into(), &config.phase_symmetry);
    memory::check(bytes, "phase symmetry").map_err(|e| about(&arguments.image, e))?;
    let chosen = config.phase_symmetry.scales_from_image;
    if chosen {
        let shown = square.as_ref().unwrap_or(&pixels);
        let section = with_scales(shown.view(), &config.phase_symmetry);
        config.phase_symmetry = section.map_err(|e| about(&arguments.image, e))?;
    }
    let bar = Progress::new("phase symmetry", 1);
    let section = &config.phase_symmetry;
    let map = of_image(pixels, section, pixel, &mut |done, of| {
        bar.set(done as u64, of as u64);
    })
    .map_err(|e| about(&arguments.image, e))?;
    bar.clear();

    let mut outputs = Outputs::new();
    image::add_to(&map, &arguments.output, &mut outputs)?;
    if let Some(picture) = &arguments.picture {
        let mut levels = map;
        scale_for_display(levels.as_slice_memory_order_mut().unwrap_or_default())?;
        image::add_to(&levels, picture, &mut outputs)?;
    }
    let inputs = [snapshot.hashed()?];
    config.add_to(&command_line(), &inputs, &config_path, &mut outputs)?;
    outputs.commit()?;
    match chosen {
        true => {
            let chosen = chosen_scales(&config.phase_symmetry, pixel.map(square_side));
            print(&format!("{chosen}\n"))
        }
        false => Ok(()),
    }
}

/// The wavelengths of scales from the image, as text; also in mm if the size of a pixel, m, is known.
pub(super) fn chosen_scales(section: &PhaseSymmetry, pixel: Option<f64>) -> String {
    let times = |factor: f64| {
        let wavelengths = section.scales.iter().map(|scale| factor / scale);
        let texts: Vec<String> = wavelengths.map(|value| format!("{value:.2}")).collect();
        texts.join(", ")
    };
    let in_mm = pixel.map(|pixel| format!(" ({} mm)", times(1e3 * pixel)));
    format!(
        "scales from the image: wavelengths of {} pixels{}",
        times(1.0),
        in_mm.unwrap_or_default()
    )
}
