//! Aligned samples → lines.

use std::process;

use bonebeam::geometry::Active;
use bonebeam::simd::InstructionSet;
use bonebeam_drive::beamform::Plan;
use ndarray::{ArrayView3, ArrayViewMut2, Axis};
use num_complex::Complex;
use numpy::{Complex32, PyReadonlyArray3, PyReadonlyArray4, PyReadwriteArray3};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::ThreadPool;

use crate::error::refused;
use crate::parameters::BeamformParameters;
use crate::threads::{Threads, threads};

/// Threads and their memory, made once for many frames.
#[pyclass(frozen, module = "bonebeam._native")]
pub struct Beamformer {
    plan: Plan,
    pool: ThreadPool,
    /// The process that made the threads: a forked one has the memory, but no threads.
    process: u32,
}

#[pymethods]
impl Beamformer {
    /// Makes threads and memory for frames of up to `elements` active elements.
    #[new]
    fn new(
        py: Python<'_>,
        parameters: &BeamformParameters,
        elements: i64,
        threads: Option<Threads>,
    ) -> PyResult<Self> {
        let elements = usize::try_from(elements);
        let elements =
            elements.map_err(|_| refused("`elements` is below 0; expected at least 1"))?;
        let pool = self::threads(threads)?;
        let section = &parameters.0;
        let plan = py.detach(|| {
            let set = InstructionSet::detect();
            pool.install(|| Plan::new(set, section.parameters(), elements))
        });
        Ok(Self {
            plan: plan.map_err(refused)?,
            pool,
            process: process::id(),
        })
    }

    /// Beamforms `x` [frame, beam, sample, element] into `out` [frame, beam, sample].
    ///
    /// `active` has the first active element and their number, [beam, sample, 2]. Without it all elements are active.
    fn run(
        &self,
        py: Python<'_>,
        x: PyReadonlyArray4<'_, Complex32>,
        active: Option<PyReadonlyArray3<'_, i64>>,
        mut out: PyReadwriteArray3<'_, Complex32>,
    ) -> PyResult<()> {
        if self.process != process::id() {
            return Err(PyRuntimeError::new_err(
                "this Beamformer was made before the process was forked, and its threads stayed behind; \
                 make one in each process",
            ));
        }
        let (x, mut out) = (x.as_array(), out.as_array_mut());
        let active = active.as_ref().map(|active| active.as_array());
        if let Some(active) = active {
            check(active, x.dim().3)?;
        }
        for (x, z) in x.outer_iter().zip(out.axis_iter_mut(Axis(0))) {
            py.detach(|| self.frame(x, active, z)).map_err(refused)?;
            // An interrupt takes effect between two frames.
            py.check_signals()?;
        }
        Ok(())
    }
}

impl Beamformer {
    fn frame(
        &self,
        x: ArrayView3<'_, Complex<f32>>,
        active: Option<ArrayView3<'_, i64>>,
        z: ArrayViewMut2<'_, Complex<f32>>,
    ) -> bonebeam_files::Result<()> {
        let all = Active::new(0, x.dim().2);
        // Checked: not negative, and within the elements.
        let given = |active: &ArrayView3<'_, i64>, beam: usize, sample: usize| {
            Active::new(
                active[[beam, sample, 0]] as usize,
                active[[beam, sample, 1]] as usize,
            )
        };
        let of = |beam: usize, sample: usize| {
            let given = active.as_ref().map(|active| given(active, beam, sample));
            given.unwrap_or(all)
        };
        self.pool.install(|| self.plan.run_into(x, &of, &|_| {}, z))
    }
}

/// Checks that every active set is within the array's elements.
fn check(active: ArrayView3<'_, i64>, elements: usize) -> PyResult<()> {
    for ((beam, sample), &first) in active.index_axis(Axis(2), 0).indexed_iter() {
        let count = active[[beam, sample, 1]];
        let end = usize::try_from(first.saturating_add(count));
        if first < 0 || count < 1 || end.is_ok_and(|end| end > elements) {
            return Err(refused(format!(
                "`active` is ({first}, {count}) at beam {beam}, sample {sample}; expected the first \
                 active element and the number of active ones, within {elements} elements"
            )));
        }
    }
    Ok(())
}
