//! `host-sim simulate`: phantom → channel data.

use std::borrow::Cow;
use std::iter::once;
use std::path::{Path, PathBuf};

use clap::Args;

use super::{ConfigArgument, command_line, load_config};
use crate::config::Config;
use crate::flags::SimulateFlags;
use crate::progress::Progress;
use crate::provenance::Snapshot;
use crate::{Error, Result};
use bonebeam_files::atomic::{Outputs, check_outputs};
use bonebeam_files::terminal::warn;
use bonebeam_files::{Recording, add_surface_to};
use bonebeam_simulate::Checkpoint;

/// Simulate channel data of a point, of bone in water or tissue, or known levels.
///
/// A linear array sends one focused beam per element and records every element. Array, pulse, transmits and record
/// are the paper's unless flags change them. No sound passes through bone: an element receives echoes only of the
/// surfaces that it sees.
///
/// The configuration used is written beside the channel data as FILE.npz.config.toml; its section
/// [simulate.scanner] has all settings of the scanner. The imaged object is written as FILE.npz.truth.npz, a bone's
/// surface as FILE.npz.surface.ply. An interrupted run of one frame resumes from FILE.npz.partial.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, allow_negative_numbers = true)]
pub struct Arguments {
    #[command(flatten)]
    simulate: SimulateFlags,

    /// File for the channel data
    ///
    /// Keys: `rf` float32 [transmit, element, sample] (or `iq`, `f_demod`), `fs`, `t0`, `element_x`, `c`, `f0`,
    /// `tx_x`, `tx_focus`, `tx_fnumber`. The samples of a sweep have a first axis for the frame.
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
  host-sim simulate vertebra-3d --slice -0.004 --tissue -o tissue.npz
  host-sim simulate vertebra-3d --mesh L3.stl --reverberation -25 --clutter -50 -o bath.npz
  host-sim simulate vertebra-3d --sweep 13 --sweep-step 0.0005 --iq -o sweep.npz
  host-sim simulate facet-joint --depth 0.025 --attenuation 0.5 --adc-bits 12 -o joint.npz
  host-sim simulate dynamic-range --element-height 0.004 --elevation-focus 0.025 -o levels.npz
  host-sim simulate --config vertebra.npz.config.toml --seed 2 -o again.npz";

/// Runs the command.
///
/// # Errors
/// A parameter out of range, a mesh that is not valid, or an output that cannot be written.
pub fn run(arguments: Arguments) -> Result<()> {
    let mut config = load_config(arguments.config.path.as_deref())?;
    arguments.simulate.apply(&mut config.simulate)?;
    config.validate()?;

    let config_path = Config::path_beside(&arguments.output);
    let [truth, surface, partial] = ["truth.npz", "surface.ply", "partial"].map(|ending| {
        let mut name = arguments.output.as_os_str().to_owned();
        name.push(".");
        name.push(ending);
        PathBuf::from(name)
    });
    let mesh = config.simulate.mesh.clone();
    let mesh: Vec<&Path> = mesh.as_deref().into_iter().collect();
    check_outputs(&mesh, &[&arguments.output, &config_path, &truth, &surface])?;

    let snapshots = mesh.iter().map(|mesh| Snapshot::of(mesh));
    let snapshots = snapshots.collect::<Result<Vec<_>>>()?;
    let scanner = config.simulate.scanner().clone();
    let built = config.simulate.build(&scanner, &|| ())?;
    built.warnings.iter().for_each(|warning| warn(warning));
    let phantom = built.phantom;
    let frames = config.simulate.sweep;
    let mut checkpoint = match frames {
        1 => Checkpoint::new(&partial, &scanner, &phantom)?,
        _ => Checkpoint::none(),
    };
    let bar = Progress::new("simulating", 1000);
    let mut record = |frame: usize| {
        let of_all = |done: f64| 1000.0 * (frame as f64 + done) / frames as f64;
        let progress = |done: f64| bar.set(of_all(done) as u64, 1000);
        let section = &config.simulate;
        let data = section.record(&scanner, &phantom, frame, &progress, &mut checkpoint);
        let data = data?;
        data.check().map_err(Error::Data)?;
        Ok(Recording::Channel(data))
    };
    let first = record(0)?;
    let mut outputs = Outputs::new();
    let others = (1..frames).map(|frame| record(frame).map(|data| (Cow::Owned(data), 0..1)));
    let parts = once(Ok((Cow::Borrowed(&first), 0..1))).chain(others);
    first.add_npz_to(frames, parts, &arguments.output, &mut outputs)?;
    bar.clear();

    let inputs = snapshots.iter().map(Snapshot::hashed);
    let inputs = inputs.collect::<Result<Vec<_>>>()?;
    config.add_to(&command_line(), &inputs, &config_path, &mut outputs)?;
    config
        .simulate
        .truth(&phantom)
        .add_to(&truth, &mut outputs)?;
    if let Some(bone) = &phantom.surface {
        add_surface_to(&surface, bone.vertices(), bone.triangles(), &mut outputs)?;
    }
    outputs.commit()?;
    checkpoint.finish();
    Ok(())
}
