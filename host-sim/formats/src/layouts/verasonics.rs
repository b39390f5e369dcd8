//! Workspaces of Verasonics' research scanners.
//!
//! By the public descriptions of their fields: lengths in wavelengths of `Trans.frequency` (MHz) at
//! `Resource.Parameters.speedOfSound`, times from the first element that fires.

use std::ops::Range;

use ndarray::{Array2, Array4};

use crate::values::{NamedArrays, Values};
use crate::variables::{LAYOUT, Variables};
use crate::waves::{Fired, Wave};
use bonebeam_files::memory::{self, product};
use bonebeam_files::{ChannelData, Result, Samples};

/// Whether a file is such a workspace.
pub fn is(source: &dyn NamedArrays) -> bool {
    [
        "RcvData",
        "Receive.startSample",
        "Receive.endSample",
        "Trans.frequency",
    ]
    .iter()
    .all(|name| source.has(name))
}

/// A workspace; missing fields are assumed and reported.
struct Workspace<'a> {
    source: &'a dyn NamedArrays,
    /// `Trans.frequency`, Hz.
    frequency: f64,
    assumed: Vec<String>,
}

impl Workspace<'_> {
    fn or(&mut self, name: &str, default: f64, why: &str) -> Result<f64> {
        if self.source.has(name) {
            return self.first(name);
        }
        self.assumed.push(why.to_owned());
        Ok(default)
    }

    /// A number from each entry of an array of structs.
    fn each(&self, name: &str) -> Result<Vec<f64>> {
        self.source.vector(name)
    }

    fn refuse<T>(&self, message: String) -> Result<T> {
        Err(self.source.error(message))
    }

    /// The positions (x, z), m, and the angles of the elements.
    fn elements(&mut self, wavelength: f64) -> Result<(Vec<[f64; 2]>, Vec<f64>)> {
        let positions = self.source.numbers("Trans.ElementPos")?;
        let shape = positions.shape().to_vec();
        if shape.len() != 2 || shape[1] < 3 {
            return self.refuse(format!(
                "`Trans.ElementPos` has shape {shape:?}; expected [element, 4 or 5]"
            ));
        }
        let units = match self.source.has("Trans.units") {
            true => self.source.text("Trans.units")?,
            false => {
                self.assumed.push(
                    "Trans.ElementPos is in wavelengths, since Trans.units is missing".into(),
                );
                "wavelengths".into()
            }
        };
        let unit = match units.as_str() {
            "mm" => 1e-3,
            "wavelengths" => wavelength,
            other => {
                return self.refuse(format!(
                    "`Trans.units` is {other}; expected mm or wavelengths"
                ));
            }
        };
        let at = |element: usize, column: usize| unit * positions[[element, column]];
        if (0..shape[0]).any(|m| at(m, 1) != 0.0) {
            return self
                .refuse("has elements out of the image plane, by `Trans.ElementPos`".into());
        }
        let angle = |m: usize| if shape[1] > 3 { positions[[m, 3]] } else { 0.0 };
        let elements = 0..shape[0];
        Ok((
            elements.clone().map(|m| [at(m, 0), at(m, 2)]).collect(),
            elements.map(angle).collect(),
        ))
    }

    /// The channel of each element, from 0.
    fn channels(&mut self, elements: usize, channels: usize) -> Result<Vec<usize>> {
        let names = ["Trans.ConnectorES", "Trans.Connector"];
        let Some(name) = names.iter().find(|name| self.source.has(name)) else {
            self.assumed
                .push("element m is channel m, since Trans.ConnectorES is missing".into());
            return match elements <= channels {
                true => Ok((0..elements).collect()),
                false => self.refuse(format!(
                    "has {elements} elements and {channels} channels; expected one channel per element"
                )),
            };
        };
        let connector = self.source.vector(name)?;
        let channel = |&number: &f64| {
            (number >= 1.0 && number <= channels as f64).then(|| number as usize - 1)
        };
        let all: Option<Vec<usize>> = connector.iter().map(channel).collect();
        match all.filter(|all| all.len() == elements) {
            Some(all) => Ok(all),
            None => self.refuse(format!(
                "`{name}` names missing channels, or lacks one of the {channels} for some of the {elements} \
                 elements; multiplexed apertures are not read"
            )),
        }
    }

    /// The first number of a field.
    fn first(&self, name: &str) -> Result<f64> {
        let numbers = self.each(name)?;
        let first = numbers.first().copied();
        first.ok_or_else(|| {
            self.source
                .error(format!("`{name}` is empty; expected a number"))
        })
    }

    /// Sampling rate of RF: four samples per wavelength, or the given rate.
    ///
    /// Bandwidth sampling leaves samples out.
    fn sampling_rate(&mut self) -> Result<f64> {
        if let Some(mode) = self.source.entries("Receive.sampleMode").first() {
            let mode = self.source.text(mode)?;
            if mode != "NS200BW" {
                return self.refuse(format!(
                    "was sampled with `Receive.sampleMode` {mode}, which keeps a part of the samples; expected NS200BW"
                ));
            }
        }
        if self.source.has("Receive.decimSampleRate") {
            return Ok(1e6 * self.first("Receive.decimSampleRate")?);
        }
        let rate = match self.source.has("Receive.samplesPerWave") {
            true => self.first("Receive.samplesPerWave")?,
            false => 4.0,
        };
        let why = "since Receive.decimSampleRate is missing";
        self.assumed.push(format!(
            "{rate} samples per wavelength of Trans.frequency, {why}"
        ));
        Ok(rate * self.frequency)
    }

    /// Rows of each acquisition of a frame, and the depth of their first, wavelengths.
    ///
    /// All have the same length.
    fn acquisitions(&self) -> Result<(Vec<Range<usize>>, f64)> {
        let (start, end) = (
            self.each("Receive.startSample")?,
            self.each("Receive.endSample")?,
        );
        let frame = match self.source.has("Receive.framenum") {
            true => self.each("Receive.framenum")?,
            false => vec![1.0; start.len()],
        };
        let depth = match self.source.has("Receive.startDepth") {
            true => self.first("Receive.startDepth")?,
            false => 0.0,
        };
        let of_first = start
            .iter()
            .zip(&end)
            .zip(&frame)
            .filter(|(_, of)| Some(*of) == frame.first());
        // The casts saturate.
        let rows = of_first
            .map(|((start, end), _)| (start.max(1.0) - 1.0) as usize..end.max(0.0) as usize);
        let rows: Vec<Range<usize>> = rows.collect();
        let length = rows.first().map_or(0, ExactSizeIterator::len);
        if length == 0 || rows.iter().any(|rows| rows.len() != length) {
            let wrong = "has acquisitions of several lengths, or of none, by `Receive.startSample` and `endSample`";
            return self.refuse(wrong.into());
        }
        Ok((rows, depth))
    }

    /// Firing time of each element per acquisition, s, and the waves that result.
    fn transmits(
        &mut self,
        acquisitions: usize,
        elements: usize,
        c: f64,
    ) -> Result<(Array2<f64>, Vec<Wave>)> {
        let names = self.source.entries("TX.Delay");
        let of: Vec<usize> = match names.len() {
            1 => vec![0; acquisitions],
            n if n < acquisitions => {
                return self.refuse(format!(
                    "has {n} `TX` for {acquisitions} acquisitions per frame; expected one for each, or one for all"
                ));
            }
            n => {
                if n > acquisitions {
                    let first = format!("the first {acquisitions} of {n} TX");
                    self.assumed.push(format!(
                        "{first} are those of the acquisitions, in their order"
                    ));
                }
                (0..acquisitions).collect()
            }
        };
        let [apodizations, steers, foci, origins] = ["Apod", "Steer", "focus", "Origin"]
            .map(|field| self.source.entries(&format!("TX.{field}")));
        let field = |names: &[String], k: usize| -> Result<Vec<f64>> {
            let numbers = names
                .get(k)
                .map(|name| self.source.vector(name))
                .transpose()?;
            Ok(numbers.unwrap_or_default())
        };
        let metres = c / self.frequency;
        let mut delay = Array2::zeros((acquisitions, elements));
        let mut waves = Vec::new();
        for (mut row, &k) in delay.outer_iter_mut().zip(&of) {
            let wavelengths = self.source.vector(&names[k])?;
            let apodization = field(&apodizations, k)?;
            if wavelengths.len() != elements
                || !(apodization.is_empty() || apodization.len() == elements)
            {
                return self.refuse(format!(
                    "`TX.Delay` has {} numbers, and `TX.Apod` {}; expected one for each of {elements} elements",
                    wavelengths.len(),
                    apodization.len()
                ));
            }
            for (m, (delay, wavelengths)) in row.iter_mut().zip(wavelengths).enumerate() {
                let fires = apodization.get(m).is_none_or(|weight| *weight != 0.0);
                *delay = if fires {
                    wavelengths / self.frequency
                } else {
                    f64::NAN
                };
            }
            let first = |numbers: Vec<f64>, axis: usize| numbers.get(axis).copied().unwrap_or(0.0);
            let steer = first(field(&steers, k)?, 0);
            let focus = metres * first(field(&foci, k)?, 0);
            let origin = field(&origins, k)?;
            let origin = [0, 2].map(|axis| metres * first(origin.clone(), axis));
            let source = [
                origin[0] + focus * steer.sin(),
                origin[1] + focus * steer.cos(),
            ];
            waves.push(match focus == 0.0 {
                true => Wave::Plane(steer),
                false => Wave::VirtualSource(source, origin),
            });
        }
        Ok((delay, waves))
    }

    /// Samples of the acquisitions, and the number of frames in the buffer.
    fn samples(
        &mut self,
        rows: &[Range<usize>],
        elements: usize,
        frames: Range<usize>,
    ) -> Result<(Array4<f32>, usize)> {
        let buffers = self.source.entries("RcvData");
        let buffer = buffers.first().map_or("RcvData", |name| name);
        if buffers.len() > 1 {
            self.assumed.push(format!(
                "the first of {} receive buffers is read",
                buffers.len()
            ));
        }
        let in_parts = self
            .source
            .shape_for_parts(buffer)?
            .filter(|shape| shape.len() == 3);
        let held = self
            .source
            .sides(buffer)
            .and_then(|sides| sides.get(2).copied())
            .unwrap_or(1);
        let Values::Real(data) = self.source.samples(buffer, in_parts.map(|_| (2, frames)))? else {
            return self.refuse("`RcvData` is complex; expected RF".into());
        };
        let there = data.shape().to_vec();
        let last = rows.iter().map(|rows| rows.end).max().unwrap_or(0);
        if !(2..=3).contains(&there.len()) || there[0] < last {
            return self.refuse(format!(
                "`RcvData` has shape {there:?}; expected [at least {last} rows, channel, frame]"
            ));
        }
        let channels = self.channels(elements, there[1])?;
        let shape = (
            there.get(2).copied().unwrap_or(1),
            rows.len(),
            elements,
            rows.first().map_or(0, ExactSizeIterator::len),
        );
        // Acquisitions may have rows in common.
        let bytes = product(&[shape.0, shape.1, shape.2, shape.3, size_of::<f32>()]);
        memory::check(bytes, "the samples").map_err(|e| self.source.error(e.to_string()))?;
        let rf = Array4::from_shape_fn(shape, |(frame, transmit, m, n)| {
            let (row, channel) = (rows[transmit].start + n, channels[m]);
            match data.ndim() {
                2 => data[[row, channel]],
                _ => data[[row, channel, frame]],
            }
        });
        Ok((rf, held))
    }
}

/// Channel data of some frames, number of all frames, and assumptions.
///
/// # Errors
/// A field is missing or of another shape, a mode of sampling that is not read, or data that are not valid.
pub fn read(
    source: &dyn NamedArrays,
    variables: &Variables,
    frames: Range<usize>,
) -> Result<(ChannelData, usize, Vec<String>)> {
    let only = variables.only_numbers(&[LAYOUT, "fs", "c", "f0", "lens_delay"]);
    only.map_err(|e| source.error(e))?;
    let frequency = 1e6 * source.scalar("Trans.frequency")?;
    let mut w = Workspace {
        source,
        frequency,
        assumed: vec![
            "a Verasonics workspace: times count from the first element that fires".into(),
        ],
    };
    let c = match variables.number("c") {
        Some(c) => c,
        None => w.or(
            "Resource.Parameters.speedOfSound",
            1540.0,
            "c is 1540 m/s, since Resource.Parameters.speedOfSound is missing",
        )?,
    };
    let f0 = variables.number("f0").unwrap_or(frequency);
    let fs = match variables.number("fs") {
        Some(fs) => fs,
        None => w.sampling_rate()?,
    };
    let (elements, angles) = w.elements(c / frequency)?;
    let (rows, depth) = w.acquisitions()?;
    let (delay, waves) = w.transmits(rows.len(), elements.len(), c)?;
    let peak = w.or(
        "TW.peak",
        0.0,
        "the pulse's peak leaves an element when it fires, since TW.peak is missing",
    )?;
    let fired = Fired {
        elements: &elements,
        delay,
        start: vec![(2.0 * depth - peak) / frequency; rows.len()],
        c,
        f0,
    };
    let (transmits, t0) = fired.law(&waves);
    let lens_delay = match variables.number("lens_delay") {
        Some(delay) => delay,
        None => {
            let why = "no lens, since Trans.lensCorrection is missing";
            w.or("Trans.lensCorrection", 0.0, why)? / frequency
        }
    };
    let (rf, held) = w.samples(&rows, elements.len(), frames)?;
    let is_flat = |values: &Vec<f64>| values.iter().all(|&value| value == 0.0);
    let element_z: Vec<f64> = elements.iter().map(|e| e[1]).collect();
    let data = ChannelData {
        samples: Samples::Rf(rf),
        fs,
        t0,
        element_x: elements.iter().map(|e| e[0]).collect(),
        element_z: Some(element_z).filter(|z| !is_flat(z)),
        element_angle: Some(angles).filter(|a| !is_flat(a)),
        c,
        f0,
        transmits,
        lens_delay,
    };
    let data = data.normalised();
    data.check().map_err(|message| source.error(message))?;
    Ok((data, held, w.assumed))
}
