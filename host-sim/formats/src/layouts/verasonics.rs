//! Workspaces of Verasonics' research scanners.
//!
//! By the public descriptions of their fields: lengths in wavelengths of `Trans.frequency` (MHz) at
//! `Resource.Parameters.speedOfSound`, of `Trans` in mm if `Trans.units` says so; times from the first element that
//! fires. An acquisition (`Receive`) belongs to a frame of a buffer, and an `Event` joins it with a `TX`.

mod buffer;
mod quadrature;

use std::ops::Range;

use ndarray::{Array2, Axis};

use crate::receivers::{merged, of_elements};
use crate::values::NamedArrays;
use crate::variables::{BUFFER, LAYOUT, Variables};
use crate::waves::{Fired, Wave, inverted, silence};
use bonebeam_files::{ChannelData, Result, Samples};
use quadrature::in_quadrature;

/// Whether a file is such a workspace.
pub fn is(source: &dyn NamedArrays) -> bool {
    let fields = [
        "Receive.startSample",
        "Receive.endSample",
        "Trans.frequency",
    ];
    fields.iter().all(|name| source.has(name))
}

/// A workspace; missing fields are assumed and reported.
struct Workspace<'a> {
    source: &'a dyn NamedArrays,
    /// `Trans.frequency`, Hz.
    frequency: f64,
    /// The unit of lengths, at the workspace's speed of sound, m.
    wavelength: f64,
    assumed: Vec<String>,
}

/// An acquisition of a frame.
struct Acquisition {
    /// Its number among all `Receive`, from 0.
    receive: usize,
    rows: Range<usize>,
    /// Depth of the first row, wavelengths.
    depth: f64,
    /// Whether it is added to what is in its rows.
    accumulates: bool,
}

impl Workspace<'_> {
    fn or(&mut self, name: &str, default: f64, why: &str) -> Result<f64> {
        if self.source.has(name) {
            return self.first(name);
        }
        self.assumed.push(why.to_owned());
        Ok(default)
    }

    /// The entries of a field, which are read.
    fn entries(&self, name: &str) -> Vec<String> {
        self.source.note(name);
        self.source.entries(name)
    }

    /// A number from each entry of an array of structs.
    fn each(&self, name: &str) -> Result<Vec<f64>> {
        self.source.vector(name)
    }

    fn refuse<T>(&self, message: String) -> Result<T> {
        Err(self.source.error(message))
    }

    /// A number from each of `count` structs, or the default where the field is missing.
    fn column(&self, name: &str, count: usize, default: f64) -> Result<Vec<f64>> {
        if !self.source.has(name) {
            return Ok(vec![default; count]);
        }
        let values = self.each(name)?;
        match values.len() == count {
            true => Ok(values),
            false => self.refuse(format!(
                "`{name}` has {} numbers; expected one for each of {count} entries",
                values.len()
            )),
        }
    }

    /// The unit of lengths in `Trans`, m.
    fn unit(&mut self) -> Result<f64> {
        if !self.source.has("Trans.units") {
            let why = "lengths in Trans are in wavelengths, since Trans.units is missing";
            self.assumed.push(why.into());
            return Ok(self.wavelength);
        }
        match self.source.text("Trans.units")?.as_str() {
            "mm" => Ok(1e-3),
            "wavelengths" => Ok(self.wavelength),
            other => self.refuse(format!(
                "`Trans.units` is {other}; expected mm or wavelengths"
            )),
        }
    }

    /// The positions (x, z), m, and the angles of the elements.
    fn elements(&self, unit: f64) -> Result<(Vec<[f64; 2]>, Vec<f64>)> {
        let positions = self.source.numbers("Trans.ElementPos")?;
        let shape = positions.shape().to_vec();
        if shape.len() != 2 || shape[1] < 3 {
            return self.refuse(format!(
                "`Trans.ElementPos` has shape {shape:?}; expected [element, 4 or 5]"
            ));
        }
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
        let switched = ["Receive.aperture", "TX.aperture"];
        if let Some(name) = switched.iter().find(|name| self.source.has(name)) {
            return self.refuse(format!(
                "has `{name}`, which switches elements to channels; multiplexed apertures are not read"
            ));
        }
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
    fn sampling_rate(&mut self) -> Result<f64> {
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

    /// Number of the receive buffer, from 1: the chosen one, or the first that has acquisitions.
    fn buffer(&mut self, bufnum: &[f64], chosen: Option<f64>) -> Result<f64> {
        let mut numbers = bufnum.to_vec();
        numbers.sort_by(f64::total_cmp);
        numbers.dedup();
        let listed = numbers.iter().map(f64::to_string).collect::<Vec<_>>();
        let listed = listed.join(", ");
        match chosen {
            Some(number) if numbers.contains(&number) => Ok(number),
            Some(number) => self.refuse(format!(
                "`buffer` is {number} (--variable); `Receive.bufnum` has {listed}"
            )),
            None => {
                if numbers.len() > 1 {
                    self.assumed.push(format!(
                        "receive buffer {} of {listed}; --variable buffer=N reads another",
                        numbers[0]
                    ));
                }
                Ok(numbers.first().copied().unwrap_or(1.0))
            }
        }
    }

    /// The acquisitions of each frame of a buffer, which are the same for all.
    fn acquisitions(&mut self, chosen: Option<f64>) -> Result<(Vec<Acquisition>, usize)> {
        let start = self.each("Receive.startSample")?;
        let column =
            |field: &str, default| self.column(&format!("Receive.{field}"), start.len(), default);
        let (end, frame, bufnum) = (
            column("endSample", 0.0)?,
            column("framenum", 1.0)?,
            column("bufnum", 1.0)?,
        );
        let (depth, mode) = (column("startDepth", 0.0)?, column("mode", 0.0)?);
        let buffer = self.buffer(&bufnum, chosen)?;
        let own: Vec<usize> = (0..start.len()).filter(|&k| bufnum[k] == buffer).collect();
        let first = own.first().map(|&k| frame[k]);
        // The casts saturate.
        let rows = |k: usize| (start[k].max(1.0) - 1.0) as usize..end[k].max(0.0) as usize;
        let (own, frame) = (&own, &frame);
        let of = |number: f64| own.iter().copied().filter(move |&k| frame[k] == number);
        let all: Vec<Acquisition> = first
            .into_iter()
            .flat_map(of)
            .map(|k| Acquisition {
                receive: k,
                rows: rows(k),
                depth: depth[k],
                accumulates: mode[k] != 0.0,
            })
            .collect();
        let length = all.first().map_or(0, |first| first.rows.len());
        if length == 0 || all.iter().any(|one| one.rows.len() != length) {
            let wrong = "has acquisitions of several lengths, or of none, by `Receive.startSample` and `endSample`";
            return self.refuse(wrong.into());
        }
        let is_alike = |&k: &usize| {
            of(frame[k])
                .map(rows)
                .eq(all.iter().map(|one| one.rows.clone()))
        };
        if let Some(&k) = own.iter().find(|k| !is_alike(k)) {
            return self.refuse(format!(
                "has other acquisitions in frame {} than in frame {}, by `Receive.framenum`; expected the same rows",
                frame[k], frame[own[0]]
            ));
        }
        Ok((all, buffer as usize))
    }

    /// The `TX` of each acquisition, from 0, of `count` ones.
    fn transmit_of(&mut self, acquisitions: &[Acquisition], count: usize) -> Result<Vec<usize>> {
        if count == 1 {
            return Ok(vec![0; acquisitions.len()]);
        }
        if self.source.has("Event.rcv") && self.source.has("Event.tx") {
            let received = self.each("Event.rcv")?;
            let sent = self.column("Event.tx", received.len(), 0.0)?;
            let of = |one: &Acquisition| {
                let number = (one.receive + 1) as f64;
                let event = received.iter().position(|&rcv| rcv == number);
                let tx = event.map(|event| sent[event]);
                match tx.filter(|&tx| tx >= 1.0 && tx <= count as f64) {
                    Some(tx) => Ok(tx as usize - 1),
                    None => self.refuse(format!(
                        "has no `Event` with one of the {count} `TX` for `Receive({number})`"
                    )),
                }
            };
            return acquisitions.iter().map(of).collect();
        }
        if count < acquisitions.len() {
            return self.refuse(format!(
                "has {count} `TX` for {} acquisitions per frame, and no `Event` that names the `TX` of each; save \
                 `Event` too",
                acquisitions.len()
            ));
        }
        self.assumed.push(format!(
            "acquisitions have the first {} of {count} TX in their order, since Event is missing",
            acquisitions.len()
        ));
        Ok((0..acquisitions.len()).collect())
    }

    /// Firing time of each element per acquisition, s, the waves that result, and the peaks of their pulses, s.
    fn transmits(
        &mut self,
        all: &[Acquisition],
        elements: usize,
    ) -> Result<(Array2<f64>, Vec<Wave>, Vec<f64>)> {
        let names = self.entries("TX.Delay");
        let of = self.transmit_of(all, names.len())?;
        let [apodizations, steers, foci, origins] =
            ["Apod", "Steer", "focus", "Origin"].map(|field| self.entries(&format!("TX.{field}")));
        let field = |names: &[String], k: usize| -> Result<Vec<f64>> {
            let numbers = names
                .get(k)
                .map(|name| self.source.vector(name))
                .transpose()?;
            Ok(numbers.unwrap_or_default())
        };
        let waveform = self.column("TX.waveform", names.len(), 1.0)?;
        let peak = match self.source.has("TW.peak") {
            true => self.each("TW.peak")?,
            false => {
                let why =
                    "the pulse's peak leaves an element when it fires, since TW.peak is missing";
                self.assumed.push(why.into());
                vec![0.0]
            }
        };
        let mut delay = Array2::zeros((all.len(), elements));
        let (mut waves, mut peaks) = (Vec::new(), Vec::new());
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
            for (delay, wavelengths) in row.iter_mut().zip(wavelengths) {
                *delay = wavelengths / self.frequency;
            }
            let weights = apodization.iter().copied();
            silence(row.iter_mut(), weights)
                .map_err(|place| self.source.error(inverted("TX.Apod", k, place)))?;
            // The cast saturates.
            let number = waveform[k] as usize;
            let Some(&peak) = peak.get(number.wrapping_sub(1)) else {
                return self.refuse(format!(
                    "`TX({}).waveform` is {number}; expected one of {} `TW`",
                    k + 1,
                    peak.len()
                ));
            };
            peaks.push(peak / self.frequency);
            let first = |numbers: Vec<f64>, axis: usize| numbers.get(axis).copied().unwrap_or(0.0);
            let steer = first(field(&steers, k)?, 0);
            let focus = self.wavelength * first(field(&foci, k)?, 0);
            let origin = field(&origins, k)?;
            let origin = [0, 2].map(|axis| self.wavelength * first(origin.clone(), axis));
            let source = [
                origin[0] + focus * steer.sin(),
                origin[1] + focus * steer.cos(),
            ];
            waves.push(match focus == 0.0 {
                true => Wave::Plane(steer),
                false => Wave::VirtualSource(source, origin),
            });
        }
        Ok((delay, waves, peaks))
    }

    /// Checks that acquisitions that accumulate repeat the transmit of their rows; the others remain.
    fn accumulated(&self, all: &[Acquisition], delay: &Array2<f64>) -> Result<Vec<usize>> {
        let mut kept: Vec<usize> = Vec::new();
        for (k, one) in all.iter().enumerate() {
            let same = kept.iter().find(|&&other| all[other].rows == one.rows);
            let alike = |other: usize| {
                let pairs = delay.row(k).into_iter().zip(delay.row(other));
                pairs
                    .into_iter()
                    .all(|(a, b)| a == b || a.is_nan() && b.is_nan())
            };
            match same {
                None => kept.push(k),
                Some(&other) if one.accumulates && alike(other) => {}
                Some(other) => {
                    return self.refuse(format!(
                        "has the sum of several transmits in the rows of `Receive({})` and `Receive({})`; expected \
                         one transmit, or repetitions of one (`Receive.mode` 1)",
                        all[*other].receive + 1,
                        one.receive + 1
                    ));
                }
            }
        }
        Ok(kept)
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
    let only = variables.only_numbers(&[LAYOUT, BUFFER, "fs", "c", "f0", "lens_delay"]);
    only.map_err(|e| source.error(e))?;
    let frequency = 1e6 * source.scalar("Trans.frequency")?;
    let mut w = Workspace {
        source,
        frequency,
        wavelength: 0.0,
        assumed: vec![
            "a Verasonics workspace: times count from the first element that fires".into(),
        ],
    };
    let speed = w.or(
        "Resource.Parameters.speedOfSound",
        1540.0,
        "c is 1540 m/s, since Resource.Parameters.speedOfSound is missing",
    )?;
    w.wavelength = speed / frequency;
    let c = variables.number("c").unwrap_or(speed);
    let carrier = match source.has("Receive.demodFrequency") {
        true => 1e6 * w.first("Receive.demodFrequency")?,
        false => frequency,
    };
    let f0 = variables.number("f0").unwrap_or(carrier);
    if (f0 - frequency).abs() > 0.01 * frequency && variables.number("f0").is_none() {
        let why = "f0 is the received frequency, Receive.demodFrequency, not Trans.frequency";
        w.assumed.push(why.into());
    }
    let periods = w.periods()?;
    let fs = match (variables.number("fs"), periods) {
        (Some(_), Some(_)) => {
            return w.refuse(
                "has pairs of samples at a part of the carrier's frequency; `fs` has no effect"
                    .into(),
            );
        }
        (Some(fs), None) => fs,
        (None, Some(periods)) => {
            w.assumed.push(
                "I/Q of pairs of samples a quarter of a period apart, by Receive.sampleMode".into(),
            );
            carrier / periods as f64
        }
        (None, None) => w.sampling_rate()?,
    };
    let unit = w.unit()?;
    let (elements, angles) = w.elements(unit)?;
    let (all, buffer) = w.acquisitions(variables.number(BUFFER))?;
    let (delay, waves, peaks) = w.transmits(&all, elements.len())?;
    let kept = w.accumulated(&all, &delay)?;
    let start = |k: &usize| 2.0 * all[*k].depth / frequency - peaks[*k];
    let fired = Fired {
        elements: &elements,
        delay: delay.select(Axis(0), &kept),
        start: kept.iter().map(start).collect(),
        c,
        f0,
    };
    let waves: Vec<Wave> = kept.iter().map(|&k| waves[k]).collect();
    let rows: Vec<Range<usize>> = kept.iter().map(|&k| all[k].rows.clone()).collect();
    let (mut transmits, mut t0) = fired.law(&waves);
    let receivers = w.receivers(&all, elements.len())?;
    let lens_delay = match variables.number("lens_delay") {
        Some(delay) => delay,
        None => {
            let why = "no lens, since Trans.lensCorrection is missing";
            w.or("Trans.lensCorrection", 0.0, why)? * unit / speed
        }
    };
    let (rf, held) = w.samples(&rows, elements.len(), (buffer, frames))?;
    let is_flat = |values: &Vec<f64>| values.iter().all(|&value| value == 0.0);
    let element_z: Vec<f64> = elements.iter().map(|e| e[1]).collect();
    let mut samples = match periods {
        None => Samples::Rf(rf),
        Some(periods) => Samples::Iq {
            iq: in_quadrature(&rf, periods, |transmit| carrier * t0[transmit]),
            f_demod: carrier,
        },
    };
    if let Some(channels) = receivers {
        let channels = channels.select(Axis(0), &kept);
        let (law, of) = merged(&(transmits, t0), &channels);
        (transmits, t0) = law;
        samples = of_elements(samples, &channels, &of).map_err(|e| source.error(e))?;
        let why = "Receive.Apod names the elements of each acquisition; acquisitions of one wave are one transmit";
        w.assumed.push(why.into());
    }
    let data = ChannelData {
        samples,
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
