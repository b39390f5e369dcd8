//! The command's sections, from Python's arguments.

use bonebeam::covariance::Covariance;
use bonebeam_drive::config::{Beamform, Image, LineKind, PhaseSymmetry, Reading, RfReading};
use bonebeam_simulate::Simulate;
use pyo3::prelude::*;
use serde::Deserialize;
use serde::de::value::{Error as TextError, StrDeserializer};

use crate::error::refused;

/// Section `[beamform]`, checked.
#[pyclass(frozen, module = "bonebeam._native")]
pub struct BeamformParameters(pub Beamform);

#[pymethods]
impl BeamformParameters {
    #[new]
    #[pyo3(signature = (
        *, method, beta, rank, exclude_first, power_steps, subaperture_ratio, temporal_half_window,
        covariance, diagonal_loading, f_number=None, min_elements=None, output_rate=None, lines=None,
        line_count=None, sector=None, rf_reading=None, iq_reading=None, depth_start=None, depth_end=None,
        sound_speed=None, beam_spacing=None, adaptive_depth_start=None, adaptive_depth_end=None
    ))]
    fn new(
        method: &str,
        beta: Option<f64>,
        rank: Option<usize>,
        exclude_first: bool,
        power_steps: Option<usize>,
        subaperture_ratio: f64,
        temporal_half_window: usize,
        covariance: &str,
        diagonal_loading: f64,
        f_number: Option<f64>,
        min_elements: Option<usize>,
        output_rate: Option<f64>,
        lines: Option<&str>,
        line_count: Option<usize>,
        sector: Option<f64>,
        rf_reading: Option<&str>,
        iq_reading: Option<&str>,
        depth_start: Option<f64>,
        depth_end: Option<f64>,
        sound_speed: Option<f64>,
        beam_spacing: Option<f64>,
        adaptive_depth_start: Option<f64>,
        adaptive_depth_end: Option<f64>,
    ) -> PyResult<Self> {
        let mut section = Beamform {
            method: named(method)?,
            beta,
            rank,
            exclude_first,
            power_steps,
            subaperture_ratio,
            temporal_half_window,
            covariance: named::<Covariance>(covariance)?,
            diagonal_loading,
            depth_start,
            depth_end,
            output_rate,
            lines: lines.map(named::<LineKind>).transpose()?,
            line_count,
            rf_reading: rf_reading.map(named::<RfReading>).transpose()?,
            iq_reading: iq_reading.map(named::<Reading>).transpose()?,
            sound_speed,
            adaptive_depth_start,
            adaptive_depth_end,
            ..Beamform::default()
        };
        section.f_number = f_number.unwrap_or(section.f_number);
        section.min_elements = min_elements.unwrap_or(section.min_elements);
        section.sector = sector.unwrap_or(section.sector);
        section.beam_spacing = beam_spacing.unwrap_or(section.beam_spacing);
        section.validate().map_err(refused)?;
        section.resolve();
        Ok(Self(section))
    }
}

/// A value of the configuration by its name.
fn named<T: for<'a> Deserialize<'a>>(name: &str) -> PyResult<T> {
    T::deserialize(StrDeserializer::<TextError>::new(name)).map_err(refused)
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
    let sections = serde_json::json!({
        "simulate": Simulate::default(),
        "beamform": Beamform::default(),
        "image": Image::default(),
        "phase_symmetry": PhaseSymmetry::default(),
    });
    Ok(sections.to_string())
}
