//! Writes zea's HDF5 of one track.
//!
//! Raw data with scan and probe, or beamformed data with the positions of their pixels.

use std::path::Path;

use super::frames::{Part, delays, each_frame, positions};
use super::tree::{Branch, Tree, all, frame};
use bonebeam_files::{BeamformedLines, ChannelData, Result, Transmits};

/// The version of zea whose format this is.
const VERSION: &str = "0.1.8";

/// Numbers in zea's type.
fn numbers(parent: &Branch, name: &str, shape: &[usize], values: &[f64]) -> Result<()> {
    let narrow: Vec<f32> = values.iter().map(|&value| value as f32).collect();
    parent.values(name, shape, &narrow).map(drop)
}

fn begin(path: &Path) -> Result<Tree> {
    let tree = Tree::create(path)?;
    tree.root().mark(&[("zea_version", VERSION)])?;
    Ok(tree)
}

/// Writes channel data.
///
/// # Errors
/// Errors of a part, or a file that cannot be written.
pub fn write<'a>(
    path: &Path,
    data: &ChannelData,
    count: usize,
    parts: impl Iterator<Item = Part<'a>>,
) -> Result<()> {
    let tree = begin(path)?;
    let root = tree.root();
    let elements = data.element_x.len();
    let probe = root.group("probe", &[], &[])?;
    let geometry: Vec<f64> = (0..elements)
        .flat_map(|element| {
            let [x, z] = data.element(element);
            [x, 0.0, z]
        })
        .collect();
    numbers(&probe, "probe_geometry", &[elements, 3], &geometry)?;
    let track = root.group("tracks", &[], &[])?.group("track_0", &[], &[])?;
    scan(&track.group("scan", &[], &[])?, data)?;
    samples(&track.group("data", &[], &[])?, data, count, parts)?;
    tree.close()
}

/// Writes the scan.
///
/// Times count from the first element that fires; the peak of the pulse is a period later.
fn scan(own: &Branch, data: &ChannelData) -> Result<()> {
    let delay = delays(data);
    let (transmits, elements) = delay.dim();
    let first: Vec<f64> = delay
        .outer_iter()
        .map(|delay| delay.iter().copied().fold(f64::NAN, f64::min))
        .collect();
    let fires = |value: f64| if value.is_nan() { 0.0 } else { 1.0 };
    let relative = |(transmit, value): (usize, f64)| {
        if value.is_nan() {
            0.0
        } else {
            value - first[transmit]
        }
    };
    let rows = delay
        .iter()
        .enumerate()
        .map(|(k, &value)| (k / elements, value));
    let relative: Vec<f64> = rows.map(relative).collect();
    let apodization: Vec<f64> = delay.iter().map(|&value| fires(value)).collect();
    let start: Vec<f64> = data
        .t0
        .iter()
        .zip(&first)
        .map(|(t0, first)| t0 - first + 1.0 / data.f0)
        .collect();
    let f_demod = data.samples.f_demod().unwrap_or(data.f0);
    numbers(own, "sampling_frequency", &[], &[data.fs])?;
    numbers(own, "center_frequency", &[], &[data.f0])?;
    numbers(own, "demodulation_frequency", &[], &[f_demod])?;
    numbers(own, "sound_speed", &[], &[data.c])?;
    numbers(own, "initial_times", &[transmits], &start)?;
    numbers(own, "t0_delays", &[transmits, elements], &relative)?;
    numbers(own, "tx_apodizations", &[transmits, elements], &apodization)?;
    let waves: Vec<_> = (0..transmits)
        .map(|transmit| wave(data, transmit))
        .collect();
    let of = |k: usize| waves.iter().map(|wave| wave[k]).collect::<Vec<f64>>();
    let origins: Vec<f64> = waves.iter().flat_map(|wave| [wave[2], 0.0, 0.0]).collect();
    numbers(own, "focus_distances", &[transmits], &of(0))?;
    numbers(own, "polar_angles", &[transmits], &of(1))?;
    numbers(own, "azimuth_angles", &[transmits], &vec![0.0; transmits])?;
    numbers(own, "transmit_origins", &[transmits, 3], &origins)
}

/// A wave's focal distance, its angle, and the lateral position of their origin.
///
/// The distance is negative for a diverging wave and infinite for a plane one.
fn wave(data: &ChannelData, transmit: usize) -> [f64; 3] {
    match &data.transmits {
        Transmits::Plane { angle } => [f64::INFINITY, angle[transmit], 0.0],
        Transmits::Focused { x, focus, .. } => [focus[transmit], 0.0, x[transmit]],
        Transmits::VirtualSource { x, z } if z[transmit] > 0.0 => {
            let (x, z) = (x[transmit], z[transmit]);
            [x.hypot(z), x.atan2(z), 0.0]
        }
        Transmits::VirtualSource { x, z } => {
            let (x, z) = (x[transmit], z[transmit]);
            [-x.hypot(z), (-x).atan2(-z), 0.0]
        }
        // Their delays and apodization tell all.
        Transmits::Element { .. } | Transmits::Delays { .. } => [f64::INFINITY, 0.0, 0.0],
    }
}

/// The samples as [frame, transmit, sample, element, 1 or 2].
///
/// The carrier phase of zea's I/Q counts from sample 0 of each transmit, that of channel data from the wave's origin.
fn samples<'a>(
    own: &Branch,
    data: &ChannelData,
    count: usize,
    parts: impl Iterator<Item = Part<'a>>,
) -> Result<()> {
    let (_, transmits, elements, samples) = data.samples.dim();
    let f_demod = data.samples.f_demod();
    let (channels, f_demod) = f_demod.map_or((1, 0.0), |f_demod| (2, f_demod));
    let shape = [count, transmits, samples, elements, channels];
    let array = own.array::<f32>("raw_data", &shape)?;
    let lens = 2.0 * data.lens_delay;
    let cycles: Vec<f64> = data.t0.iter().map(|t0| f_demod * (t0 + lens)).collect();
    let mut turned = vec![0.0; transmits * samples * elements * channels];
    each_frame(parts, &cycles, |index, parts| {
        for (channel, part) in parts.into_iter().take(channels).enumerate() {
            for (k, &value) in part.iter().enumerate() {
                let (record, sample) = (k / samples, k % samples);
                let (transmit, element) = (record / elements, record % elements);
                let position = (transmit * samples + sample) * elements + element;
                turned[position * channels + channel] = value;
            }
        }
        frame(&array, &shape, index, &turned)
    })
}

/// Writes lines as `beamformed_data`: [frame, sample, beam, 2], with positions.
///
/// # Errors
/// A file that cannot be written.
pub fn write_lines(path: &Path, frames: &[BeamformedLines]) -> Result<()> {
    let Some(lines) = frames.first() else {
        return Ok(());
    };
    let (beams, samples) = lines.z.dim();
    let tree = begin(path)?;
    let track = tree
        .root()
        .group("tracks", &[], &[])?
        .group("track_0", &[], &[])?;
    let own = track
        .group("data", &[], &[])?
        .group("beamformed_data", &[], &[])?;
    let values = own.array::<f32>("values", &[frames.len(), samples, beams, 2])?;
    let of_frame = |frame: &BeamformedLines| {
        let z = frame.z.t();
        z.iter().flat_map(|z| [z.re, z.im]).collect::<Vec<f32>>()
    };
    all(
        &values,
        &frames.iter().flat_map(of_frame).collect::<Vec<f32>>(),
    )?;
    let positions = positions(lines);
    let ordered =
        (0..samples).flat_map(|sample| (0..beams).map(move |beam| beam * samples + sample));
    let coordinates: Vec<f64> = ordered.flat_map(|pixel| positions[pixel]).collect();
    numbers(&own, "coordinates", &[samples, beams, 3], &coordinates)?;
    tree.close()
}
