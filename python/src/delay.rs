//! Channel data → aligned samples, and on to lines.

use bonebeam_drive::coherence;
use bonebeam_drive::config::Beamform;
use bonebeam_drive::delay::DelayStage;
use bonebeam_drive::frame;
use bonebeam_drive::policy::{warnings, working_memory};
use bonebeam_files::memory;
use bonebeam_files::{BeamRays, ChannelData, FrameSamples, Recording, Transmits};
use ndarray::{Array, Array3, Dimension, IntoDimension};
use numpy::{
    Complex32, IntoPyArray, PyArray, PyArray1, PyArray2, PyArray3, PyArrayMethods,
    PyReadonlyArray2, PyReadonlyArray3, PyReadwriteArray, PyUntypedArrayMethods,
};
use pyo3::prelude::*;

use crate::error::refused;
use crate::parameters::BeamformParameters;
use crate::threads::{Threads, threads};
use crate::words::in_python;

/// A frame of channel data from Python; its fields are the keys of a recording.
#[derive(FromPyObject)]
pub struct FrameArrays<'py> {
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

impl FrameArrays<'_> {
    /// The samples, in Python's memory.
    fn frame(&self) -> PyResult<FrameSamples<'_>> {
        match (&self.rf, &self.iq, self.f_demod) {
            (Some(rf), None, None) => Ok(FrameSamples::Rf(rf.as_array())),
            (None, Some(iq), Some(f_demod)) => Ok(FrameSamples::Iq {
                iq: iq.as_array(),
                f_demod,
            }),
            _ => Err(refused("expected either `rf`, or `iq` and `f_demod`")),
        }
    }

    /// The data without samples, checked like the contents of a file.
    fn channel_data(&self, py: Python<'_>, frame: &FrameSamples<'_>) -> PyResult<ChannelData> {
        let data = ChannelData {
            samples: frame.none(),
            fs: self.fs,
            t0: self.t0.clone(),
            element_x: self.element_x.clone(),
            element_z: self.element_z.clone(),
            element_angle: self.element_angle.clone(),
            c: self.c,
            f0: self.f0,
            transmits: self.transmits()?,
            lens_delay: self.lens_delay.unwrap_or(0.0),
        };
        py.detach(|| data.check_with(frame)).map_err(refused)?;
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

/// A value for each beam; `None` if the beams go straight down from z = 0.
type Positions = Option<Py<PyArray1<f64>>>;

/// Depths and angles of beams that are rays.
fn positions(py: Python<'_>, rays: Option<BeamRays>) -> [Positions; 2] {
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
    beam_z: Positions,
    beam_angle: Positions,
    c: f64,
    warnings: Vec<String>,
}

/// Memory for a result of that shape: the caller's, if given.
fn written<'py, D: Dimension>(
    py: Python<'py>,
    out: Option<Bound<'py, PyArray<Complex32, D>>>,
    shape: impl IntoDimension<Dim = D>,
    what: &str,
) -> PyResult<Bound<'py, PyArray<Complex32, D>>> {
    let shape = shape.into_dimension();
    let Some(out) = out else {
        let bytes = memory::product(&[shape.size(), size_of::<Complex32>()]);
        memory::check(bytes, what).map_err(refused)?;
        return Ok(py.detach(|| Array::zeros(shape)).into_pyarray(py));
    };
    let given = out.dims();
    if given != shape || !out.is_c_contiguous() {
        let [given, shape] = [given, shape].map(|shape| shape.slice().to_vec());
        return Err(refused(format!(
            "`out` has shape {given:?}; expected {shape:?}, C-contiguous"
        )));
    }
    Ok(out)
}

/// Delays channel data, into `out` if it is given.
#[pyfunction]
pub fn delay<'py>(
    py: Python<'py>,
    data: FrameArrays<'py>,
    parameters: &BeamformParameters,
    out: Option<Bound<'py, PyArray3<Complex32>>>,
    threads: Option<Threads>,
) -> PyResult<Aligned> {
    let pool = self::threads(threads)?;
    let frame = data.frame()?;
    let data = data.channel_data(py, &frame)?;
    // The aligned samples are those used for lines.
    let parameters = &Beamform {
        sub_lines: Some(1),
        ..parameters.0.clone()
    };
    let warnings = warnings(&data, &data.samples.survey(), parameters).map_err(refused)?;
    let warnings = warnings.iter().map(|text| in_python(text)).collect();
    let stage = DelayStage::new(&data, parameters).map_err(refused)?;
    let (beams, samples, elements) = (stage.beam_x().len(), stage.samples(), data.samples.dim().2);
    let x = written(py, out, (beams, samples, elements), "aligned data")?;
    let mut memory: PyReadwriteArray<'py, _, _> = x.try_readwrite()?;
    let view = memory.as_slice_mut()?;
    py.detach(|| pool.install(|| stage.delay_into(frame, 0..beams, view)))
        .map_err(refused)?;
    drop(memory);
    let active = Array3::from_shape_fn((beams, samples, 2), |(beam, sample, k)| {
        let active = stage.active(beam, sample);
        [active.first, active.count][k] as i64
    });
    let [beam_z, beam_angle] = positions(py, stage.beam_rays());
    Ok(Aligned {
        x: x.unbind(),
        active: active.into_pyarray(py).unbind(),
        fs: parameters.rate_of(&data),
        t0: stage.start(),
        beam_x: PyArray1::from_slice(py, stage.beam_x()).unbind(),
        beam_z,
        beam_angle,
        c: stage.sound_speed(),
        warnings,
    })
}

/// Lines with their positions and times.
#[pyclass(frozen, get_all, module = "bonebeam._native")]
pub struct BeamformedLines {
    z: Py<PyArray2<Complex32>>,
    fs: f64,
    t0: f64,
    beam_x: Py<PyArray1<f64>>,
    beam_z: Positions,
    beam_angle: Positions,
    sub_lines: usize,
    c: f64,
    warnings: Vec<String>,
}

/// Delays and beamforms channel data, some beams at a time.
///
/// The lines are written into `out` if it is given.
#[pyfunction]
pub fn beamform_channel_data<'py>(
    py: Python<'py>,
    data: FrameArrays<'py>,
    parameters: &BeamformParameters,
    out: Option<Bound<'py, PyArray2<Complex32>>>,
    threads: Option<Threads>,
) -> PyResult<BeamformedLines> {
    let pool = self::threads(threads)?;
    let frame = data.frame()?;
    let data = data.channel_data(py, &frame)?;
    let parameters = &parameters.0;
    let warnings = warnings(&data, &data.samples.survey(), parameters).map_err(refused)?;
    let warnings = warnings.iter().map(|text| in_python(text)).collect();
    let recording = Recording::Channel(data);
    memory::check(
        working_memory(&recording, parameters, None, 1),
        "beamforming",
    )
    .map_err(refused)?;
    let Recording::Channel(data) = &recording else {
        unreachable!("it was made above");
    };
    let frames = frame::RecordingFrames::of_channel_data(data, parameters).map_err(refused)?;
    let stage = frames.stage().expect("channel data have one");
    let shape = (stage.beam_x().len(), stage.samples());
    let z = written(py, out, shape, "lines")?;
    let mut memory: PyReadwriteArray<'py, _, _> = z.try_readwrite()?;
    let view = memory.as_array_mut();
    py.detach(|| pool.install(|| frames.frame(frame, &|_| {}, view)))
        .map_err(refused)?;
    drop(memory);
    let [beam_z, beam_angle] = positions(py, stage.beam_rays());
    Ok(BeamformedLines {
        z: z.unbind(),
        fs: parameters.rate_of(data),
        t0: stage.start(),
        beam_x: PyArray1::from_slice(py, stage.beam_x()).unbind(),
        beam_z,
        beam_angle,
        sub_lines: stage.lines(()).sub_lines,
        c: stage.sound_speed(),
        warnings,
    })
}

/// Short-lag coherence of channel data, [line, sample].
#[pyfunction]
pub fn coherence_of_channel_data<'py>(
    py: Python<'py>,
    data: FrameArrays<'py>,
    parameters: &BeamformParameters,
    threads: Option<Threads>,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let pool = self::threads(threads)?;
    let frame = data.frame()?;
    let data = data.channel_data(py, &frame)?;
    let stage = DelayStage::new(&data, &parameters.0).map_err(refused)?;
    let map = py.detach(|| pool.install(|| coherence::of_channel_data(&stage, frame)));
    Ok(map.map_err(refused)?.into_pyarray(py))
}

/// Beam positions and sound speed of aligned data without their own.
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
