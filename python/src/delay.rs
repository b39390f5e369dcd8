//! Channel data → aligned samples, and right on to lines.

use std::num::NonZeroUsize;

use host_sim::commands::beamform::{doubts, working_memory};
use host_sim::drive::delay::DelayStage;
use host_sim::drive::frame;
use host_sim::files::{BeamRays, ChannelData, Lines, Recording, Samples, Transmits};
use host_sim::memory;
use ndarray::{Array3, ArrayViewMut3};
use num_complex::Complex;
use numpy::{
    Complex32, IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods, PyReadonlyArray2,
    PyReadonlyArray3, PyReadwriteArray3,
};
use pyo3::prelude::*;

use crate::error::refused;
use crate::parameters::BeamformParameters;
use crate::threads::threads;

/// One frame of channel data of Python: its fields are the keys of a recording.
#[derive(FromPyObject)]
pub struct Record<'py> {
    rf: Option<PyReadonlyArray3<'py, f32>>,
    iq: Option<PyReadonlyArray3<'py, Complex32>>,
    f_demod: Option<f64>,
    fs: f64,
    t0: Vec<f64>,
    element_x: Vec<f64>,
    element_z: Option<Vec<f64>>,
    element_angle: Option<Vec<f64>>,
    lens_delay: Option<f64>,
    c: f64,
    f0: f64,
    tx_x: Option<Vec<f64>>,
    tx_focus: Option<Vec<f64>>,
    tx_fnumber: Option<f64>,
    tx_angle: Option<Vec<f64>>,
    tx_element: Option<Vec<usize>>,
    tx_source_x: Option<Vec<f64>>,
    tx_source_z: Option<Vec<f64>>,
    tx_delay: Option<PyReadonlyArray2<'py, f64>>,
}

impl Record<'_> {
    /// Checked as one that is read from a file. The samples are copied.
    fn channel_data(self) -> PyResult<ChannelData> {
        let transmits = self.transmits()?;
        let samples = match (self.rf, self.iq, self.f_demod) {
            (Some(rf), None, None) => rf.as_array().to_owned().into(),
            (None, Some(iq), Some(f_demod)) => Samples::iq(iq.as_array().to_owned(), f_demod),
            _ => return Err(refused("expected either `rf`, or `iq` and `f_demod`")),
        };
        let data = ChannelData {
            samples,
            fs: self.fs,
            t0: self.t0,
            element_x: self.element_x,
            element_z: self.element_z,
            element_angle: self.element_angle,
            c: self.c,
            f0: self.f0,
            transmits,
            lens_delay: self.lens_delay.unwrap_or(0.0),
        };
        data.check().map_err(refused)?;
        Ok(data)
    }

    fn transmits(&self) -> PyResult<Transmits> {
        let focused = self.tx_x.clone().zip(self.tx_focus.clone());
        let source = self.tx_source_x.clone().zip(self.tx_source_z.clone());
        let delay = self.tx_delay.as_ref();
        let laws = [
            focused.map(|(x, focus)| Transmits::Focused {
                x,
                focus,
                f_number: self.tx_fnumber,
            }),
            self.tx_angle
                .clone()
                .map(|angle| Transmits::Plane { angle }),
            self.tx_element
                .clone()
                .map(|index| Transmits::Element { index }),
            source.map(|(x, z)| Transmits::VirtualSource { x, z }),
            delay.map(|delay| Transmits::Delays {
                delay: delay.as_array().to_owned(),
            }),
        ];
        let mut laws = laws.into_iter().flatten();
        match (laws.next(), laws.next()) {
            (Some(law), None) => Ok(law),
            _ => Err(refused(
                "expected exactly one delay law: `tx_x` and `tx_focus` (focused beams), `tx_angle` \
                 (plane waves), `tx_element` (single elements), `tx_source_x` and `tx_source_z` (virtual \
                 sources), or `tx_delay` (delays of the elements)",
            )),
        }
    }
}

/// A value a beam; none where the beams go straight down from z = 0.
type Places = Option<Py<PyArray1<f64>>>;

/// Depths and angles of beams that are rays.
fn places(py: Python<'_>, rays: Option<BeamRays>) -> [Places; 2] {
    let arrays = rays.map(|rays| [rays.z, rays.angle].map(|v| Some(v.into_pyarray(py).unbind())));
    arrays.unwrap_or_default()
}

/// Aligned samples.
#[pyclass(frozen, get_all, module = "bonebeam._native")]
pub struct Aligned {
    x: Py<PyArray3<Complex32>>,
    /// The first active element and their number, [beam, sample, 2].
    active: Py<PyArray3<i64>>,
    fs: f64,
    t0: f64,
    beam_x: Py<PyArray1<f64>>,
    beam_z: Places,
    beam_angle: Places,
    c: f64,
    doubts: Vec<String>,
}

/// Delays channel data, into `out` where it is given.
#[pyfunction]
pub fn delay<'py>(
    py: Python<'py>,
    data: Record<'py>,
    parameters: &BeamformParameters,
    out: Option<Bound<'py, PyArray3<Complex32>>>,
    threads: Option<NonZeroUsize>,
) -> PyResult<Aligned> {
    let pool = self::threads(threads)?;
    let data = data.channel_data()?;
    let parameters = &parameters.0;
    let doubts = doubts(&data, parameters).map_err(refused)?;
    let stage = DelayStage::new(&data, parameters).map_err(refused)?;
    let (beams, samples, elements) = (stage.beam_x().len(), stage.samples(), data.samples.dim().2);
    let shape = (beams, samples, elements);
    let x = match out {
        Some(out) => out,
        None => {
            let bytes = memory::product(&[beams, samples, elements, size_of::<Complex32>()]);
            memory::check(bytes, "aligned data").map_err(refused)?;
            py.detach(|| Array3::zeros(shape)).into_pyarray(py)
        }
    };
    let mut written: PyReadwriteArray3<'py, Complex32> = x.try_readwrite()?;
    let view: ArrayViewMut3<'_, Complex<f32>> = written.as_array_mut();
    let given = view.dim();
    let samples_of_x = view.into_slice().filter(|_| given == shape);
    let samples_of_x = samples_of_x.ok_or_else(|| {
        refused(format!(
            "`out` has shape {given:?}; expected {shape:?}, C-contiguous"
        ))
    })?;
    py.detach(|| pool.install(|| stage.delay_into(0..beams, samples_of_x)))
        .map_err(refused)?;
    drop(written);
    let active = Array3::from_shape_fn((beams, samples, 2), |(beam, sample, k)| {
        let active = stage.active(beam, sample);
        [active.first, active.count][k] as i64
    });
    let [beam_z, beam_angle] = places(py, frame::beam_rays(&stage));
    Ok(Aligned {
        x: x.unbind(),
        active: active.into_pyarray(py).unbind(),
        fs: parameters.rate_of(&data),
        t0: stage.start(),
        beam_x: PyArray1::from_slice(py, stage.beam_x()).unbind(),
        beam_z,
        beam_angle,
        c: stage.sound_speed(),
        doubts,
    })
}

/// Lines with where and when they are.
#[pyclass(frozen, get_all, module = "bonebeam._native")]
pub struct BeamformedLines {
    z: Py<PyArray2<Complex32>>,
    fs: f64,
    t0: f64,
    beam_x: Py<PyArray1<f64>>,
    beam_z: Places,
    beam_angle: Places,
    c: f64,
    doubts: Vec<String>,
}

impl BeamformedLines {
    fn new(py: Python<'_>, lines: Lines, doubts: Vec<String>) -> Self {
        let [beam_z, beam_angle] = places(py, lines.rays);
        Self {
            z: lines.z.into_pyarray(py).unbind(),
            fs: lines.fs,
            t0: lines.t0,
            beam_x: lines.beam_x.into_pyarray(py).unbind(),
            beam_z,
            beam_angle,
            c: lines.c,
            doubts,
        }
    }
}

/// Delays and beamforms channel data, some beams at a time.
#[pyfunction]
pub fn beamform_channel_data(
    py: Python<'_>,
    data: Record<'_>,
    parameters: &BeamformParameters,
    threads: Option<NonZeroUsize>,
) -> PyResult<BeamformedLines> {
    let pool = self::threads(threads)?;
    let data = data.channel_data()?;
    let parameters = &parameters.0;
    let doubts = doubts(&data, parameters).map_err(refused)?;
    let recording = Recording::Channel(data);
    memory::check(
        working_memory(&recording, parameters, None, 1),
        "beamforming",
    )
    .map_err(refused)?;
    let Recording::Channel(data) = &recording else {
        unreachable!("it was made above");
    };
    let lines =
        py.detach(|| pool.install(|| frame::beamform_channel_data(data, parameters, &|_| {})));
    Ok(BeamformedLines::new(py, lines.map_err(refused)?, doubts))
}

/// Where the beams of aligned data are that do not tell it, and the speed of sound of theirs.
#[pyfunction]
pub fn even_beams(
    py: Python<'_>,
    beams: usize,
    parameters: &BeamformParameters,
) -> (Py<PyArray1<f64>>, f64) {
    let section = &parameters.0;
    let beam_x = frame::even_beams(beams, section.beam_spacing);
    let c = section.sound_speed.unwrap_or(frame::DEFAULT_SOUND_SPEED);
    (beam_x.into_pyarray(py).unbind(), c)
}
