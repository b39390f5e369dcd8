//! Measures that `--json` prints: SI units in their names, null if undefined.

use serde::Serialize;

use crate::provenance::{COMMIT, Input, VERSION};
use crate::{Error, Result};
use bonebeam_drive::config::{Beamform, PixelSize};
use bonebeam_drive::image::BModeImage;
use bonebeam_files::terminal::digits;
use bonebeam_files::{BeamformedLines, Recording};
use bonebeam_formats::Format;
use bonebeam_measure::point::PointSpread;

/// A beamforming run.
#[derive(Serialize)]
pub struct Measures {
    program: &'static str,
    version: &'static str,
    commit: &'static str,
    input: String,
    /// XXH3 of 128 bits over the input's bytes.
    input_xxh128: Option<String>,
    format: &'static str,
    /// Time of delay and beamforming.
    seconds: f64,
    /// Frames taken from an interrupted run.
    resumed_frames: usize,
    lines: LineMeasures,
    point: Option<PointMeasures>,
    image: Option<ImageMeasures>,
}

#[derive(Serialize)]
struct LineMeasures {
    count: usize,
    samples: usize,
    rate_hz: f64,
    first_m: f64,
    last_m: f64,
    sound_speed_m_s: f64,
    /// Largest envelope, and root mean square.
    peak: f64,
    rms: f64,
}

/// Profiles through the largest envelope, as by [`PointSpread`].
#[derive(Serialize)]
struct PointMeasures {
    x_m: f64,
    z_m: f64,
    /// Widths across the lines at its depth, interpolated linearly in dB between lines.
    width_6db_m: Option<f64>,
    width_12db_m: Option<f64>,
    /// The same along its line.
    axial_6db_m: Option<f64>,
    /// Distance of the lines there; a width of `n` of them errs by up to 1/n².
    spacing_m: Option<f64>,
    side_lobe_db: Option<f64>,
}

#[derive(Serialize)]
struct ImageMeasures {
    rows: usize,
    columns: usize,
    pixel_m: PixelSize,
    /// The angles of the first and the last column of a polar grid.
    #[serde(skip_serializing_if = "Option::is_none")]
    polar_rad: Option<[f64; 2]>,
    left_m: f64,
    top_m: f64,
    /// Mean and deviation of the grey levels, 0 to 255.
    mean: f64,
}

#[derive(Serialize)]
struct WithParameters<'a> {
    #[serde(flatten)]
    measures: &'a Measures,
    parameters: &'a Beamform,
}

impl Measures {
    /// Measures of the lines.
    pub fn new(
        input: &Input,
        format: Format,
        seconds: f64,
        resumed_frames: usize,
        lines: &BeamformedLines,
    ) -> Self {
        let (count, samples) = lines.z.dim();
        let depth = |sample: usize| lines.c * (lines.t0 + sample as f64 / lines.fs) / 2.0;
        let powers = lines
            .z
            .iter()
            .map(|z| f64::from(z.re).powi(2) + f64::from(z.im).powi(2));
        let sum: f64 = powers.clone().sum();
        let spread = PointSpread::new(lines, None, f64::INFINITY).ok();
        let point = spread.map(|spread| PointMeasures {
            x_m: spread.x,
            z_m: spread.z,
            width_6db_m: spread.lateral.width(-6.0),
            width_12db_m: spread.lateral.width(-12.0),
            axial_6db_m: spread.axial.width(-6.0),
            spacing_m: spread.lateral.spacing(),
            side_lobe_db: spread.lateral.side_lobe(),
        });
        Measures {
            program: env!("CARGO_PKG_NAME"),
            version: VERSION,
            commit: COMMIT,
            input: input.path.display().to_string(),
            input_xxh128: input.xxh128.clone(),
            format: format.name(),
            seconds,
            resumed_frames,
            lines: LineMeasures {
                count,
                samples,
                rate_hz: lines.fs,
                first_m: depth(0),
                last_m: depth(samples.saturating_sub(1)),
                sound_speed_m_s: lines.c,
                peak: powers.fold(0.0, f64::max).sqrt(),
                rms: (sum / lines.z.len().max(1) as f64).sqrt(),
            },
            point,
            image: None,
        }
    }

    /// Adds the measures of the image.
    pub fn add_image(&mut self, image: &BModeImage) {
        let (rows, columns) = image.pixels.dim();
        let sum: f64 = image.pixels.iter().map(|&level| f64::from(level)).sum();
        self.image = Some(ImageMeasures {
            rows,
            columns,
            pixel_m: image.pixel.into(),
            polar_rad: image.angles.map(|angles| [angles.first, angles.last()]),
            left_m: image.x0,
            top_m: image.z0,
            mean: sum / image.pixels.len().max(1) as f64,
        });
    }

    /// The measures and the parameters used, as one line of JSON.
    ///
    /// # Errors
    /// A value that JSON cannot hold.
    pub fn json(&self, parameters: &Beamform) -> Result<String> {
        let all = WithParameters {
            measures: self,
            parameters,
        };
        let text = serde_json::to_string(&all);
        let text = text.map_err(|e| Error::Data(format!("the measures cannot be written: {e}")))?;
        // JSON leaves DEL and the controls above it as they are, which a terminal would obey.
        let safe = |c: char| match c.is_control() {
            true => format!("\\u{:04x}", u32::from(c)),
            false => c.to_string(),
        };
        Ok(text.chars().map(safe).collect::<String>() + "\n")
    }
}

/// Summary of the lines, with the values that the program chose.
pub fn summary_of_lines(
    recording: &Recording,
    parameters: &Beamform,
    frames: usize,
    lines: &BeamformedLines,
) -> String {
    let (beams, samples) = lines.z.dim();
    let of_frames = match frames {
        1 => String::new(),
        count => format!("{count} frames of "),
    };
    let depth = |sample: f64| 1e3 * lines.c * (lines.t0 + sample / lines.fs) / 2.0;
    let (first, last) = (depth(0.0), depth((samples - 1) as f64));
    let rate = digits(lines.fs / 1e6);
    let chosen = match recording {
        Recording::Channel(data) if parameters.output_rate.is_none() => {
            format!(" ({:.3} f0)", lines.fs / data.f0)
        }
        _ => String::new(),
    };
    format!("{of_frames}{beams} lines from {first:.2} to {last:.2} mm at {rate} MHz{chosen}")
}
