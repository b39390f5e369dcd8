//! Findings: what a check has to say.

use std::fmt::{self, Display, Formatter};

use serde::Serialize;

/// How wrong a picture of the recording is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// A value that agrees with the file, or that cannot be measured.
    Note,
    /// Depths, levels or single elements are wrong.
    Warning,
    /// The picture is wrong.
    Error,
}

/// One result of a check.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Its name, the same in every run.
    pub name: &'static str,
    /// Its severity.
    pub severity: Severity,
    /// The measured value, in `unit`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// The interval of 95 % of the value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval: Option<[f64; 2]>,
    /// Unit of the value.
    #[serde(skip_serializing_if = "str::is_empty")]
    pub unit: &'static str,
    /// Shift of an echo in the middle of the record, mm; positive for an echo that is drawn too deep.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shift_mm: Option<f64>,
    /// A sentence.
    pub text: String,
    /// The flag or key that mends it.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub remedy: String,
}

impl Finding {
    /// A finding without a value.
    pub(crate) fn new(name: &'static str, severity: Severity, text: impl Into<String>) -> Self {
        Finding {
            name,
            severity,
            value: None,
            interval: None,
            unit: "",
            shift_mm: None,
            text: text.into(),
            remedy: String::new(),
        }
    }

    pub(crate) fn valued(self, value: f64, unit: &'static str) -> Self {
        Finding {
            value: Some(value),
            unit,
            ..self
        }
    }

    pub(crate) fn remedy(self, remedy: impl Into<String>) -> Self {
        Finding {
            remedy: remedy.into(),
            ..self
        }
    }
}

impl Display for Finding {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let severity = match self.severity {
            Severity::Note => "note",
            Severity::Warning => "warning",
            Severity::Error => "error",
        };
        write!(f, "{severity:<8}{:<15}", self.name)?;
        if let Some(value) = self.value {
            write!(f, "{}", short(value))?;
            if let Some([low, high]) = self.interval {
                write!(f, " ({} to {})", short(low), short(high))?;
            }
            write!(f, " {}", self.unit)?;
        }
        if let Some(shift) = self.shift_mm {
            write!(f, ", {}", drawn(shift))?;
        }
        let colon = if self.value.is_some() { ": " } else { "" };
        write!(f, "{colon}{}", self.text)?;
        match self.remedy.as_str() {
            "" => Ok(()),
            remedy => write!(f, "; remedy: {remedy}"),
        }
    }
}

/// Where an echo is drawn, by its shift in mm.
pub(crate) fn drawn(shift: f64) -> String {
    let side = if shift < 0.0 { "shallow" } else { "deep" };
    let size = shift.abs();
    format!("an echo in the middle of the record is {size:.2} mm too {side}")
}

/// Four digits.
fn short(value: f64) -> String {
    let digits = 3 - value.abs().max(1e-3).log10().floor() as i32;
    format!("{value:.*}", digits.clamp(0, 6) as usize)
}
