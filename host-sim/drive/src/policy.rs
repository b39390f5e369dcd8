//! Defaults, warnings and the memory that beamforming takes.

use bonebeam_files::memory::product;
use bonebeam_files::terminal::short;
use bonebeam_files::{ChannelData, Recording, Samples};
use num_complex::Complex;

use crate::beamform::TILE;
use crate::config::{Beamform, Image, LONGER_SIDE, RfInterpolation};
use crate::delay::LINES_UPSAMPLED;
use crate::{Error, Result};

/// Depths beyond so many times the record's end are a mistake, and would take memory for nothing.
const FAR_BEYOND: f64 = 2.0;

/// Warnings about input that is accepted but probably not meant: sentences for a person.
///
/// # Errors
/// As [`check_depths`].
pub fn warnings(data: &ChannelData, parameters: &Beamform) -> Result<Vec<String>> {
    let band = match data.samples {
        Samples::Rf(_) => parameters.warnings(data.f0, data.fs),
        Samples::Iq { .. } => None,
    };
    let depths = check_depths(data, parameters)?;
    let reported = data.warnings().into_iter().chain(band);
    Ok(reported
        .chain(sparse(data, parameters))
        .chain(depths)
        .collect())
}

/// Elements so far apart that the receive aperture has grating lobes within the angles that it takes in.
fn sparse(data: &ChannelData, parameters: &Beamform) -> Option<String> {
    let wavelengths = data.pitch() * data.f0 / parameters.sound_speed.unwrap_or(data.c);
    // The angle to the aperture's edge, and the one from which a lobe falls back into it.
    let edge = (0.5 / parameters.f_number).atan().sin();
    let free = 0.5 / wavelengths;
    let needed = 0.5 / free.min(1.0).asin().tan();
    (edge > free).then(|| {
        format!(
            "the elements are {wavelengths:.2} wavelengths apart, which makes grating lobes at an \
             --f-number of {}; {:.1} and more have none",
            parameters.f_number,
            (10.0 * needed).ceil() / 10.0
        )
    })
}

/// Depths that were asked for must be recorded; a little beyond may be meant, and is a warning.
///
/// # Errors
/// [`Error::Usage`] for depths that are not recorded at all, or far beyond.
pub fn check_depths(data: &ChannelData, parameters: &Beamform) -> Result<Option<String>> {
    let [first, last] = data.depths(parameters.sound_speed.unwrap_or(data.c));
    let start = parameters.depth_start.unwrap_or(first);
    let end = parameters.depth_end.unwrap_or(last);
    let holds = format!("the record holds {first:.6} m to {last:.6} m");
    let flag = match (parameters.depth_start, parameters.depth_end) {
        (Some(start), _) if start >= last => ("start", start),
        (_, Some(end)) if end <= first || end > FAR_BEYOND * last => ("end", end),
        _ if start < first || end > last => {
            return Ok(Some(format!(
                "{} m to {} m are asked for, {holds}; what lies outside is zero",
                short(start),
                short(end)
            )));
        }
        _ => return Ok(None),
    };
    let (flag, depth) = flag;
    Err(Error::Usage(format!(
        "--depth-{flag} is {} m; {holds}",
        short(depth)
    )))
}

/// The memory that beamforming takes beside a recording, bytes, for so many frames at a time: the samples
/// in order, the aligned samples that threads work on, the lines, and an image before and after its median.
pub fn working_memory(
    recording: &Recording,
    parameters: &Beamform,
    image: Option<&Image>,
    frames: usize,
) -> usize {
    const COMPLEX: usize = size_of::<Complex<f32>>();
    let beamforming = match recording {
        Recording::Aligned(data) => vec![product(&[2, data.x.len(), COMPLEX])],
        Recording::Channel(data) => {
            let c = parameters.sound_speed.unwrap_or(data.c);
            let [first, last] = data.depths(c);
            let first = parameters.depth_start.unwrap_or(first);
            let last = parameters.depth_end.unwrap_or(last);
            // The cast saturates.
            let rate = parameters.rate_of(data);
            let samples = (2.0 * (last - first) / c * rate).ceil() as usize;
            let (_, transmits, elements, _) = data.samples.dim();
            let lines = parameters.line_count.unwrap_or(transmits.max(2 * elements));
            // The real parts of every element, and where every transmit is read.
            let upsampled = match parameters.rf_interpolation {
                Some(RfInterpolation::Upsampled) => {
                    let rows = elements.saturating_add(transmits);
                    let at_a_time = lines.min(LINES_UPSAMPLED);
                    product(&[rows, at_a_time, samples, size_of::<f32>()])
                }
                _ => 0,
            };
            vec![
                data.samples.bytes(),
                upsampled,
                product(&[rayon::current_num_threads(), TILE]),
                product(&[3, frames, lines, samples, COMPLEX]),
            ]
        }
    };
    // Pixels, those before the median, and the 8-bit ones.
    let image = image.map(|image| {
        let [rows, columns] = [image.rows, image.columns].map(|side| side.unwrap_or(LONGER_SIDE));
        product(&[rows, columns, 2 * size_of::<f32>() + 1])
    });
    beamforming
        .into_iter()
        .chain(image)
        .fold(0, usize::saturating_add)
}
