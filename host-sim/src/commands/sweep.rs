//! `host-sim sweep`: a tracked sequence → the bone surface in space.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::PossibleValuesParser;

use super::VariableArguments;
use super::frames::{FrameRange, parse_frames};
use super::sequence::{PlaceArguments, SequenceArguments};
use super::surface_files::Overlay;
use super::surface_inputs::{Found, Source};
use crate::config::Config;
use crate::flags::Flags;
use crate::progress::Progress;
use crate::provenance::{PROGRAM, Snapshot};
use crate::{Error, Result};
use bonebeam_drive::config::Surface;
use bonebeam_drive::methods::MethodName;
use bonebeam_drive::surface::Verdict;
use bonebeam_files::atomic::{Outputs, check_outputs};
use bonebeam_files::terminal::{print, remark, short, warn};
use bonebeam_files::{file_error, image};
use bonebeam_formats::{RecordingFile, is_hdf5};
use bonebeam_tracked::{
    Cloud, Delay, Finder, Sequence, Settings, Space, Track, add_cloud_to, check_name, sweep, views,
};

/// Find the bone surface in a tracked sweep.
///
/// The points are in the frame of a tracker's reference or of a CT.
///
/// SEQUENCE is a file of PLUS or 3D Slicer (.mha, .nrrd), a folder of PNGs with a table of poses, or a recording of zea
/// with poses (probe_pose), which is beamformed by das. A point of a picture (column, row, 0, 1) is mapped by
/// ImageToProbe and the sequence's transforms; of a recording, x = along the array, z = depth. Frames without a picture, with
/// a pose that is missing or not OK, and frames that jump are left out and counted; so are points that none of at least
/// three frames nearby shows. An interrupted run of more than ten
/// seconds resumes from BONE.ply.partial.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, allow_negative_numbers = true)]
pub struct Arguments {
    /// Tracked sequence
    #[arg(value_name = "SEQUENCE")]
    input: PathBuf,

    /// Points, written as .ply, .vtp, .vtk, .csv or .mrk.json, in mm
    ///
    /// .ply, .vtp, .vtk and .csv: positions, normals towards the probe, confidence, frame and line; .ply and .csv also the
    /// sound's way to the point (px, py, pz). .mrk.json: at most 1000 fiducials for 3D Slicer.
    #[arg(short, long, value_name = "BONE.ply")]
    output: PathBuf,

    /// Axes of the frame of reference, written into the files; positions are not changed
    ///
    /// 3D Slicer shows the frames of PLUS as RAS. Frames of a CT are LPS by DICOM.
    #[arg(long, value_name = "LPS|RAS", value_parser = PossibleValuesParser::new(["LPS", "RAS"]), default_value = "RAS")]
    space: String,

    /// Frames A to B−1, or frame A alone: A..B or A [default: all]
    #[arg(long, value_name = "A..B", value_parser = parse_frames)]
    frames: Option<FrameRange>,

    /// Use every Nth frame
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    every: u32,

    /// Deviation of a picture from the median of five frames that is a jump, m; up to four usual steps are none
    #[arg(long, value_name = "M", default_value_t = 0.005)]
    jump: f64,

    /// Distance within which points of different frames are joined, m; 0 joins none
    #[arg(long, value_name = "M", default_value_t = 0.0001)]
    join: f64,

    /// Delay of the pictures behind the poses, in the unit of the timestamps (s by PLUS), or `estimate`
    ///
    /// A picture of time t has the pose of t minus the delay, interpolated between frames. The estimate is the delay at
    /// which passes over the same bone agree best, within eight frames; a sweep without such passes is refused.
    #[arg(long, value_name = "TIME|estimate", value_parser = parse_delay, default_value = "0")]
    delay: Delay,

    /// Also write a picture of the points from three sides: x and y, x and z, y and z
    #[arg(long, value_name = "VIEWS.png")]
    image: Option<PathBuf>,

    /// Also write the middle one of the searched frames with the surface drawn over it
    #[arg(long, value_name = "FRAME.png")]
    overlay: Option<PathBuf>,

    #[command(flatten)]
    place: PlaceArguments,

    #[command(flatten)]
    sequence: SequenceArguments,

    #[command(flatten)]
    variables: VariableArguments,

    #[command(flatten)]
    surface: Flags<Surface>,
}

const EXAMPLES: &str = "\
Examples:
  host-sim sweep sweep.igs.mha --calibration PlusConfiguration.xml -o bone.ply --image views.png
  host-sim sweep sweep.seq.nrrd --calibration ImageToProbe.json --to Tracker -o bone.mrk.json
  host-sim sweep UltrasoundImages --poses tracking.csv --euler xyz --pose-unit mm --angle-unit degrees \\
      --calibration 26.4,-0.5,128.0,92.5,-0.5,179.2 --pixel-size 0.00005392 --space LPS -o bone.ply";

fn parse_delay(text: &str) -> std::result::Result<Delay, String> {
    match (text, text.parse::<f64>()) {
        ("estimate", _) => Ok(Delay::Estimated),
        (_, Ok(delay)) if delay.is_finite() => Ok(Delay::Known(delay)),
        _ => Err("expected a time or estimate".into()),
    }
}

/// Runs the command.
///
/// # Errors
/// A flag out of range, a sequence or a calibration that is not valid, or an output that cannot be written.
pub fn run(arguments: Arguments) -> Result<()> {
    check_name(&arguments.output)?;
    let pictures = [&arguments.image, &arguments.overlay].map(Option::as_deref);
    let pictures: Vec<&Path> = pictures.into_iter().flatten().collect();
    for path in &pictures {
        if image::Format::of(path)? != image::Format::Png {
            let message = format!("{}: expected a name that ends in .png", path.display());
            return Err(Error::Usage(message));
        }
    }
    let outputs: Vec<&Path> = pictures
        .into_iter()
        .chain([arguments.output.as_path()])
        .collect();
    check_outputs(&[&arguments.input], &outputs)?;
    let mut section = Surface::default();
    arguments.surface.apply(&mut section);
    section.validate()?;
    if section.sweep_step.is_some() {
        return Err(Error::Usage(
            "--sweep-step has no effect on a tracked sweep".into(),
        ));
    }
    let mm = |flag: &str, metres: f64| match (0.0..=1.0).contains(&metres) {
        true => Ok(1e3 * metres),
        false => Err(Error::Usage(format!(
            "--{flag} is {}; expected 0 to 1 (m)",
            short(metres)
        ))),
    };
    let pixel = arguments.place.pixel()?;

    let snapshot = Snapshot::of(&arguments.input)?;
    let mut config = Config::default();
    arguments.variables.apply(&mut config.variables)?;
    let is_recording = is_hdf5(&arguments.input);
    let sequence = match is_recording {
        true => {
            let poses = RecordingFile::open(&arguments.input, &config.variables)?.poses()?;
            let none = "has no poses of the probe; expected a recording of zea with them";
            let poses = poses.ok_or_else(|| file_error(&arguments.input, none))?;
            Sequence::of_recording(&arguments.input, &poses)
        }
        false => arguments.sequence.open(&arguments.input)?,
    };
    for what in &sequence.assumed {
        remark(&format!("{}: {what}", arguments.input.display()));
    }
    let euler = arguments.sequence.euler();
    let calibration = arguments.place.calibration(euler)?;
    let jump = mm("jump", arguments.jump)?;
    let track = Track::of(
        &sequence,
        &calibration,
        arguments.place.target(),
        pixel,
        jump,
    )?;
    let range = FrameRange::of(arguments.frames.as_ref(), sequence.frames.len())?;
    let settings = Settings {
        surface: section,
        frames: range.step_by(arguments.every as usize).collect(),
        crop: arguments.place.part(),
        join: mm("join", arguments.join)?,
        delay: arguments.delay,
        resumable: Some((arguments.output.clone(), PROGRAM)),
    };
    let ((cloud, partial), drawn) = match is_recording {
        true => {
            config.surface = settings.surface.clone();
            let (cloud, drawn) = arguments.of_recording(config, &track, &settings, &snapshot)?;
            ((cloud, None), drawn)
        }
        false => {
            let bar = Progress::new("searching", 1000);
            let cloud = sweep(&sequence, &track, &settings, &|share| {
                bar.set((1000.0 * share) as u64, 1000)
            });
            bar.clear();
            (cloud?, None)
        }
    };
    snapshot.check()?;
    if let Some([delay, deviation]) = cloud.delay {
        let within = 1.96 * deviation;
        remark(&format!(
            "{}: pictures are {delay:.4} behind their poses, {:.4} to {:.4}",
            arguments.input.display(),
            delay - within,
            delay + within
        ));
    }

    let space = if arguments.space == "LPS" {
        Space::Lps
    } else {
        Space::Ras
    };
    let mut outputs = Outputs::new();
    add_cloud_to(&cloud, space, &arguments.output, &mut outputs)?;
    if let Some(path) = &arguments.image {
        image::add_colours_to(&views(&cloud.points), path, &mut outputs)?;
    }
    let mut why = None;
    let drawn = match drawn {
        None if !is_recording && (arguments.overlay.is_some() || cloud.points.is_empty()) => {
            let (drawn, verdict) = overlay(&sequence, &track, &settings)?;
            why = cloud.points.is_empty().then_some(verdict);
            Some(drawn)
        }
        drawn => drawn,
    };
    if let (Some(path), Some(drawn)) = (&arguments.overlay, drawn) {
        drawn.add_to(path, &mut outputs)?;
    }
    outputs.commit()?;
    if let Some(partial) = partial {
        partial.finish();
    }
    if let Some(verdict) = why {
        warn(&format!("no bone in any frame; the middle one: {verdict}"));
    }
    print(&format!("{}\n", summary(&cloud, space)))
}

impl Arguments {
    /// The bone in the frames of a recording, and the first of them with its surface.
    fn of_recording(
        &self,
        mut config: Config,
        track: &Track,
        settings: &Settings,
        snapshot: &Snapshot,
    ) -> Result<(Cloud, Option<Overlay>)> {
        if self.delay != Delay::Known(0.0) {
            let message = "--delay has no effect on a recording, whose poses have times";
            return Err(Error::Usage(message.into()));
        }
        config.beamform.method = MethodName::Das;
        config.beamform.resolve();
        config.validate()?;
        let of_picture = self
            .surface
            .given()
            .find(|(_, heading)| *heading == "Picture");
        let of_picture = self.place.given().or(of_picture.map(|(flag, _)| flag));
        let found = Found::of(
            &Source {
                path: &self.input,
                crop: None,
                frames: self.frames.as_ref(),
                hash: None,
                every: self.every as usize,
                drawn: self.overlay.is_some(),
                of_picture,
            },
            &config,
            snapshot,
        )?;
        let cloud = Cloud::of_surfaces(track, settings, &found.frames, &found.starts);
        let points = found.frames.first().map_or(&[][..], |frame| &frame.points);
        let drawn = found.picture.as_ref();
        Ok((
            cloud,
            drawn.map(|picture| Overlay::of(picture, None, points, Overlay::colour)),
        ))
    }
}

/// The middle one of the searched frames with its surface, and how sure this is.
fn overlay(sequence: &Sequence, track: &Track, settings: &Settings) -> Result<(Overlay, Verdict)> {
    let frames = track.usable(&settings.frames);
    let finder = Finder::new(sequence, track, (&settings.surface, settings.crop), &frames)?;
    let (frame, _) = frames[frames.len() / 2];
    let encoded = sequence.reader()?.frame(frame)?;
    let pixels = finder.part_of(sequence.picture(encoded)?);
    let found = finder.search(&pixels)?;
    let picture = finder.image(pixels);
    let (fan, points) = (found.fan.as_ref(), &found.points);
    let drawn = Overlay::of(&picture, fan, points, Overlay::colour);
    Ok((drawn, found.verdict))
}

/// One line for the terminal.
fn summary(cloud: &Cloud, space: Space) -> String {
    let [searched, with] = cloud.searched;
    let left_out: Vec<String> = cloud
        .left_out
        .iter()
        .map(|(reason, count)| format!("{count} ({reason})"))
        .collect();
    let left_out = match left_out.is_empty() {
        true => "none".to_owned(),
        false => left_out.join(", "),
    };
    let resumed = match cloud.resumed {
        0 => String::new(),
        resumed => format!(" ({resumed} of them from an interrupted run)"),
    };
    format!(
        "{} points of bone in {with} of {searched} frames{resumed}, in the frame {} ({}), {} joined, {} left out that no neighbouring frame shows, {} of unsure pieces that neighbours show; frames left out: {left_out}; lines are {}",
        cloud.points.len(),
        cloud.target,
        space.name(),
        cloud.joined,
        cloud.alone,
        cloud.confirmed,
        if cloud.fan.is_some() {
            "beams of a fan"
        } else {
            "columns"
        }
    )
}
