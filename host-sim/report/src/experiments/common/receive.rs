//! Receive parameters of an experiment.

use bonebeam::beamform::{Method, Parameters};
use bonebeam::covariance::Covariance;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use toml::Table;

use bonebeam_drive::config::Beamform;
use bonebeam_simulate::Settings;

/// Delay and beamformer parameters of an experiment, for every beamformer.
///
/// They are the keys of `[beamform]`, by default the paper's values, without those that choose a beamformer.
#[derive(Clone, Debug, PartialEq)]
pub struct Receive(pub Beamform);

/// Keys of `[beamform]` that an experiment does not accept.
///
/// It compares all beamformers, and its data have the positions of the beams.
const NOT_TAKEN: [&str; 8] = [
    "method",
    "beta",
    "rank",
    "exclude_first",
    "power_steps",
    "adaptive_depth_start",
    "adaptive_depth_end",
    "beam_spacing",
];

/// Default depths of the lines' ends, m.
const DEPTHS: [f64; 2] = [5e-3, 40e-3];

impl Default for Receive {
    /// Forward covariance and one direction per line, as in the paper's figures.
    fn default() -> Self {
        Receive(Beamform {
            covariance: Covariance::Forward,
            depth_start: Some(DEPTHS[0]),
            depth_end: Some(DEPTHS[1]),
            sub_lines: Some(1),
            ..Beamform::default()
        })
    }
}

impl Receive {
    /// The default to another end of the lines, m.
    pub fn to(end: f64) -> Self {
        Receive::between(DEPTHS[0], end)
    }

    /// The default between other ends of the lines, m.
    pub fn between(start: f64, end: f64) -> Self {
        let mut receive = Receive::default();
        (receive.0.depth_start, receive.0.depth_end) = (Some(start), Some(end));
        receive
    }

    /// Those of the paper's point.
    pub fn of_point() -> Self {
        let mut receive = Receive::between(12.5e-3, 17.5e-3);
        receive.0.f_number = 2.5;
        receive
    }

    /// Checks every value.
    ///
    /// # Errors
    /// As [`Beamform::validate`].
    pub fn validate(&self) -> crate::Result<()> {
        self.0.validate()
    }

    /// Sets missing values, with the output rate for the recordings of `scanner`.
    ///
    /// Nothing is set if the result is invalid; the scanner's own check then reports its rates.
    pub fn resolve(&mut self, scanner: &Settings) {
        let mut resolved = self.0.clone();
        resolved.resolve();
        let rate = self.0.rate(scanner.f0, scanner.fs);
        resolved.output_rate.get_or_insert(rate);
        if resolved.validate().is_ok() {
            self.0 = resolved;
        }
    }

    /// Depths of the lines' ends, m.
    pub fn depths(&self) -> [f64; 2] {
        let (start, end) = (self.0.depth_start, self.0.depth_end);
        [start.unwrap_or(DEPTHS[0]), end.unwrap_or(DEPTHS[1])]
    }

    /// The core's parameters for a method.
    pub fn parameters(&self, method: Method) -> Parameters {
        Parameters {
            method,
            ..self.0.parameters()
        }
    }
}

impl Serialize for Receive {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut table = Table::try_from(&self.0).map_err(serde::ser::Error::custom)?;
        for key in NOT_TAKEN {
            table.remove(key);
        }
        table.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Receive {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        use serde::de::Error;
        let given = Table::deserialize(deserializer)?;
        if let Some(key) = NOT_TAKEN.iter().find(|key| given.contains_key(**key)) {
            let message = format!("`{key}` has no effect on an experiment");
            return Err(D::Error::custom(message));
        }
        let default = Receive::default().0;
        let covariance = given.contains_key("covariance");
        let mut section: Beamform = given
            .try_into()
            .map_err(|e: toml::de::Error| D::Error::custom(e.message()))?;
        // The defaults of these differ from those of `[beamform]`.
        if !covariance {
            section.covariance = default.covariance;
        }
        section.sub_lines = section.sub_lines.or(default.sub_lines);
        section.depth_start = section.depth_start.or(default.depth_start);
        section.depth_end = section.depth_end.or(default.depth_end);
        Ok(Receive(section))
    }
}
