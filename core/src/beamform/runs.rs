//! The kernel's drive: a vector's lanes of sample runs, from aligned samples to `z`.
//!
//! Each stage (snapshot, lag sums, matrix, solver) is a function of its own, never inlined: the
//! compiler then knows that what its arguments refer to does not overlap, and keeps what it counts in
//! registers. On a Cortex-M7 that takes a tenth of the instructions of MV at 16/8 away, with AVX-512 a
//! tenth to a sixth of the time of rank 1.

use super::methods::weighted_sum;
use super::parameters::{Beamformer, Parameters};
use super::run::Run;
use super::snapshot::snapshot;
use super::workspace::{Memory, Workspace};
use crate::Error;
use crate::covariance::diagonal_loading::DiagonalLoading;
use crate::covariance::lag_sums::lag_sums;
use crate::covariance::{Averaging, time_window};
use crate::error::check_length;
use crate::linalg::panels::PanelColumn;
use crate::simd::{ComplexVector, Scalar, Vector};
use num_complex::Complex;

impl Beamformer {
    /// Beamforms up to `V::LANES` runs with the same number `count` of active elements, one in each
    /// lane: `z[lane][i]` is sample `first_sample + i`.
    ///
    /// Runs may differ in beam, depth and length. A lane's bits do not depend on the other lanes nor
    /// on `V`, but for `K > 0` on where its run begins: the time window's blocks are counted from
    /// there, so give [`constant_runs`] whole. The scale is that of the input: a unit signal from
    /// straight ahead gives 1 with DAS and MV. With `count = 0`, `z` is 0.
    ///
    /// [`constant_runs`]: super::constant_runs
    ///
    /// Cost a sample and lane, in flops with `P = count − L + 1`: DAS `2·count`. The others: the
    /// covariance `6(count·L − L²/2) + 4PL + 4L²` once, whatever `K` is, and three additions a number
    /// for the time window; a run of `n` samples takes `n + 2K` covariances. MV adds `L³/3 + 3L²`;
    /// rank 1 `L³/3 + L²`, and `2L²` a Lanczos step, of which an echo takes 2 or 3, or `4L³/3` where
    /// no eigenvalue stands out; the full eigensolver, which serves the other methods and the lanes
    /// whose matrix is singular, `4L³/3` and the QL steps. Forward multiplies these by 4. RAM: the
    /// workspace.
    ///
    /// # Errors
    /// [`Error::Capacity`] where there are more runs than lanes, or `count`, `L` or `2K+1` exceeds the
    /// workspace; [`Error::Length`] where `z` is not as long as `runs`; [`Error::Parameter`] where
    /// `K` is beyond a record or a run is outside its line.
    pub fn runs<A, V, const M: usize, const L: usize, const ROWS: usize>(
        &self,
        workspace: &mut Workspace<A, V, M, L, ROWS>,
        runs: &[Run<'_>],
        count: usize,
        z: &mut [&mut [Complex<f32>]],
    ) -> Result<(), Error>
    where
        A: Averaging<V>,
        V: Vector,
    {
        if runs.len() > V::LANES {
            return Err(Error::Capacity {
                name: "runs",
                actual: runs.len(),
                capacity: V::LANES,
            });
        }
        check_length("z", z.len(), runs.len())?;
        for (run, z) in runs.iter().zip(z.iter()) {
            self.check_run(run, count, z.len())?;
        }
        if count == 0 {
            for z in z.iter_mut() {
                z.fill(Complex::new(0.0, 0.0));
            }
            return Ok(());
        }
        let subaperture = self.check_capacity::<A, V>(count, [M, L, ROWS])?;
        if let Some(direct) = self.parameters().method.direct() {
            for (run, z) in runs.iter().zip(z) {
                direct(run, count, z);
            }
            return Ok(());
        }
        let mut memory = workspace.memory();
        // A lane without a run keeps its zeros.
        let zero = memory.snapshot[0].zero();
        memory.snapshot.fill(zero);
        self.vectorized::<A, V>(&mut memory, runs, count, subaperture, z);
        Ok(())
    }

    /// [`Beamformer::lanes`] with the vector's instructions: compiled once for all capacities.
    fn vectorized<A: Averaging<V>, V: Vector>(
        &self,
        memory: &mut Memory<'_, A::Scalar, V>,
        runs: &[Run<'_>],
        count: usize,
        subaperture: usize,
        z: &mut [&mut [Complex<f32>]],
    ) {
        memory.snapshot[0].re.vectorize(
            #[inline(always)]
            || self.lanes::<A, V>(memory, runs, count, subaperture, z),
        );
    }

    #[inline(always)]
    fn lanes<A: Averaging<V>, V: Vector>(
        &self,
        memory: &mut Memory<'_, A::Scalar, V>,
        runs: &[Run<'_>],
        count: usize,
        subaperture: usize,
        z: &mut [&mut [Complex<f32>]],
    ) {
        let mut longest = 0;
        for z in z.iter() {
            if z.len() > longest {
                longest = z.len();
            }
        }
        for push in 0..longest + 2 * self.parameters().temporal_half_window {
            if let Some(silent) = self.push::<A, V>(memory, runs, count, subaperture, push) {
                let i = push - 2 * self.parameters().temporal_half_window;
                let value = self.output::<A, V>(memory, count, subaperture, i, silent);
                emit(runs, z, i, value);
            }
        }
    }

    /// Takes the run's sample `push − K` into the covariance; from push `2K` on, the loaded
    /// covariance of sample `push − 2K` is complete, and the lanes without power are returned.
    #[inline(always)]
    pub(super) fn push<A: Averaging<V>, V: Vector>(
        &self,
        memory: &mut Memory<'_, A::Scalar, V>,
        runs: &[Run<'_>],
        count: usize,
        subaperture: usize,
        push: usize,
    ) -> Option<V::Mask> {
        let temporal_half_window = self.parameters().temporal_half_window;
        let active = &mut memory.snapshot[..count];
        let work = &mut *memory.solver.work;
        let (ring, window) = memory
            .window
            .split_at_mut((temporal_half_window + 1) * subaperture);
        let data = push % (temporal_half_window + 1) * subaperture;
        let data = &mut ring[data..data + subaperture];
        snapshot::<A, V>(
            runs,
            push as isize - temporal_half_window as isize,
            active,
            &mut work[..subaperture],
            data,
        );
        let size = A::lag_count(subaperture);
        let lags = time_window::slot(window, size, temporal_half_window, push);
        lag_sums::<A, V>(active, subaperture, work, lags);
        let (suffix, prefix) = time_window::window(window, size, temporal_half_window, push);
        if push < 2 * temporal_half_window {
            return None;
        }
        let diagonal_loading = self.parameters().diagonal_loading;
        Some(match suffix {
            None => loaded_matrix::<A, V>(
                #[inline(always)]
                move |i| prefix[i],
                subaperture,
                diagonal_loading,
                memory.solver.matrix,
            ),
            Some(suffix) => loaded_matrix::<A, V>(
                #[inline(always)]
                move |i| suffix[i] + prefix[i],
                subaperture,
                diagonal_loading,
                memory.solver.matrix,
            ),
        })
    }

    /// `z` of sample `i` of the runs, at the runs' working scale.
    #[inline(always)]
    fn output<A: Averaging<V>, V: Vector>(
        &self,
        memory: &mut Memory<'_, A::Scalar, V>,
        count: usize,
        subaperture: usize,
        i: usize,
        silent: V::Mask,
    ) -> ComplexVector<V> {
        let Parameters {
            method,
            temporal_half_window,
            ..
        } = *self.parameters();
        // The sample was pushed as number i + K.
        let data = (i + temporal_half_window) % (temporal_half_window + 1) * subaperture;
        let data = &memory.window[data..data + subaperture];
        let zero = data[0].zero();
        let sum = weighted_sum::<A, V>(method, &mut memory.solver, subaperture, data, silent);
        let gain = zero.re.splat(A::gain(count - subaperture + 1));
        ComplexVector::select(silent, zero, sum.divide(gain))
    }

    /// The run lies within its line and the time window within the record.
    pub(super) fn check_run(
        &self,
        run: &Run<'_>,
        count: usize,
        samples: usize,
    ) -> Result<(), Error> {
        let temporal_half_window = self.parameters().temporal_half_window;
        if temporal_half_window >= run.line.samples() {
            return Err(Error::Parameter {
                name: "temporal_half_window",
                value: temporal_half_window as f64,
                expected: "fewer than the record's samples",
            });
        }
        let (elements, record) = (run.line.elements(), run.line.samples());
        if run.first_element > elements || count > elements - run.first_element {
            return Err(Error::Parameter {
                name: "first element",
                value: run.first_element as f64,
                expected: "an active set within the line's elements",
            });
        }
        if run.first_sample > record || samples > record - run.first_sample {
            return Err(Error::Parameter {
                name: "first sample",
                value: run.first_sample as f64,
                expected: "a run within the line's samples",
            });
        }
        Ok(())
    }

    /// The subaperture's length for `count ≥ 1`, where everything fits a workspace with these `M`, `L`
    /// and `ROWS`.
    pub(super) fn check_capacity<A: Averaging<V>, V: Vector>(
        &self,
        count: usize,
        [elements, longest, rows]: [usize; 3],
    ) -> Result<usize, Error> {
        if count > elements {
            return Err(Error::Capacity {
                name: "active elements",
                actual: count,
                capacity: elements,
            });
        }
        let subaperture = self.subaperture(count);
        if self.parameters().method.direct().is_some() {
            return Ok(subaperture);
        }
        if subaperture > longest {
            return Err(Error::Capacity {
                name: "subaperture",
                actual: subaperture,
                capacity: longest,
            });
        }
        let temporal_half_window = self.parameters().temporal_half_window;
        let size = A::lag_count(subaperture);
        let fits = |temporal_half_window: usize| {
            let (ring, sets) = (
                temporal_half_window + 1,
                time_window::sets(temporal_half_window),
            );
            let needed = ring
                .saturating_mul(subaperture)
                .saturating_add(sets.saturating_mul(size));
            needed <= rows * longest
        };
        if !fits(temporal_half_window) {
            let capacity = (0..temporal_half_window)
                .rev()
                .find(|&k| fits(k))
                .unwrap_or(0);
            return Err(Error::Capacity {
                name: "temporal_half_window",
                actual: temporal_half_window,
                capacity,
            });
        }
        Ok(subaperture)
    }
}

/// The loaded matrix from the lag sums `lag(index)`; returns the lanes without power.
#[inline(never)]
fn loaded_matrix<A: Averaging<V>, V: Vector>(
    lag: impl Fn(usize) -> ComplexVector<V>,
    subaperture: usize,
    diagonal_loading: f32,
    matrix: &mut [PanelColumn<A::Scalar>],
) -> V::Mask {
    lag(0).re.vectorize(
        #[inline(always)]
        || {
            let diagonal_loading =
                DiagonalLoading::new(A::trace(&lag, subaperture), subaperture, diagonal_loading);
            A::matrix(&lag, subaperture, &diagonal_loading, matrix);
            diagonal_loading.silent
        },
    )
}

/// Puts sample `i` of the lanes out, at the line's own scale.
#[inline(always)]
fn emit<V: Vector>(
    runs: &[Run<'_>],
    z: &mut [&mut [Complex<f32>]],
    i: usize,
    value: ComplexVector<V>,
) {
    for (lane, (run, z)) in runs.iter().zip(z).enumerate() {
        if let Some(z) = z.get_mut(i) {
            *z = run.line.unscale(value.lane(lane));
        }
    }
}
