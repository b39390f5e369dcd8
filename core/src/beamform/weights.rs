//! Weights of one sample, for inspection.

use super::extent::Given;
use super::methods::{Method, Subspace, at_least_floor, rank_order, weighted_sum};
use super::parameters::{Beamformer, Parameters};
use super::segment::Segment;
use super::workspace::{Solver, View, Workspace, with_view};
use crate::Error;
use crate::covariance::Averaging;
use crate::linalg::eigen::eigen;
use crate::linalg::householder::Reduction;
use crate::simd::{ComplexVector, Scalar};
use num_complex::Complex;

impl Beamformer {
    /// Computes the weights of a segment's first sample with `count` active elements.
    ///
    /// The weights `w` (Eq. 1) or `w_p` (Eq. 7) are stored in the first `L` entries of `weights`. DAS stores `1/count`,
    /// or the window divided by its sum, in the first `count`. Returns their number. The full eigensolver is used,
    /// except for [`Method::EsmvRank1Steps`] with its own kernel.
    ///
    /// For inspection and tests: [`Beamformer::line`] never forms weights. `z` is `wᴴ` times the
    /// mean snapshot of the subapertures, weighted by the apodization. A sample without power has weights 0.
    ///
    /// # Errors
    /// As [`Beamformer::segments`]; [`Error::Length`] if `weights` is too short; [`Error::Parameter`] for a sample
    /// outside the line or an empty active set.
    // Inline, as the self-test is.
    #[inline]
    pub fn weights(
        &self,
        workspace: &mut Workspace<'_>,
        segment: &Segment<'_>,
        count: usize,
        weights: &mut [Complex<f32>],
    ) -> Result<usize, Error> {
        self.check_segment(segment, count, 1)?;
        if count == 0 {
            return Err(Error::parameter("active elements", 0.0, "at least 1"));
        }
        let method = self.parameters().method;
        let direct = method.direct();
        let length = match direct {
            Some(_) => count,
            None => self.check_sizes(count, workspace.sizes())?,
        };
        let available = weights.len();
        let Some(weights) = weights.get_mut(..length) else {
            return Err(Error::length("weights", available, length));
        };
        if let Some(direct) = direct {
            (direct.weights)(segment, self.parameters().window().as_ref(), weights);
            return Ok(length);
        }
        let segments = core::slice::from_ref(segment);
        let extent = Given::<true> {
            count,
            subaperture: length,
        };
        // For any sample, computed in a line or not.
        let every = Beamformer::unchecked(Parameters {
            depth_step: 1,
            ..*self.parameters()
        });
        with_view!(workspace, view => {
            let mut zero_power = true;
            for push in 0..=2 * self.parameters().temporal_half_window {
                let pushed = every.push::<_, f32, true>(view, segments, extent, push);
                zero_power = pushed.unwrap_or(true);
            }
            match method {
                _ if zero_power => weights.fill(Complex::new(0.0, 0.0)),
                Method::EsmvRank1Steps(_) => kernel_weights(method, view, weights),
                _ => eigenspace_weights(method.subspace(), view, weights),
            }
        });
        Ok(length)
    }
}

/// Weights from the method's kernel, by unit vectors.
///
/// Entry `i` is `(w_pᴴu_i)*`, the kernel's output for the unit vector `u_i`, for the loaded covariance in the
/// solver's panels.
fn kernel_weights<A: Averaging<f32>>(
    method: Method,
    view: &mut View<'_, A, f32>,
    weights: &mut [Complex<f32>],
) {
    let n = weights.len();
    let View { ring, solver, .. } = view;
    let Some(unit) = ring.get_mut(..n) else {
        return;
    };
    for (i, weight) in weights.iter_mut().enumerate() {
        unit.fill(ComplexVector::new(0.0, 0.0));
        if let Some(entry) = unit.get_mut(i) {
            entry.re = 1.0;
        }
        let sum = weighted_sum::<A, f32>(0.0, method, solver, n, unit, false);
        *weight = Complex::new(sum.re, -sum.im);
    }
    let (result, scratch) = solver.work.split_at_mut(solver.work.len() / 2);
    let Some(result) = result.get_mut(..n) else {
        return;
    };
    for (result, weight) in result.iter_mut().zip(&*weights) {
        *result = ComplexVector::new(weight.re, weight.im);
    }
    A::weights(result, scratch);
    for (weight, value) in weights.iter_mut().zip(&*result) {
        *weight = value.lane(0);
    }
}

/// Divides the projections by their eigenvalues times `total` within the subspace, and leaves 0 outside of it. `metrics`
/// are ranked, `order` has their indices.
fn keep_subspace(
    subspace: Subspace,
    total: f32,
    order: &[f32],
    metrics: &[f32],
    (projections, eigenvalues): (&mut [ComplexVector<f32>], &[ComplexVector<f32>]),
) {
    let mut before = 0.0;
    for (position, (&index, &metric)) in order.iter().zip(metrics).enumerate() {
        let k = index as usize;
        if let (Some(entry), Some(eigenvalue)) = (projections.get_mut(k), eigenvalues.get(k)) {
            *entry = if subspace.has(position, before, total) {
                entry.divide(eigenvalue.re * total)
            } else {
                ComplexVector::new(0.0, 0.0)
            };
        }
        before = metric;
    }
}

/// `w_p = Σ e_k(e_kᴴa)/λ_k / c_L` over the eigenvectors that `subspace` has, as many as there are
/// `weights`, for the loaded covariance in the solver's panels.
///
/// Entry `i` is `(Eᴴu_i)ᴴ` times the kept `Eᴴa/λ`, with `u_i` the unit vector: the eigensolver is given
/// two of them at a time, the first among the matrix's own numbers.
fn eigenspace_weights<A: Averaging<f32>>(
    subspace: Subspace,
    view: &mut View<'_, A, f32>,
    weights: &mut [Complex<f32>],
) {
    let n = weights.len();
    let Solver {
        matrix,
        factor,
        rows,
        phases,
        tridiagonal,
        values,
        vector,
        work,
        ..
    } = &mut view.solver;
    let nothing = ComplexVector::new(0.0, 0.0);
    let (filtered, result) = work.split_at_mut(work.len() / 2);
    let (Some((filtered, unit)), Some((result, next))) = (
        filtered.split_at_mut_checked(n),
        result.split_at_mut_checked(n),
    ) else {
        return;
    };
    let (Some(vector), Some(unit), Some(next), Some(values)) = (
        vector.get_mut(..n),
        unit.get_mut(..n),
        next.get_mut(..n),
        values.get_mut(..n),
    ) else {
        return;
    };
    for (i, entry) in vector.iter_mut().enumerate() {
        *entry = A::Scalar::from_real(A::steering(i, n));
    }
    let mut reduction = Reduction {
        panels: factor,
        vectors: rows.as_flattened_mut(),
        phases,
        tridiagonal,
    };
    eigen(matrix, &mut reduction, values, vector, next);
    // The remains of the matrix are overwritten.
    let (Some(metrics), Some(order)) = (
        reduction.tridiagonal.diagonal.get_mut(..n),
        reduction.tridiagonal.eigenvector.get_mut(..n),
    ) else {
        return;
    };
    // The eigenvalues are kept apart, since the ranking moves them.
    let kept = filtered.iter_mut().zip(result.iter_mut());
    let found = metrics.iter_mut().zip(vector.iter().zip(&*values));
    for ((entry, eigenvalue), (metric, (projection, &value))) in kept.zip(found) {
        eigenvalue.re = at_least_floor(value);
        *metric = projection.norm_sqr() / eigenvalue.re;
        *entry = projection.complex();
    }
    let total = rank_order(0.0, values, metrics, order);
    keep_subspace(subspace, total, order, values, (filtered, result));
    for (i, results) in result.chunks_mut(2).enumerate() {
        vector.fill(A::Scalar::from_real(0.0));
        next.fill(nothing);
        if let Some(entry) = vector.get_mut(2 * i) {
            *entry = A::Scalar::from_real(1.0);
        }
        if let Some(entry) = next.get_mut(2 * i + 1) {
            entry.re = 1.0;
        }
        eigen(matrix, &mut reduction, values, vector, next);
        for (unit, entry) in unit.iter_mut().zip(&*vector) {
            *unit = entry.complex();
        }
        let order = reduction.tridiagonal.eigenvector.get(..n);
        for (result, unit) in results.iter_mut().zip([&*unit, &*next]) {
            let mut sum = nothing;
            for &index in order.unwrap_or_default() {
                let k = index as usize;
                if let (Some(filtered), Some(&unit)) = (filtered.get(k), unit.get(k)) {
                    sum = sum + filtered.mul_conj(unit);
                }
            }
            *result = sum;
        }
    }
    A::weights(result, filtered);
    for (weight, value) in weights.iter_mut().zip(&*result) {
        *weight = value.lane(0);
    }
}
