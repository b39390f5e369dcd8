//! `host-sim info`: a recording's contents, and the lines `beamform` would make.

use std::path::PathBuf;

use clap::Args;
use ndarray::arr0;
use num_complex::Complex;

use super::sequence::{self, SequenceArguments};
use super::{ConfigArgument, VariableArguments, load_config, recording_help};
use crate::config::Config;
use crate::flags::Flags;
use crate::{Error, Result};
use bonebeam_drive::config::{Beamform, Grid};
use bonebeam_drive::delay::DelayStage;
use bonebeam_drive::image::sides_of;
use bonebeam_drive::policy::warnings;
use bonebeam_files::terminal::{digits, one_line, print};
use bonebeam_files::{AlignedData, ChannelData, LineFrames, Recording, Transmits};
use bonebeam_formats::{RecordingFile, tracks};
use bonebeam_tracked::Sequence;

/// Print the contents of a recording or of a tracked sequence.
///
/// Of a recording also the processing that `beamform` would apply.
///
/// It takes the flags of `beamform`. Of several frames it reads the first. A tracked sequence is a file of PLUS or 3D
/// Slicer (.mha, .nrrd), or a folder of PNGs.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, allow_negative_numbers = true)]
pub struct Arguments {
    #[arg(value_name = "FILE", help = recording_help())]
    recording: PathBuf,

    #[command(flatten)]
    variables: VariableArguments,

    #[command(flatten)]
    beamform: Flags<Beamform>,

    #[command(flatten)]
    sequence: SequenceArguments,

    #[command(flatten)]
    config: ConfigArgument,
}

const EXAMPLES: &str = "\
Examples:
  host-sim info recording.hdf5
  host-sim info recording.mat --variable rf=RcvData --variable c=1540
  host-sim info simulation.mat --layout kwave --variable pitch=0.3e-3 --variable f0=5e6
  host-sim info recording.npz --depth-end 0.04
  host-sim info sweep.igs.mha";

/// Runs the command.
///
/// # Errors
/// A recording that is not valid.
pub fn run(arguments: Arguments) -> Result<()> {
    let mut config = load_config(arguments.config.path.as_deref())?;
    arguments.beamform.apply(&mut config.beamform);
    config.beamform.resolve();
    arguments.variables.apply(&mut config.variables)?;
    config.validate()?;
    let mut facts = vec![("file", arguments.recording.display().to_string())];
    if Sequence::recognizes(&arguments.recording) {
        facts.extend(sequence::facts(
            &arguments.sequence.open(&arguments.recording)?,
        ));
        return print_facts(&facts);
    }
    let tracks = tracks(&arguments.recording)?;
    if tracks.len() > 1 && config.variables.get("track").is_none() {
        for [track, label] in tracks {
            let mut variables = config.variables.clone();
            let taken = variables.take(&format!("track={track}"));
            taken.map_err(Error::Usage)?;
            let file = RecordingFile::open(&arguments.recording, &variables);
            let what = file.map_or_else(|e| e.to_string(), |file| of_track(&file));
            facts.push(("track", format!("{track}{label}: {what}")));
        }
        facts.push(("choose", "one by --track NAME".into()));
        return print_facts(&facts);
    }
    let file = RecordingFile::open(&arguments.recording, &config.variables)?;
    facts.push(("format", file.format().name().to_owned()));
    facts.extend(file.assumed().iter().map(|what| ("assumed", what.clone())));
    match file.first() {
        Recording::Channel(data) => {
            facts.extend(of_channel_data(data, file.frames()));
            facts.extend(to_be_done(data, &config));
        }
        Recording::Aligned(data) => {
            facts.extend(of_aligned_data(data, file.frames(), &config.beamform))
        }
        Recording::Lines(lines) => facts.extend(of_lines(lines)),
    }
    let mut unread = file.unread().to_vec();
    if let Some(poses) = file.poses().transpose() {
        let of_poses = |name: &String| {
            name.starts_with("metadata/probe_pose")
                || name.ends_with("time_to_next_transmit")
                || name == "track_schedule"
        };
        unread.retain(|name| !of_poses(name));
        let of = |poses: Vec<Option<Vec<f64>>>| {
            let with = poses.iter().flatten().count();
            format!(
                "of the probe in {with} of {}, for `sweep`",
                count(poses.len(), "frame")
            )
        };
        facts.push(("poses", poses.map_or_else(|e| e.to_string(), of)));
    }
    facts.extend(not_used(&unread));
    print_facts(&facts)
}

fn print_facts(facts: &[Fact]) -> Result<()> {
    let mut text = String::new();
    for (what, fact) in facts {
        text += &format!("{what:<10} {}\n", one_line(fact));
    }
    print(&text)
}

type Fact = (&'static str, String);

fn mm(metres: f64) -> String {
    format!("{:.4}", 1e3 * metres)
        .trim_end_matches('0')
        .trim_end_matches('.')
        .to_owned()
}

fn count(number: usize, of: &str) -> String {
    match number {
        1 => format!("1 {of}"),
        _ => format!("{number} {of}s"),
    }
}

fn mhz(hertz: f64) -> String {
    format!("{} MHz", digits(hertz / 1e6))
}

/// Least and greatest value in `unit`, or the one value.
fn range(values: &[f64], scale: f64, unit: &str) -> String {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // Rounded first: -0.0000 is 0.
    let rounded = |value: f64| (1e4 * scale * value).round() / 1e4 + 0.0;
    let [least, most] = [least, most].map(|value| format!("{:.4}", rounded(value)));
    match least == most {
        true => format!("{least} {unit}"),
        false => format!("{least} to {most} {unit}"),
    }
}

fn of_channel_data(data: &ChannelData, frames: usize) -> Vec<Fact> {
    let (_, transmits, elements, samples) = data.samples.dim();
    let kind = match data.samples.f_demod() {
        None => "RF".to_owned(),
        Some(f_demod) => format!("I/Q demodulated at {}", mhz(f_demod)),
    };
    let mut facts = vec![(
        "holds",
        format!(
            "{kind}: {}, {}, {}, {}",
            count(frames, "frame"),
            count(transmits, "transmit"),
            count(elements, "element"),
            count(samples, "sample")
        ),
    )];
    facts.push((
        "sampled",
        format!(
            "at {}, {:.3} times the centre frequency of {}",
            mhz(data.fs),
            data.fs / data.f0,
            mhz(data.f0)
        ),
    ));
    let [first, last] = data.depths(data.c);
    facts.push((
        "depths",
        format!("{} to {} mm at {} m/s", mm(first), mm(last), digits(data.c)),
    ));
    facts.push(("begins", format!("at {}", range(&data.t0, 1e6, "us"))));
    let shape = if data.is_straight() {
        "straight"
    } else {
        "not straight"
    };
    let pitch = data.pitch();
    facts.push((
        "array",
        format!(
            "{shape}, pitch {} mm ({:.2} wavelengths), x {}",
            mm(pitch),
            pitch * data.f0 / data.c,
            range(&data.element_x, 1e3, "mm")
        ),
    ));
    if data.lens_delay != 0.0 {
        facts.push((
            "lens",
            format!("{} us one way", digits(1e6 * data.lens_delay)),
        ));
    }
    facts.push(("transmits", law_names(&data.transmits)));
    facts
}

/// What one of several tracks holds.
fn of_track(file: &RecordingFile) -> String {
    let Recording::Channel(data) = file.first() else {
        return String::new();
    };
    let mut facts = of_channel_data(data, file.frames());
    facts.retain(|(what, _)| ["holds", "transmits"].contains(what));
    let facts: Vec<String> = facts.into_iter().map(|(_, fact)| fact).collect();
    facts.join("; ")
}

fn law_names(transmits: &Transmits) -> String {
    match transmits {
        Transmits::Focused { x, focus, .. } => format!(
            "focused beams at {}, {} deep",
            range(x, 1e3, "mm"),
            range(focus, 1e3, "mm")
        ),
        Transmits::Plane { angle } => {
            format!(
                "plane waves at {}",
                range(angle, 1f64.to_degrees(), "degrees")
            )
        }
        Transmits::Element { index } => format!("{} single elements", index.len()),
        Transmits::VirtualSource { x, z } => format!(
            "virtual sources at x {}, z {}",
            range(x, 1e3, "mm"),
            range(z, 1e3, "mm")
        ),
        Transmits::Delays { delay } => {
            let fired: Vec<f64> = delay.iter().copied().filter(|d| !d.is_nan()).collect();
            format!("delays of {}", range(&fired, 1e6, "us"))
        }
    }
}

/// The lines that `beamform` would make.
fn to_be_done(data: &ChannelData, config: &Config) -> Vec<Fact> {
    let parameters = &config.beamform;
    let mut facts = Vec::new();
    match DelayStage::new(data, parameters) {
        Ok(stage) => {
            let rate = parameters.rate_of(data);
            let (beams, samples, c) = (stage.beam_x().len(), stage.samples(), stage.sound_speed());
            let [first, last] =
                [0, samples - 1].map(|n| c * (stage.start() + n as f64 / rate) / 2.0);
            facts.push((
                "lines",
                format!(
                    "{beams} of {samples} samples, {} to {} mm, at {} ({:.3} f0), by {}",
                    mm(first),
                    mm(last),
                    mhz(rate),
                    rate / data.f0,
                    parameters.method
                ),
            ));
            facts.extend(sub_lines(&stage));
            let zero = arr0(Complex::ZERO);
            if beams > 1
                && last > first
                && config.image.grid == Grid::Cartesian
                && (stage.pooled().is_some() || stage.sub_lines() == 1)
                && let Some(z) = zero.broadcast((beams, samples))
                && let Ok([rows, columns]) = sides_of(&stage.lines(z), &config.image)
            {
                facts.push(("image", format!("{rows} x {columns} pixels")));
            }
        }
        Err(error) => facts.push(("lines", format!("none: {error}"))),
    }
    match warnings(data, &data.samples.survey(), parameters) {
        Ok(warnings) => facts.extend(warnings.into_iter().map(|warning| ("warning", warning))),
        Err(error) => facts.push(("warning", error.to_string())),
    }
    facts
}

/// Sub-lines, and the loss of a point between two lines.
fn sub_lines(stage: &DelayStage<'_>) -> Option<Fact> {
    let loss = stage.loss_between()?;
    let aligned = stage.rays().len();
    let own = match (stage.sub_lines(), stage.pooled()) {
        (1, _) => "none; a point between two lines".to_owned(),
        (count, None) => {
            format!("{count} per aligned line, of {aligned}; a point between two")
        }
        (count, Some(1)) => {
            format!("{count} per aligned line, of {aligned}; each is a line; a point between two")
        }
        (count, Some(size)) => format!(
            "{count} per aligned line, of {aligned}; each line is the largest of {size}; a point between two"
        ),
    };
    Some(("sub-lines", format!("{own} loses up to about {loss:.1} dB")))
}

/// The arrays that were not read; of many, the first.
fn not_used(names: &[String]) -> Option<Fact> {
    const MOST: usize = 12;
    let more = match names.len().saturating_sub(MOST) {
        0 => String::new(),
        count => format!(" and {count} more"),
    };
    let first = names[..names.len().min(MOST)].join(", ");
    (!names.is_empty()).then(|| ("not used", format!("{first}{more}")))
}

fn of_lines(lines: &LineFrames) -> Vec<Fact> {
    let (frames, beams, samples) = lines.z.dim();
    let [first, last] = [0, samples - 1].map(|n| lines.c * (lines.t0 + n as f64 / lines.fs) / 2.0);
    let counts = [
        count(frames, "frame"),
        count(beams, "beam"),
        count(samples, "sample"),
    ];
    vec![
        ("holds", format!("lines: {}", counts.join(", "))),
        ("sampled", format!("at {}", mhz(lines.fs))),
        (
            "depths",
            format!(
                "{} to {} mm at {} m/s",
                mm(first),
                mm(last),
                digits(lines.c)
            ),
        ),
        ("beams", format!("at {}", range(&lines.beam_x, 1e3, "mm"))),
    ]
}

fn of_aligned_data(data: &AlignedData, frames: usize, parameters: &Beamform) -> Vec<Fact> {
    let (_, beams, samples, elements) = data.x.dim();
    let positions = match &data.beam_x {
        Some(x) => format!("at {}", range(x, 1e3, "mm")),
        None => format!(
            "{} mm apart, by --beam-spacing",
            mm(parameters.beam_spacing)
        ),
    };
    vec![
        (
            "holds",
            format!(
                "aligned data: {}, {}, {}, {}",
                count(frames, "frame"),
                count(beams, "beam"),
                count(samples, "sample"),
                count(elements, "element")
            ),
        ),
        (
            "sampled",
            format!("at {}, from {} us on", mhz(data.fs), digits(1e6 * data.t0)),
        ),
        ("beams", positions),
        (
            "lines",
            format!("{beams} of {samples} samples, by {}", parameters.method),
        ),
    ]
}
