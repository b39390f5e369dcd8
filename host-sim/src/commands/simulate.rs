//! `host-sim simulate`: phantom → channel data.

use std::path::{Path, PathBuf};

use clap::Args;

use super::{ConfigArgument, command_line, load_config, progress_bar};
use crate::config::{self, Config, Kind};
use crate::files::atomic::{Outputs, check_outputs};
use crate::simulate::{Summation, channel_data};
use crate::{Error, Result};

/// Simulate the channel data of a point or of a vertebra.
///
/// A linear array sends one focused beam per element (the paper's array, pulse, transmit and
/// record, unless told otherwise) and records every element. Bone attenuates totally: an element
/// hears only what it sees. The configuration used is written beside the channel data as
/// FILE.npz.config.toml; its section [simulate.scanner] has all settings of the scanner.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, allow_negative_numbers = true)]
pub struct Arguments {
    /// What is imaged
    #[arg(value_enum, required_unless_present = "path")]
    phantom: Option<Kind>,

    /// The channel data: `rf` float32 [transmit, element, sample], `fs`, `t0`, `element_x`, `c`,
    /// `f0`, `tx_x`, `tx_focus`, `tx_fnumber`
    #[arg(short, long, value_name = "FILE.npz")]
    output: PathBuf,

    /// How far the point lies to the right of the middle element, m [default: 0]
    #[arg(long, value_name = "M", help_heading = "Point")]
    offset: Option<f64>,

    /// A closed surface in mm, +x towards the front and +z towards the head, in place of the
    /// built-in vertebra
    #[arg(long, value_name = "FILE.ply", help_heading = "Vertebra")]
    mesh: Option<PathBuf>,

    /// Height of the slice, m [default: 0]
    #[arg(long, value_name = "M", help_heading = "Vertebra")]
    slice: Option<f64>,

    /// Depth of the bone's shallowest point, m [default: 0.015]
    #[arg(long, value_name = "M", help_heading = "Vertebra")]
    depth: Option<f64>,

    /// Soft tissue around the bone, not water
    #[arg(long, help_heading = "Vertebra")]
    tissue: bool,

    /// Electronic noise, dB relative to the largest sample of the record [default: none for the
    /// point, -40 for the vertebra]
    #[arg(long, value_name = "DB", help_heading = "Scanner")]
    noise: Option<f64>,

    /// No electronic noise
    #[arg(long, conflicts_with = "noise", help_heading = "Scanner")]
    noise_free: bool,

    /// Seed of noise and tissue [default: 1]
    #[arg(long, value_name = "N", help_heading = "Scanner")]
    seed: Option<u64>,

    /// Depth of the transmit focus, m [default: 0.015]
    #[arg(long, value_name = "M", help_heading = "Scanner")]
    focus: Option<f64>,

    /// Transmit f-number [default: 2.8]
    #[arg(long, help_heading = "Scanner")]
    f_number: Option<f64>,

    /// How many beams [default: 128]
    #[arg(long, value_name = "N", help_heading = "Scanner")]
    beams: Option<usize>,

    /// Where the first beam lies, in pitches from the first element [default: 0]
    #[arg(long, value_name = "PITCHES", help_heading = "Scanner")]
    first_beam: Option<f64>,

    /// Distance between the beams, in pitches [default: 1]
    #[arg(long, value_name = "PITCHES", help_heading = "Scanner")]
    beam_step: Option<f64>,

    /// Shallowest depth that the record serves, m [default: 0.012 for the point, 0.005 for the
    /// vertebra]
    #[arg(long, value_name = "M", help_heading = "Scanner")]
    depth_start: Option<f64>,

    /// Greatest depth that the record serves, m [default: 0.018 for the point, 0.04 for the
    /// vertebra]
    #[arg(long, value_name = "M", help_heading = "Scanner")]
    depth_end: Option<f64>,

    #[command(flatten)]
    config: ConfigArgument,
}

const EXAMPLES: &str = "\
Examples:
  host-sim simulate point -o point.npz
  host-sim simulate point --offset 0.000154 --noise -60 -o point.npz
  host-sim simulate vertebra --slice -0.008 -o vertebra.npz
  host-sim simulate vertebra --mesh L3.ply --slice -0.01 --tissue -o vertebra.npz
  host-sim simulate --config vertebra.npz.config.toml --seed 2 -o again.npz";

impl Arguments {
    /// What the flags say in place of the file's values.
    fn apply(&self, config: &mut config::Simulate) {
        config.phantom = self.phantom.unwrap_or(config.phantom);
        config.offset = self.offset.unwrap_or(config.offset);
        config.mesh = self.mesh.clone().or(config.mesh.take());
        config.slice = self.slice.unwrap_or(config.slice);
        config.depth = self.depth.unwrap_or(config.depth);
        config.tissue |= self.tissue;
        let scanner = config.scanner();
        scanner.noise = match self.noise_free {
            true => None,
            false => self.noise.or(scanner.noise),
        };
        scanner.seed = self.seed.unwrap_or(scanner.seed);
        scanner.focus = self.focus.unwrap_or(scanner.focus);
        scanner.f_number = self.f_number.unwrap_or(scanner.f_number);
        scanner.beams = self.beams.unwrap_or(scanner.beams);
        scanner.first_beam = self.first_beam.unwrap_or(scanner.first_beam);
        scanner.beam_step = self.beam_step.unwrap_or(scanner.beam_step);
        scanner.depth_start = self.depth_start.unwrap_or(scanner.depth_start);
        scanner.depth_end = self.depth_end.unwrap_or(scanner.depth_end);
    }

    /// A flag that would have no effect is a mistake.
    fn refuse_flags_of_the_other(&self, phantom: Kind) -> Result<()> {
        let flags = [
            ("--offset", self.offset.is_some(), Kind::Point),
            ("--mesh", self.mesh.is_some(), Kind::Vertebra),
            ("--slice", self.slice.is_some(), Kind::Vertebra),
            ("--depth", self.depth.is_some(), Kind::Vertebra),
            ("--tissue", self.tissue, Kind::Vertebra),
        ];
        match flags.iter().find(|(_, given, of)| *given && *of != phantom) {
            None => Ok(()),
            Some((flag, ..)) => Err(Error::Usage(format!(
                "{flag} has no effect on the phantom {}",
                match phantom {
                    Kind::Point => "point",
                    Kind::Vertebra => "vertebra",
                }
            ))),
        }
    }
}

/// Runs the command.
///
/// # Errors
/// A parameter out of range, a mesh that is not valid, or an output that cannot be written.
pub fn run(arguments: Arguments) -> Result<()> {
    let mut config = load_config(arguments.config.path.as_deref())?;
    arguments.apply(&mut config.simulate);
    arguments.refuse_flags_of_the_other(config.simulate.phantom)?;
    config.validate()?;

    let config_path = Config::path_beside(&arguments.output);
    let mesh: Vec<&Path> = config.simulate.mesh.as_deref().into_iter().collect();
    check_outputs(&mesh, &[&arguments.output, &config_path])?;

    let scanner = config.simulate.scanner().clone();
    let phantom = config.simulate.build(&scanner)?;
    // One point can be summed exactly at every frequency; for the thousands of a bone that would
    // take hours.
    let summation = match config.simulate.phantom {
        Kind::Point => Summation::Direct,
        Kind::Vertebra => Summation::Gridded,
    };
    let bar = progress_bar("simulating", 1000);
    let progress = |done: f64| bar.set_position((1000.0 * done) as u64);
    let data = channel_data(&scanner, &phantom, summation, &progress)?;
    bar.finish_and_clear();

    let mut outputs = Outputs::new();
    data.stage(&arguments.output, &mut outputs)?;
    config.stage(&command_line(), &config_path, &mut outputs)?;
    outputs.commit()
}
