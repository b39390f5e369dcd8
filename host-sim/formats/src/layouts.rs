//! Common layouts of programs: names of arrays, order of axes, origin of times.
//!
//! Every assumption is reported.

mod completion;
mod cubdl;
#[cfg(test)]
mod tests;
mod verasonics;

use std::ops::Range;

use ndarray::Array2;

use crate::aliases::{complete, is_given};
use crate::keyed::Keyed;
use crate::layout::Layout;
use crate::values::{NamedArrays, steps};
use crate::variables::{
    AXES, BUFFER, CHANNELS, Given, LAWS, LAYOUT, ORIGIN, TIMES, TRACK, Variables,
};
use crate::waves::{Fired, Law, Wave, inverted, silence};
use bonebeam_files::{ChannelData, Result};
use completion::Completion;

/// The requested layout, or the one that the names of the arrays show.
fn layout_of(source: &dyn NamedArrays, variables: &Variables) -> Option<Layout> {
    if let Some(Given::Name(asked)) = variables.get(LAYOUT) {
        return Layout::ALL
            .into_iter()
            .find(|layout| layout.name() == asked);
    }
    if is_given(source, variables, "rf") || is_given(source, variables, "iq") {
        return None;
    }
    let names = source.names();
    let last = |wanted: &str| {
        let is = |name: &String| steps(name).last().is_some_and(|(last, _)| *last == wanted);
        names.iter().any(is)
    };
    let in_a_struct = |name: &String| {
        let parent = name.strip_suffix("fs")?;
        let is_parent = parent.ends_with(['.', '/']);
        (is_parent && source.has(&format!("{parent}pitch"))).then_some(())
    };
    if verasonics::is(source) {
        Some(Layout::Verasonics)
    } else if cubdl::is(source) {
        Some(Layout::Cubdl)
    } else if last("sensor_data") {
        Some(Layout::KWave)
    } else if last("scat") {
        Some(Layout::Field2)
    } else {
        names
            .iter()
            .any(|name| in_a_struct(name).is_some())
            .then_some(Layout::Must)
    }
}

/// Channel data of a file's arrays, number of frames, and assumptions.
///
/// # Errors
/// As [`Keyed::channel_data`].
pub fn channel_data(
    source: &dyn NamedArrays,
    variables: &Variables,
    frames: Range<usize>,
) -> Result<(ChannelData, usize, Vec<String>)> {
    let layout = layout_of(source, variables);
    if layout == Some(Layout::Verasonics) {
        return verasonics::read(source, variables, frames);
    }
    let (mut all, mut assumed) = complete(source, variables);
    let law = match layout {
        None => None,
        Some(layout) => Completion {
            source,
            layout,
            given: variables,
            all: &mut all,
            assumed: &mut assumed,
        }
        .tell()?,
    };
    let keyed = Keyed {
        source,
        variables: &all,
        law,
    };
    let (data, held) = keyed.channel_data(frames)?;
    keyed.check_that_all_has_effect(variables, &[BUFFER, CHANNELS, TRACK])?;
    Ok((data, held, assumed))
}

impl Completion<'_> {
    fn tell(&mut self) -> Result<Option<Law>> {
        let samples = ["rf", "iq"].map(|key| match self.all.get(key) {
            Some(Given::Name(name)) => Some(name.clone()),
            _ => self.source.has(key).then(|| key.to_owned()),
        });
        let [rf, iq] = samples;
        let Some(sides) = rf.or(iq).and_then(|name| self.source.sides(&name)) else {
            return Ok(None);
        };
        let [transmits, elements] = self.counts(&sides);
        *self.all = self.all.spread(transmits, elements);
        if self.layout == Layout::Cubdl {
            cubdl::tell(self, &sides)?;
        }
        let [transmits, elements] = self.counts(&sides);
        if self.layout != Layout::Field2 {
            if !self.is_given("c") {
                let (c, why) = self.speed()?;
                self.assume("c", Given::Number(c), &why);
            }
            if !self.is_given("t0") {
                let why = "t0 is 0: sample 0 is when the first element fires";
                self.assume("t0", Given::Number(0.0), why);
            }
        }
        if matches!(self.layout, Layout::KWave | Layout::Field2) && self.given.get("t0").is_none() {
            let why = "the pulse peaks when an element fires; of a pulse that peaks later give t0 earlier by as much";
            self.assumed.push(why.into());
        }
        let is_one = self.layout != Layout::Cubdl || transmits == 1;
        if self.layout != Layout::Field2 && is_one && !LAWS.iter().any(|key| self.is_given(key)) {
            let why = "plane waves straight down, since no delay law is given";
            self.assume("tx_angle", Given::Number(0.0), why);
        }
        if self.layout == Layout::KWave
            && !self.is_given("fs")
            && let Some(dt) = self.step_in_time()?
        {
            self.assume("fs", Given::Number(1.0 / dt), "fs is 1/dt");
        }
        self.curve(elements)?;
        let law = self.law(elements)?;
        if self.layout != Layout::Cubdl && self.all.get(AXES).is_none() {
            let transmits = match &law {
                Some((law, _)) => law.len(),
                None => ["tx_angle", "tx_x", "tx_element", "tx_source_x"]
                    .iter()
                    .find_map(|key| self.numbers(key).ok().flatten())
                    .map_or(1, |values| values.len()),
            };
            let mut axes = self.layout.axes().to_vec();
            let third = sides.get(2).copied().unwrap_or(1);
            if third > 1 {
                axes.push(if third == transmits {
                    "transmit"
                } else {
                    "frame"
                });
            }
            let names: Vec<String> = axes.into_iter().map(str::to_owned).collect();
            let why = format!("the axes of the samples are {}", names.join(", "));
            self.assume(AXES, Given::Names(names), &why);
        }
        Ok(law)
    }

    /// Numbers of transmits and elements along the axes of the samples.
    ///
    /// It is not yet known whether a third axis is that of frames.
    fn counts(&self, sides: &[usize]) -> [usize; 2] {
        let mut names: Vec<&str> = match self.all.get(AXES) {
            Some(Given::Names(names)) => names.iter().map(String::as_str).collect(),
            _ if self.layout == Layout::Cubdl && sides.len() == 2 => self.layout.axes().to_vec(),
            _ if self.layout == Layout::Cubdl => vec!["transmit", "element", "sample"],
            _ => [self.layout.axes().as_slice(), &["transmit"]].concat(),
        };
        // Where the transmits follow each other along the axis of the samples, the two are one.
        let is_joined = |pair: &[&str]| !pair.contains(&"element") && !pair.contains(&"frame");
        if names.len() > sides.len() && names.windows(2).any(is_joined) {
            names.retain(|name| *name != "sample");
        }
        ["transmit", "element"].map(|axis| {
            let at = names.iter().position(|name| *name == axis);
            at.and_then(|at| sides.get(at).copied()).unwrap_or(1)
        })
    }

    /// MUST's curved arrays: `radius` beside `pitch`, the edges of the array at z = 0.
    fn curve(&mut self, elements: usize) -> Result<()> {
        let beside = match self.all.get("pitch") {
            Some(Given::Name(pitch)) => pitch
                .strip_suffix("pitch")
                .map(|path| format!("{path}radius")),
            _ => None,
        };
        let (Some(name), Layout::Must) = (beside.filter(|name| self.source.has(name)), self.layout)
        else {
            return Ok(());
        };
        let (radius, Some(pitch)) = (self.source.scalar(&name)?, self.number("pitch")?) else {
            return Ok(());
        };
        if !radius.is_finite() {
            return Ok(());
        }
        let step = 2.0 * (pitch / 2.0 / radius).asin();
        let angles = centred(elements, step);
        let edge = radius * angles.first().map_or(1.0, |angle| angle.cos());
        let of = |f: &dyn Fn(&f64) -> f64| Given::Numbers(angles.iter().map(f).collect());
        let (x, z) = (of(&|a| radius * a.sin()), of(&|a| radius * a.cos() - edge));
        self.all.insert("element_z", z);
        self.all.insert("element_angle", of(&|a| *a));
        self.assume(
            "element_x",
            x,
            &format!("the array is curved, by the file's {name}"),
        );
        Ok(())
    }

    /// An array from any place in the file.
    fn anywhere(&self, wanted: &str) -> Option<String> {
        let is = |name: &String| steps(name).last().is_some_and(|(last, _)| *last == wanted);
        self.source.names().into_iter().find(is)
    }

    /// The speed of sound if no number gives it, m/s, and why: the median of a map.
    fn speed(&self) -> Result<(f64, String)> {
        let Some(name) = self.anywhere("sound_speed") else {
            return Ok((1540.0, "c is 1540 m/s, which the file does not give".into()));
        };
        let mut map: Vec<f64> = self.source.all_numbers(&name)?.into_iter().collect();
        map.sort_by(f64::total_cmp);
        let median = map.get(map.len() / 2).copied().unwrap_or(1540.0);
        Ok((median, format!("c is {median} m/s, the median of {name}")))
    }

    /// k-Wave's time step `dt`, s.
    fn step_in_time(&self) -> Result<Option<f64>> {
        let name = self.anywhere("dt");
        name.map(|name| self.source.scalar(&name)).transpose()
    }

    /// The delay law if delays give it, as MUST's: a plane wave if they match one.
    ///
    /// Any other law is left to its key, and so is the origin of times, by [`TIMES`].
    fn law(&mut self, elements: usize) -> Result<Option<Law>> {
        let is_first = match self.all.get(TIMES) {
            Some(Given::Name(from)) => from != ORIGIN,
            _ => self.layout != Layout::Field2,
        };
        if !is_first {
            return Ok(None);
        }
        let why = "times count from the first element that fires";
        self.assume(TIMES, Given::Name("first".into()), why);
        let (Some(Given::Name(name)), Some(c), Some(f0), Some(mut start)) = (
            self.all.get("tx_delay").cloned(),
            self.number("c")?,
            self.number("f0")?,
            self.numbers("t0")?,
        ) else {
            return Ok(None);
        };
        let x = match (self.numbers("element_x")?, self.number("pitch")?) {
            (Some(x), _) => x,
            (None, Some(pitch)) => centred(elements, pitch),
            (None, None) => return Ok(None),
        };
        let z = self
            .numbers("element_z")?
            .unwrap_or_else(|| vec![0.0; x.len()]);
        let delay = self.delays(&name, x.len())?;
        let plane =
            |delay: ndarray::ArrayView1<'_, f64>| Wave::Plane(steering(&x, delay.as_slice(), c));
        let waves: Vec<Wave> = delay.outer_iter().map(plane).collect();
        if let [one] = start[..] {
            start = vec![one; waves.len()];
        }
        if start.len() != waves.len() {
            return Err(self.source.error(format!(
                "`t0` has length {}; expected {}, one for each transmit",
                start.len(),
                waves.len()
            )));
        }
        let elements: Vec<[f64; 2]> = x.iter().zip(&z).map(|(&x, &z)| [x, z]).collect();
        let fired = Fired {
            elements: &elements,
            delay,
            start,
            c,
            f0,
        };
        Ok(Some(fired.law(&waves)))
    }

    /// Delays as [transmit, element]: one row per transmit, or a vector for one.
    fn delays(&self, name: &str, elements: usize) -> Result<Array2<f64>> {
        let delay = self.source.all_numbers(name)?;
        let shape = delay.shape().to_vec();
        let values: Vec<f64> = delay.iter().copied().collect();
        let rows = values.len() / elements.max(1);
        let rows_of_elements = shape.last() == Some(&elements) || rows == 1;
        let mut delay = Array2::from_shape_vec((rows, elements), values);
        let fields = self
            .source
            .entries(&name.replace("TXdelay", "TXapodization"));
        if let (Ok(delay), [field]) = (&mut delay, &fields[..])
            && field != name
        {
            let weights = self.source.vector(field)?;
            if weights.len() != elements {
                return Err(self.source.error(format!(
                    "`{field}` has {} numbers; expected one for each of {elements} elements",
                    weights.len()
                )));
            }
            silence(delay.iter_mut(), weights.iter().copied().cycle()).map_err(|place| {
                self.source
                    .error(inverted(field, place / elements, place % elements))
            })?;
        }
        delay.ok().filter(|_| rows_of_elements && rows > 0).ok_or_else(|| {
            self.source.error(format!(
                "`{name}` has shape {shape:?}; expected [transmit, element] with {elements} elements"
            ))
        })
    }
}

/// Positions of elements at a pitch, centred on 0.
fn centred(elements: usize, pitch: f64) -> Vec<f64> {
    let centre = (elements.max(1) - 1) as f64 / 2.0;
    (0..elements).map(|m| (m as f64 - centre) * pitch).collect()
}

/// Angle of the plane wave that is closest to these delays, rad.
fn steering(x: &[f64], delay: Option<&[f64]>, c: f64) -> f64 {
    let pairs: Vec<(f64, f64)> = x
        .iter()
        .copied()
        .zip(delay.into_iter().flatten().copied())
        .collect();
    let fires: Vec<&(f64, f64)> = pairs.iter().filter(|(_, delay)| !delay.is_nan()).collect();
    let count = fires.len() as f64;
    let (mx, md) = fires
        .iter()
        .fold((0.0, 0.0), |(a, b), (x, d)| (a + x / count, b + d / count));
    let (xd, xx) = fires.iter().fold((0.0, 0.0), |(a, b), (x, d)| {
        (a + (x - mx) * (d - md), b + (x - mx) * (x - mx))
    });
    if xx > 0.0 {
        (c * xd / xx).clamp(-1.0, 1.0).asin()
    } else {
        0.0
    }
}
