//! One beam, depth by depth, with an aperture that grows; and its weights for inspection.

use super::aligned_line::AlignedLine;
use super::methods::{Subspace, at_least_floor, rank_order};
use super::parameters::Beamformer;
use super::run::{Run, constant_runs};
use super::workspace::{Memory, Solver, Workspace};
use crate::Error;
use crate::covariance::Averaging;
use crate::error::check_length;
use crate::geometry::Active;
use crate::linalg::eigen::eigen;
use crate::linalg::householder::Reduction;
use crate::simd::{ComplexVector, Scalar};
use num_complex::Complex;

impl Beamformer {
    /// Beamforms one beam: `z[n]` from the samples of `line`, with the active set `active(n)`.
    ///
    /// One active set serves the whole time window of a sample. Samples without an active element
    /// are 0. See [`Beamformer::runs`] for scale and cost. `active` is asked twice for each sample:
    /// the whole line is checked before anything is put out.
    ///
    /// # Errors
    /// As [`Beamformer::runs`]; [`Error::Length`] where `z` is not as long as the line.
    pub fn line<A, const M: usize, const L: usize, const ROWS: usize>(
        &self,
        workspace: &mut Workspace<A, f32, M, L, ROWS>,
        line: AlignedLine<'_>,
        active: impl Fn(usize) -> Active,
        z: &mut [Complex<f32>],
    ) -> Result<(), Error>
    where
        A: Averaging<f32>,
    {
        check_length("z", z.len(), line.samples())?;
        let run = |first_sample, set: Active| Run {
            line,
            first_element: set.first,
            first_sample,
        };
        for (first_sample, samples, set) in constant_runs(line.samples(), &active) {
            self.check_run(&run(first_sample, set), set.count, samples)?;
            self.check_capacity::<A, f32>(set.count, [M, L, ROWS])?;
        }
        for (first_sample, samples, set) in constant_runs(line.samples(), &active) {
            let run = run(first_sample, set);
            let out = &mut z[first_sample..first_sample + samples];
            self.runs(workspace, &[run], set.count, &mut [out])?;
        }
        Ok(())
    }

    /// The weights of one sample: `w` (Eq. 1) or `w_p` (Eq. 7), by the full eigensolver, into the
    /// first `L` entries of `weights` (for DAS `1/count`, into the first `count`). Returns how many.
    ///
    /// For inspection and tests: [`Beamformer::line`] never forms weights. `z` is `wᴴ` times the
    /// mean snapshot of the subapertures. A sample without power has weights 0.
    ///
    /// # Errors
    /// As [`Beamformer::runs`]; [`Error::Length`] where `weights` is too short;
    /// [`Error::Parameter`] for a sample outside the line or an empty active set.
    pub fn weights<A, const M: usize, const L: usize, const ROWS: usize>(
        &self,
        workspace: &mut Workspace<A, f32, M, L, ROWS>,
        line: AlignedLine<'_>,
        active: Active,
        sample: usize,
        weights: &mut [Complex<f32>],
    ) -> Result<usize, Error>
    where
        A: Averaging<f32>,
    {
        let run = Run {
            line,
            first_element: active.first,
            first_sample: sample,
        };
        self.check_run(&run, active.count, 1)?;
        if active.count == 0 {
            return Err(Error::Parameter {
                name: "active elements",
                value: 0.0,
                expected: "at least 1",
            });
        }
        let subaperture = self.check_capacity::<A, f32>(active.count, [M, L, ROWS])?;
        let method = self.parameters().method;
        let direct = method.direct().is_some();
        let length = if direct { active.count } else { subaperture };
        let available = weights.len();
        let Some(weights) = weights.get_mut(..length) else {
            return Err(Error::Length {
                name: "weights",
                actual: available,
                expected: length,
            });
        };
        if direct {
            method.direct_weights(weights);
            return Ok(length);
        }
        let mut memory = workspace.memory();
        let mut silent = true;
        for push in 0..=2 * self.parameters().temporal_half_window {
            let pushed = self.push::<A, f32>(&mut memory, &[run], active.count, subaperture, push);
            silent = pushed.unwrap_or(true);
        }
        if silent {
            weights.fill(Complex::new(0.0, 0.0));
        } else {
            eigenspace_weights::<A>(method.subspace(), &mut memory, weights);
        }
        Ok(length)
    }
}

/// `w_p = Σ e_k(e_kᴴa)/λ_k / c_L` over the eigenvectors that `subspace` has, as many as there are
/// `weights`, for the loaded covariance in the solver's panels.
///
/// Entry `i` is `(Eᴴu_i)ᴴ` times the kept `Eᴴa/λ`, with `u_i` the unit vector: the eigensolver is
/// given as many unit vectors at a time as the time window's memory, which is free by now, holds.
fn eigenspace_weights<A: Averaging<f32>>(
    subspace: Subspace,
    memory: &mut Memory<'_, A::Scalar, f32>,
    weights: &mut [Complex<f32>],
) {
    let n = weights.len();
    let Solver {
        matrix,
        factor,
        rows,
        phases,
        tridiagonal,
        lane,
        values,
        work,
        order,
        cumulative,
        ..
    } = &mut memory.solver;
    let (filtered, result) = work.split_at_mut(work.len() / 2);
    let zero = ComplexVector { re: 0.0, im: 0.0 };
    for (i, entry) in filtered.iter_mut().enumerate() {
        entry.re = A::steering(i, n);
        entry.im = 0.0;
    }
    let mut reduction = Reduction {
        panels: factor.as_chunks_mut().0,
        vectors: rows.as_flattened_mut(),
        phases,
        tridiagonal,
    };
    eigen(
        matrix,
        n,
        &mut reduction,
        lane,
        values,
        &mut filtered[..n],
        n,
    );
    let total = rank_order(&values[..n], filtered, 0, order, cumulative);
    let places = subspace.places(cumulative, total, n);
    for (place, &k) in order[..n].iter().enumerate() {
        filtered[k] = if places.contains(&place) {
            filtered[k].divide(at_least_floor(values[k]) * total)
        } else {
            zero
        };
    }
    let batch = memory.window.len() / n;
    for first in (0..n).step_by(batch) {
        let count = if batch < n - first { batch } else { n - first };
        let units = &mut memory.window[..count * n];
        units.fill(zero);
        for (i, unit) in units.chunks_exact_mut(n).enumerate() {
            unit[first + i].re = 1.0;
        }
        eigen(matrix, n, &mut reduction, lane, values, units, n);
        for (i, unit) in units.chunks_exact(n).enumerate() {
            let mut sum = zero;
            for &k in &order[..n] {
                sum = sum + filtered[k].mul_conj(unit[k]);
            }
            result[first + i] = sum;
        }
    }
    A::weights(&mut result[..n], filtered);
    for (weight, value) in weights.iter_mut().zip(&*result) {
        *weight = value.lane(0);
    }
}
