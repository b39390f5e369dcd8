//! Lines from Python.

use bonebeam_files::{BeamRays, BeamformedLines};
use ndarray::ArrayView2;
use numpy::{Complex32, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::error::refused;

/// Lines of one frame; its fields are those of Python's `Lines`.
#[derive(FromPyObject)]
pub struct LinesArrays<'py> {
    z: PyReadonlyArray2<'py, Complex32>,
    fs: f64,
    t0: f64,
    beam_x: Vec<f64>,
    beam_z: Option<Vec<f64>>,
    beam_angle: Option<Vec<f64>>,
    sub_lines: usize,
    c: f64,
}

impl LinesArrays<'_> {
    /// The lines, checked like those of a file, over samples in Python's memory.
    pub fn checked(&self) -> PyResult<BeamformedLines<ArrayView2<'_, Complex32>>> {
        let place = |place: &Option<Vec<f64>>| match place {
            Some(values) => values.clone(),
            None => vec![0.0; self.beam_x.len()],
        };
        let given = self.beam_z.is_some() || self.beam_angle.is_some();
        let lines = BeamformedLines {
            z: self.z.as_array(),
            fs: self.fs,
            t0: self.t0,
            beam_x: self.beam_x.clone(),
            rays: given.then(|| BeamRays {
                z: place(&self.beam_z),
                angle: place(&self.beam_angle),
            }),
            sub_lines: self.sub_lines,
            c: self.c,
        };
        lines.checked().map_err(refused)
    }
}
