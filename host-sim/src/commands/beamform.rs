//! `host-sim beamform`: channel data or aligned data → lines and an image.

use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use twox_hash::XxHash3_128;

use super::check::{EstimateArgument, warn_of};
use super::frames::{FrameRange, parse_frames};
use super::measures::{Measures, summary_of_lines};
use super::phase_symmetry::chosen_scales;
use super::{ConfigArgument, VariableArguments};
use super::{about, command_line, load_config, recording_help, tell_assumed};
use crate::config::Config;
use crate::flags::{Flags, choice};
use crate::progress::Progress;
use crate::provenance::{PROGRAM, Snapshot};
use crate::{Error, Result};
use bonebeam::phase_symmetry::scale_for_display;
use bonebeam_drive::coherence::{self, Measure};
use bonebeam_drive::config::{Beamform, DELAY, Image, PhaseSymmetry, PixelSize};
use bonebeam_drive::frame::RecordingFrames;
use bonebeam_drive::image::{BModeImage, check_beams, image_of, square_side, squared};
use bonebeam_drive::phase_symmetry;
use bonebeam_drive::policy::{Pictures, working_memory};
use bonebeam_drive::surface::{FrameSurface, Kind, add_surfaces_to, of_recording};
use bonebeam_files::atomic::{Outputs, check_outputs};
use bonebeam_files::image::{self, Format};
use bonebeam_files::memory;
use bonebeam_files::terminal::print;
use bonebeam_files::{BeamformedLines, PartialFrames, Recording, Transmits};
use bonebeam_formats::{Blocks, RecordingFile};
use bonebeam_report::page::figure;

/// Beamform channel data: one complex value per line and depth.
///
/// FILE holds channel data, aligned data (`x` …) as .npz, which are not delayed again, or lines (`z` or `lines` …), of
/// which images, bone map and surface are made. Focused transmits make
/// one line each, from left to right; those at one position are averaged. So do virtual sources in front of the array
/// if none is behind another. Other transmits are compounded into two lines per element: straight down, along the normals of a curved array, or in a
/// sector. With an adaptive method, lines are up to 0.1 mm apart, and each is the largest of several directions
/// (--sub-lines), so that echoes between two lines are kept.
///
/// The configuration used is written beside the lines as LINES.npz.config.toml, with the program's version and
/// commit and the recording's hash. An interrupted run over many frames resumes from LINES.npz.partial.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES, allow_negative_numbers = true)]
pub struct Arguments {
    #[arg(value_name = "FILE", help = recording_help())]
    recording: PathBuf,

    /// File for the beamformed lines
    ///
    /// Keys: `z` complex64 [beam, sample] ([frame, beam, sample] for several frames), `fs`, `t0`, `beam_x`, `c`,
    /// and `beam_z`, `beam_angle` of lines that do not go straight down. Needed unless FILE holds lines.
    #[arg(short, long, value_name = "LINES.npz")]
    output: Option<PathBuf>,

    #[command(flatten)]
    variables: VariableArguments,

    #[command(flatten)]
    estimate: EstimateArgument,

    /// Print the run's measures as JSON
    #[arg(long)]
    json: bool,

    #[command(flatten)]
    config: ConfigArgument,

    #[command(flatten)]
    beamform: Flags<Beamform>,

    /// Frames A to B−1, or frame A alone: A..B, A.. or A [default: all]
    #[arg(long, value_name = "A..B", value_parser = parse_frames)]
    frames: Option<FrameRange>,

    /// Also write an image of the first frame: .png, .npy or .svg
    ///
    /// The .png and .npy have grey levels from 0 to 255. The .svg also has axes in mm and a grey bar in dB.
    #[arg(long, value_name = "IMG.png", help_heading = "Image")]
    image: Option<PathBuf>,

    #[command(flatten)]
    image_flags: Flags<Image>,

    /// Also write the phase symmetry of the first frame's image: .npy or .png
    ///
    /// The filter reads the grey levels before they are rounded. The .npy is float32 [row, column]; the largest
    /// value of the .png is 255. Without --rows, --columns and --resize, --pad is set.
    #[arg(long, value_name = "MAP.npy", help_heading = "Bone map")]
    bone_map: Option<PathBuf>,

    #[command(flatten, next_help_heading = "Bone map")]
    phase_symmetry: Flags<PhaseSymmetry>,

    /// Also write the bone surface of the first frame: .csv, .json, .ply or .vtp
    ///
    /// The file is as `host-sim surface` writes it. Parameters come from the section [surface] of --config.
    #[arg(long, value_name = "SURFACE.csv", help_heading = "Bone surface")]
    surface: Option<PathBuf>,

    /// Also write the coherence of the samples of the first frame: .npy
    ///
    /// float32 [beam, sample], as the lines. Clutter and noise have values near the minimum, tissue and bone have
    /// higher ones.
    #[arg(long, value_name = "MAP.npy", help_heading = "Coherence")]
    coherence: Option<PathBuf>,

    /// The measure of --coherence [default: short-lag]
    ///
    /// --surface has short-lag coherence with either.
    #[arg(
        long,
        value_name = "MEASURE",
        value_parser = choice::<Measure>(),
        requires = "coherence",
        help_heading = "Coherence"
    )]
    coherence_of: Option<Measure>,
}

const EXAMPLES: &str = "\
Examples:
  host-sim beamform channels.npz --method das -o das.npz --image das.png
  host-sim beamform channels.npz --method esmv --beta 0.00001 --temporal-half-window 10 -o lines.npz
  host-sim beamform channels.npz --method esmv-rank1 --depth-start 0.005 --depth-end 0.04 \\
      -o lines.npz --image bone.png --dynamic-range 60
  host-sim beamform channels.npz --power-steps 8 --adaptive-depth-start 0.015 --adaptive-depth-end 0.03 \\
      -o lines.npz
  host-sim beamform frames.npz --frames 0..10 -o lines.npz
  host-sim beamform plane.npz --lateral-start -0.012 --lateral-end 0.012 --line-spacing 0.1e-3 \\
      --transmit-weights hann --apodization hamming -o lines.npz
  host-sim beamform phased.npz --lines sector --sector 1.2 -o lines.npz --image sector.png
  host-sim beamform channels.npz -o lines.npz --image figure.svg --dynamic-range 60
  host-sim beamform channels.npz -o lines.npz --image bone.png --rows 512 --columns 512 \\
      --bone-map map.npy --scales 2^-7,2^-8,2^-9 --threshold 15
  host-sim beamform channels.npz --method das -o lines.npz --surface surface.csv --coherence map.npy
  host-sim beamform channels.npz --temporal-half-window 10 -o lines.npz --coherence map.npy \\
      --coherence-of largest-eigenvalue
  host-sim beamform delayed.npz --method mv --covariance forward -o lines.npz
  host-sim beamform recording.mat --variable rf=RcvData --variable c=1540 -o lines.npz
  host-sim beamform channels.npz --config lines.npz.config.toml -o again.npz";

impl Arguments {
    /// Refuses flags that have no effect on the recording.
    fn refuse_flags_without_effect(&self, recording: &Recording) -> Result<()> {
        let spacing = self.beamform.has("beam-spacing").then_some("beam-spacing");
        let mut given = self.beamform.given();
        let delay = given
            .find(|(_, heading)| *heading == DELAY)
            .map(|(flag, _)| flag);
        let (flag, holds) = match recording {
            Recording::Channel(_) => (spacing, "channel data"),
            Recording::Aligned(data) if data.beam_x.is_some() && spacing.is_some() => {
                (spacing, "the beams' positions")
            }
            Recording::Aligned(_) => (delay, "aligned data"),
            Recording::Lines(_) => {
                let any = self.beamform.given().next().map(|(flag, _)| flag);
                (
                    any.or(self.coherence.as_ref().map(|_| "coherence")),
                    "lines",
                )
            }
        };
        match flag {
            None => Ok(()),
            Some(flag) => Err(Error::Usage(format!(
                "--{flag} has no effect on {}, which holds {holds}",
                self.recording.display()
            ))),
        }
    }

    /// Refuses outputs that cannot be written, or that would overwrite another file.
    fn check_paths(&self, config_path: &Path) -> Result<()> {
        let output = self.output.as_deref();
        if let Some(path) = output.filter(|path| path.extension().is_none_or(|end| end != "npz")) {
            return Err(Error::Usage(format!(
                "--output is {}; expected a name that ends in .npz, which `convert` turns into .uff or .hdf5",
                path.display()
            )));
        }
        let mut outputs: Vec<_> = output.into_iter().chain([config_path]).collect();
        if let Some(path) = &self.image {
            if !is_figure(path) {
                Format::of(path)?;
            }
            outputs.push(path);
        }
        match &self.bone_map {
            Some(path) => {
                Format::of(path)?;
                outputs.push(path);
            }
            None => {
                if let Some((flag, _)) = self.phase_symmetry.given().next() {
                    let message = format!("--{flag} has no effect without --bone-map");
                    return Err(Error::Usage(message));
                }
            }
        }
        if let Some(path) = &self.surface {
            Kind::of("--surface", path)?;
            outputs.push(path);
        }
        if let Some(path) = &self.coherence {
            if Format::of(path)? != Format::Npy {
                return Err(Error::Usage(format!(
                    "--coherence is {}; expected a name that ends in .npy",
                    path.display()
                )));
            }
            outputs.push(path);
        }
        check_outputs(&[&self.recording], &outputs)
    }

    /// Whether an image or a bone map was asked for.
    fn pictured(&self) -> bool {
        self.image.is_some() || self.bone_map.is_some()
    }

    /// Refuses beams that the surface or a picture cannot have.
    fn check_beams(&self, recording: &Recording) -> Result<()> {
        match given_beams(recording) {
            Some(beam_x) if self.pictured() || self.surface.is_some() => {
                check_beams(&beam_x).map_err(|e| about(&self.recording, e))
            }
            _ => Ok(()),
        }
    }

    /// The pictures that were asked for.
    fn pictures<'a>(&self, config: &'a Config) -> Pictures<'a> {
        Pictures {
            image: &config.image,
            bone_map: self.bone_map.as_ref().map(|_| &config.phase_symmetry),
            figure: self.image.as_deref().is_some_and(is_figure),
        }
    }

    /// Lines of an interrupted run with the same configuration and frames of the same samples.
    fn partial(
        output: &Path,
        settings: &Beamform,
        frames: &Range<usize>,
        (shared, blocks): (&Recording, &mut Blocks),
    ) -> Result<PartialFrames> {
        // All arrays are written out by `#`.
        let key = format!("{PROGRAM} {settings:?} {frames:?} {shared:#?}");
        let key = XxHash3_128::oneshot(key.as_bytes());
        let mut partial = PartialFrames::beside(output, key)?;
        partial.keep(|frame| {
            let (recording, own) = blocks.block(frames.start + frame)?;
            Ok(recording.frame_hash(own.start))
        })?;
        Ok(partial)
    }

    /// Adds coherence and surface if asked for; returns the surface's summary.
    fn add_maps(
        &self,
        lines: &BeamformedLines,
        (frames, frame): (&RecordingFrames<'_>, (&Recording, usize)),
        config: &Config,
        outputs: &mut Outputs,
    ) -> Result<String> {
        let of_file = |error| about(&self.recording, error);
        let map = self.coherence.as_ref();
        let measure = self.coherence_of.unwrap_or_default();
        let map = map.map(|_| coherence::of_frame(frames, frame.0, frame.1, measure));
        let map = map.transpose().map_err(of_file)?;
        if let (Some(path), Some(map)) = (&self.coherence, &map) {
            image::add_to(map, path, outputs)?;
        }
        let Some(path) = &self.surface else {
            return Ok(String::new());
        };
        let known = map.as_ref().filter(|_| measure == Measure::ShortLag);
        let points = of_recording(frames, frame, lines, known, &config.surface);
        let points = points.map_err(of_file)?;
        let surface = FrameSurface {
            frame: 0,
            points,
            verdict: None,
        };
        let count = lines.beam_x.len();
        let text = format!("; {}", surface.summary(count));
        add_surfaces_to(&[surface], count, None, path, outputs)?;
        Ok(text)
    }

    /// Adds the image and the bone map if asked for.
    fn add_pictures(
        &self,
        image: &BModeImage,
        config: &Config,
        outputs: &mut Outputs,
    ) -> Result<()> {
        match &self.image {
            Some(path) if is_figure(path) => {
                let figure = figure(image, config.image.dynamic_range)?;
                outputs.add(path, |sink| Ok(sink.write_all(figure.as_bytes())?))?;
            }
            Some(path) => image::add_to(&image.pixels, path, outputs)?,
            None => {}
        }
        if let Some(path) = &self.bone_map {
            let bar = Progress::new("phase symmetry", 1);
            let map = phase_symmetry::of_image(
                image.pixels.clone(),
                &config.phase_symmetry,
                image.angles.is_none().then_some(image.pixel),
                &mut |done, of| bar.set(done as u64, of as u64),
            );
            let mut map = map.map_err(|e| about(&self.recording, e))?;
            bar.clear();
            if Format::of(path)? == Format::Png {
                scale_for_display(map.as_slice_memory_order_mut().unwrap_or_default())?;
            }
            image::add_to(&map, path, outputs)?;
        }
        Ok(())
    }
}

/// Runs the command.
///
/// # Errors
/// A parameter out of range, a recording that is not valid, or an output that cannot be written.
pub fn run(arguments: Arguments) -> Result<()> {
    let mut config = load_config(arguments.config.path.as_deref())?;
    arguments.beamform.apply(&mut config.beamform);
    arguments.variables.apply(&mut config.variables)?;
    arguments.image_flags.apply(&mut config.image);
    arguments.phase_symmetry.apply(&mut config.phase_symmetry);
    config.beamform.resolve();
    let any_size = config.image.rows.is_none() && config.image.columns.is_none();
    if arguments.bone_map.is_some() && any_size && config.phase_symmetry.resize.is_none() {
        config.phase_symmetry.pad = true;
    }
    config.validate()?;

    let outputs = [
        &arguments.output,
        &arguments.image,
        &arguments.bone_map,
        &arguments.surface,
    ];
    let Some(beside) = outputs.into_iter().flatten().next() else {
        let message = "no output is asked for; expected --output LINES.npz, or of lines --image, --bone-map or --surface";
        return Err(Error::Usage(message.into()));
    };
    let config_path = Config::path_beside(beside);
    arguments.check_paths(&config_path)?;

    let snapshot = Snapshot::of(&arguments.recording)?;
    arguments
        .estimate
        .apply(&arguments.recording, &mut config)?;
    let mut hashing = snapshot.hashing();
    let (path, hash) = (&arguments.recording, hashing.shared());
    let mut file = RecordingFile::open_hashed(path, &config.variables, hash)?;
    let first = file.first();
    arguments.refuse_flags_without_effect(first)?;
    if !matches!(first, Recording::Lines(_)) && arguments.output.is_none() {
        return Err(Error::Usage(format!(
            "{} holds no lines yet; expected --output LINES.npz for them",
            arguments.recording.display()
        )));
    }
    arguments.check_beams(first)?;
    if let Recording::Channel(data) = first {
        warn_of(&arguments.recording, data, &config.beamform)?;
    }
    tell_assumed(&arguments.recording, &file);
    let pictured = arguments.pictured();
    let pictures = pictured.then(|| arguments.pictures(&config));
    let frames = FrameRange::of(arguments.frames.as_ref(), file.frames())?;
    let at_a_time = file.frames_at_a_time().min(frames.len());
    let bytes = working_memory(first, &config.beamform, pictures.as_ref(), at_a_time);
    memory::check(bytes, "beamforming").map_err(|e| about(&arguments.recording, e))?;
    let (format, of) = (file.format(), file.frames());
    if frames.len() < of {
        hashing.of_part();
        file.set_hash(hashing.shared());
    }
    let (shared, mut blocks) = file.into_blocks(frames.clone(), at_a_time);
    let beamformer = RecordingFrames::new(&shared, &config.beamform);
    let beamformer = beamformer.map_err(|e| about(&arguments.recording, e))?;
    let mut partial = match &arguments.output {
        Some(output) if of > 1 => {
            let recorded = (&shared, &mut blocks);
            Some(Arguments::partial(
                output,
                &config.beamform,
                &frames,
                recorded,
            )?)
        }
        _ => None,
    };
    let bar = Progress::new("beamforming", 1000);
    let mut seconds = 0.0;
    // The lines of the next frames, after `done` of them, and hashes of their samples.
    let mut next = |done: usize| -> Result<Vec<(BeamformedLines, u128)>> {
        let (recording, own) = blocks.block(frames.start + done)?;
        snapshot.check()?;
        let block = own.len() as f64;
        let fraction = |part: f64| (done as f64 + part * block) / frames.len() as f64;
        let progress = |part: f64| bar.set((1000.0 * fraction(part)) as u64, 1000);
        hashing.follow(fraction(1.0));
        let begin = Instant::now();
        let lines = beamformer.lines(recording, own.clone(), &progress);
        seconds += begin.elapsed().as_secs_f64();
        let lines = lines.map_err(|e| about(&arguments.recording, e))?;
        let hashes = own.map(|frame| recording.frame_hash(frame));
        Ok(lines.into_iter().zip(hashes).collect())
    };

    let mut outputs = Outputs::new();
    let lines = match (&arguments.output, &mut partial) {
        (Some(output), Some(partial)) => {
            let count = frames.len();
            BeamformedLines::add_frames_to(count, output, &mut outputs, partial, next)?
        }
        (output, _) => {
            let (lines, _) = next(0)?.remove(0);
            if let Some(output) = output {
                lines.add_to(output, &mut outputs)?;
            }
            lines
        }
    };
    let resumed = partial.as_ref().map_or(0, PartialFrames::resumed);
    bar.clear();
    let input = hashing.finish()?;
    let mut measures = Measures::new(&input, format, seconds, resumed, &lines);
    let count = arguments.output.as_ref().map_or(1, |_| frames.len());
    let mut summary = summary_of_lines(&shared, &config.beamform, count, &lines);
    if resumed > 0 {
        summary += &format!(", {resumed} of them from an interrupted run");
    }
    if pictured {
        let image = image_of(&lines, &config.image).map_err(|e| about(&arguments.recording, e))?;
        let chosen = config.phase_symmetry.scales_from_image && arguments.bone_map.is_some();
        if chosen {
            let own = |e| about(&arguments.recording, e);
            let square = squared(image.pixels.view(), image.pixel).map_err(own)?;
            let shown = square.as_ref().unwrap_or(&image.pixels);
            let section = phase_symmetry::with_scales(shown.view(), &config.phase_symmetry);
            config.phase_symmetry = section.map_err(own)?;
        }
        arguments.add_pictures(&image, &config, &mut outputs)?;
        let (rows, columns) = image.pixels.dim();
        summary += &format!(
            "; an image of {rows} x {columns} pixels of {} mm",
            match PixelSize::from(image.pixel) {
                PixelSize::Square(side) => format!("{:.3}", 1e3 * side),
                PixelSize::Sides([across, down]) =>
                    format!("{:.3} x {:.3}", 1e3 * across, 1e3 * down),
            }
        );
        if chosen {
            let pixel = image.angles.is_none().then(|| square_side(image.pixel));
            let scales = chosen_scales(&config.phase_symmetry, pixel);
            summary += &format!("; {scales}");
        }
        // The configuration tells what was chosen, and so repeats it.
        (config.image.rows, config.image.columns) = (Some(rows), Some(columns));
        measures.add_image(&image);
    }
    if arguments.surface.is_some() || arguments.coherence.is_some() {
        let (recording, own) = blocks.block(frames.start)?;
        let recorded = (&beamformer, (recording, own.start));
        summary += &arguments.add_maps(&lines, recorded, &config, &mut outputs)?;
    }
    if let Recording::Channel(_) = shared {
        config.beamform.output_rate = Some(lines.fs);
    }
    config.add_to(&command_line(), &[input], &config_path, &mut outputs)?;
    outputs.commit()?;
    if let Some(partial) = partial {
        partial.finish();
    }
    match arguments.json {
        true => print(&measures.json(&config.beamform)?),
        false => print(&format!("{summary}\n")),
    }
}

/// Whether the image's name asks for axes (.svg).
fn is_figure(path: &Path) -> bool {
    let extension = path.extension().and_then(|e| e.to_str());
    extension.is_some_and(|e| e.eq_ignore_ascii_case("svg"))
}

/// Positions of the lines if the recording has them; else they are evenly spaced.
fn given_beams(recording: &Recording) -> Option<Vec<f64>> {
    match recording {
        Recording::Channel(data) => match &data.transmits {
            Transmits::Focused { x, .. } => {
                let mut x = x.clone();
                x.sort_by(f64::total_cmp);
                x.dedup();
                Some(x)
            }
            _ => None,
        },
        Recording::Aligned(data) => data.beam_x.clone(),
        Recording::Lines(_) => None,
    }
}
