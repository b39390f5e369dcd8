//! Sections of the command's configuration from Python's arguments.

use std::collections::HashMap;

use bonebeam::beamform::{Apodization, Method, Parameters, Postfilter};
use bonebeam_drive::config::{Beamform, Image, PhaseSymmetry, Surface};
use bonebeam_files::section::{Key, Section};
use bonebeam_simulate::Simulate;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};

use crate::error::refused;

/// Section `[beamform]`, validated.
#[pyclass(frozen, module = "bonebeam._native")]
pub struct BeamformParameters(pub Beamform);

#[pymethods]
impl BeamformParameters {
    /// Reads the section from the given keys, as JSON.
    #[new]
    fn new(section: &str) -> PyResult<Self> {
        let given: Map<String, Value> = serde_json::from_str(section).map_err(refused)?;
        let mut section: Beamform = of_keys(given)?;
        section.validate().map_err(refused)?;
        section.resolve();
        Ok(Self(section))
    }

    /// Depth step of the beamformed lines, samples.
    #[getter]
    fn depth_step(&self) -> u32 {
        self.0.depth_step() as u32
    }
}

/// Functions that validate a section, given as JSON.
macro_rules! validated {
    ($($section:ident: $type:ty;)*) => {$(
        pub fn $section(section: &str) -> PyResult<$type> {
            let given: Map<String, Value> = serde_json::from_str(section).map_err(refused)?;
            let section: $type = of_keys(given)?;
            section.validate().map_err(refused)?;
            Ok(section)
        }
    )*};
}

validated! {
    image: Image;
    surface: Surface;
    phase_symmetry: PhaseSymmetry;
}

/// Reads a section key by key, so that an error names the key.
fn of_keys<T: DeserializeOwned>(given: Map<String, Value>) -> PyResult<T> {
    for (key, value) in &given {
        let alone = Map::from_iter([(key.clone(), value.clone())]);
        if let Err(error) = serde_json::from_value::<T>(Value::Object(alone)) {
            let error = error.to_string();
            // A fraction is a number, though not every key accepts one.
            let other_type = error.starts_with("invalid type") && !value.is_f64();
            let (cause, expected) = error.rsplit_once(", expected ").unwrap_or((&error, ""));
            let message = match expected {
                "f64" => format!("`{key}`: {cause}, expected a number"),
                "usize" | "u64" | "u32" => {
                    format!("`{key}`: {cause}, expected a whole number from 0")
                }
                _ => format!("`{key}`: {error}"),
            };
            return Err(match other_type {
                true => PyTypeError::new_err(message),
                false => PyValueError::new_err(message),
            });
        }
    }
    serde_json::from_value(Value::Object(given)).map_err(refused)
}

/// The command's defaults as JSON, section by section.
#[pyfunction]
pub fn defaults() -> PyResult<String> {
    let sections = json!({
        "simulate": Simulate::default(),
        "beamform": Beamform::default(),
        "image": Image::default(),
        "phase_symmetry": PhaseSymmetry::default(),
        "surface": Surface::default(),
    });
    Ok(sections.to_string())
}

/// Tables for tests of the package's lists, as JSON.
///
/// They hold the keys of each section, and an example of every method, postfilter, apodization and parameter of the core.
#[pyfunction]
pub fn tables() -> PyResult<String> {
    let methods = Method::EXAMPLES.map(Parameters::of);
    let postfilters = Postfilter::EXAMPLES.map(|postfilter| Parameters {
        postfilter,
        ..Parameters::DEFAULT
    });
    let apodizations = Apodization::EXAMPLES.map(|apodization| Parameters {
        apodization,
        ..Parameters::DEFAULT
    });
    let rows = Parameters::TABLE.map(|row| {
        let mut parameters = Parameters::DEFAULT;
        parameters.set(row.name, row.example);
        parameters
    });
    let examples = methods.into_iter().chain(postfilters).chain(apodizations);
    let examples = examples.chain(rows);
    let examples: Vec<_> = examples.map(Beamform::of).collect();
    fn keys<S: Section>() -> (&'static str, Vec<Value>) {
        (S::NAME, S::keys().iter().map(keyword).collect())
    }
    let sections = [
        keys::<Simulate>(),
        keys::<Beamform>(),
        keys::<Image>(),
        keys::<PhaseSymmetry>(),
        keys::<Surface>(),
    ];
    let sections: HashMap<_, _> = sections.into();
    Ok(json!({ "sections": sections, "examples": examples }).to_string())
}

/// A key as Python's keyword.
fn keyword(key: &Key) -> Value {
    json!({
        "name": key.name,
        "heading": key.heading,
        "help": format!("{}. {}", key.help, key.more).trim(),
        "choices": key.choices,
        "type": key.python,
    })
}
