//! Writes `channel_data` and `beamformed_data` of USTB's Ultrasound File Format.
//!
//! pyuff reads them.

use std::path::Path;

use rust_hdf5::types::H5Type;

use super::frames::{Part, each_frame};
use super::tree::{Branch, Tree, frame, mark};
use bonebeam_files::{BeamformedLines, ChannelData, Result, Transmits};

/// Version of USTB's files.
const VERSION: &str = "v1.2.0";

/// An object of a class, or a list of `count` objects.
fn object(parent: &Branch, name: &str, class: &str, count: usize) -> Result<Branch> {
    let texts = [("class", class), ("name", name)];
    let array = i64::from(count > 1);
    parent.group(
        name,
        &texts,
        &[("array", &[array]), ("size", &[1, count as i64])],
    )
}

/// Numbers of an object.
fn numbers<T: H5Type>(parent: &Branch, name: &str, shape: &[usize], values: &[T]) -> Result<()> {
    let array = parent.values(name, shape, values)?;
    let texts = [("class", "single"), ("name", name)];
    mark(&array, &texts, &[("complex", &[0]), ("imaginary", &[0])])
}

fn number(parent: &Branch, name: &str, value: f64) -> Result<()> {
    numbers(parent, name, &[], &[value])
}

fn point(parent: &Branch, name: &str, [distance, azimuth]: [f64; 2]) -> Result<()> {
    let point = object(parent, name, "uff.point", 1)?;
    number(&point, "distance", distance)?;
    number(&point, "azimuth", azimuth)?;
    number(&point, "elevation", 0.0)
}

/// Distance and azimuth of a position (x, z).
fn polar([x, z]: [f64; 2]) -> [f64; 2] {
    [x.hypot(z), x.atan2(z)]
}

/// A wave's front, its source, and the origin of its time.
///
/// Positions are distance and azimuth.
fn wave(data: &ChannelData, transmit: usize) -> (i64, [f64; 2], [f64; 2]) {
    const PLANE: i64 = 0;
    const SPHERICAL: i64 = 1;
    match &data.transmits {
        Transmits::Plane { angle } => (PLANE, [f64::INFINITY, angle[transmit]], [0.0; 2]),
        Transmits::Focused { x, focus, .. } => {
            let (x, z) = (x[transmit], focus[transmit]);
            (SPHERICAL, polar([x, z]), polar([x, 0.0]))
        }
        Transmits::Element { index } => {
            let position = polar(data.element(index[transmit]));
            (SPHERICAL, position, position)
        }
        Transmits::VirtualSource { x, z } => {
            (SPHERICAL, polar([x[transmit], z[transmit]]), [0.0; 2])
        }
        // Refused before.
        Transmits::Delays { .. } => (SPHERICAL, [0.0; 2], [0.0; 2]),
    }
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
    let tree = Tree::create(path)?;
    let root = tree.root();
    root.mark(&[("version", VERSION)])?;
    let own = object(&root, "channel_data", "uff.channel_data", 1)?;
    let first = data.t0.first().copied().unwrap_or(0.0);
    let f_demod = data.samples.f_demod().unwrap_or(0.0);
    number(&own, "sampling_frequency", data.fs)?;
    number(&own, "initial_time", first)?;
    number(&own, "sound_speed", data.c)?;
    number(&own, "modulation_frequency", f_demod)?;
    let pulse = object(&own, "pulse", "uff.pulse", 1)?;
    number(&pulse, "center_frequency", data.f0)?;
    probe(&own, data)?;
    let sequence = object(&own, "sequence", "uff.wave", data.t0.len())?;
    for (transmit, t0) in data.t0.iter().enumerate() {
        match data.t0.len() {
            1 => fill_wave(&sequence, data, transmit, t0 - first)?,
            _ => {
                let name = format!("sequence_{:04}", transmit + 1);
                let own = object(&sequence, &name, "uff.wave", 1)?;
                fill_wave(&own, data, transmit, t0 - first)?;
            }
        }
    }
    samples(&own, data, count, parts)?;
    tree.close()
}

fn fill_wave(own: &Branch, data: &ChannelData, transmit: usize, delay: f64) -> Result<()> {
    let (front, source, origin) = wave(data, transmit);
    let array = own.values("wavefront", &[1, 1], &[front])?;
    mark(
        &array,
        &[("class", "uff.wavefront"), ("name", "wavefront")],
        &[],
    )?;
    point(own, "source", source)?;
    point(own, "origin", origin)?;
    number(own, "delay", delay)?;
    number(own, "sound_speed", data.c)
}

/// The elements: x, y, z, azimuth, elevation, width, height of each.
fn probe(parent: &Branch, data: &ChannelData) -> Result<()> {
    let probe = object(parent, "probe", "uff.probe", 1)?;
    let count = data.element_x.len();
    let zero = vec![0.0; count];
    let z = data.element_z.clone().unwrap_or_else(|| zero.clone());
    let azimuth = data.element_angle.clone().unwrap_or_else(|| zero.clone());
    let width = vec![data.pitch(); count];
    let rows = [&data.element_x, &zero, &z, &azimuth, &zero, &width, &zero];
    let geometry: Vec<f64> = rows.into_iter().flatten().copied().collect();
    numbers(&probe, "geometry", &[rows.len(), count], &geometry)
}

/// The samples as [frame, wave, channel, sample].
///
/// The carrier phase of UFF's I/Q counts from time 0 of the samples, that of channel data from each wave's origin.
fn samples<'a>(
    parent: &Branch,
    data: &ChannelData,
    count: usize,
    parts: impl Iterator<Item = Part<'a>>,
) -> Result<()> {
    let (_, transmits, elements, samples) = data.samples.dim();
    let shape = [count, transmits, elements, samples];
    let Some(f_demod) = data.samples.f_demod() else {
        let array = parent.array::<f32>("data", &shape)?;
        let texts = [("class", "single"), ("name", "data")];
        mark(&array, &texts, &[("complex", &[0]), ("imaginary", &[0])])?;
        return each_frame(parts, &[], |index, [rf, _]| {
            frame(&array, &shape, index, rf)
        });
    };
    let [real, imaginary] = complex(parent, &shape)?;
    let first = data.t0.first().copied().unwrap_or(0.0);
    let lens = 2.0 * data.lens_delay;
    let later = data.t0.iter().map(|t0| t0 - first + lens);
    let cycles: Vec<f64> = later.map(|later| f_demod * later).collect();
    each_frame(parts, &cycles, |index, [re, im]| {
        frame(&real, &shape, index, re)?;
        frame(&imaginary, &shape, index, im)
    })
}

/// The two arrays of complex numbers: real and imaginary part.
fn complex(parent: &Branch, shape: &[usize]) -> Result<[rust_hdf5::H5Dataset; 2]> {
    let texts = [("class", "single"), ("name", "data")];
    let marks: [(&str, &[i64]); 2] = [("complex", &[1]), ("imaginary", &[0])];
    let data = parent.group("data", &texts, &marks)?;
    let real = data.array::<f32>("real", shape)?;
    mark(&real, &texts, &[("imaginary", &[0])])?;
    let imaginary = data.array::<f32>("imag", shape)?;
    mark(&imaginary, &texts, &[("imaginary", &[1])])?;
    Ok([real, imaginary])
}

/// Writes lines as `beamformed_data`: [pixel, 1, 1, frame].
///
/// The samples come beam by beam, with the position of each pixel.
///
/// # Errors
/// A file that cannot be written.
pub fn write_lines(path: &Path, frames: &[BeamformedLines]) -> Result<()> {
    let Some(lines) = frames.first() else {
        return Ok(());
    };
    let tree = Tree::create(path)?;
    let root = tree.root();
    root.mark(&[("version", VERSION)])?;
    let own = object(&root, "beamformed_data", "uff.beamformed_data", 1)?;
    number(&own, "sampling_frequency", lines.fs)?;
    number(&own, "modulation_frequency", 0.0)?;
    let pixels = lines.z.len();
    let [real, imaginary] = complex(&own, &[pixels, 1, 1, frames.len()])?;
    for (array, part) in [(&real, 0), (&imaginary, 1)] {
        let of = |pixel: usize, frame: &BeamformedLines| {
            let (beam, sample) = (pixel / lines.z.ncols(), pixel % lines.z.ncols());
            let z = frame.z[(beam, sample)];
            if part == 0 { z.re } else { z.im }
        };
        let values: Vec<f32> = (0..pixels)
            .flat_map(|pixel| frames.iter().map(move |frame| of(pixel, frame)))
            .collect();
        super::tree::all(array, &values)?;
    }
    scan(&own, lines)?;
    tree.close()
}

/// A scan: straight down with its axes, or only the positions.
fn scan(parent: &Branch, lines: &BeamformedLines) -> Result<()> {
    let (beams, samples) = lines.z.dim();
    let depth = |sample: usize| lines.c * (lines.t0 + sample as f64 / lines.fs) / 2.0;
    let class = match lines.rays {
        None => "uff.linear_scan",
        Some(_) => "uff.scan",
    };
    let scan = object(parent, "scan", class, 1)?;
    if lines.rays.is_none() {
        let depths: Vec<f64> = (0..samples).map(depth).collect();
        numbers(&scan, "x_axis", &[beams], &lines.beam_x)?;
        numbers(&scan, "z_axis", &[samples], &depths)?;
    }
    let positions = super::frames::positions(lines);
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let along: Vec<f64> = positions.iter().map(|position| position[axis]).collect();
        numbers(&scan, name, &[positions.len()], &along)?;
    }
    Ok(())
}
