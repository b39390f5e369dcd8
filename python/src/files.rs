//! Recordings from files.

use std::path::PathBuf;

use bonebeam_files::{ChannelData, Recording, Samples, Transmits};
use bonebeam_formats::{self as formats, Variables};
use bonebeam_tracked::Sequence;
use ndarray::{Array3, Axis, Slice};
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};

use crate::error::refused;
use crate::tracked::matrices;

/// A recording's file.
#[pyclass(frozen, module = "bonebeam._native")]
pub struct RecordingFile {
    file: formats::RecordingFile,
    /// The probe's pose in each frame, m.
    poses: Option<Array3<f64>>,
    assumed: Vec<String>,
}

impl RecordingFile {
    fn open(path: PathBuf, variables: &Variables) -> bonebeam_files::Result<Self> {
        let file = formats::RecordingFile::open(&path, variables)?;
        let mut assumed = file.assumed().to_vec();
        let poses = file.poses().unwrap_or_else(|error| {
            assumed.push(format!("poses are left out: {error}"));
            None
        });
        let poses = poses.map(|poses| {
            let sequence = Sequence::of_recording(&path, &poses);
            assumed.extend_from_slice(&sequence.assumed);
            let frames = &sequence.frames;
            let pose = |k: usize| frames[k].transforms["ProbeToReference"].matrix.as_ref();
            let mut poses = matrices(frames.len(), pose);
            for mut pose in poses.outer_iter_mut() {
                (0..3).for_each(|row| pose[[row, 3]] /= 1e3);
            }
            poses
        });
        Ok(Self {
            file,
            poses,
            assumed,
        })
    }
}

#[pymethods]
impl RecordingFile {
    /// The file at `path`, with the section `[variables]` as JSON.
    #[new]
    fn new(py: Python<'_>, path: PathBuf, variables: &str) -> PyResult<Self> {
        let variables: Variables = serde_json::from_str(variables).map_err(refused)?;
        py.detach(|| Self::open(path, &variables)).map_err(refused)
    }

    /// Number of frames in the file.
    #[getter]
    fn frames(&self) -> usize {
        self.file.frames()
    }

    /// The frames from `start` to before `end`, with the keys of a `.npz` recording.
    ///
    /// Samples have an axis of frames.
    fn read<'py>(&self, py: Python<'py>, start: usize, end: usize) -> PyResult<Bound<'py, PyDict>> {
        let read = || {
            let (recording, own) = self.file.read(start..end)?;
            Ok(recording.into_owned().into_frames(own))
        };
        match py
            .detach(read)
            .map_err(|e: bonebeam_files::Error| refused(e))?
        {
            Recording::Channel(data) => {
                let keys = channel_data(py, data)?;
                keys.set_item("assumed", PyTuple::new(py, &self.assumed)?)?;
                if let Some(poses) = &self.poses {
                    let own = poses
                        .slice_axis(Axis(0), Slice::from(start..end))
                        .to_owned();
                    keys.set_item("poses", own.into_pyarray(py))?;
                }
                Ok(keys)
            }
            Recording::Aligned(data) => {
                let keys = PyDict::new(py);
                keys.set_item("x", data.x.into_pyarray(py))?;
                keys.set_item("fs", data.fs)?;
                keys.set_item("t0", data.t0)?;
                keys.set_item("beam_x", data.beam_x.map(|x| x.into_pyarray(py)))?;
                Ok(keys)
            }
            Recording::Lines(lines) => {
                let keys = PyDict::new(py);
                keys.set_item("z", lines.z.into_pyarray(py))?;
                keys.set_item("fs", lines.fs)?;
                keys.set_item("t0", lines.t0)?;
                keys.set_item("c", lines.c)?;
                keys.set_item("beam_x", lines.beam_x.into_pyarray(py))?;
                if let Some(rays) = lines.rays {
                    keys.set_item("beam_z", rays.z.into_pyarray(py))?;
                    keys.set_item("beam_angle", rays.angle.into_pyarray(py))?;
                }
                keys.set_item("sub_lines", lines.sub_lines)?;
                Ok(keys)
            }
        }
    }
}

/// Channel data as a dictionary of keys, without copies of the samples.
///
/// The samples are [frame, transmit, element, sample].
pub fn channel_data(py: Python<'_>, data: ChannelData) -> PyResult<Bound<'_, PyDict>> {
    let keys = PyDict::new(py);
    match data.samples {
        Samples::Rf(rf) => keys.set_item("rf", rf.into_pyarray(py))?,
        Samples::Counts(counts) => keys.set_item("rf", counts.into_pyarray(py))?,
        Samples::Stored(_) => {}
        Samples::Iq { iq, f_demod } => {
            keys.set_item("iq", iq.into_pyarray(py))?;
            keys.set_item("f_demod", f_demod)?;
        }
    }
    keys.set_item("fs", data.fs)?;
    keys.set_item("t0", data.t0.into_pyarray(py))?;
    keys.set_item("element_x", data.element_x.into_pyarray(py))?;
    for (key, places) in [
        ("element_z", data.element_z),
        ("element_angle", data.element_angle),
    ] {
        keys.set_item(key, places.map(|places| places.into_pyarray(py)))?;
    }
    let lens = Some(data.lens_delay).filter(|&delay| delay != 0.0);
    keys.set_item("lens_delay", lens)?;
    keys.set_item("c", data.c)?;
    keys.set_item("f0", data.f0)?;
    match data.transmits {
        Transmits::Focused { x, focus, f_number } => {
            keys.set_item("tx_x", x.into_pyarray(py))?;
            keys.set_item("tx_focus", focus.into_pyarray(py))?;
            keys.set_item("tx_fnumber", f_number)?;
        }
        Transmits::Plane { angle } => keys.set_item("tx_angle", angle.into_pyarray(py))?,
        Transmits::Element { index } => {
            let index: Vec<i64> = index.into_iter().map(|i| i as i64).collect();
            keys.set_item("tx_element", index.into_pyarray(py))?;
        }
        Transmits::VirtualSource { x, z } => {
            keys.set_item("tx_source_x", x.into_pyarray(py))?;
            keys.set_item("tx_source_z", z.into_pyarray(py))?;
        }
        Transmits::Delays { delay } => keys.set_item("tx_delay", delay.into_pyarray(py))?,
    }
    Ok(keys)
}
