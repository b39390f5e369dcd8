//! The tuned variables: keys of the configuration with their ranges.

use crate::experiments::study::*;
use bonebeam::surface::Settings;
use toml::{Table, Value};

use bonebeam_drive::config::{Beamform, Preset, Surface};
use bonebeam_drive::methods::MethodName;

/// The sections of a configuration that are tuned or follow from tuned ones.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sections {
    /// Delay and beamformer.
    pub beamform: Beamform,
    /// The image, over the detector's dynamic range.
    pub image: Image,
    /// The detector.
    pub surface: Surface,
}

/// A key that is tuned.
#[derive(Clone, Copy, Debug)]
pub struct Variable {
    /// Section of the key: `beamform` or `surface`.
    section: &'static str,
    pub key: &'static str,
    /// Smallest and largest value.
    range: [f64; 2],
    scale: Scale,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scale {
    Linear,
    Logarithmic,
    Whole,
    /// 0: chosen by the recording, and pooled; n: 2ⁿ⁻¹ sub-lines, each written.
    SubLines,
}

const fn of_beamformer(key: &'static str, scale: Scale, range: [f64; 2]) -> Variable {
    Variable {
        section: "beamform",
        key,
        range,
        scale,
    }
}

const fn of_detector(key: &'static str, range: [f64; 2]) -> Variable {
    Variable {
        section: "surface",
        key,
        range,
        scale: Scale::Linear,
    }
}

/// All variables.
///
/// The first two apply to every method, the next three to methods with a covariance, and the sixth to those with β.
const VARIABLES: [Variable; 16] = [
    of_beamformer("f_number", Scale::Linear, [0.8, 3.0]),
    of_beamformer("sub_lines", Scale::SubLines, [0.0, 2.0]),
    of_beamformer("temporal_half_window", Scale::Whole, [0.0, 16.0]),
    of_beamformer("subaperture_ratio", Scale::Linear, [0.15, 0.6]),
    of_beamformer("diagonal_loading", Scale::Logarithmic, [2e-3, 1.0]),
    of_beamformer("beta", Scale::Logarithmic, [1e-5, 0.5]),
    of_detector("grey_range", [40.0, 80.0]),
    of_detector("absence", [-4.0, 1.0]),
    of_detector("end_price", [1.0, 10.0]),
    of_detector("jump_price", [4.0, 16.0]),
    of_detector("slope_price", [0.5, 6.0]),
    of_detector("contrast", [0.0, 3.0]),
    of_detector("level", [0.0, 3.0]),
    of_detector("rest", [0.0, 4.0]),
    of_detector("shadow", [0.0, 4.0]),
    of_detector("margin", [0.0, 1.0]),
];

impl Variable {
    /// The variables of a method, the beamformer's first.
    pub fn of_method(method: MethodName) -> Vec<Variable> {
        let takes = |variable: &&Variable| match variable.key {
            "temporal_half_window" | "subaperture_ratio" | "diagonal_loading" => {
                method != MethodName::Das
            }
            "beta" => method.takes().contains(&"beta"),
            _ => true,
        };
        VARIABLES.iter().filter(takes).copied().collect()
    }

    /// The variables of the detector alone.
    pub fn of_detector() -> Vec<Variable> {
        let mut all = Variable::of_method(MethodName::Das);
        all.retain(|variable| !variable.needs_new_lines());
        all
    }

    /// Whether a change of the value changes the lines.
    pub fn needs_new_lines(&self) -> bool {
        self.section == "beamform"
    }

    /// The range of [`Variable::place`], the end excluded.
    pub fn positions(&self) -> [f64; 2] {
        let [low, high] = self.range;
        match self.scale {
            Scale::Linear => [low, high],
            Scale::Logarithmic => [low.ln(), high.ln()],
            Scale::Whole | Scale::SubLines => [low, high + 1.0],
        }
    }

    /// The place of a value for the optimiser, limited to the range.
    pub fn position(&self, value: f64) -> f64 {
        let [low, high] = self.positions();
        let position = match self.scale {
            Scale::Logarithmic => value.ln(),
            Scale::Linear => value,
            Scale::Whole | Scale::SubLines => value + 0.5,
        };
        position.clamp(low, high.next_down())
    }

    /// The value at a place, with three digits.
    pub fn value(&self, position: f64) -> f64 {
        match self.scale {
            Scale::Linear => three_digits(position),
            Scale::Logarithmic => three_digits(position.exp()),
            Scale::Whole | Scale::SubLines => position.floor(),
        }
    }

    /// Reads the value from a configuration.
    fn read(&self, sections: &Table) -> f64 {
        let value = sections.get(self.section).and_then(|s| s.get(self.key));
        let number = match value {
            Some(Value::Integer(n)) => *n as f64,
            Some(Value::Float(x)) => *x,
            _ => 0.0,
        };
        match self.scale {
            Scale::SubLines if number >= 1.0 => number.log2() + 1.0,
            _ => number,
        }
    }

    fn write(&self, value: f64, sections: &mut Table) {
        let Some(Value::Table(section)) = sections.get_mut(self.section) else {
            return;
        };
        let written = match self.scale {
            Scale::Linear | Scale::Logarithmic => Value::Float(value),
            Scale::Whole => Value::Integer(value as i64),
            Scale::SubLines if value < 1.0 => {
                section.remove(self.key);
                return;
            }
            Scale::SubLines => Value::Integer(1 << (value as u32 - 1)),
        };
        section.insert(self.key.into(), written);
    }
}

fn three_digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

impl Sections {
    /// The start of a method's search.
    ///
    /// It has the method's own parameters in place of another method's, the depth step of `--preset live`, and all
    /// parameters of the detector.
    pub fn start(&self, method: MethodName) -> Sections {
        let mut start = self.clone();
        let beamform = &mut start.beamform;
        if beamform.method != method {
            beamform.method = method;
            (beamform.beta, beamform.rank, beamform.power_steps) = (None, None, None);
            beamform.exclude_first = false;
        }
        if method.takes().contains(&"beta") {
            beamform.rank = None;
        }
        (beamform.preset, beamform.depth_step) = (Some(Preset::Live), None);
        beamform.resolve();
        let usual = Settings::COHERENCE;
        let surface = &mut start.surface;
        for (value, usual) in [
            (&mut surface.absence, usual.absence),
            (&mut surface.end_price, usual.end),
            (&mut surface.jump_price, usual.jump),
            (&mut surface.slope_price, 1e-3 * usual.slope),
            (&mut surface.contrast, usual.contrast.weight),
            (&mut surface.level, usual.level.weight),
            (&mut surface.rest, usual.rest.weight),
            (&mut surface.shadow, -usual.shadow.weight),
            (&mut surface.margin, usual.margin),
        ] {
            value.get_or_insert(usual);
        }
        start
    }

    /// The values of variables.
    pub fn values(&self, variables: &[Variable]) -> Result<Vec<f64>> {
        let table = Table::try_from(self).map_err(cannot_be_written)?;
        Ok(variables.iter().map(|v| v.read(&table)).collect())
    }

    /// The sections with other values of variables.
    pub fn with(&self, variables: &[Variable], values: &[f64]) -> Result<Sections> {
        let mut table = Table::try_from(self).map_err(cannot_be_written)?;
        for (variable, value) in variables.iter().zip(values) {
            variable.write(*value, &mut table);
        }
        let mut sections: Sections = table.try_into().map_err(cannot_be_written)?;
        sections.image.dynamic_range = sections.surface.grey_range;
        Ok(sections)
    }

    /// The sections as TOML, for `--config`.
    pub fn toml(&self) -> Result<String> {
        toml::to_string(self).map_err(cannot_be_written)
    }
}

fn cannot_be_written(error: impl std::fmt::Display) -> Error {
    Error::Data(format!("the configuration cannot be written: {error}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every place of every variable is a valid value of the configuration, and is read back.
    #[test]
    fn every_value_is_one_of_the_configuration() {
        for method in MethodName::ALL {
            let variables = Variable::of_method(method);
            let start = Sections::default().start(method);
            assert_eq!(start.beamform.method, method);
            for fraction in [0.0, 0.31, 0.77, 1.0] {
                let position = |v: &Variable| {
                    let [low, high] = v.positions();
                    v.value((low + fraction * (high - low)).min(high.next_down()))
                };
                let values: Vec<f64> = variables.iter().map(position).collect();
                let made = start.with(&variables, &values).unwrap();
                made.beamform.validate().unwrap();
                made.image.validate().unwrap();
                made.surface.validate().unwrap();
                assert_eq!(made.values(&variables).unwrap(), values);
                for (variable, value) in variables.iter().zip(&values) {
                    assert_eq!(
                        variable.value(variable.position(*value)),
                        *value,
                        "{variable:?}"
                    );
                }
            }
        }
    }

    /// With the values of the start, the detector has the core's settings.
    #[test]
    fn the_start_is_the_default() {
        let start = Sections::default().start(MethodName::Mv);
        let variables = Variable::of_method(MethodName::Mv);
        let values = start.values(&variables).unwrap();
        let again = start.with(&variables, &values).unwrap();
        assert_eq!(again, start);
        let settings = again.surface.settings(Settings::COHERENCE);
        assert_eq!(settings, Surface::default().settings(Settings::COHERENCE));
        assert_eq!(Variable::of_detector().len(), 10);
    }
}
