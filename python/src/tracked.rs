//! Tracked sequences and sweeps.

use std::ops::Range;
use std::path::PathBuf;

use bonebeam_files::{Error, Result};
use bonebeam_tracked::{
    Calibration, Delay, Encoded, Euler, Matrix, PoseTable, Sequence, Settings, Track, sweep,
};
use ndarray::{Array2, Array3, Axis};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray3};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::error::refused;
use crate::parameters;

/// A tracked sequence: its file, and the axes of Euler angles.
#[pyclass(frozen, module = "bonebeam._native")]
pub struct TrackedSequence(Sequence, Euler);

fn parsed<T: std::str::FromStr<Err = String>>(name: &str, text: &str) -> PyResult<T> {
    text.parse()
        .map_err(|e| refused(Error::Usage(format!("`{name}` is {text}; {e}"))))
}

/// Matrices as an array [frame, 4, 4], with NaN where there is none.
pub(crate) fn matrices<'m>(count: usize, of: impl Fn(usize) -> Option<&'m Matrix>) -> Array3<f64> {
    Array3::from_shape_fn((count, 4, 4), |(k, row, column)| {
        of(k).map_or(f64::NAN, |m| m[row][column])
    })
}

/// Frames of a sequence as an array [frame, row, column], read without the interpreter's lock.
fn frames<'py, T: numpy::Element + Clone + Default>(
    py: Python<'py>,
    sequence: &Sequence,
    range: Range<usize>,
    decode: fn(&Sequence, Encoded) -> Result<Array2<T>>,
) -> PyResult<Bound<'py, PyArray3<T>>> {
    let [columns, rows] = sequence.sides;
    let read = || -> Result<Array3<T>> {
        let mut all = Array3::default((range.len(), rows, columns));
        let mut reader = sequence.reader()?;
        for (k, mut own) in range.zip(all.axis_iter_mut(Axis(0))) {
            own.assign(&decode(sequence, reader.frame(k)?)?);
        }
        Ok(all)
    };
    Ok(py.detach(read).map_err(refused)?.into_pyarray(py))
}

#[pymethods]
impl TrackedSequence {
    #[new]
    fn new(
        py: Python<'_>,
        path: PathBuf,
        poses: Option<PathBuf>,
        columns: Option<Vec<String>>,
        euler: &str,
        pose_unit: Option<&str>,
        angle_unit: Option<&str>,
    ) -> PyResult<Self> {
        let euler = parsed("euler", euler)?;
        let poses = PoseTable {
            path: poses,
            columns,
            euler,
            length: pose_unit
                .map(|unit| parsed("pose_unit", unit))
                .transpose()?,
            angle: angle_unit
                .map(|unit| parsed("angle_unit", unit))
                .transpose()?,
        };
        let opened = py.detach(|| Sequence::open(&path, &poses));
        Ok(Self(opened.map_err(refused)?, euler))
    }

    /// Number of frames.
    #[getter]
    fn frames(&self) -> usize {
        self.0.frames.len()
    }

    /// What was assumed.
    #[getter]
    fn assumed(&self) -> Vec<String> {
        self.0.assumed.clone()
    }

    /// Whether frames are lines of RF.
    #[getter]
    fn is_lines(&self) -> bool {
        self.0.content.is_lines()
    }

    /// Times, s, NaN if missing.
    #[getter]
    fn timestamps<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let times = self
            .0
            .frames
            .iter()
            .map(|frame| frame.timestamp.unwrap_or(f64::NAN));
        times.collect::<Vec<_>>().into_pyarray(py)
    }

    /// Whether each frame has a valid picture.
    #[getter]
    fn has_picture<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        let valid = self.0.frames.iter().map(|frame| frame.has_picture);
        valid.collect::<Vec<_>>().into_pyarray(py)
    }

    /// For each transform its matrices and statuses.
    fn transforms<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        let frames = &self.0.frames;
        for name in self.0.transform_names() {
            let of = |k: usize| frames[k].transforms.get(name)?.matrix.as_ref();
            let status = |k: usize| {
                frames[k]
                    .transforms
                    .get(name)
                    .map_or("MISSING", |own| &own.status[..])
            };
            let statuses: Vec<&str> = (0..frames.len()).map(status).collect();
            all.set_item(
                name,
                (matrices(frames.len(), of).into_pyarray(py), statuses),
            )?;
        }
        Ok(all)
    }

    /// Pictures [frame, row, column] from `start` to before `end`.
    fn pictures<'py>(
        &self,
        py: Python<'py>,
        start: usize,
        end: usize,
    ) -> PyResult<Bound<'py, PyArray3<f32>>> {
        frames(py, &self.0, start..end, Sequence::picture)
    }

    /// Lines [frame, line, sample] from `start` to before `end`.
    fn lines<'py>(
        &self,
        py: Python<'py>,
        start: usize,
        end: usize,
    ) -> PyResult<Bound<'py, PyArray3<numpy::Complex32>>> {
        frames(py, &self.0, start..end, Sequence::lines)
    }

    /// Poses of the pictures [frame, 4, 4], NaN for frames left out, and the reasons.
    fn poses<'py>(
        &self,
        py: Python<'py>,
        calibration: Vec<String>,
        to: Option<&str>,
        pixel: Option<[f64; 2]>,
        jump: f64,
        delay: f64,
    ) -> PyResult<(Bound<'py, PyArray3<f64>>, Vec<String>)> {
        let mut all = Calibration::default();
        for text in &calibration {
            all.transforms
                .extend(Calibration::of(text, self.1).map_err(refused)?.transforms);
        }
        let pixel = pixel.map(|sides| sides.map(|side| 1e3 * side));
        let mut track = Track::of(&self.0, &all, to, pixel, 1e3 * jump).map_err(refused)?;
        if delay != 0.0 {
            track = track.delayed(&self.0, delay).map_err(refused)?;
        }
        let poses = matrices(track.poses.len(), |k| track.poses[k].as_ref().ok()).into_pyarray(py);
        let reason = |pose: &std::result::Result<Matrix, String>| pose.as_ref().err().cloned();
        let reasons = track
            .poses
            .iter()
            .map(|pose| reason(pose).unwrap_or_default());
        Ok((poses, reasons.collect()))
    }
}

/// Points, normals, confidence, frames and lines of bone; lengths in mm.
type Points<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<i64>>,
);

/// The bone in pictures with poses, by the keys of the section `[surface]` as JSON.
#[pyfunction]
pub fn sweep_of_pictures<'py>(
    py: Python<'py>,
    pictures: PyReadonlyArray3<'py, f32>,
    poses: PyReadonlyArray3<'py, f64>,
    jump: f64,
    join: f64,
    section: &str,
) -> PyResult<Points<'py>> {
    let surface = parameters::surface(section)?;
    let poses: Vec<Option<Matrix>> = poses
        .as_array()
        .outer_iter()
        .map(|pose| {
            let rows = std::array::from_fn(|row| std::array::from_fn(|column| pose[[row, column]]));
            pose.iter().all(|value| value.is_finite()).then_some(rows)
        })
        .collect();
    let pictures = pictures.as_array().to_owned();
    let found = py.detach(|| {
        let settings = Settings {
            surface,
            frames: (0..poses.len()).collect(),
            crop: None,
            join: 1e3 * join,
            delay: Delay::Known(0.0),
            resumable: None,
        };
        let sequence = Sequence::of_arrays(pictures, &poses)?;
        let track = Track::of(&sequence, &Calibration::default(), None, None, 1e3 * jump)?;
        sweep(&sequence, &track, &settings, &|_| ())
    });
    let points = found.map_err(refused)?.0.points;
    let three = |of: fn(&bonebeam_tracked::CloudPoint) -> [f64; 3]| {
        let all = Array2::from_shape_fn((points.len(), 3), |(k, axis)| of(&points[k])[axis]);
        all.into_pyarray(py)
    };
    let counts = |of: fn(&bonebeam_tracked::CloudPoint) -> usize| {
        points
            .iter()
            .map(|point| of(point) as i64)
            .collect::<Vec<_>>()
            .into_pyarray(py)
    };
    let confidence: Vec<f32> = points.iter().map(|point| point.confidence).collect();
    Ok((
        three(|point| point.position),
        three(|point| point.normal),
        confidence.into_pyarray(py),
        counts(|point| point.frame),
        counts(|point| point.line),
    ))
}
