//! zea's HDF5 files: raw data of a track, with the parameters of scan and probe.
//!
//! zea counts time from the first element that fires, and its pulse has its peak some time after that.

pub mod poses;

use std::ops::Range;

use ndarray::{Array2, Array4, Axis, Ix5};
use num_complex::Complex;

use crate::hdf5::Store;
use crate::receivers::{self, NONE, merged, of_elements};
use crate::values::{NamedArrays, Values};
use crate::variables::{Given, TRACK, Variables};
use crate::waves::{Fired, Wave, inverted, silence};
use bonebeam_files::memory::{self, product};
use bonebeam_files::terminal::digits;
use bonebeam_files::{ChannelData, OUT_OF_PLANE, Result, Samples, Transmits};

/// Sampling rate of zea's waveforms, Hz.
const WAVEFORM_RATE: f64 = 250e6;
/// Half a period of the slowest pulse, in samples of a waveform.
const MAX_HALF_PERIOD: f64 = 2000.0;
/// Speed of sound if a file gives none, m/s.
const SOUND_SPEED: f64 = 1540.0;

/// Groups with raw data: files of zea 0.1 have tracks, older ones do not.
fn folders(store: &Store) -> Vec<String> {
    let tracks = store.groups("tracks");
    let tracks = tracks.iter().map(|track| format!("tracks/{track}/"));
    let holds = |folder: &String| store.has(&format!("{folder}data/raw_data"));
    let mut folders: Vec<String> = tracks.filter(holds).collect();
    if folders.is_empty() {
        folders.extend([String::new()].into_iter().filter(holds));
    }
    folders
}

/// Whether a file is zea's, unless the variables name its samples.
///
/// # Errors
/// A file of zea without raw data.
pub fn is(store: &Store, variables: &Variables) -> Result<bool> {
    let marked = ["zea_version", "us_machine", "probe"];
    let marked = marked.iter().any(|name| store.mark("", name).is_some());
    if !folders(store).is_empty() {
        return Ok(marked || store.has_group("scan"));
    }
    let keys = ["rf", "iq", "lines"];
    let is_named = keys.iter().any(|key| variables.get(key).is_some());
    let is_own = marked && store.has_group("tracks") || store.mark("", "zea_version").is_some();
    if is_own && !is_named {
        let of_data = |name: &String| name.contains("data/");
        let held: Vec<String> = store.names().into_iter().filter(of_data).collect();
        return Err(store.error(format!(
            "is a zea file without `data/raw_data`, the channel data; images cannot be beamformed; it holds {}",
            if held.is_empty() { "no data".into() } else { held.join(", ") }
        )));
    }
    Ok(false)
}

fn name(folder: &str) -> &str {
    folder.trim_start_matches("tracks/").trim_end_matches('/')
}

fn label(store: &Store, folder: &str) -> Option<String> {
    store.word(&format!("{folder}label")).ok()
}

/// The tracks with raw data: names, and labels in parentheses.
pub fn tracks(store: &Store) -> Vec<[String; 2]> {
    let mut folders = folders(store);
    folders.retain(|folder| !folder.is_empty());
    let label =
        |folder: &String| label(store, folder).map_or(String::new(), |label| format!(" ({label})"));
    let of = |folder: String| [name(&folder).to_owned(), label(&folder)];
    folders.into_iter().map(of).collect()
}

/// The group of the chosen track, or of the only one with raw data.
fn folder(store: &Store, chosen: Option<&Given>) -> Result<String> {
    let folders = folders(store);
    let is = |folder: &&String, track: &String| {
        name(folder) == track || label(store, folder).as_ref() == Some(track)
    };
    if let Some(Given::Name(track)) = chosen
        && let Some(folder) = folders.iter().find(|folder| is(folder, track))
    {
        return Ok(folder.clone());
    }
    if let (None, [folder]) = (chosen, &folders[..]) {
        return Ok(folder.clone());
    }
    let held = tracks(store).into_iter().map(|[track, label]| {
        let shape = store.shape(&format!("tracks/{track}/data/raw_data"))?;
        Ok(format!("{track}{label} {shape:?}"))
    });
    let held: Vec<String> = held.collect::<Result<_>>()?;
    Err(store.error(format!(
        "has raw data in {} tracks; --track NAME chooses one: {} [frame, transmit, sample, element, channel]",
        held.len(),
        held.join(", ")
    )))
}

/// Channel data of some frames of a track, number of all frames, and assumptions.
///
/// # Errors
/// An array is missing, of another type or shape, or not valid; several tracks of which none is chosen.
pub fn read(
    store: &Store,
    variables: &Variables,
    frames: Range<usize>,
) -> Result<(ChannelData, usize, Vec<String>)> {
    let folder = folder(store, variables.get(TRACK))?;
    let scan = |name: &str| format!("{folder}scan/{name}");
    let number = |name: &str, key: &str| -> Result<f64> {
        let values = store.vector(&scan(name))?;
        match values.as_slice() {
            [first, rest @ ..] if rest.iter().all(|v| v == first) => Ok(*first),
            _ => Err(store.error(format!(
                "`{name}` differs between transmits; --variable {key}=NUMBER gives one"
            ))),
        }
    };
    let elements = elements(store, &scan)?;
    let mut assumed = others(store, &folder);
    let c = match variables.number("c") {
        Some(c) => c,
        None if store.has(&scan("sound_speed")) => number("sound_speed", "c")?,
        None => {
            assumed.push("c is 1540 m/s, which the file does not give".into());
            SOUND_SPEED
        }
    };
    // The pulse is sent at one frequency, and a harmonic is received at another.
    let optional = |name: &str| {
        let value = store.has(&scan(name)).then(|| number(name, "f0"));
        value.transpose()
    };
    let f0 = variables.number("f0");
    let sent = match optional("center_frequency") {
        Err(_) if f0.is_some() => None,
        sent => sent?,
    };
    let received = optional("demodulation_frequency")?;
    let name = format!("{folder}data/raw_data");
    // RF that was not demodulated may have 0.
    let is_iq = store.shape(&name)?.last() == Some(&2);
    let f0 = f0.or(received.filter(|&f0| is_iq || f0 != 0.0)).or(sent);
    let Some((f0, sent)) = f0.map(|f0| (f0, sent.unwrap_or(f0))) else {
        return Err(store.error("has no `center_frequency`; give it by --variable f0=HZ".into()));
    };
    if f0 != sent {
        let given = variables.number("f0").map(|_| "as given");
        let from = given.unwrap_or("by demodulation_frequency");
        assumed.push(format!(
            "f0 is the received frequency, {} MHz, {from}; the pulse was sent at {} MHz, center_frequency",
            digits(f0 / 1e6),
            digits(sent / 1e6)
        ));
    }
    if let Some(lens) = lens(store)?
        && variables.number("lens_delay").is_none()
    {
        assumed.push(format!(
            "the probe's lens is not added, since initial_times may hold it; --variable lens_delay={lens:.4e} adds it"
        ));
    }
    let of_custom = |name: &String| name.starts_with("custom/") && name.contains("lens");
    if let Some(name) = store.names().into_iter().find(of_custom) {
        assumed.push(format!(
            "{name} is not added; --variable lens_delay=SECONDS adds a lens, one way"
        ));
    }
    let fs = variables
        .number("fs")
        .map_or_else(|| number("sampling_frequency", "fs"), Ok)?;
    let delay = delays(store, &scan, elements.len())?;
    let transmits = delay.nrows();
    let peaks = peaks(store, &scan, transmits, sent)?;
    if !["t_peak", "waveforms_two_way"]
        .iter()
        .any(|name| store.has(&scan(name)))
    {
        let why = "the pulse peaks a period of center_frequency after an element fires, since t_peak and \
                   waveforms_two_way are missing";
        assumed.push(why.into());
    }
    let start = each(store, &scan("initial_times"), transmits)?;
    let fired = Fired {
        elements: &elements,
        delay,
        start: start.iter().zip(&peaks).map(|(t, peak)| t - peak).collect(),
        c,
        f0,
    };
    let (law, t0) = fired.law(&waves(store, &scan, transmits)?);
    if matches!(law, Transmits::Delays { .. }) {
        assumed.push("elements fire by t0_delays, which are not the waves of polar_angles and focus_distances".into());
    }
    let f_demod = received.unwrap_or(f0);
    let receivers = scan("rx_aperture_indices");
    let channels = match store.has(&receivers) {
        true => Some(channels(store, &receivers, [transmits, elements.len()])?),
        false => None,
    };
    if let Some(channels) = &channels {
        let first = channels.row(0);
        let recorded = first.iter().filter(|channel| **channel != NONE);
        assumed.push(format!(
            "of each transmit {} of {} elements were recorded, by rx_aperture_indices; the others are 0",
            recorded.count(),
            elements.len()
        ));
    }
    if store.has(&scan("tgc_gain_curve")) {
        let why = "the samples keep the gain over depth that was applied to them, tgc_gain_curve";
        assumed.push(why.into());
    }
    let (mut samples, held) = samples(store, &name, frames, f_demod, &t0)?;
    let recorded = samples.dim().2;
    if channels.is_none() && recorded < elements.len() {
        return Err(store.error(format!(
            "`{name}` has {recorded} channels of {} elements, and no `rx_aperture_indices` that name them",
            elements.len()
        )));
    }
    let (mut law, mut t0) = (law, t0);
    if let Some(channels) = channels {
        let (of_waves, of) = merged(&(law, t0), &channels);
        (law, t0) = of_waves;
        samples = of_elements(samples, &channels, &of).map_err(|e| store.error(e))?;
    }
    let data = ChannelData {
        samples,
        fs,
        t0,
        element_x: elements.iter().map(|e| e[0]).collect(),
        element_z: elements
            .iter()
            .any(|e| e[1] != 0.0)
            .then(|| elements.iter().map(|e| e[1]).collect()),
        element_angle: None,
        c,
        f0,
        transmits: law,
        lens_delay: variables.number("lens_delay").unwrap_or(0.0),
    };
    let data = data.normalised();
    data.check().map_err(|message| store.error(message))?;
    Ok((data, held, assumed))
}

/// Says that other tracks are not read, whose arrays need no list of their own.
fn others(store: &Store, own: &str) -> Vec<String> {
    let folder = |track: String| format!("tracks/{track}/");
    let mut folders: Vec<String> = store.groups("tracks").into_iter().map(folder).collect();
    folders.retain(|folder| folder != own);
    let names = store.names().into_iter();
    let of_others = names.filter(|name| folders.iter().any(|folder| name.starts_with(folder)));
    of_others.for_each(|name| store.note(&name));
    let named = |folder: &String| match label(store, folder) {
        Some(label) => format!("{} ({label})", folder.trim_end_matches('/')),
        None => folder.trim_end_matches('/').to_owned(),
    };
    if folders.is_empty() {
        return Vec::new();
    }
    let others: Vec<String> = folders.iter().map(named).collect();
    let own = named(&own.to_owned());
    vec![format!("{own} is read, not {}", others.join(", "))]
}

/// Time through the probe's lens, one way, s.
fn lens(store: &Store) -> Result<Option<f64>> {
    let names = ["probe/lens_thickness", "probe/lens_sound_speed"];
    if !names.iter().all(|name| store.has(name)) {
        return Ok(None);
    }
    let time = store.scalar(names[0])? / store.scalar(names[1])?;
    Ok((time.is_finite() && time > 0.0).then_some(time))
}

/// The positions (x, z) of the elements.
fn elements(store: &Store, scan: &dyn Fn(&str) -> String) -> Result<Vec<[f64; 2]>> {
    let names = ["probe/probe_geometry".to_owned(), scan("probe_geometry")];
    let name = names
        .iter()
        .find(|name| store.has(name))
        .unwrap_or(&names[0]);
    let geometry = store.numbers(name)?;
    if geometry.ndim() != 2 || geometry.shape()[1] != 3 {
        return Err(store.misshapen(name, geometry.shape(), "[element, 3]"));
    }
    let mut elements = Vec::new();
    for (index, position) in geometry.axis_iter(Axis(0)).enumerate() {
        if position[1].abs() > OUT_OF_PLANE {
            return Err(store.error(format!(
                "`{name}` is out of the image plane by {} m at element {index}; expected one row of \
                 elements, not a matrix",
                digits(position[1])
            )));
        }
        elements.push([position[0], position[2]]);
    }
    Ok(elements)
}

/// Firing time of each element, s; NaN if it does not fire.
fn delays(store: &Store, scan: &dyn Fn(&str) -> String, elements: usize) -> Result<Array2<f64>> {
    let table = |name: &str| -> Result<Array2<f64>> {
        let values = store.numbers(&scan(name))?;
        let shape = values.shape().to_vec();
        let table: Option<Array2<f64>> = values.into_dimensionality().ok();
        table.filter(|t| t.ncols() == elements).ok_or_else(|| {
            store.misshapen(name, &shape, &format!("[transmit, {elements} elements]"))
        })
    };
    let mut delay = table("t0_delays")?;
    if store.has(&scan("tx_apodizations")) {
        let apodization = table("tx_apodizations")?;
        if apodization.dim() != delay.dim() {
            return Err(store.error("`tx_apodizations` has another shape than `t0_delays`".into()));
        }
        silence(delay.iter_mut(), apodization.iter().copied()).map_err(|place| {
            let sides = elements.max(1);
            store.error(inverted("tx_apodizations", place / sides, place % sides))
        })?;
    }
    let mut waves = delay.outer_iter();
    match waves.position(|wave| wave.iter().all(|delay| delay.is_nan())) {
        None => Ok(delay),
        Some(transmit) => Err(store.error(format!(
            "`tx_apodizations` is 0 at every element of transmit {transmit}: a passive recording has no delays to its echoes"
        ))),
    }
}

fn each(store: &Store, name: &str, transmits: usize) -> Result<Vec<f64>> {
    let values = store.vector(name)?;
    match values.len() {
        1 => Ok(vec![values[0]; transmits]),
        count if count == transmits => Ok(values),
        count => Err(store.error(format!(
            "`{name}` has length {count}; expected {transmits}, one for each transmit"
        ))),
    }
}

/// Time from the firing of an element to the peak of the pulse.
///
/// It is that of the two-way waveform, else a period.
fn peaks(
    store: &Store,
    scan: &dyn Fn(&str) -> String,
    transmits: usize,
    f0: f64,
) -> Result<Vec<f64>> {
    if store.has(&scan("t_peak")) {
        return each(store, &scan("t_peak"), transmits);
    }
    let name = scan("waveforms_two_way");
    if !store.has(&name) {
        return Ok(vec![1.0 / f0; transmits]);
    }
    let waveforms = store.numbers(&name)?;
    if waveforms.ndim() != 2 || waveforms.shape()[0] != transmits || waveforms.shape()[1] == 0 {
        let expected = format!("[{transmits} transmits, sample]");
        return Err(store.misshapen(&name, waveforms.shape(), &expected));
    }
    let peak = |waveform: ndarray::ArrayViewD<'_, f64>| envelope_peak(waveform.iter().copied(), f0);
    Ok(waveforms.axis_iter(Axis(0)).map(peak).collect())
}

/// Time of the envelope's peak, s.
///
/// The waveform is multiplied by a carrier and averaged over a period.
fn envelope_peak(waveform: impl Iterator<Item = f64>, f0: f64) -> f64 {
    let phase = |n: usize| std::f64::consts::TAU * f0 * n as f64 / WAVEFORM_RATE;
    let mixed: Vec<Complex<f64>> = waveform
        .enumerate()
        .map(|(n, value)| Complex::from_polar(value, -phase(n)))
        .collect();
    let half = (0.5 * WAVEFORM_RATE / f0)
        .round()
        .clamp(0.0, MAX_HALF_PERIOD) as usize;
    let sum = |n: usize| {
        let last = mixed.len().min(n + half + 1);
        mixed[n.saturating_sub(half)..last]
            .iter()
            .sum::<Complex<f64>>()
    };
    let (mut best, mut peak) = (0.0, 0);
    for n in 0..mixed.len() {
        let level = sum(n).norm_sqr();
        if level > best {
            (best, peak) = (level, n);
        }
    }
    peak as f64 / WAVEFORM_RATE
}

fn waves(store: &Store, scan: &dyn Fn(&str) -> String, transmits: usize) -> Result<Vec<Wave>> {
    let angles = each(store, &scan("polar_angles"), transmits)?;
    let focus = each(store, &scan("focus_distances"), transmits)?;
    if store.has(&scan("azimuth_angles")) {
        let azimuth = each(store, &scan("azimuth_angles"), transmits)?;
        if let Some(transmit) = azimuth.iter().position(|a| a.abs() > 1e-6) {
            return Err(store.error(format!(
                "`azimuth_angles` is {} at transmit {transmit}; expected 0, waves of the image plane",
                digits(azimuth[transmit])
            )));
        }
    }
    let mut origins = vec![[0.0; 2]; transmits];
    if store.has(&scan("transmit_origins")) {
        let positions = store.numbers(&scan("transmit_origins"))?;
        if positions.shape() != [transmits, 3] {
            let expected = format!("[{transmits} transmits, 3]");
            return Err(store.misshapen("transmit_origins", positions.shape(), &expected));
        }
        for (origin, position) in origins.iter_mut().zip(positions.axis_iter(Axis(0))) {
            *origin = [position[0], position[2]];
        }
    }
    let waves = angles.iter().zip(&focus).zip(&origins);
    Ok(waves
        .map(|((angle, focus), &[x, z])| match *focus {
            0.0 => Wave::Plane(*angle),
            focus if !focus.is_finite() => Wave::Plane(*angle),
            focus => {
                let (sine, cosine) = angle.sin_cos();
                Wave::VirtualSource([x + focus * sine, z + focus * cosine], [x, z])
            }
        })
        .collect())
}

/// The receive channel of each element, [transmit, element], of a walking or multiplexed aperture.
fn channels(store: &Store, name: &str, sides: [usize; 2]) -> Result<Array2<usize>> {
    let indices = store.numbers(name)?;
    if indices.ndim() != 2 || indices.shape()[0] != sides[0] {
        let expected = format!("[{} transmits, channel]", sides[0]);
        return Err(store.misshapen(name, indices.shape(), &expected));
    }
    let channels = receivers::channels(&indices, sides[1]);
    channels.map_err(|message| store.error(format!("`{name}` {message}")))
}

/// The samples, from [frame, transmit, sample, element, channel].
///
/// The carrier phase of zea's I/Q counts from sample 0 of each transmit, that of channel data from the wave's origin.
fn samples(
    store: &Store,
    name: &str,
    frames: Range<usize>,
    f_demod: f64,
    t0: &[f64],
) -> Result<(Samples, usize)> {
    let shape = store.shape(name)?;
    let part = (shape.len() == 5).then_some((0, frames));
    let values = match store.samples(name, part)? {
        Values::Real(values) => values.into_dimensionality::<Ix5>().ok(),
        Values::Complex(_) => None,
    };
    let wrong = || {
        let expected = format!(
            "real numbers as [frame, {} transmits, sample, element, 1 of RF or 2 of I/Q]",
            t0.len()
        );
        store.misshapen(name, &shape, &expected)
    };
    let values = values.ok_or_else(wrong)?;
    let (frames, transmits, samples, elements, parts) = values.dim();
    if transmits != t0.len() || !(1..=2).contains(&parts) {
        return Err(wrong());
    }
    let order = (frames, transmits, elements, samples);
    let bytes = product(&[
        frames,
        transmits,
        elements,
        samples,
        parts * size_of::<f32>(),
    ]);
    memory::check(bytes, "the samples").map_err(|e| store.error(e.to_string()))?;
    if parts == 1 {
        let rf = Array4::from_shape_fn(order, |(f, t, e, n)| values[(f, t, n, e, 0)]);
        return Ok((Samples::Rf(rf), shape[0]));
    }
    let phasors: Vec<Complex<f64>> = t0
        .iter()
        .map(|t0| Complex::from_polar(1.0, -std::f64::consts::TAU * f_demod * t0))
        .collect();
    let iq = Array4::from_shape_fn(order, |(f, t, e, n)| {
        let [re, im] = [0, 1].map(|part| f64::from(values[(f, t, n, e, part)]));
        let rotated = Complex::new(re, im) * phasors[t];
        Complex::new(rotated.re as f32, rotated.im as f32)
    });
    Ok((Samples::Iq { iq, f_demod }, shape[0]))
}
