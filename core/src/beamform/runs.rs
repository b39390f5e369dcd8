//! The kernel's drive: `W` runs of samples, one a lane, from delayed samples to `z`.

use super::das::das;
use super::delayed_line::DelayedLine;
use super::esmv::{esmv, esmv_rank1};
use super::mv::mv;
use super::parameters::{Beamformer, Method};
use super::workspace::Workspace;
use crate::Error;
use crate::covariance::loading::load;
use crate::covariance::sliding::{sliding_covariance, subarray_sum};
use crate::covariance::{Averaging, TimeWindow};
use crate::lanes::{ComplexLanes, Lanes, Scalar};
use num_complex::Complex;

/// Consecutive samples of one beam that have one active set: what a lane works on.
#[derive(Clone, Copy, Debug)]
pub struct Run<'a> {
    /// The beam.
    pub line: DelayedLine<'a>,
    /// The first active element.
    pub first_element: usize,
    /// The first sample that is put out.
    pub first_sample: usize,
}

impl Beamformer {
    /// Beamforms `W` runs with the same number `count` of active elements, one in each lane:
    /// `z[lane][i]` is sample `first_sample + i`.
    ///
    /// Runs may differ in beam, depth and length; a lane that is not needed gets an empty `z`. A
    /// lane's bits do not depend on the other lanes nor on `W`, but for `K > 0` on where its run
    /// begins: the time window's blocks are counted from there, so give [`constant_runs`] whole.
    /// The scale is that of the input: a unit signal from straight ahead gives 1 with DAS and MV.
    /// With `count = 0`, `z` is 0.
    ///
    /// [`constant_runs`]: super::constant_runs
    ///
    /// Cost a sample and lane, in flops with `P = count − L + 1`: DAS `2·count`. The others: the
    /// covariance `8LP + 8L²` once, whatever `K` is, and three additions an entry for the time
    /// window; a run of `n` samples takes `n + 2K` covariances. MV adds `L³/3`; rank 1 that and
    /// `2L²` a power step, 32 at most; the full eigensolver, which serves the other methods and the
    /// lanes in which those two fail, `4L³/3` and the QL steps. Forward multiplies these by 4. RAM:
    /// the workspace.
    ///
    /// # Errors
    /// [`Error::Capacity`] where `count`, `L` or `2K+1` exceeds the workspace;
    /// [`Error::Parameter`] where `K` is beyond a record or a run is outside its line.
    pub fn runs<A, const M: usize, const L: usize, const SLOTS: usize, const W: usize>(
        &self,
        workspace: &mut Workspace<A, M, L, SLOTS, W>,
        runs: &[Run<'_>; W],
        count: usize,
        z: &mut [&mut [Complex<f32>]; W],
    ) -> Result<(), Error>
    where
        A: Averaging<W>,
    {
        let mut longest = 0;
        for (run, z) in runs.iter().zip(z.iter()) {
            self.check_run(run, count, z.len())?;
            if z.len() > longest {
                longest = z.len();
            }
        }
        if count == 0 {
            for z in z.iter_mut() {
                z.fill(Complex::new(0.0, 0.0));
            }
            return Ok(());
        }
        let subarray = self.check_capacity::<M, L, SLOTS>(count)?;
        if self.parameters().method == Method::Das {
            for i in 0..longest {
                gather(runs, count, i as isize, &mut workspace.snapshot);
                emit(runs, z, i, das(&workspace.snapshot[..count]));
            }
            return Ok(());
        }
        workspace.window.clear();
        for push in 0..longest + 2 * self.parameters().temporal {
            if let Some(i) = self.push(workspace, runs, count, subarray, push) {
                emit(runs, z, i, self.output(workspace, count, subarray, i));
            }
        }
        Ok(())
    }

    /// Takes the run's sample `push − K` into the covariance; from push `2K` on, the loaded
    /// covariance's window is complete for sample `push − 2K`, which is returned.
    #[inline]
    pub(super) fn push<A, const M: usize, const L: usize, const SLOTS: usize, const W: usize>(
        &self,
        workspace: &mut Workspace<A, M, L, SLOTS, W>,
        runs: &[Run<'_>; W],
        count: usize,
        subarray: usize,
        push: usize,
    ) -> Option<usize>
    where
        A: Averaging<W>,
    {
        let temporal = self.parameters().temporal;
        let length = 2 * temporal + 1;
        let Workspace {
            snapshot,
            forward,
            window,
            data,
            matrix,
            ..
        } = workspace;
        gather(runs, count, push as isize - temporal as isize, snapshot);
        let data = &mut data[push % length];
        subarray_sum(snapshot, count, subarray, data);
        A::data(data, subarray);
        sliding_covariance(snapshot, count, subarray, forward);
        A::matrix(forward, subarray, window.slot());
        let output = push.checked_sub(2 * temporal);
        TimeWindow::push(window, subarray, length, output.map(|_| matrix));
        output
    }

    /// `z` of sample `i` of the runs, at the runs' working scale.
    #[inline]
    fn output<A, const M: usize, const L: usize, const SLOTS: usize, const W: usize>(
        &self,
        workspace: &mut Workspace<A, M, L, SLOTS, W>,
        count: usize,
        subarray: usize,
        i: usize,
    ) -> ComplexLanes<W>
    where
        A: Averaging<W>,
    {
        let parameters = self.parameters();
        let Workspace {
            data,
            matrix,
            solver,
            ..
        } = workspace;
        let data = &data[(i + parameters.temporal) % (2 * parameters.temporal + 1)];
        let silent = load(matrix, subarray, parameters.loading);
        let (mut sum, solved) = match parameters.method {
            Method::Mv => mv::<A, L, W>(matrix, subarray, data, solver),
            Method::EsmvRank1 => esmv_rank1::<A, L, W>(matrix, subarray, data, solver),
            _ => (ComplexLanes::ZERO, [false; W]),
        };
        // The other methods, and the lanes that the faster solvers leave.
        if (0..W).any(|k| !solved[k] && !silent[k]) {
            let exact = esmv::<A, L, W>(parameters.method, matrix, subarray, data, solver);
            sum = ComplexLanes::select(solved, sum, exact);
        }
        let gain = Lanes::splat(A::gain(count - subarray + 1));
        let z = ComplexLanes {
            re: sum.re / gain,
            im: sum.im / gain,
        };
        ComplexLanes::select(silent, ComplexLanes::ZERO, z)
    }

    /// The run lies within its line and the time window within the record.
    pub(super) fn check_run(
        &self,
        run: &Run<'_>,
        count: usize,
        samples: usize,
    ) -> Result<(), Error> {
        let temporal = self.parameters().temporal;
        if temporal >= run.line.samples() {
            return Err(Error::Parameter {
                name: "temporal",
                value: temporal as f64,
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

    /// The subarray's length for `count ≥ 1`, where everything fits the workspace.
    pub(super) fn check_capacity<const M: usize, const L: usize, const SLOTS: usize>(
        &self,
        count: usize,
    ) -> Result<usize, Error> {
        if count > M {
            return Err(Error::Capacity {
                name: "active elements",
                actual: count,
                capacity: M,
            });
        }
        let subarray = self.subarray(count);
        if self.parameters().method == Method::Das {
            return Ok(subarray);
        }
        if subarray > L {
            return Err(Error::Capacity {
                name: "subarray",
                actual: subarray,
                capacity: L,
            });
        }
        let temporal = self.parameters().temporal;
        if temporal > (SLOTS - 1) / 2 {
            return Err(Error::Capacity {
                name: "temporal",
                actual: temporal,
                capacity: (SLOTS - 1) / 2,
            });
        }
        Ok(subarray)
    }
}

/// The active elements of each run's sample `i` (counted from the run's first), at the line's
/// working scale; zero outside the record.
#[inline]
fn gather<const M: usize, const W: usize>(
    runs: &[Run<'_>; W],
    count: usize,
    i: isize,
    snapshot: &mut [ComplexLanes<W>; M],
) {
    for (lane, run) in runs.iter().enumerate() {
        let sample = run
            .first_sample
            .checked_add_signed(i)
            .filter(|&n| n < run.line.samples());
        let Some(sample) = sample else {
            for x in snapshot.iter_mut().take(count) {
                x.set_lane(lane, Complex::new(0.0, 0.0));
            }
            continue;
        };
        let scale = run.line.scale();
        let active = &run.line.snapshot(sample)[run.first_element..run.first_element + count];
        for (x, &value) in snapshot.iter_mut().zip(active) {
            x.set_lane(lane, Complex::new(value.re * scale, value.im * scale));
        }
    }
}

/// Puts sample `i` of the lanes out, at the line's own scale.
#[inline]
fn emit<const W: usize>(
    runs: &[Run<'_>; W],
    z: &mut [&mut [Complex<f32>]; W],
    i: usize,
    value: ComplexLanes<W>,
) {
    for lane in 0..W {
        if let Some(z) = z[lane].get_mut(i) {
            *z = runs[lane].line.unscale(value.lane(lane));
        }
    }
}
