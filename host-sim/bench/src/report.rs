//! Results of the benchmark: rows with a figure, its reference and target.

use serde::{Deserialize, Serialize};

use super::machine::Machine;

/// All measurements of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The version and the commit of the program.
    pub program: String,
    /// The machine.
    pub machine: Machine,
    /// The instruction set of the core's lanes.
    pub instruction_set: String,
    /// Whether this was a quick run, whose figures are coarse.
    pub quick: bool,
    /// One table per section, in the order of the run.
    pub tables: Vec<Table>,
}

/// One section.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Table {
    /// The section's name on the command line.
    pub section: String,
    /// Title: the things compared.
    pub title: String,
    /// The data and the method of measuring.
    pub method: String,
    /// Title of the column of the references.
    pub yardstick: String,
    /// The measurements.
    pub rows: Vec<Row>,
}

/// One measurement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The task that is measured.
    pub work: String,
    /// The figure of the core.
    pub here: Quantity,
    /// The figure of the reference.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yardstick: Option<Quantity>,
    /// The quantity of the target: a ratio, a share or a rate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub result: Option<Quantity>,
    /// The target for the result.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<Target>,
    /// Whether the target is met; `None` without a target.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub met: Option<bool>,
    /// Largest difference between both sides' results, relative to the largest result.
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

/// Target of a result.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Target {
    /// At least this value.
    AtLeast(f64),
    /// At most this value.
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
    /// A measurement without a reference.
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

    /// Seconds beside others, and how many times as long they are.
    pub fn slower(
        work: impl Into<String>,
        unit: fn(f64) -> Quantity,
        [here, beside]: [f64; 2],
    ) -> Self {
        let row = Self::new(work, unit(here)).beside(unit(beside));
        row.result(here / beside, "×")
    }

    /// Seconds beside others, and how many times as long the others are.
    pub fn faster(work: impl Into<String>, unit: fn(f64) -> Quantity, seconds: [f64; 2]) -> Self {
        let [here, beside] = seconds;
        Self::slower(work, unit, seconds).result(beside / here, "×")
    }

    /// The row with its reference.
    pub fn beside(mut self, yardstick: Quantity) -> Self {
        self.yardstick = Some(yardstick);
        self
    }

    /// The row with a result.
    pub fn result(mut self, value: f64, unit: &str) -> Self {
        self.result = Some(Quantity::new(value, unit));
        self
    }

    /// The row with a target for the result.
    pub fn target(mut self, target: Target) -> Self {
        self.met = self.result.as_ref().map(|result| target.met(result.value));
        self.target = Some(target);
        self
    }

    /// The row with the difference between both sides' results.
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
