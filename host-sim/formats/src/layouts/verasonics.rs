//! Workspaces of Verasonics' research scanners, by the public descriptions of their fields: lengths in wavelengths of
//! `Trans.frequency` (MHz) at `Resource.Parameters.speedOfSound`, times from the first element that fires.

use std::ops::Range;

use ndarray::{Array2, Array4};

use crate::values::{NamedArrays, Values};
use crate::variables::Variables;
use crate::waves::{Fired, Wave};
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

/// What is left out is assumed, and said.
struct Workspace<'a> {
    source: &'a dyn NamedArrays,
    assumed: Vec<String>,
}

impl Workspace<'_> {
    fn or(&mut self, name: &str, default: f64, why: &str) -> Result<f64> {
        if self.source.has(name) {
            return self.source.scalar(name);
        }
        self.assumed.push(why.to_owned());
        Ok(default)
    }

    /// A number of each entry of an array of structs.
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
                    "Trans.ElementPos is in wavelengths, since Trans.units is not there".into(),
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
                .push("element m is channel m, since Trans.ConnectorES is not there".into());
            return match elements <= channels {
                true => Ok((0..elements).collect()),
                false => self.refuse(format!(
                    "has {elements} elements and {channels} channels; expected a channel each"
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
                "`{name}` names channels that are not there, or not one of the {channels} for each of {elements} \
                 elements; multiplexed apertures are not read"
            )),
        }
    }
}

/// The channel data of some frames, how many there are, and what was assumed.
///
/// # Errors
/// A field is missing or of another shape, a mode of sampling that is not read, or data that are not valid.
pub fn read(
    source: &dyn NamedArrays,
    variables: &Variables,
    frames: Range<usize>,
) -> Result<(ChannelData, usize, Vec<String>)> {
    variables
        .only_numbers(&["fs", "c", "f0", "lens_delay"])
        .map_err(|e| source.error(e))?;
    let mut w = Workspace {
        source,
        assumed: vec![
            "a Verasonics workspace: times count from the first element that fires".into(),
        ],
    };
    let c = match variables.number("c") {
        Some(c) => c,
        None => w.or(
            "Resource.Parameters.speedOfSound",
            1540.0,
            "c is 1540 m/s, since Resource.Parameters.speedOfSound is not there",
        )?,
    };
    let f_trans = 1e6 * source.scalar("Trans.frequency")?;
    let f0 = variables.number("f0").unwrap_or(f_trans);
    // RF at four samples a wavelength, or at the rate that is told; bandwidth sampling leaves samples out.
    if let Some(mode) = source.entries("Receive.sampleMode").first() {
        let mode = source.text(mode)?;
        if mode != "NS200BW" {
            return w.refuse(format!(
                "was sampled by `Receive.sampleMode` {mode}, which keeps a part of the samples; expected NS200BW"
            ));
        }
    }
    let fs = if let Some(fs) = variables.number("fs") {
        fs
    } else if source.has("Receive.decimSampleRate") {
        1e6 * w.each("Receive.decimSampleRate")?[0]
    } else {
        let rate = match source.has("Receive.samplesPerWave") {
            true => w.each("Receive.samplesPerWave")?[0],
            false => 4.0,
        };
        w.assumed.push(format!("{rate} samples a wavelength of Trans.frequency, since Receive.decimSampleRate is not there"));
        rate * f_trans
    };
    let (elements, angles) = w.elements(c / f_trans)?;

    // The rows of each acquisition of a frame.
    let (start, end) = (w.each("Receive.startSample")?, w.each("Receive.endSample")?);
    let frame_of = match source.has("Receive.framenum") {
        true => w.each("Receive.framenum")?,
        false => vec![1.0; start.len()],
    };
    let is_first = |k: &usize| frame_of.get(*k) == frame_of.first();
    let first_frame: Vec<usize> = (0..start.len().min(end.len())).filter(is_first).collect();
    let rows: Vec<(usize, usize)> = first_frame
        .iter()
        .map(|&k| ((start[k].max(1.0) - 1.0) as usize, end[k].max(0.0) as usize))
        .collect();
    let samples = rows
        .first()
        .map_or(0, |(start, end)| end.saturating_sub(*start));
    if samples == 0
        || rows
            .iter()
            .any(|(start, end)| end.checked_sub(*start) != Some(samples))
    {
        return w.refuse("has acquisitions of several lengths, or of none, by `Receive.startSample` and `endSample`".into());
    }

    // The transmit of each acquisition.
    let transmits = source.entries("TX.Delay");
    let of =
        match transmits.len() {
            1 => vec![0; rows.len()],
            n if n == rows.len() => (0..n).collect(),
            n if n > rows.len() => {
                w.assumed.push(format!(
                    "the first {} of {n} TX are those of the acquisitions, in their order",
                    rows.len()
                ));
                (0..rows.len()).collect()
            }
            n => return w.refuse(format!(
                "has {n} `TX` for {} acquisitions a frame; expected one for each, or one for all",
                rows.len()
            )),
        };
    let entry = |k: usize, field: &str| {
        transmits[k]
            .strip_suffix("Delay")
            .map(|tx| format!("{tx}{field}"))
    };
    let optional = |k: usize, field: &str| -> Result<Option<Vec<f64>>> {
        // By the place among the entries: a path that MATLAB made up has no fields.
        let entries = source.entries(&format!("TX.{field}"));
        let name = entries
            .get(k)
            .cloned()
            .or_else(|| entry(k, field))
            .filter(|name| source.has(name));
        name.map(|name| source.vector(&name)).transpose()
    };
    let mut delay = Array2::zeros((rows.len(), elements.len()));
    let mut waves = Vec::new();
    for (row, &k) in of.iter().enumerate() {
        let wavelengths = source.vector(&transmits[k])?;
        let apodization = optional(k, "Apod")?;
        if wavelengths.len() != elements.len()
            || apodization
                .as_ref()
                .is_some_and(|a| a.len() != elements.len())
        {
            return w.refuse(format!(
                "`TX.Delay` has {} numbers for {} elements",
                wavelengths.len(),
                elements.len()
            ));
        }
        for (m, &of_element) in wavelengths.iter().enumerate() {
            let fires = apodization.as_ref().is_none_or(|a| a[m] != 0.0);
            delay[[row, m]] = if fires {
                of_element / f_trans
            } else {
                f64::NAN
            };
        }
        let steer = optional(k, "Steer")?
            .and_then(|s| s.first().copied())
            .unwrap_or(0.0);
        let focus = optional(k, "focus")?
            .and_then(|f| f.first().copied())
            .unwrap_or(0.0)
            * c
            / f_trans;
        let origin = optional(k, "Origin")?.unwrap_or_default();
        let at = |axis: usize| origin.get(axis).copied().unwrap_or(0.0) * c / f_trans;
        let origin = [at(0), at(2)];
        waves.push(match focus == 0.0 {
            true => Wave::Plane(steer),
            false => Wave::VirtualSource(
                [
                    origin[0] + focus * steer.sin(),
                    origin[1] + focus * steer.cos(),
                ],
                origin,
            ),
        });
    }
    let start_depth = match source.has("Receive.startDepth") {
        true => w.each("Receive.startDepth")?[first_frame[0]],
        false => 0.0,
    };
    let peak = match source.entries("TW.peak").first() {
        Some(name) => source.scalar(name)?,
        None => {
            w.assumed.push(
                "the pulse's peak leaves when an element fires, since TW.peak is not there".into(),
            );
            0.0
        }
    };
    let fired = Fired {
        elements: &elements,
        delay,
        start: vec![(2.0 * start_depth - peak) / f_trans; rows.len()],
        c,
        f0,
    };
    let (law, t0) = fired.law(&waves);
    let lens_delay = match variables.number("lens_delay") {
        Some(delay) => delay,
        None => {
            w.or(
                "Trans.lensCorrection",
                0.0,
                "no lens, since Trans.lensCorrection is not there",
            )? / f_trans
        }
    };

    let buffers = source.entries("RcvData");
    let buffer = buffers.first().map_or("RcvData", |name| name);
    if buffers.len() > 1 {
        w.assumed.push(format!(
            "the first of {} receive buffers is read",
            buffers.len()
        ));
    }
    let part = source
        .shape_for_parts(buffer)?
        .filter(|shape| shape.len() == 3)
        .map(|_| (2, frames));
    let sides = source.sides(buffer).unwrap_or_default();
    let held = sides.get(2).copied().unwrap_or(1);
    let Values::Real(data) = source.samples(buffer, part)? else {
        return w.refuse("`RcvData` is complex; expected RF".into());
    };
    let (last, there) = (
        rows.iter().map(|(_, end)| *end).max().unwrap_or(0),
        data.shape().to_vec(),
    );
    if !(2..=3).contains(&there.len()) || there[0] < last {
        return w.refuse(format!(
            "`RcvData` has shape {there:?}; expected [at least {last} rows, channel, frame]"
        ));
    }
    let channels = w.channels(elements.len(), there[1])?;
    let frames_read = there.get(2).copied().unwrap_or(1);
    let at = |frame: usize, row: usize, channel: usize| match data.ndim() {
        2 => data[[row, channel]],
        _ => data[[row, channel, frame]],
    };
    let shape = (frames_read, rows.len(), elements.len(), samples);
    let rf = Array4::from_shape_fn(shape, |(frame, transmit, m, n)| {
        at(frame, rows[transmit].0 + n, channels[m])
    });
    let is_flat = |values: &[f64]| values.iter().all(|&value| value == 0.0);
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
        transmits: law,
        lens_delay,
    };
    let data = data.normalised();
    data.check().map_err(|message| source.error(message))?;
    Ok((data, held, w.assumed))
}
