//! One beam, depth by depth, with an aperture that grows; and its weights for inspection.

use super::delayed_line::DelayedLine;
use super::esmv::Spectrum;
use super::parameters::{Beamformer, Method};
use super::runs::Run;
use super::workspace::Workspace;
use crate::Error;
use crate::channel::aperture::Active;
use crate::covariance::Averaging;
use crate::covariance::loading::load;
use crate::error::check_length;
use crate::lanes::ComplexLanes;
use crate::linalg::eigen::eigen;
use num_complex::Complex;

/// Splits `0..samples` where the active set changes: `(first sample, number of samples, active)`.
pub fn constant_runs(
    samples: usize,
    active: impl Fn(usize) -> Active,
) -> impl Iterator<Item = (usize, usize, Active)> {
    let mut start = 0;
    core::iter::from_fn(move || {
        if start >= samples {
            return None;
        }
        let set = active(start);
        let mut end = start + 1;
        while end < samples && active(end) == set {
            end += 1;
        }
        let run = (start, end - start, set);
        start = end;
        Some(run)
    })
}

impl Beamformer {
    /// Beamforms one beam: `z[n]` from the samples of `line`, with the active set `active(n)`.
    ///
    /// One active set serves the whole time window of a sample. Samples without an active element
    /// are 0. See [`Beamformer::runs`] for scale and cost. `active` is asked twice for each sample:
    /// the whole line is checked before anything is put out.
    ///
    /// # Errors
    /// As [`Beamformer::runs`]; [`Error::Length`] where `z` is not as long as the line.
    pub fn line<A, const M: usize, const L: usize, const SLOTS: usize>(
        &self,
        workspace: &mut Workspace<A, M, L, SLOTS, 1>,
        line: DelayedLine<'_>,
        active: impl Fn(usize) -> Active,
        z: &mut [Complex<f32>],
    ) -> Result<(), Error>
    where
        A: Averaging<1>,
    {
        check_length("z", z.len(), line.samples())?;
        let run = |first_sample, set: Active| Run {
            line,
            first_element: set.first,
            first_sample,
        };
        for (first_sample, samples, set) in constant_runs(line.samples(), &active) {
            self.check_run(&run(first_sample, set), set.count, samples)?;
            self.check_capacity::<M, L, SLOTS>(set.count)?;
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
    /// mean snapshot of the subarrays. A sample without power has weights 0.
    ///
    /// # Errors
    /// As [`Beamformer::runs`]; [`Error::Length`] where `weights` is too short;
    /// [`Error::Parameter`] for a sample outside the line or an empty active set.
    pub fn weights<A, const M: usize, const L: usize, const SLOTS: usize>(
        &self,
        workspace: &mut Workspace<A, M, L, SLOTS, 1>,
        line: DelayedLine<'_>,
        active: Active,
        sample: usize,
        weights: &mut [Complex<f32>],
    ) -> Result<usize, Error>
    where
        A: Averaging<1>,
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
        let subarray = self.check_capacity::<M, L, SLOTS>(active.count)?;
        let method = self.parameters().method;
        let length = if method == Method::Das {
            active.count
        } else {
            subarray
        };
        let available = weights.len();
        let Some(weights) = weights.get_mut(..length) else {
            return Err(Error::Length {
                name: "weights",
                actual: available,
                expected: length,
            });
        };
        if method == Method::Das {
            weights.fill(Complex::new(1.0 / active.count as f32, 0.0));
            return Ok(length);
        }
        workspace.window.clear();
        for push in 0..=2 * self.parameters().temporal {
            self.push(workspace, &[run], active.count, subarray, push);
        }
        let Workspace {
            forward: vectors,
            matrix,
            solver,
            ..
        } = workspace;
        if load(matrix, subarray, self.parameters().loading)[0] {
            weights.fill(Complex::new(0.0, 0.0));
            return Ok(length);
        }
        for i in 0..subarray {
            for k in 0..subarray {
                let one = if i == k { 1.0 } else { 0.0 };
                vectors[i][k].set_lane(0, Complex::new(one, 0.0));
            }
        }
        eigen(
            matrix,
            subarray,
            &mut solver.eigen,
            &mut solver.values,
            &mut vectors[..subarray],
        );
        // vectors[i][k] = E(i,k)*; Eᴴa first.
        let [projections, result] = &mut solver.projections;
        for k in 0..subarray {
            let mut sum = Complex::new(0.0f32, 0.0);
            for i in 0..subarray {
                sum += vectors[i][k].lane(0) * A::steering(i, subarray);
            }
            projections[k].set_lane(0, sum);
        }
        let spectrum = Spectrum::new(&solver.values, projections, subarray, 0);
        for i in 0..subarray {
            let mut sum = Complex::new(0.0f32, 0.0);
            for place in spectrum.kept(method, subarray) {
                let k = spectrum.order[place];
                let term = vectors[i][k].lane(0).conj() * projections[k].lane(0);
                sum += term / spectrum.value(&solver.values, k, 0);
            }
            result[i] = ComplexLanes::ZERO;
            result[i].set_lane(0, sum / spectrum.total);
        }
        A::weights(result, subarray);
        for (weight, value) in weights.iter_mut().zip(result.iter()) {
            *weight = value.lane(0);
        }
        Ok(length)
    }
}
