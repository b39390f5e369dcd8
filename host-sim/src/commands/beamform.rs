//! `host-sim beamform`: channel data or aligned data → beamformed lines, and an image of them.

use std::path::PathBuf;

use clap::Args;

use super::{ConfigArgument, about, command_line, load_config, progress_bar};
use crate::config::{Beamform, Config, Image, Method};
use crate::drive::beamform::Covariance;
use crate::drive::frame::{beamform_aligned_data, beamform_channel_data};
use crate::drive::image::{PixelGrid, b_mode, check_beams};
use crate::files::atomic::{Outputs, check_outputs};
use crate::files::image::{self, Format};
use crate::files::{Lines, Recording, Transmits};
use crate::{Error, Result};

/// Beamform channel data: one complex value a beam and depth.
///
/// FILE.npz holds channel data (`rf` …), which are delayed first, or aligned data (`x` …), which
/// are not. Focused transmits make one line each; plane waves and single-element transmits are
/// compounded into two lines per element. The configuration used is written beside the lines as
/// LINES.npz.config.toml.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, allow_negative_numbers = true)]
pub struct Arguments {
    /// The recording
    #[arg(value_name = "FILE.npz")]
    recording: PathBuf,

    /// The beamformed lines: `z` complex64 [beam, sample], `fs`, `t0`, `beam_x`, `c`
    #[arg(short, long, value_name = "LINES.npz")]
    output: PathBuf,

    /// The beamformer [default: esmv-rank1]
    #[arg(long, value_enum, help_heading = "Beamformer")]
    method: Option<Method>,

    /// With esmv: the share of the power that the signal subspace keeps (Eq. 8), above 0 and at
    /// most 1 [default: 0.01]
    #[arg(long, help_heading = "Beamformer")]
    beta: Option<f64>,

    /// With esmv: a fixed rank of the signal subspace instead of --beta
    #[arg(long, help_heading = "Beamformer")]
    rank: Option<usize>,

    /// With esmv-rank1: all eigenvectors but the first, as in Fig. 2c of the paper
    #[arg(long, help_heading = "Beamformer")]
    exclude_first: bool,

    /// Length of the subapertures over the number of active elements, above 0 and at most 1
    /// [default: 0.5]
    #[arg(long, value_name = "RATIO", help_heading = "Beamformer")]
    subaperture_ratio: Option<f64>,

    /// Average the covariance over K samples before and K after, at most 31 [default: 0]
    #[arg(long, value_name = "K", help_heading = "Beamformer")]
    temporal_half_window: Option<usize>,

    /// Covariance of Eq. 2 or of Eq. 3 [default: forward-backward]
    #[arg(long, value_enum, help_heading = "Beamformer")]
    covariance: Option<Covariance>,

    /// Diagonal loading, in shares of the mean eigenvalue [default: 0.05]
    #[arg(long, value_name = "DELTA", help_heading = "Beamformer")]
    diagonal_loading: Option<f64>,

    /// Receive f-number, depth over aperture [default: 1.5]
    #[arg(long, help_heading = "Delay (channel data only)")]
    f_number: Option<f64>,

    /// Active elements at the least [default: 8]
    #[arg(long, value_name = "N", help_heading = "Delay (channel data only)")]
    min_elements: Option<usize>,

    /// Sampling rate of the lines, Hz [default: 20e6]
    #[arg(long, value_name = "HZ", help_heading = "Delay (channel data only)")]
    output_rate: Option<f64>,

    /// Shallowest depth of the lines, m [default: where the record begins]
    #[arg(long, value_name = "M", help_heading = "Delay (channel data only)")]
    depth_start: Option<f64>,

    /// Greatest depth of the lines, m [default: where the record ends]
    #[arg(long, value_name = "M", help_heading = "Delay (channel data only)")]
    depth_end: Option<f64>,

    /// Speed of sound, m/s [default: the file's; 1540 for aligned data]
    #[arg(long, value_name = "M/S")]
    sound_speed: Option<f64>,

    /// Distance between the beams of aligned data that do not tell `beam_x`, m [default: 0.308e-3]
    #[arg(long, value_name = "M")]
    beam_spacing: Option<f64>,

    /// Also an image of the lines: 0 to 255, as .png or .npy
    #[arg(long, value_name = "IMG.png", help_heading = "Image")]
    image: Option<PathBuf>,

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

    #[command(flatten)]
    config: ConfigArgument,
}

const EXAMPLES: &str = "\
Examples:
  host-sim beamform channels.npz --method das -o das.npz --image das.png
  host-sim beamform channels.npz --method esmv --beta 0.00001 --temporal-half-window 10 -o lines.npz
  host-sim beamform channels.npz --method esmv-rank1 --depth-start 0.005 --depth-end 0.04 \\
      -o lines.npz --image bone.png --dynamic-range 60
  host-sim beamform delayed.npz --method mv --covariance forward -o lines.npz
  host-sim beamform channels.npz --config lines.npz.config.toml -o again.npz";

impl Arguments {
    /// What the flags say in place of the file's values.
    fn apply(&self, config: &mut Config) {
        self.apply_method(&mut config.beamform);
        let Config {
            beamform: b,
            image: i,
            ..
        } = config;
        b.subaperture_ratio = self.subaperture_ratio.unwrap_or(b.subaperture_ratio);
        b.temporal_half_window = self.temporal_half_window.unwrap_or(b.temporal_half_window);
        b.covariance = self.covariance.unwrap_or(b.covariance);
        b.diagonal_loading = self.diagonal_loading.unwrap_or(b.diagonal_loading);
        b.f_number = self.f_number.unwrap_or(b.f_number);
        b.min_elements = self.min_elements.unwrap_or(b.min_elements);
        b.output_rate = self.output_rate.unwrap_or(b.output_rate);
        b.depth_start = self.depth_start.or(b.depth_start);
        b.depth_end = self.depth_end.or(b.depth_end);
        b.sound_speed = self.sound_speed.or(b.sound_speed);
        b.beam_spacing = self.beam_spacing.unwrap_or(b.beam_spacing);
        i.dynamic_range = self.dynamic_range.unwrap_or(i.dynamic_range);
        i.depth = self.depth.or(i.depth);
        i.width = self.width.or(i.width);
        i.rows = self.rows.unwrap_or(i.rows);
        i.columns = self.columns.unwrap_or(i.columns);
        i.median |= self.median;
    }

    /// The method and its rank rule belong together: a flag that changes one of them takes back
    /// what the file says about the others where both cannot hold.
    fn apply_method(&self, b: &mut Beamform) {
        if let Some(method) = self.method {
            if method != b.method {
                (b.beta, b.rank, b.exclude_first) = (None, None, false);
            }
            b.method = method;
        }
        if self.beta.is_some() || self.rank.is_some() {
            (b.beta, b.rank) = (self.beta, self.rank);
        }
        b.exclude_first |= self.exclude_first;
    }

    /// A flag that would have no effect is a mistake.
    fn refuse_flags_without_effect(&self, recording: &Recording) -> Result<()> {
        let spacing = ("--beam-spacing", self.beam_spacing.is_some());
        let delay = vec![
            ("--f-number", self.f_number.is_some()),
            ("--min-elements", self.min_elements.is_some()),
            ("--output-rate", self.output_rate.is_some()),
            ("--depth-start", self.depth_start.is_some()),
            ("--depth-end", self.depth_end.is_some()),
        ];
        let (flags, holds) = match recording {
            Recording::Channel(_) => (vec![spacing], "channel data"),
            Recording::Aligned(data) if data.beam_x.is_some() && spacing.1 => {
                (vec![spacing], "the beams' positions")
            }
            Recording::Aligned(_) => (delay, "aligned data"),
        };
        match flags.iter().find(|(_, given)| *given) {
            None => Ok(()),
            Some((flag, _)) => Err(Error::Usage(format!(
                "{flag} has no effect on {}, which holds {holds}",
                self.recording.display()
            ))),
        }
    }
}

/// Runs the command.
///
/// # Errors
/// A parameter out of range, a recording that is not valid, or an output that cannot be written.
pub fn run(arguments: Arguments) -> Result<()> {
    let mut config = load_config(arguments.config.path.as_deref())?;
    arguments.apply(&mut config);
    config.beamform.resolve();
    config.validate()?;

    let config_path = Config::path_beside(&arguments.output);
    let mut outputs = vec![arguments.output.as_path(), &config_path];
    if let Some(path) = &arguments.image {
        Format::of(path)?;
        outputs.push(path);
    }
    check_outputs(&[&arguments.recording], &outputs)?;

    let recording = Recording::read(&arguments.recording)?;
    arguments.refuse_flags_without_effect(&recording)?;
    if arguments.image.is_some()
        && let Some(beam_x) = told_beams(&recording)
    {
        check_beams(beam_x).map_err(|e| about(&arguments.recording, e))?;
    }
    let bar = progress_bar("beamforming", 1000);
    let progress = |done: f64| bar.set_position((1000.0 * done) as u64);
    let lines = match &recording {
        Recording::Channel(data) => beamform_channel_data(data, &config.beamform, &progress),
        Recording::Aligned(data) => beamform_aligned_data(data, &config.beamform, &progress),
    }
    .map_err(|e| about(&arguments.recording, e))?;
    bar.finish_and_clear();

    let mut outputs = Outputs::new();
    lines.stage(&arguments.output, &mut outputs)?;
    if let Some(path) = &arguments.image {
        let image = image_of(&lines, &config.image).map_err(|e| about(&arguments.recording, e))?;
        image::stage(&image.pixels, path, &mut outputs)?;
    }
    config.stage(&command_line(), &config_path, &mut outputs)?;
    outputs.commit()
}

/// Where the beams lie, if the recording tells it: else they are evenly spaced.
fn told_beams(recording: &Recording) -> Option<&[f64]> {
    match recording {
        Recording::Channel(data) => match &data.transmits {
            Transmits::Focused { x, .. } => Some(x),
            Transmits::Plane { .. } | Transmits::Element { .. } => None,
        },
        Recording::Aligned(data) => data.beam_x.as_deref(),
    }
}

/// The B-mode image over the depths and the width asked for.
fn image_of(lines: &Lines, parameters: &Image) -> Result<crate::drive::image::Image> {
    let (rows, columns) = (parameters.rows, parameters.columns);
    let [first, last] = [0, lines.z.ncols() - 1]
        .map(|sample| lines.c * (lines.t0 + sample as f64 / lines.fs) / 2.0);
    if let Some(depth) = parameters.depth.filter(|&depth| depth <= first) {
        return Err(Error::Usage(format!(
            "--depth is {depth} m; expected more than {first} m, where the lines begin"
        )));
    }
    let bottom = parameters.depth.unwrap_or(last);
    let beams = [lines.beam_x[0], lines.beam_x[lines.beam_x.len() - 1]];
    let across = match parameters.width {
        Some(width) => {
            let centre = (beams[0] + beams[1]) / 2.0;
            [centre - width / 2.0, centre + width / 2.0]
        }
        None => beams,
    };
    let grid = PixelGrid::cover(across, [first, bottom], rows, columns);
    b_mode(
        lines,
        parameters.dynamic_range as f32,
        &grid,
        parameters.median,
    )
}
