//! `host-sim view`: the live page, with a recording in it.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use flate2::Compression;
use flate2::write::GzEncoder;
use ndarray::{Array4, ArrayView4};
use num_complex::Complex;
use serde_json::json;

use super::elsewhere::found;
use super::frames::{FrameRange, parse_frames};
use super::{ConfigArgument, VariableArguments, about, load_config, tell_assumed};
use crate::config::Config;
use crate::progress::Progress;
use crate::{Error, Result};
use bonebeam_files::atomic::{Outputs, check_outputs};
use bonebeam_files::terminal::{print, short};
use bonebeam_files::{
    ChannelData, Recording, Samples, cannot_be_opened, file_error, image, input, npz,
};
use bonebeam_formats::RecordingFile;
use bonebeam_report::page::base64;
use bonebeam_simulate::{Settings, Simulate};

/// Write a live page: a recording, beamformed in a browser by the same bits.
///
/// The page is one file, which opens from disk and needs no network. FILE is a recording, lines, or a PNG picture;
/// without it the page has a simulated vertebra. RF becomes whole numbers of 16 bits. A recording that is larger than
/// --limit gets fewer bits, then fewer transmits; the command prints the loss. The known surface of a simulated
/// recording comes from FILE.truth.npz. The page is built by `page/build`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Recording of any format, lines, or picture [default: a simulated vertebra]
    #[arg(value_name = "FILE")]
    input: Option<PathBuf>,

    /// The page
    #[arg(short, long, value_name = "PAGE.html")]
    output: PathBuf,

    /// Frames A to B−1, or frame A alone: A..B or A [default: all]
    #[arg(long, value_name = "A..B", value_parser = parse_frames)]
    frames: Option<FrameRange>,

    /// Largest size of the recording in the page, MB
    #[arg(long, value_name = "MB", default_value_t = 6.0)]
    limit: f64,

    /// The built page without a recording [default: page.html beside the program or in a folder of PATH]
    #[arg(long, value_name = "PAGE.html")]
    page: Option<PathBuf>,

    #[command(flatten)]
    variables: VariableArguments,

    #[command(flatten)]
    config: ConfigArgument,
}

const EXAMPLES: &str = "\
Examples:
  host-sim view -o page.html
  host-sim view recording.hdf5 -o page.html
  host-sim view recording.npz --config lines.npz.config.toml -o page.html
  host-sim view frames.npz --frames 0..10 --limit 2 -o page.html
  host-sim view scan.png -o page.html";

/// Name of the built page.
const PAGE: &str = "page.html";
/// Where the page takes a recording, and what it takes beside it.
const RECORDING: &str = "id=\"recording\">";
const EXTRA: &str = "id=\"extra\">{}";
/// Largest page and largest picture to read, bytes.
const MOST: u64 = 64 << 20;
/// Bits of whole numbers, from the first that is tried to the last.
const BITS: [u32; 7] = [16, 14, 12, 11, 10, 9, 8];
/// Index of the bits of the built-in recording.
const BUILT_IN: usize = 4;

/// Runs the command.
///
/// # Errors
/// A page that is not built, a recording that is not valid, too large or of another kind, or an output that cannot be
/// written.
pub fn run(arguments: &Arguments) -> Result<()> {
    let mut config = load_config(arguments.config.path.as_deref())?;
    arguments.variables.apply(&mut config.variables)?;
    config.validate()?;
    if !(0.01..=1000.0).contains(&arguments.limit) {
        let limit = short(arguments.limit);
        return Err(Error::Usage(format!(
            "--limit is {limit}; expected 0.01 to 1000 MB"
        )));
    }
    let inputs = arguments.input.iter().map(PathBuf::as_path);
    check_outputs(&inputs.collect::<Vec<_>>(), &[&arguments.output])?;
    let path = arguments.page.clone().or_else(|| found(PAGE));
    let path = path.ok_or_else(|| {
        Error::Usage(format!(
            "view needs the built page, {PAGE}, which is not here; build it by page/build"
        ))
    })?;
    let page = built(&path)?;
    // Base64 has four digits for three bytes.
    let limit = (arguments.limit * 1e6 * 0.75) as usize;
    let content = match &arguments.input {
        None => simulated(limit)?,
        Some(path) if matches!(image::Format::of(path), Ok(image::Format::Png)) => {
            picture(path, limit)?
        }
        Some(path) => {
            let content = recorded(path, arguments.frames.as_ref(), &config, limit);
            content.map_err(|e| about(path, e))?
        }
    };
    let settings = match arguments.config.path {
        Some(_) => toml::to_string(&config).map_err(|e| Error::Usage(e.to_string()))?,
        None => String::new(),
    };
    let page = filled(&page, &content, &settings);
    let mut outputs = Outputs::new();
    outputs.add(&arguments.output, |sink| {
        Ok(sink.write_all(page.as_bytes())?)
    })?;
    outputs.commit()?;
    let megabytes = page.len() as f64 / 1e6;
    print(&format!("{}; a page of {megabytes:.2} MB\n", content.words))
}

/// The page of the simulated vertebra, if the page is built.
///
/// # Errors
/// A file of the page's name that is another.
pub fn of_vertebra() -> Result<Option<String>> {
    let Some(path) = found(PAGE) else {
        return Ok(None);
    };
    let page = built(&path)?;
    Ok(Some(filled(&page, &simulated(usize::MAX)?, "")))
}

fn built(path: &Path) -> Result<String> {
    let page = input::read(path, MOST).map_err(|e| file_error(path, cannot_be_opened(&e)))?;
    let page = String::from_utf8(page).unwrap_or_default();
    match page.contains(RECORDING) && page.contains(EXTRA) {
        true => Ok(page),
        false => Err(file_error(path, "is not the page that page/build makes")),
    }
}

fn filled(page: &str, content: &Content, settings: &str) -> String {
    // To a tenth of a micrometre.
    let short = |m: f64| (1e7 * m).round() / 1e7;
    let truth = content
        .truth
        .iter()
        .map(|ends| ends.map(|end| end.map(short)));
    let truth: Vec<[[f64; 2]; 2]> = truth.collect();
    let extra = json!({ "name": content.name, "truth": truth, "toml": settings });
    // No name ends the element.
    let extra = extra.to_string().replace('<', "\\u003c");
    let recording = format!("{RECORDING}{}", base64(&content.bytes));
    page.replacen(EXTRA, &EXTRA.replace("{}", &extra), 1)
        .replacen(RECORDING, &recording, 1)
}

/// What the page shows.
struct Content {
    name: String,
    /// The file, compressed.
    bytes: Vec<u8>,
    /// Segments of the known surface, m.
    truth: Vec<[[f64; 2]; 2]>,
    words: String,
}

/// A vertebra in water with few elements and beams, noise-free, in few bits.
fn simulated(limit: usize) -> Result<Content> {
    let scanner = Settings {
        elements: 64,
        beams: 64,
        fs: 20e6,
        depth_start: 10e-3,
        depth_end: 30e-3,
        noise: None,
        ..Settings::vertebra()
    };
    let mut simulate = Simulate {
        scanner: Some(scanner),
        ..Simulate::default()
    };
    let bar = Progress::new("simulating", 1000);
    let (data, truth) = simulate.recorded(&|done| bar.set((1000.0 * done) as u64, 1000))?;
    bar.clear();
    let segments = truth.outline.outer_iter();
    let segments = segments.map(|s| [[s[[0, 0]], s[[0, 1]]], [s[[1, 0]], s[[1, 1]]]]);
    let (bytes, words) = fitted(data, limit, &BITS[BUILT_IN..])?;
    Ok(Content {
        name: "vertebra.npz".into(),
        bytes,
        truth: segments.collect(),
        words,
    })
}

fn picture(path: &Path, limit: usize) -> Result<Content> {
    let pixels = image::read_levels(path)?;
    let bytes = input::read(path, MOST).map_err(|e| file_error(path, cannot_be_opened(&e)))?;
    let bytes = compressed(&bytes);
    let (rows, columns) = pixels.dim();
    match bytes.len() <= limit {
        true => Ok(Content {
            name: name_of(path, "png"),
            bytes,
            truth: Vec::new(),
            words: format!("a picture of {rows} x {columns} pixels"),
        }),
        false => Err(too_large(path, bytes.len(), limit)),
    }
}

fn recorded(
    path: &Path,
    frames: Option<&FrameRange>,
    config: &Config,
    limit: usize,
) -> Result<Content> {
    let file = RecordingFile::open(path, &config.variables)?;
    tell_assumed(path, &file);
    let frames = FrameRange::of(frames, file.frames())?;
    let (recording, own) = match file.first() {
        // As stored.
        first if frames.end <= first.frames() => (first.clone(), frames),
        _ => {
            let (recording, own) = file.read(frames)?;
            (recording.into_owned(), own)
        }
    };
    let recording = recording.into_frames(own);
    let (bytes, words) = match recording {
        Recording::Channel(data) => fitted(data, limit, &BITS)?,
        Recording::Lines(_) => {
            let bytes = compressed(&recording.npz()?);
            if bytes.len() > limit {
                return Err(too_large(path, bytes.len(), limit));
            }
            (bytes, "lines, unchanged".into())
        }
        Recording::Aligned(_) => {
            let message = "holds aligned data; the page beamforms recordings and shows lines";
            return Err(file_error(path, message));
        }
    };
    let mut truth = path.as_os_str().to_owned();
    truth.push(".truth.npz");
    Ok(Content {
        name: name_of(path, "npz"),
        bytes,
        truth: known_surface(Path::new(&truth)).unwrap_or_default(),
        words,
    })
}

/// The outline in a file of the simulator's, if there is one.
fn known_surface(path: &Path) -> Option<Vec<[[f64; 2]; 2]>> {
    fs::metadata(path).ok()?;
    let outline = npz::Reader::open(path)
        .ok()?
        .real_of_any_rank("outline")
        .ok()?;
    let numbers: Vec<f64> = outline.iter().copied().collect();
    let segments = numbers.chunks_exact(4);
    Some(segments.map(|s| [[s[0], s[1]], [s[2], s[3]]]).collect())
}

fn name_of(path: &Path, extension: &str) -> String {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    format!("{stem}.{extension}")
}

fn too_large(path: &Path, bytes: usize, limit: usize) -> Error {
    let [size, most] = [bytes, limit].map(|bytes| bytes as f64 / 0.75e6);
    let message = format!("needs {size:.2} MB of the page, more than --limit {most:.2}");
    file_error(path, message)
}

fn compressed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    let written = encoder.write_all(bytes).and_then(|()| encoder.finish());
    written.unwrap_or_default()
}

/// The recording's archive, compressed to at most `limit` bytes, and what was lost.
///
/// Samples are rounded to the first of `bits` that fits; if none does, every second transmit is left out, and so on.
///
/// # Errors
/// A single transmit that does not fit.
fn fitted(mut data: ChannelData, limit: usize, bits: &[u32]) -> Result<(Vec<u8>, String)> {
    let all = data.transmits.len();
    loop {
        let kept = data.transmits.len();
        let of_all = match kept == all {
            true => format!("{all} transmits"),
            false => format!("{kept} of {all} transmits"),
        };
        let mut least = usize::MAX;
        for &bits in bits {
            let (rounded, loss) = rounded(&data, bits);
            let bytes = compressed(&Recording::Channel(rounded).npz()?);
            if bytes.len() <= limit {
                let loss = match loss {
                    None => "as stored".into(),
                    Some(db) => format!(
                        "rounded to {bits} bits, an error of {db:.1} dB of the samples' power"
                    ),
                };
                return Ok((
                    bytes,
                    format!("{of_all} of {} elements, {loss}", data.element_x.len()),
                ));
            }
            least = bytes.len();
        }
        if kept < 2 {
            let [size, most] = [least, limit].map(|bytes| bytes as f64 / 0.75e6);
            return Err(Error::Data(format!(
                "a transmit needs {size:.2} MB of the page, more than --limit {most:.2}; give fewer --frames"
            )));
        }
        let every: Vec<usize> = (0..kept).step_by(2).collect();
        data = data.only(&every);
    }
}

/// The samples as whole numbers of so many bits, and the power of the error, dB; without, they are as they were.
fn rounded(data: &ChannelData, bits: u32) -> (ChannelData, Option<f64>) {
    let full = ((1u32 << (bits - 1)) - 1) as f32;
    let (samples, loss) = match &data.samples {
        Samples::Stored(_) => (data.samples.clone(), None),
        Samples::Counts(_) if bits == 16 => (data.samples.clone(), None),
        Samples::Counts(counts) => whole(counts.view(), full, f32::from),
        Samples::Rf(rf) => whole(rf.view(), full, |value| value),
        Samples::Iq { iq, f_demod } => {
            let parts = iq.iter().flat_map(|z| [z.re, z.im]);
            let scale = scale_of(parts.clone(), full);
            let loss = loss(parts, scale);
            let iq = iq.mapv(|z| Complex::new((z.re * scale).round(), (z.im * scale).round()));
            let f_demod = *f_demod;
            (Samples::Iq { iq, f_demod }, Some(loss))
        }
    };
    let data = data.clone();
    (ChannelData { samples, ..data }, loss)
}

fn whole<T: Copy>(
    samples: ArrayView4<'_, T>,
    full: f32,
    value: impl Fn(T) -> f32,
) -> (Samples, Option<f64>) {
    let values = samples.iter().map(|&sample| value(sample));
    let scale = scale_of(values.clone(), full);
    let counts: Array4<i16> = samples.mapv(|sample| (value(sample) * scale).round() as i16);
    (Samples::Counts(counts), Some(loss(values, scale)))
}

/// The factor that makes the largest sample `full`.
fn scale_of(values: impl Iterator<Item = f32>, full: f32) -> f32 {
    let largest = values.fold(0.0f32, |largest, value| largest.max(value.abs()));
    if largest > 0.0 { full / largest } else { 1.0 }
}

/// Power of the rounding error over that of the samples, dB.
fn loss(values: impl Iterator<Item = f32>, scale: f32) -> f64 {
    let (mut signal, mut error) = (0.0, 0.0);
    for value in values {
        let scaled = f64::from(value * scale);
        signal += scaled * scaled;
        error += (scaled - scaled.round()).powi(2);
    }
    10.0 * (error / signal.max(f64::MIN_POSITIVE)).max(1e-30).log10()
}
