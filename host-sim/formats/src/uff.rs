//! `channel_data` of USTB's Ultrasound File Format: HDF5, one group per object.

use std::ops::Range;

use num_complex::Complex;

use crate::hdf5::Store;
use crate::values::{NamedArrays, Values};
use crate::variables::Variables;
use bonebeam_files::{ChannelData, OUT_OF_PLANE, Result, Samples, Transmits};

/// Speed of sound if a file gives none, m/s.
const SOUND_SPEED: f64 = 1540.0;
/// Largest distance of a source from the element that it is, m.
const AT_ELEMENT: f64 = 1e-6;

/// A wave of the sequence.
struct Wave {
    kind: Kind,
    /// The moment when it passes its origin, on the clock of the samples, s.
    delay: f64,
}

enum Kind {
    /// Angle of a plane wave, rad.
    Plane(f64),
    /// A source at (x, z), and the origin of its time.
    VirtualSource([f64; 2], [f64; 2]),
}

/// The groups that hold channel data.
fn groups(store: &Store) -> Vec<String> {
    let mut groups = store.groups("");
    groups.retain(|name| store.mark(name, "class").as_deref() == Some("uff.channel_data"));
    groups
}

/// Whether a file is UFF, with or without channel data.
pub fn is(store: &Store) -> bool {
    let class = |name: &String| store.mark(name, "class");
    store
        .groups("")
        .iter()
        .filter_map(class)
        .any(|class| class.starts_with("uff."))
}

/// Refuses files of version 0.3, whose objects and references are others.
///
/// # Errors
/// The file is one of them; the message has the arrays to name.
pub fn refuse_other_version(store: &Store, variables: &Variables) -> Result<()> {
    let groups = ["uff.channel_data", "channel_data"].into_iter();
    let mut others = groups.filter(|group| {
        store.has(&format!("{group}/data_real"))
            && store.has_group(&format!("{group}/unique_events"))
    });
    match others.next() {
        Some(group) if variables.is_empty() => Err(store.error(format!(
            "is UFF of version 0.3, whose events and waves are not read; name its samples and give the rest: --variable \
             rf={group}/data_real --variable axes=frame,transmit,element,sample --variable \
             fs={group}/unique_events/00000001/receive_setup/sampling_frequency --variable \
             c={group}/sound_speed --variable f0=HZ --variable pitch=METRES --variable t0=SECONDS --variable \
             tx_angle=RADIANS, or write it anew by pyuff_ustb"
        ))),
        _ => Ok(()),
    }
}

/// Channel data of some frames, the number of all frames, and assumptions.
///
/// # Errors
/// There are no channel data, or an array of them is missing, has another type or shape, or is not valid.
pub fn read(
    store: &Store,
    variables: &Variables,
    frames: Range<usize>,
) -> Result<(ChannelData, usize, Vec<String>)> {
    let groups = groups(store);
    let group = groups.first().ok_or_else(|| {
        store.error("holds no `channel_data`; beamformed data are not read".into())
    })?;
    let mut assumed = Vec::new();
    if groups.len() > 1 {
        assumed.push(format!("`{group}` is read, of {}", groups.join(", ")));
    }
    let at = |name: &str| format!("{group}/{name}");
    let optional = |name: &str| match store.has(&at(name)) {
        true => store.scalar(&at(name)).map(Some),
        false => Ok(None),
    };
    let [element_x, element_z, element_angle] = elements(store, &at("probe"))?;
    let waves = waves(store, &at("sequence"))?;
    let modulation = optional("modulation_frequency")?.unwrap_or(0.0);
    let modulation = variables.number("f_demod").unwrap_or(modulation);
    let given = [optional("pulse/center_frequency")?, Some(modulation)];
    let given = given.into_iter().flatten().find(|&f0| f0 > 0.0);
    let f0 = variables.number("f0").or(given).ok_or_else(|| {
        store.error("has no centre frequency (`pulse`); give it by --variable f0=HZ".into())
    })?;
    let c = match variables.number("c") {
        Some(c) => Some(c),
        None => optional("sound_speed")?,
    };
    let c = c.unwrap_or_else(|| {
        assumed.push("c is 1540 m/s, which the file does not give".into());
        SOUND_SPEED
    });
    let start = optional("initial_time")?.unwrap_or(0.0);
    let positions: Vec<[f64; 2]> = element_x
        .iter()
        .zip(&element_z)
        .map(|(&x, &z)| [x, z])
        .collect();
    let (transmits, t0) = law(&waves, start, c, &positions)
        .ok_or_else(|| store.error("mixes plane waves with others; expected one kind".into()))?;
    let (samples, held) = samples(store, &at("data"), frames, modulation, &waves)?;
    let data = ChannelData {
        samples,
        fs: match variables.number("fs") {
            Some(fs) => fs,
            None => store.scalar(&at("sampling_frequency"))?,
        },
        t0,
        element_x,
        element_z: Some(element_z).filter(|z| z.iter().any(|&z| z != 0.0)),
        element_angle: Some(element_angle).filter(|a| a.iter().any(|&a| a != 0.0)),
        c,
        f0,
        transmits,
        lens_delay: variables.number("lens_delay").unwrap_or(0.0),
    };
    let data = data.normalised();
    data.check().map_err(|message| store.error(message))?;
    Ok((data, held, assumed))
}

/// The elements' x, z and angles.
///
/// From the probe's list, or from a linear or curved array.
fn elements(store: &Store, probe: &str) -> Result<[Vec<f64>; 3]> {
    let at = |name: &str| format!("{probe}/{name}");
    if store.has(&at("geometry")) {
        let geometry = store.numbers(&at("geometry"))?;
        if geometry.ndim() != 2 || geometry.shape()[0] < 4 {
            return Err(store.misshapen(&at("geometry"), geometry.shape(), "[7, element]"));
        }
        let row = |row: usize| -> Vec<f64> {
            let row = geometry.index_axis(ndarray::Axis(0), row);
            row.iter().copied().collect()
        };
        if let Some(index) = row(1).iter().position(|y| y.abs() > OUT_OF_PLANE) {
            return Err(store.error(format!(
                "`{}` is out of the image plane at element {index}; expected one row of elements, not \
                 a matrix",
                at("geometry")
            )));
        }
        return Ok([row(0), row(2), row(3)]);
    }
    let count = store.scalar(&at("N"))?;
    if !(1.0..=65_536.0).contains(&count) {
        return Err(store.error(format!(
            "`{}` is {count}; expected a number of elements",
            at("N")
        )));
    }
    let pitch = store.scalar(&at("pitch"))?;
    let indices = (0..count as usize).map(|m| m as f64 - (count - 1.0) / 2.0);
    if !store.has(&at("radius")) {
        let x: Vec<f64> = indices.map(|index| index * pitch).collect();
        let zero = vec![0.0; x.len()];
        return Ok([x, zero.clone(), zero]);
    }
    let radius = store.scalar(&at("radius"))?;
    let step = 2.0 * (pitch / 2.0 / radius).asin();
    let angles: Vec<f64> = indices.map(|index| index * step).collect();
    let along = |f: fn(f64) -> f64| angles.iter().map(move |&a| radius * f(a));
    let x = along(f64::sin).collect();
    let z = along(f64::cos).map(|z| z - radius).collect();
    Ok([x, z, angles])
}

fn waves(store: &Store, sequence: &str) -> Result<Vec<Wave>> {
    if store.has_group(&format!("{sequence}/source")) {
        return Ok(vec![wave(store, sequence)?]);
    }
    let mut names = store.groups(sequence);
    // sequence_0001 to sequence_9999, sequence_10000 …
    names.sort_by_key(|name| (name.len(), name.clone()));
    if names.is_empty() {
        return Err(store.error(format!("`{sequence}` has no wave")));
    }
    let each = names.iter().map(|name| format!("{sequence}/{name}"));
    each.map(|name| wave(store, &name)).collect()
}

fn wave(store: &Store, name: &str) -> Result<Wave> {
    let optional = |field: &str| {
        let path = format!("{name}/{field}");
        match store.has(&path) {
            true => store.scalar(&path).map(Some),
            false => Ok(None),
        }
    };
    // USTB's enumeration: plane 0, spherical 1, photoacoustic 2.
    let front = optional("wavefront")?.unwrap_or(1.0);
    let distance = optional("source/distance")?.unwrap_or(0.0);
    let azimuth = optional("source/azimuth")?.unwrap_or(0.0);
    for field in ["source/elevation", "origin/elevation"] {
        if optional(field)?.unwrap_or(0.0).abs() > OUT_OF_PLANE {
            return Err(store.error(format!(
                "`{name}/{field}` is not 0; expected waves of the image plane"
            )));
        }
    }
    let delay = optional("delay")?.unwrap_or(0.0);
    let position =
        |distance: f64, azimuth: f64| [distance * azimuth.sin(), distance * azimuth.cos()];
    let origin = match optional("origin/distance")?.unwrap_or(0.0) {
        distance if distance.is_finite() && distance != 0.0 => {
            position(distance, optional("origin/azimuth")?.unwrap_or(0.0))
        }
        _ => [0.0, 0.0],
    };
    let kind = match front {
        0.0 => Kind::Plane(azimuth),
        1.0 if !distance.is_finite() => Kind::Plane(azimuth),
        1.0 => Kind::VirtualSource(position(distance, azimuth), origin),
        _ => {
            return Err(store.error(format!(
                "`{name}` is not a transmitted wave (wavefront {front}); expected plane or spherical ones"
            )));
        }
    };
    Ok(Wave { kind, delay })
}

/// The delay law of the waves, and the time of sample 0 of each from its origin.
///
/// `None` for waves of several kinds.
fn law(waves: &[Wave], start: f64, c: f64, elements: &[[f64; 2]]) -> Option<(Transmits, Vec<f64>)> {
    let start = |wave: &Wave| start + wave.delay;
    let plane = |wave: &Wave| match wave.kind {
        Kind::Plane(angle) => Some(angle),
        Kind::VirtualSource(..) => None,
    };
    let angle: Option<Vec<f64>> = waves.iter().map(plane).collect();
    if let Some(angle) = angle {
        let t0 = waves.iter().map(start).collect();
        return Some((Transmits::Plane { angle }, t0));
    }
    let source = |wave: &Wave| match wave.kind {
        Kind::Plane(_) => None,
        Kind::VirtualSource(source, origin) => Some((source, origin)),
    };
    let sources: Vec<_> = waves.iter().map(source).collect::<Option<_>>()?;
    // Each at an element: single-element transmits, whose time counts from that element.
    let element = |[x, z]: [f64; 2]| {
        let at = |&[ex, ez]: &[f64; 2]| (ex - x).hypot(ez - z) < AT_ELEMENT;
        elements.iter().position(at)
    };
    let index: Option<Vec<usize>> = sources.iter().map(|&(source, _)| element(source)).collect();
    if let Some(index) = index {
        let later = |([sx, sz], [ox, oz]): &([f64; 2], [f64; 2])| (sx - ox).hypot(sz - oz) / c;
        let t0 = waves.iter().zip(&sources);
        let t0 = t0
            .map(|(wave, source)| start(wave) + later(source))
            .collect();
        return Some((Transmits::Element { index }, t0));
    }
    // Each straight below its own origin: one line a transmit.
    let below = |&([sx, sz], [ox, oz]): &([f64; 2], [f64; 2])| {
        sz > 0.0 && (sx - ox).abs() < 1e-9 && oz.abs() < 1e-9
    };
    let apart = sources.windows(2).all(|pair| pair[0].0[0] != pair[1].0[0]);
    if sources.len() > 1 && apart && sources.iter().all(below) {
        let (x, focus) = sources
            .iter()
            .map(|(source, _)| (source[0], source[1]))
            .unzip();
        let f_number = None;
        let t0 = waves.iter().map(start).collect();
        return Some((Transmits::Focused { x, focus, f_number }, t0));
    }
    let t0 = waves
        .iter()
        .zip(&sources)
        .map(|(wave, ([sx, sz], [ox, oz]))| {
            // From the wave's own origin to x = 0, z = 0.
            let further = sx.hypot(*sz) - (sx - ox).hypot(sz - oz);
            start(wave) + if *sz > 0.0 { further / c } else { -further / c }
        });
    let t0 = t0.collect();
    let (x, z) = sources
        .iter()
        .map(|(source, _)| (source[0], source[1]))
        .unzip();
    Some((Transmits::VirtualSource { x, z }, t0))
}

/// The samples, from [frame, wave, channel, sample].
///
/// Leading axes of length 1 may be missing. The carrier phase of USTB's I/Q counts from time 0 of the samples, that of
/// channel data from each wave's origin.
fn samples(
    store: &Store,
    name: &str,
    frames: Range<usize>,
    modulation: f64,
    waves: &[Wave],
) -> Result<(Samples, usize)> {
    let whole = store.shape_for_parts(name)?;
    let along = whole.as_ref().filter(|shape| shape.len() == 4);
    let along = along.map(|shape| shape[0]);
    let values = store.samples(name, along.map(|_| (0, frames)))?;
    let shape = values.shape().to_vec();
    let wrong = || {
        let expected = format!("[frame, {} waves, channel, sample]", waves.len());
        store.misshapen(name, whole.as_ref().unwrap_or(&shape), &expected)
    };
    if !(2..=4).contains(&shape.len()) {
        return Err(wrong());
    }
    let mut full = vec![1; 4 - shape.len()];
    full.extend(&shape);
    if full[1] != waves.len() {
        return Err(wrong());
    }
    let full = (full[0], full[1], full[2], full[3]);
    let held = along.unwrap_or(full.0);
    match values {
        Values::Real(rf) => {
            let rf = rf.into_shape_with_order(full).map_err(|_| wrong())?;
            Ok((Samples::Rf(rf), held))
        }
        Values::Complex(iq) => {
            if modulation <= 0.0 {
                return Err(store.error(
                    "is I/Q, and `modulation_frequency` is 0; give it by --variable f_demod=HZ"
                        .into(),
                ));
            }
            let mut iq = iq.into_shape_with_order(full).map_err(|_| wrong())?;
            for (transmit, wave) in waves.iter().enumerate() {
                let phase = -std::f64::consts::TAU * modulation * wave.delay;
                if phase != 0.0 {
                    let phasor = Complex::from_polar(1.0, phase);
                    let mut own = iq.index_axis_mut(ndarray::Axis(1), transmit);
                    own.mapv_inplace(|sample| {
                        let wide =
                            Complex::new(f64::from(sample.re), f64::from(sample.im)) * phasor;
                        Complex::new(wide.re as f32, wide.im as f32)
                    });
                }
            }
            let f_demod = modulation;
            Ok((Samples::Iq { iq, f_demod }, held))
        }
    }
}
