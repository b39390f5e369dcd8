//! `host-sim simulate`: phantom → channel data.

use std::path::{Path, PathBuf};

use clap::Args;

use super::{ConfigArgument, command_line, load_config, progress_bar};
use crate::Result;
use crate::config::{Config, Kind, Simulate, SimulateFlags};
use crate::files::ChannelData;
use crate::files::atomic::{Outputs, check_outputs};
use crate::simulate::{Summation, channel_data, demodulate};

/// Simulate the channel data of a point or of a vertebra.
///
/// A linear array sends one focused beam per element (the paper's array, pulse, transmit and
/// record, unless told otherwise) and records every element. Bone attenuates totally: an element
/// hears only what it sees. The configuration used is written beside the channel data as
/// FILE.npz.config.toml; its section [simulate.scanner] has all settings of the scanner.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, allow_negative_numbers = true)]
pub struct Arguments {
    #[command(flatten)]
    simulate: SimulateFlags,

    /// The channel data: `rf` float32 [transmit, element, sample] (or `iq`, `f_demod`), `fs`, `t0`, `element_x`, `c`,
    /// `f0`, `tx_x`, `tx_focus`, `tx_fnumber`
    #[arg(short, long, value_name = "FILE.npz")]
    output: PathBuf,

    #[command(flatten)]
    config: ConfigArgument,
}

const EXAMPLES: &str = "\
Examples:
  host-sim simulate point -o point.npz
  host-sim simulate point --offset 0.000154 --noise -60 -o point.npz
  host-sim simulate point --iq -o iq.npz
  host-sim simulate vertebra --slice -0.008 -o vertebra.npz
  host-sim simulate vertebra --mesh L3.ply --slice -0.01 --tissue -o vertebra.npz
  host-sim simulate --config vertebra.npz.config.toml --seed 2 -o again.npz";

/// Runs the command.
///
/// # Errors
/// A parameter out of range, a mesh that is not valid, or an output that cannot be written.
pub fn run(arguments: Arguments) -> Result<()> {
    let mut config = load_config(arguments.config.path.as_deref())?;
    config.simulate.apply(&arguments.simulate)?;
    config.validate()?;

    let config_path = Config::path_beside(&arguments.output);
    let mesh: Vec<&Path> = config.simulate.mesh.as_deref().into_iter().collect();
    check_outputs(&mesh, &[&arguments.output, &config_path])?;

    let bar = progress_bar("simulating", 1000);
    let progress = |done: f64| bar.set_position((1000.0 * done) as u64);
    let data = recorded(&mut config.simulate, &progress)?;
    bar.finish_and_clear();

    let mut outputs = Outputs::new();
    data.stage(&arguments.output, &mut outputs)?;
    config.stage(&command_line(), &config_path, &mut outputs)?;
    outputs.commit()
}

/// The channel data of the section. `progress` hears the fraction done, from any thread.
///
/// # Errors
/// A mesh that is not valid, a phantom outside the record, or a record that takes too much memory.
pub fn recorded(section: &mut Simulate, progress: &(dyn Fn(f64) + Sync)) -> Result<ChannelData> {
    let scanner = section.scanner().clone();
    let phantom = section.build(&scanner)?;
    // One point can be summed exactly at every frequency; for the thousands of a bone that would
    // take hours.
    let summation = match section.phantom {
        Kind::Point => Summation::Direct,
        Kind::Vertebra => Summation::Cells,
    };
    let data = channel_data(&scanner, &phantom, summation, progress)?;
    Ok(match section.iq {
        true => demodulate(data),
        false => data,
    })
}
