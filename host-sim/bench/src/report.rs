//! What the benchmark found: tables of rows, each with a figure, its yardstick and its target.

use serde::{Deserialize, Serialize};

use super::machine::Machine;

/// Everything that one run measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The version and the commit of the program.
    pub program: String,
    /// Where.
    pub machine: Machine,
    /// The instruction set of the core's lanes.
    pub instruction_set: String,
    /// Whether it was a short look, whose figures are coarse.
    pub quick: bool,
    /// One a section, in the order of the run.
    pub tables: Vec<Table>,
}

/// One section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// The section's name on the command line.
    pub section: String,
    /// What it compares.
    pub title: String,
    /// The data and the way of measuring.
    pub method: String,
    /// What the column of the yardsticks holds.
    pub yardstick: String,
    /// The measurements.
    pub rows: Vec<Row>,
}

/// One measurement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The work.
    pub work: String,
    /// What the core took or gave.
    pub here: Quantity,
    /// The same of what it is compared with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yardstick: Option<Quantity>,
    /// What the target is about: a ratio, a share or a rate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub result: Option<Quantity>,
    /// The target for the result.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<Target>,
    /// Whether the target is met; none without a target.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub met: Option<bool>,
    /// The largest difference between the results of the two sides, relative to the largest result.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub difference: Option<f64>,
}

/// A number and its unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quantity {
    /// The number.
    pub value: f64,
    /// The unit, "×" for a ratio.
    pub unit: String,
}

/// What a result should be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Target {
    /// This or more.
    AtLeast(f64),
    /// This or less.
    AtMost(f64),
}

impl Quantity {
    /// A number with its unit.
    pub fn new(value: f64, unit: &str) -> Self {
        Quantity {
            value,
            unit: unit.to_owned(),
        }
    }

    /// A time in s, as µs.
    pub fn microseconds(seconds: f64) -> Self {
        Self::new(1e6 * seconds, "µs")
    }

    /// A time in s, as ms.
    pub fn milliseconds(seconds: f64) -> Self {
        Self::new(1e3 * seconds, "ms")
    }
}

impl Row {
    /// A measurement by itself.
    pub fn new(work: impl Into<String>, here: Quantity) -> Self {
        Row {
            work: work.into(),
            here,
            yardstick: None,
            result: None,
            target: None,
            met: None,
            difference: None,
        }
    }

    /// Beside its yardstick.
    pub fn beside(mut self, yardstick: Quantity) -> Self {
        self.yardstick = Some(yardstick);
        self
    }

    /// With what follows from it.
    pub fn result(mut self, value: f64, unit: &str) -> Self {
        self.result = Some(Quantity::new(value, unit));
        self
    }

    /// With a target for the result.
    pub fn target(mut self, target: Target) -> Self {
        self.met = self.result.as_ref().map(|result| target.met(result.value));
        self.target = Some(target);
        self
    }

    /// With the difference between the two sides' results.
    pub fn difference(mut self, difference: f64) -> Self {
        self.difference = Some(difference);
        self
    }
}

impl Target {
    fn met(self, value: f64) -> bool {
        match self {
            Target::AtLeast(least) => value >= least,
            Target::AtMost(most) => value <= most,
        }
    }
}
