//! Channel data from named arrays: MATLAB files and other HDF5 files.
//!
//! Names and meanings are those of the `.npz` files, unless `[variables]` gives others.

mod axes;
mod laws;

use std::ops::Range;

use ndarray::{ArrayD, IxDyn};

use crate::aliases::{is_given, listed};
use crate::receivers::{channels as channels_of, merged, of_elements};
use crate::values::{NamedArrays, Values};
use crate::variables::{AXES, Given, LAWS, LINE_KEYS, RX_ELEMENT, Variables};
use crate::waves::Law;
pub(crate) use axes::Axes;
use axes::ORDER;
use bonebeam_files::{ChannelData, Error, Result, Samples, check_plane};

/// The arrays of a file, by the keys of channel data.
pub struct Keyed<'a> {
    /// The file.
    pub source: &'a dyn NamedArrays,
    /// The names of its arrays for keys.
    pub variables: &'a Variables,
    /// The delay law and the times of sample 0, if the layout gives them.
    pub law: Option<Law>,
}

/// Keys of which one is needed, and its placeholder in a command line.
type Needed = (&'static [&'static str], &'static str);

const SAMPLES: Needed = (&["rf", "iq"], "rf=NAME");
const LINES: [Needed; 2] = [(&["fs"], "fs=HZ"), (&["beam_x", "pitch"], "pitch=METRES")];
const CARRIER: Needed = (&["f_demod"], "f_demod=HZ");
/// Keys needed besides the samples.
const NEEDED: [Needed; 6] = [
    (&["fs"], "fs=HZ"),
    (&["f0"], "f0=HZ"),
    (&["c"], "c=1540"),
    (&["t0"], "t0=SECONDS"),
    (&["element_x", "pitch"], "pitch=METRES"),
    (&LAWS, "tx_angle=RADIANS"),
];

/// Keys of a delay law besides its own.
const OF_LAWS: [(&str, &[&str]); 3] = [
    ("tx_x", &["tx_focus", "tx_fnumber"]),
    ("tx_source_x", &["tx_source_z"]),
    ("tx_delay", &["tx_active"]),
];

impl Keyed<'_> {
    /// Channel data of some frames, and the number of all frames.
    ///
    /// Samples that are read whole give all frames.
    ///
    /// # Errors
    /// A key that neither the file nor the variables give, an array of another shape or type, or data that are not
    /// valid.
    pub fn channel_data(&self, frames: Range<usize>) -> Result<(ChannelData, usize)> {
        self.check_that_all_is_given(Some(SAMPLES))?;
        let (samples, held) = self.samples(frames)?;
        let (_, transmits, channels, _) = samples.dim();
        let data = match self.optional_numbers(RX_ELEMENT)? {
            Some(indices) => self.with_receivers(samples, indices)?,
            None => self.with_samples(samples, transmits, channels)?,
        };
        Ok((data, held))
    }

    /// Channel data of acquisitions, each by the elements of `indices` [acquisition, channel].
    ///
    /// Acquisitions of one wave by several elements become one transmit.
    fn with_receivers(&self, samples: Samples, indices: ArrayD<f64>) -> Result<ChannelData> {
        self.check_that_all_is_given(None)?;
        let (_, acquisitions, channels, _) = samples.dim();
        let wrong = |message: String| self.source.error(format!("`{RX_ELEMENT}` {message}"));
        let shape = indices.shape().to_vec();
        let indices = indices.into_shape_with_order(IxDyn(&[acquisitions, channels]));
        let indices = indices.map_err(|_| {
            wrong(format!(
                "has shape {shape:?}; expected that of the samples, {acquisitions} transmits of {channels} channels"
            ))
        })?;
        let is_spread = |key: &str| self.variables.get(key).is_some_and(Given::is_spread);
        let elements = match is_spread("element_x") {
            false => self.optional("element_x")?.map(|x| x.len()),
            true => None,
        };
        let elements = match elements {
            Some(elements) => elements,
            None => {
                let sent = self.optional("tx_element")?.unwrap_or_default();
                let last = indices.iter().chain(&sent).copied().fold(0.0, f64::max);
                (last as usize).saturating_add(1)
            }
        };
        let channels = channels_of(&indices, elements).map_err(wrong)?;
        let variables = self.variables.spread(acquisitions, elements);
        let keyed = |law| Keyed {
            source: self.source,
            variables: &variables,
            law,
        };
        let own = keyed(self.law.clone());
        let law = own.law_of(acquisitions, &own.positions(elements)?)?;
        let (law, of) = merged(&law, &channels);
        let samples = of_elements(samples, &channels, &of).map_err(wrong)?;
        let transmits = law.0.len();
        keyed(Some(law)).of_all(samples, transmits, elements)
    }

    /// Channel data with samples from elsewhere.
    ///
    /// # Errors
    /// As [`Keyed::channel_data`].
    pub fn with_samples(
        &self,
        samples: Samples,
        transmits: usize,
        elements: usize,
    ) -> Result<ChannelData> {
        self.check_that_all_is_given(None)?;
        let variables = self.variables.spread(transmits, elements);
        let keyed = Keyed {
            source: self.source,
            variables: &variables,
            law: self.law.clone(),
        };
        keyed.of_all(samples, transmits, elements)
    }

    /// Channel data; all keys are given.
    fn of_all(&self, samples: Samples, transmits: usize, elements: usize) -> Result<ChannelData> {
        if let Some(y) = self.optional("element_y")? {
            check_plane(&y).map_err(|message| self.source.error(message))?;
        }
        let positions = self.positions(elements)?;
        let (transmits, t0) = self.law_of(transmits, &positions)?;
        let data = ChannelData {
            samples,
            fs: self.scalar("fs")?,
            t0,
            element_x: positions.iter().map(|[x, _]| *x).collect(),
            element_z: self.optional("element_z")?,
            element_angle: self.optional("element_angle")?,
            c: self.scalar("c")?,
            f0: self.scalar("f0")?,
            transmits,
            lens_delay: match self.optional("lens_delay")? {
                Some(_) => self.scalar("lens_delay")?,
                None => 0.0,
            },
        };
        let data = data.normalised();
        data.check().map_err(|message| self.source.error(message))?;
        Ok(data)
    }

    fn check_count(&self, key: &str, count: usize, expected: usize, of: &str) -> Result<()> {
        if count == expected {
            return Ok(());
        }
        Err(self.source.error(format!(
            "{key} has length {count}; expected {expected}, one for each {of} of the samples; \
             perhaps their axes are not in the order {}; --variable axes=… gives another order",
            ORDER[1..].join(", ")
        )))
    }

    /// The positions (x, z) of the elements, m.
    fn positions(&self, elements: usize) -> Result<Vec<[f64; 2]>> {
        let x = match self.optional("element_x")? {
            Some(x) => x,
            None => self.centred(elements)?,
        };
        self.check_count("element_x", x.len(), elements, "element")?;
        let z = self.optional("element_z")?.into_iter().flatten();
        let z = z.chain(std::iter::repeat(0.0));
        Ok(x.into_iter().zip(z).map(Into::into).collect())
    }

    /// Even positions about 0, by `pitch`.
    ///
    /// # Errors
    /// No pitch, or several.
    pub fn centred(&self, elements: usize) -> Result<Vec<f64>> {
        let Some(pitch) = self.optional("pitch")? else {
            return Err(self.missing("element_x"));
        };
        let [pitch] = pitch.as_slice() else {
            return Err(self
                .source
                .error("`pitch` has several numbers; expected one".into()));
        };
        let centre = (elements.max(1) - 1) as f64 / 2.0;
        Ok((0..elements).map(|m| (m as f64 - centre) * pitch).collect())
    }

    fn missing(&self, key: &str) -> Error {
        self.source.error(format!(
            "has no `{key}`; its arrays: {}",
            listed(self.source)
        ))
    }

    /// Reports all missing keys at once, and a command line to complete.
    ///
    /// The samples are among them if they are an array.
    ///
    /// # Errors
    /// The message, with a list of the arrays in the file.
    fn check_that_all_is_given(&self, samples: Option<Needed>) -> Result<()> {
        let carrier = is_given(self.source, self.variables, "iq").then_some(CARRIER);
        self.check_needed(samples.into_iter().chain(NEEDED).chain(carrier))
    }

    /// As for channel data, for lines.
    ///
    /// # Errors
    /// As for channel data.
    pub fn check_that_lines_are_given(&self) -> Result<()> {
        self.check_needed(LINES)
    }

    fn check_needed(&self, needed: impl IntoIterator<Item = Needed>) -> Result<()> {
        let given = |key: &str| is_given(self.source, self.variables, key);
        let by_layout = |key: &str| self.law.is_some() && (key == "t0" || key.starts_with("tx_"));
        let missing: Vec<Needed> = needed
            .into_iter()
            .filter(|(keys, _)| !keys.iter().any(|key| given(key) || by_layout(key)))
            .collect();
        if missing.is_empty() {
            return Ok(());
        }
        let keys = missing
            .iter()
            .map(|(keys, _)| format!("`{}`", keys.join("` or `")));
        let flags = missing
            .iter()
            .map(|(_, text)| format!(" --variable {text}"));
        Err(self.source.error(format!(
            "has no {}; add what is missing by{}, each the name of an array or a value; its arrays: {}",
            keys.collect::<Vec<_>>().join(", no "),
            flags.collect::<String>(),
            listed(self.source)
        )))
    }

    /// Refuses keys of `given` that do not change the channel data.
    ///
    /// These are `unread`, and keys beside another one that takes their place.
    ///
    /// # Errors
    /// The message names each of them, with the reason.
    pub fn check_that_all_has_effect(&self, given: &Variables, unread: &[&str]) -> Result<()> {
        let is_given = |key: &str| is_given(self.source, self.variables, key);
        let law = LAWS
            .into_iter()
            .find(|key| is_given(key))
            .unwrap_or("tx_angle");
        let of_law = OF_LAWS.iter().find(|(name, _)| *name == law);
        let of_law = of_law.map_or(&[][..], |(_, keys)| keys);
        let wrong: Vec<String> = given
            .keys()
            .filter_map(|key| {
                let reason = match key {
                    _ if LINE_KEYS.contains(&key) => "the samples are channel data".into(),
                    _ if unread.contains(&key) => "this format does not have it".into(),
                    "f_demod" if !is_given("iq") => "the samples are RF".into(),
                    "pitch" if is_given("element_x") => "`element_x` gives the array".into(),
                    _ if key.starts_with("tx_") && key != law && !of_law.contains(&key) => {
                        format!("`{law}` gives the delay law")
                    }
                    _ => return None,
                };
                Some(format!("`{key}`, since {reason}"))
            })
            .collect();
        match wrong.is_empty() {
            true => Ok(()),
            false => Err(self.source.error(format!(
                "does not use these keys of [variables] (--variable): {}",
                wrong.join("; ")
            ))),
        }
    }

    /// The array of a key, if there is one.
    pub fn name<'b>(&'b self, key: &'b str) -> Option<&'b str> {
        match self.variables.get(key) {
            Some(Given::Name(name)) => Some(name),
            Some(_) => None,
            None => Some(key).filter(|key| self.source.has(key)),
        }
    }

    fn optional_numbers(&self, key: &str) -> Result<Option<ArrayD<f64>>> {
        match self.variables.get(key) {
            Some(Given::Number(value)) => Ok(Some(ArrayD::from_elem(IxDyn(&[]), *value))),
            Some(Given::Numbers(values)) => {
                let shape = IxDyn(&[values.len()]);
                Ok(ArrayD::from_shape_vec(shape, values.clone()).ok())
            }
            _ => self
                .name(key)
                .map(|name| self.source.all_numbers(name))
                .transpose(),
        }
    }

    /// The numbers of a key, if there are any.
    ///
    /// # Errors
    /// As [`NamedArrays::vector`].
    pub fn optional(&self, key: &str) -> Result<Option<Vec<f64>>> {
        match self.variables.get(key) {
            Some(Given::Number(value)) => Ok(Some(vec![*value])),
            Some(Given::Numbers(values)) => Ok(Some(values.clone())),
            _ => self
                .name(key)
                .map(|name| self.source.vector(name))
                .transpose(),
        }
    }

    fn vector(&self, key: &str) -> Result<Vec<f64>> {
        self.optional(key)?.ok_or_else(|| self.missing(key))
    }

    /// The number of a key.
    ///
    /// # Errors
    /// A key that is missing, or several numbers.
    pub fn scalar(&self, key: &str) -> Result<f64> {
        match self.vector(key)?.as_slice() {
            [value] => Ok(*value),
            values => Err(self.source.error(format!(
                "`{key}` has {} numbers; expected one",
                values.len()
            ))),
        }
    }

    /// One for each transmit, or one for all.
    fn each(&self, key: &str, transmits: usize) -> Result<Vec<f64>> {
        match self.vector(key)?.as_slice() {
            [value] => Ok(vec![*value; transmits]),
            values => Ok(values.to_vec()),
        }
    }

    /// Samples of one array, or of several with the same shape.
    ///
    /// The transmits of several follow each other.
    fn samples(&self, frames: Range<usize>) -> Result<(Samples, usize)> {
        for key in ["rf", "iq"] {
            let Some(Given::Names(names)) = self.variables.get(key) else {
                continue;
            };
            let mut parts = Vec::new();
            let mut held = 0;
            for name in names {
                let mut variables = self.variables.clone();
                variables.insert(key, Given::Name(name.clone()));
                let own = Keyed {
                    source: self.source,
                    variables: &variables,
                    law: None,
                };
                let (samples, of_part) = own.samples(frames.clone())?;
                held = of_part;
                parts.push(samples);
            }
            let stacked = Samples::stacked(parts);
            let stacked = stacked.ok_or_else(|| {
                self.source.error(format!(
                    "`{}` have several shapes; expected one, for the transmits of one recording",
                    names.join("`, `")
                ))
            });
            return Ok((stacked?, held));
        }
        let (key, name) = match (self.name("rf"), self.name("iq")) {
            (Some(rf), None) => ("rf", rf),
            (None, Some(iq)) => ("iq", iq),
            (Some(_), Some(_)) => {
                let both = "holds both `rf` and `iq`; expected the samples of one kind";
                return Err(self.source.error(both.into()));
            }
            (None, None) => return Err(self.missing("rf")),
        };
        let sides = self.source.sides(name);
        let list = Given::Names(["transmit", "sample"].map(str::to_owned).into());
        let is_list = self.optional_numbers(RX_ELEMENT)?.is_some()
            && sides.as_ref().is_some_and(|sides| sides.len() == 2);
        let given = self.variables.get(AXES).or(is_list.then_some(&list));
        let transmits = self.transmits_of_law()?;
        let axes = Axes::new(given, sides.as_deref(), transmits, is_list)?;
        let shape = self.source.shape_for_parts(name)?;
        let along = shape.and_then(|shape| {
            let axis = axes.of_frames(shape.len())?;
            Some((axis, shape[axis]))
        });
        let part = along.map(|(axis, _)| (axis, frames));
        let wrong = |message: String| self.source.error(format!("`{name}` {message}"));
        let samples = match (key, self.source.samples(name, part)?) {
            ("rf", Values::Real(rf)) => Samples::Rf(axes.arranged(rf).map_err(wrong)?),
            ("iq", Values::Complex(iq)) => Samples::Iq {
                iq: axes.arranged(iq).map_err(wrong)?,
                f_demod: self.scalar("f_demod")?,
            },
            ("rf", Values::Complex(_)) => {
                return Err(self.source.error(format!(
                    "`{name}` is complex; if it is I/Q, give it as --variable iq={name}, with `f_demod`"
                )));
            }
            _ => {
                return Err(self
                    .source
                    .error(format!("`{name}` is real; expected complex I/Q")));
            }
        };
        let (frames, transmits, elements, count) = samples.dim();
        if [frames, transmits, elements, count].contains(&0) {
            return Err(self.source.error(format!(
                "`{name}` is empty: {transmits} transmits of {elements} elements and {count} samples"
            )));
        }
        let held = along.map_or_else(|| samples.frames(), |(_, held)| held);
        Ok((samples, held))
    }
}
