//! Section `[variables]`: names and values of the keys of channel data.
//!
//! It gives the names of arrays in the file, and values that the file lacks.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::layout::Layout;

/// Keys that stand for arrays.
pub const KEYS: [&str; 23] = [
    "rf",
    "iq",
    "f_demod",
    "fs",
    "f0",
    "c",
    "t0",
    "element_x",
    "element_y",
    "element_z",
    "element_angle",
    "lens_delay",
    "tx_x",
    "tx_focus",
    "tx_fnumber",
    "tx_angle",
    "tx_element",
    "tx_source_x",
    "tx_source_z",
    "tx_delay",
    "tx_active",
    RX_ELEMENT,
    // The distance between neighbouring elements, m, where there is no `element_x`: centred on 0.
    "pitch",
];
/// Elements that recorded each transmit, one for each channel.
pub const RX_ELEMENT: &str = "rx_element";
/// Keys of lines.
pub const LINE_KEYS: [&str; 4] = ["lines", "beam_x", "beam_z", "beam_angle"];
/// Keys of which one gives the delay law.
pub const LAWS: [&str; 5] = ["tx_x", "tx_angle", "tx_element", "tx_source_x", "tx_delay"];
/// The order of the axes of the samples.
pub const AXES: &str = "axes";
/// Program whose layout the arrays have.
pub const LAYOUT: &str = "layout";
/// Origin of the times of sample 0 in a layout.
///
/// [`ORIGIN`] of the delay law, or the first element that fires, `first`.
pub const TIMES: &str = "times";
/// [`TIMES`] from the origin of the delay law.
pub const ORIGIN: &str = "origin";
/// Number of the receive buffer of a Verasonics workspace, from 1.
pub const BUFFER: &str = "buffer";
/// Name of a track of zea's file.
pub const TRACK: &str = "track";
/// Keys that stand for neither arrays nor numbers of channel data.
const OTHERS: [&str; 7] = [AXES, BUFFER, CHANNELS, LAYOUT, TIMES, TRACK, IQ_CONJUGATE];
/// Whether I/Q has the opposite sign of the carrier; 1 conjugates it.
pub const IQ_CONJUGATE: &str = "iq_conjugate";
/// The order of the channels of a SonixDAQ folder.
pub const CHANNELS: &str = "channels";

/// Section `[variables]`: for each key the name of an array, or a value.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Variables(BTreeMap<String, Given>);

/// Value of a key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Given {
    /// A value.
    Number(f64),
    /// The name of an array.
    Name(String),
    /// Values.
    Numbers(Vec<f64>),
    /// Names of axes.
    Names(Vec<String>),
}

/// A number, or degrees as radians: `10deg`.
fn number(text: &str) -> Option<f64> {
    match text.trim().strip_suffix("deg") {
        Some(degrees) => degrees.trim().parse().ok().map(f64::to_radians),
        None => text.trim().parse().ok(),
    }
}

impl Given {
    /// The ends of `FIRST..LAST`.
    fn ends(&self) -> Option<[f64; 2]> {
        let Given::Name(text) = self else { return None };
        let (first, last) = text.split_once("..")?;
        Some([number(first)?, number(last)?])
    }

    /// Whether it is `FIRST..LAST`: evenly spaced numbers over transmits or elements.
    pub fn is_spread(&self) -> bool {
        self.ends().is_some()
    }
}

impl Variables {
    /// The variables with numbers in place of each `FIRST..LAST`.
    #[must_use]
    pub fn spread(&self, transmits: usize, elements: usize) -> Self {
        let spread = |(key, given): (&String, &Given)| {
            let of_elements = key.starts_with("element_");
            let count = if of_elements { elements } else { transmits };
            let values = given.ends().map(|[first, last]| {
                let step = (last - first) / (count.max(2) - 1) as f64;
                (0..count).map(|k| first + k as f64 * step).collect()
            });
            (key.clone(), values.map_or(given.clone(), Given::Numbers))
        };
        Self(self.0.iter().map(spread).collect())
    }

    /// Whether it is empty.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// All keys.
    pub fn keys(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }

    /// Value of a key, if given.
    pub fn get(&self, key: &str) -> Option<&Given> {
        self.0.get(key)
    }

    /// Sets the value of a key.
    pub fn insert(&mut self, key: &str, given: Given) {
        self.0.insert(key.to_owned(), given);
    }

    /// Parses `KEY=VALUE` of the command line.
    ///
    /// The value is a number, numbers with commas, the ends of evenly spaced numbers (`-16deg..16deg`), a name, or
    /// names with commas.
    ///
    /// # Errors
    /// There is no `=`, or nothing on one side of it.
    pub fn take(&mut self, text: &str) -> Result<(), String> {
        let (key, value) = text
            .split_once('=')
            .map(|(key, value)| (key.trim(), value.trim()))
            .filter(|(key, value)| !key.is_empty() && !value.is_empty())
            .ok_or_else(|| format!("{text}: expected KEY=NAME or KEY=NUMBER"))?;
        let parts = || value.split(',').map(str::trim);
        let numbers: Option<Vec<f64>> = parts().map(number).collect();
        let given = match numbers.as_deref() {
            Some([number]) => Given::Number(*number),
            Some(numbers) => Given::Numbers(numbers.to_vec()),
            None if key == AXES || ["rf", "iq"].contains(&key) && value.contains(',') => {
                Given::Names(parts().map(str::to_owned).collect())
            }
            None => Given::Name(value.to_owned()),
        };
        self.0.insert(key.to_owned(), given);
        Ok(())
    }

    /// Value of a key, if it is a number.
    pub fn number(&self, key: &str) -> Option<f64> {
        match self.get(key) {
            Some(Given::Number(value)) => Some(*value),
            _ => None,
        }
    }

    /// Checks that only numbers for these keys are given.
    ///
    /// The file gives the rest itself.
    ///
    /// # Errors
    /// A key that has no effect.
    pub fn only_numbers(&self, keys: &[&str]) -> Result<(), String> {
        let has_effect = |key: &str| {
            let fits = [LAYOUT, TRACK].contains(&key) || self.number(key).is_some();
            key == IQ_CONJUGATE || keys.contains(&key) && fits
        };
        let Some(key) = self.0.keys().find(|key| !has_effect(key)) else {
            return Ok(());
        };
        let numbers: Vec<&str> = keys
            .iter()
            .copied()
            .filter(|key| ![LAYOUT, TRACK].contains(key))
            .collect();
        let others = match &numbers[..] {
            [] => String::new(),
            numbers => format!("; numbers for {} have an effect", numbers.join(", ")),
        };
        let flag = match &key[..] {
            LAYOUT => "--layout",
            TRACK => "--track",
            _ => "--variable",
        };
        Err(format!(
            "`{key}` in [variables] ({flag}) has no effect on a file of this format, which names its arrays \
             itself{others}"
        ))
    }

    /// Checks every key and its value.
    ///
    /// # Errors
    /// The first wrong one.
    pub fn check(&self) -> Result<(), String> {
        for (key, given) in &self.0 {
            let fits = match (key.as_str(), given) {
                (AXES, Given::Names(_)) | (CHANNELS | TRACK, Given::Name(_)) => true,
                (LAYOUT, Given::Name(name)) => {
                    Layout::ALL.into_iter().any(|layout| layout.name() == name)
                }
                (IQ_CONJUGATE, Given::Number(turn)) => [0.0, 1.0].contains(turn),
                (BUFFER, Given::Number(number)) => *number >= 1.0 && number.fract() == 0.0,
                (TIMES, Given::Name(from)) => [ORIGIN, "first"].contains(&from.as_str()),
                (AXES | BUFFER | CHANNELS | LAYOUT | TIMES | TRACK | IQ_CONJUGATE, _) => false,
                ("lines", given) => matches!(given, Given::Name(_)),
                ("rf" | "iq", given) => matches!(given, Given::Name(_) | Given::Names(_)),
                (_, Given::Names(_)) => false,
                (_, Given::Number(value)) => value.is_finite(),
                (_, Given::Numbers(values)) => values.iter().all(|v| v.is_finite()),
                (_, Given::Name(_)) => true,
            };
            let known = [&OTHERS[..], &KEYS, &LINE_KEYS];
            if !known.iter().any(|keys| keys.contains(&key.as_str())) {
                return Err(format!(
                    "`{key}` in [variables] (--variable) is unknown; expected {}",
                    known.map(|keys| keys.join(", ")).join(", ")
                ));
            }
            if !fits {
                return Err(format!(
                    "`{key}` in [variables] (--variable) has a wrong value; `{AXES}` takes names of axes, `{BUFFER}` a number from 1, \
                     `{LAYOUT}` one of {}, `{IQ_CONJUGATE}` 0 or 1, `{TIMES}` {ORIGIN} or first, `rf` and `iq` the name of an array, or one name \
                     per transmit with commas between them, the others a name or finite \
                     numbers",
                    Layout::ALL.map(Layout::name).join(", ")
                ));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_effect_is_told_with_what_has() {
        let mut variables = Variables::default();
        variables.insert("c", Given::Name("speed".into()));
        let refused = |keys: &[&str]| variables.only_numbers(keys).unwrap_err();
        assert!(
            refused(&["c", "fs"])
                .ends_with("names its arrays itself; numbers for c, fs have an effect")
        );
        assert!(refused(&[]).ends_with("names its arrays itself"));
        variables.insert("c", Given::Number(1500.0));
        assert_eq!(variables.only_numbers(&["c"]), Ok(()));
        variables.insert(LAYOUT, Given::Name("must".into()));
        assert_eq!(variables.only_numbers(&[LAYOUT, "c"]), Ok(()));
        let refused = variables.only_numbers(&["c"]).unwrap_err();
        assert!(
            refused.contains("`layout` in [variables] (--layout) has no effect"),
            "{refused}"
        );
    }

    #[test]
    fn names_and_numbers_are_distinguished() {
        let mut variables = Variables::default();
        for text in [
            "rf=RcvData",
            "fs = 40e6",
            "tx_angle=-0.1,0,0.1",
            "axes=sample,element,transmit",
        ] {
            variables.take(text).unwrap();
        }
        assert_eq!(variables.get("fs"), Some(&Given::Number(40e6)));
        assert_eq!(
            variables.get("tx_angle"),
            Some(&Given::Numbers(vec![-0.1, 0.0, 0.1]))
        );
        assert_eq!(
            variables.get("rf"),
            Some(&Given::Name("RcvData".to_owned()))
        );
        variables.check().unwrap();
        variables.take("tx_angle=-180deg..90deg").unwrap();
        variables.take("element_x=-3..1").unwrap();
        let spread = variables.spread(4, 3);
        let quarter = std::f64::consts::FRAC_PI_2;
        let angles = [-2.0 * quarter, -quarter, 0.0, quarter];
        assert_eq!(spread.get("tx_angle"), Some(&Given::Numbers(angles.into())));
        let x = Given::Numbers(vec![-3.0, -1.0, 1.0]);
        assert_eq!(spread.get("element_x"), Some(&x));
        variables.take("tx_angle=90deg").unwrap();
        assert_eq!(variables.number("tx_angle"), Some(quarter));
        variables.take("fs=").unwrap_err();
        variables.take("fs").unwrap_err();
        for wrong in ["depth=3", "rf=3", "axes=3", "fs=nan"] {
            let mut variables = Variables::default();
            variables.take(wrong).unwrap();
            let message = variables.check().unwrap_err();
            assert!(
                message.contains(wrong.split('=').next().unwrap()),
                "{message}"
            );
        }
    }
}
