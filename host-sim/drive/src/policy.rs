//! Defaults, warnings and memory use of beamforming.

use bonebeam::geometry::Steering;
use bonebeam::phase_symmetry::Sizes;
use bonebeam_files::memory::product;
use bonebeam_files::settings::in_mm;
use bonebeam_files::terminal::short;
use bonebeam_files::{ChannelData, Recording, Survey};
use num_complex::Complex;

use crate::beamform::TILE;
use crate::config::{Beamform, Image, LONGER_SIDE, PhaseSymmetry, RfInterpolation};
use crate::delay::{LINES_UPSAMPLED, UPSAMPLED_FROM};
use crate::limits::depths_of;
use crate::methods::MethodName;
use crate::phase_symmetry::FROM_IMAGE;
use crate::sub_lines;
use crate::{Error, Result};

/// Depths deeper than this many times the record's end are a mistake.
///
/// They would waste memory.
const FAR_BEYOND: f64 = 2.0;

/// Warnings about input that is accepted but probably a mistake.
///
/// Each is a sentence. The survey is that of the data's samples.
///
/// # Errors
/// As [`check_depths`].
pub fn warnings(data: &ChannelData, survey: &Survey, parameters: &Beamform) -> Result<Vec<String>> {
    let band = match data.samples.f_demod() {
        None => parameters.warnings(data.f0, data.fs),
        Some(_) => None,
    };
    let depths = check_depths(data, parameters)?;
    let few = match parameters.method {
        MethodName::Das => None,
        _ => data.few_receivers(survey),
    };
    let reported = data.warnings(survey).into_iter().chain(few);
    Ok(reported
        .chain(band)
        .chain(sparse(data, parameters))
        .chain(depths)
        .collect())
}

/// Warns of elements so far apart that the aperture has grating lobes.
///
/// Only grating lobes within the angles that the aperture receives count.
fn sparse(data: &ChannelData, parameters: &Beamform) -> Option<String> {
    let wavelengths = data.pitch() * data.f0 / parameters.sound_speed.unwrap_or(data.c);
    // The angle to the aperture's edge, and the one from which a lobe falls back into it.
    let edge = (0.5 / parameters.f_number).atan().sin();
    let free = 0.5 / wavelengths;
    let needed = 0.5 / free.min(1.0).asin().tan();
    (edge > free).then(|| {
        format!(
            "the elements are {wavelengths:.2} wavelengths apart, which causes grating lobes at an \
             --f-number of {}; {:.1} and more have none",
            parameters.f_number,
            (10.0 * needed).ceil() / 10.0
        )
    })
}

/// Checks that the given depths are recorded.
///
/// Depths a little beyond may be intended, so they give a warning.
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
                "{} m to {} m were requested, but {holds}; samples outside are zero",
                short(start),
                short(end)
            )));
        }
        _ => return Ok(None),
    };
    let (flag, depth) = flag;
    Err(Error::Usage(format!(
        "--depth-{flag} is {} m; {holds}{}",
        short(depth),
        in_mm(depth)
    )))
}

/// Memory that beamforming needs besides a recording's first frame, bytes.
///
/// For `frames` frames at a time: a block in use and one that is read, the weighted samples of a frame, the
/// threads' aligned samples, the lines, and the pictures of one frame.
pub fn working_memory(
    recording: &Recording,
    parameters: &Beamform,
    pictures: Option<&Pictures<'_>>,
    frames: usize,
) -> usize {
    const COMPLEX: usize = size_of::<Complex<f32>>();
    let frame = recording.bytes() / recording.frames().max(1);
    let blocks = product(&[(2 * frames).saturating_sub(1), frame]);
    let beamforming = match recording {
        Recording::Aligned(_) | Recording::Lines(_) => vec![blocks, frame],
        Recording::Channel(data) => {
            let c = parameters.sound_speed.unwrap_or(data.c);
            let [first, last] = depths_of(data, parameters);
            // The cast saturates.
            let rate = parameters.rate_of(data);
            let samples = (2.0 * (last - first) / c * rate).ceil() as usize;
            let (_, transmits, elements, _) = data.samples.dim();
            // Lines that there cannot be are refused later.
            let (lines, sub_lines) = sub_lines::count(data, parameters).unwrap_or_default();
            let directions = match sub_lines {
                0 | 1 => 0,
                count => Steering::need(samples, count).complex,
            };
            // The real parts of every element, and where every transmit is read.
            let upsampled = match parameters.rf_interpolation {
                choice
                    if choice == Some(RfInterpolation::Upsampled)
                        || choice.is_none() && transmits >= UPSAMPLED_FROM =>
                {
                    let rows = elements.saturating_add(transmits);
                    let at_a_time = lines.min(LINES_UPSAMPLED);
                    product(&[rows, at_a_time, samples, size_of::<f32>()])
                }
                _ => 0,
            };
            let weighted = parameters.transmit_weights.as_ref().map_or(0, |_| frame);
            vec![
                blocks,
                weighted,
                upsampled,
                product(&[rayon::current_num_threads(), TILE]),
                product(&[lines, directions, COMPLEX]),
                product(&[3, frames, lines, sub_lines, samples, COMPLEX]),
            ]
        }
    };
    let pictures = pictures.map(|pictures| pictures.memory());
    let all = beamforming.into_iter().chain(pictures).chain([SPARE]);
    all.fold(0, usize::saturating_add)
}

/// Reserve besides arrays of known sizes, bytes.
///
/// For small arrays, and for the memory that the system takes itself.
const SPARE: usize = 16 << 20;

/// Pictures that are made of lines.
pub struct Pictures<'a> {
    /// The image.
    pub image: &'a Image,
    /// The bone map, if there is one.
    pub bone_map: Option<&'a PhaseSymmetry>,
    /// Whether the image is written within a figure, as text.
    pub figure: bool,
}

impl Pictures<'_> {
    /// Memory that the pictures need, bytes.
    fn memory(&self) -> usize {
        let image = self.image;
        let [rows, columns] = [image.rows, image.columns].map(|side| side.unwrap_or(LONGER_SIDE));
        let median = if image.median { size_of::<f32>() } else { 0 };
        // The figure holds the PNG as base64, and again in its text.
        let encoded = PNG + if self.figure { 4 } else { 0 };
        let pixels = product(&[rows, columns, size_of::<f32>() + encoded.max(median)]);
        let map = self
            .bone_map
            .map(|map| phase_symmetry_memory([rows, columns], map));
        pixels.saturating_add(map.unwrap_or(0))
    }
}

/// Bytes per pixel while a PNG is encoded.
///
/// Grey levels, and the encoder's output, which grows by doubling.
const PNG: usize = 4;

/// Memory that phase symmetry needs besides the image, bytes.
pub fn phase_symmetry_memory([rows, columns]: [usize; 2], section: &PhaseSymmetry) -> usize {
    // No side of an image that is filtered is longer.
    const LONGEST: usize = 1024;
    let [high, wide] = match section.resize {
        Some(size) => [size.rows, size.columns],
        None => [rows, columns],
    };
    let side = |side: usize| {
        side.checked_next_power_of_two()
            .unwrap_or(side)
            .min(LONGEST)
    };
    let sizes = Sizes::new(side(high), side(wide), section.strip);
    let lanes = 16 * (2 * sizes.line_len() + sizes.gains_len());
    let thread = sizes.strip_len() + sizes.sums_len() + lanes;
    let scales = match section.scales_from_image {
        true => FROM_IMAGE,
        false => section.scales.len().max(section.wavelengths.len()),
    };
    // The noise is measured first, with two scales and an amplitude for each direction.
    let noise = section.noise_deviations.map_or(0, |_| 8);
    let filters = sizes.gain_tables_len(scales.max(2));
    let numbers = [
        // Resized, padded and as the result.
        product(&[3, sizes.image_len()]),
        sizes.spectrum_len(),
        sizes.filtered_len(),
        sizes.amplitude_len(),
        filters,
        product(&[noise, sizes.image_len()]),
        product(&[rayon::current_num_threads() + 1, thread]),
        // The image that is resampled, and its copy; the map of its size; a PNG.
        product(&[3 + PNG / size_of::<f32>(), rows, columns]),
    ];
    let numbers = numbers.into_iter().fold(0, usize::saturating_add);
    product(&[numbers, size_of::<f32>()])
}
