//! The command's sections, from Python's arguments.

use bonebeam::beamform::{Method, Parameters, Postfilter};
use bonebeam_drive::config::{Beamform, BeamformFlags, Image, Kind, PhaseSymmetry};
use bonebeam_drive::methods::MethodName;
use bonebeam_simulate::Simulate;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use serde_json::{Map, Value, json};

use crate::error::refused;

/// Section `[beamform]`, checked.
#[pyclass(frozen, module = "bonebeam._native")]
pub struct BeamformParameters(pub Beamform);

#[pymethods]
impl BeamformParameters {
    /// From the keys that are given, as JSON.
    #[new]
    fn new(section: &str) -> PyResult<Self> {
        let given: Map<String, Value> = serde_json::from_str(section).map_err(refused)?;
        // One by one, so that an error names the key.
        for (key, value) in &given {
            let alone = Map::from_iter([(key.clone(), value.clone())]);
            if let Err(error) = serde_json::from_value::<Beamform>(Value::Object(alone)) {
                let message = format!("`{key}`: {error}");
                let kind = BeamformFlags::kind(key);
                return Err(if kind.is_some() && kind != kind_of(value) {
                    PyTypeError::new_err(message)
                } else {
                    PyValueError::new_err(message)
                });
            }
        }
        let mut section: Beamform =
            serde_json::from_value(Value::Object(given)).map_err(refused)?;
        section.validate().map_err(refused)?;
        section.resolve();
        Ok(Self(section))
    }
}

fn kind_of(value: &Value) -> Option<Kind> {
    match value {
        Value::Number(_) => Some(Kind::Number),
        Value::String(_) => Some(Kind::Name),
        Value::Bool(_) => Some(Kind::Switch),
        _ => None,
    }
}

/// Section `[image]`, checked.
pub fn image(
    dynamic_range: f64,
    rows: Option<usize>,
    columns: Option<usize>,
    depth: Option<f64>,
    width: Option<f64>,
    median: bool,
) -> PyResult<Image> {
    let section = Image {
        dynamic_range,
        rows,
        columns,
        depth,
        width,
        median,
    };
    section.validate().map_err(refused)?;
    Ok(section)
}

/// Section `[phase_symmetry]`, checked.
pub fn phase_symmetry(
    scales: Vec<f64>,
    threshold: f64,
    strip: usize,
    pad: bool,
) -> PyResult<PhaseSymmetry> {
    let section = PhaseSymmetry {
        scales,
        threshold,
        strip,
        pad,
        ..PhaseSymmetry::default()
    };
    section.validate().map_err(refused)?;
    Ok(section)
}

/// The command's defaults as JSON, section by section.
#[pyfunction]
pub fn defaults() -> PyResult<String> {
    let sections = json!({
        "simulate": Simulate::default(),
        "beamform": Beamform::default(),
        "image": Image::default(),
        "phase_symmetry": PhaseSymmetry::default(),
    });
    Ok(sections.to_string())
}

/// What the package's lists are tested against, as JSON: the keys of the section, the names of the methods and of
/// the postfilters, and an example of every method, postfilter and parameter of the core.
#[pyfunction]
pub fn tables() -> PyResult<String> {
    let methods = Method::EXAMPLES.map(|method| Parameters {
        method,
        ..Parameters::DEFAULT
    });
    let postfilters = Postfilter::EXAMPLES.map(|postfilter| Parameters {
        postfilter,
        ..Parameters::DEFAULT
    });
    let rows = Parameters::TABLE.map(|row| {
        let mut parameters = Parameters::DEFAULT;
        parameters.set(row.name, row.example);
        parameters
    });
    let examples = methods.into_iter().chain(postfilters).chain(rows);
    let examples: Vec<_> = examples.map(Beamform::of).collect();
    let tables = json!({
        "keys": BeamformFlags::keys(),
        "methods": MethodName::all(),
        "postfilters": Postfilter::EXAMPLES.map(|postfilter| postfilter.key()),
        "examples": examples,
    });
    Ok(tables.to_string())
}
