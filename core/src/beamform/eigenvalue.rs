//! The share of a sample's power in the largest eigenvalue of its covariance.

use super::extent::{Extent, Given};
use super::line::{LineBlock, Run};
use super::methods::{Method, first_eigenpair};
use super::parameters::{Beamformer, Parameters};
use super::pushes::Pushes;
use super::segment::{Segment, constant_segments};
use super::workspace::{View, Workspace, with_view};
use super::{AlignedLine, Sizes};
use crate::Error;
use crate::covariance::Averaging;
use crate::error::check_length;
use crate::geometry::Active;
use crate::linalg::panels::{TILE, panel};
use crate::simd::{ComplexVector, Scalar, Vector, vectorize};

impl Beamformer {
    /// Shapes of the workspace of [`Beamformer::eigenvalue_shares`].
    ///
    /// `elements` is the largest number of active elements.
    pub fn eigenvalue_sizes(&self, elements: usize) -> Sizes {
        of_covariance(*self.parameters()).sizes(elements)
    }

    /// The share `λ₁/tr R` of the largest eigenvalue in each computed sample.
    ///
    /// Equal echoes on all elements give 1, independent noise about `(1 + √(L/n))²/L` with `n` independent snapshots,
    /// and the least share is `1/L`. Silence, and a sample without an active element, give 0. `R` is the covariance of
    /// the parameters: subapertures, covariance and time window, without diagonal loading. Method, apodization and postfilter
    /// have no effect. `active` is called twice for each sample.
    ///
    /// Cost: that of rank 1 without its factorisation.
    ///
    /// # Errors
    /// As [`Beamformer::line`], also for a workspace below [`Beamformer::eigenvalue_sizes`]; [`Error::Parameter`]
    /// without the feature `eigenspace`.
    ///
    /// ```
    /// use bonebeam::prelude::stages::*;
    /// use bonebeam::beamform::Parameters;
    ///
    /// // An echo, one that is on two of four elements alone, nothing.
    /// let mut x = [Complex::new(0.0, 0.0); 12];
    /// x[..4].fill(Complex::new(0.5, -2.0));
    /// x[5..7].fill(Complex::new(1.0, 0.0));
    /// let line = AlignedLine::new(&x, 4)?;
    /// let all = |_| Active { first: 0, count: 4 };
    ///
    /// let beamformer = Beamformer::new(Parameters::default())?;
    /// let sizes = beamformer.eigenvalue_sizes(4);
    /// let mut memory = Memory::<100, 100>::new();
    /// let mut workspace = Workspace::new(0.0f32, sizes, memory.scratch())?;
    /// let mut shares = [0.0; 3];
    /// beamformer.eigenvalue_shares(&mut workspace, line, all, &mut shares)?;
    /// // Subapertures (0, 1), (1, 1) and (1, 0): R has 2 on its diagonal and 1 beside it.
    /// for (share, expected) in shares.iter().zip([1.0, 0.75, 0.0]) {
    ///     assert!((share - expected).abs() < 1e-6);
    /// }
    /// # Ok::<(), bonebeam::Error>(())
    /// ```
    pub fn eigenvalue_shares<V: Vector>(
        &self,
        workspace: &mut Workspace<'_, V>,
        line: AlignedLine<'_>,
        active: impl Fn(usize) -> Active,
        shares: &mut [f32],
    ) -> Result<(), Error> {
        check_length("shares", shares.len(), self.line_samples(line.samples()))?;
        let of = Beamformer::unchecked(of_covariance(*self.parameters()));
        of.parameters().method.check_compiled(0.0)?;
        let block = LineBlock {
            line,
            first: 0,
            samples: line.samples(),
            active,
            adaptive: 0..line.samples(),
        };
        of.check_block(workspace.sizes(), &block)?;
        with_view!(workspace, view => {
            for run in constant_segments(block.samples, |n| block.active(n)) {
                let samples = run.0..run.0 + run.1;
                let shares = shares.get_mut(block.outputs(of.parameters().step(), samples));
                of.shares_of_run(view, (&block, run), shares.unwrap_or_default());
            }
        });
        Ok(())
    }

    /// Samples with one active set, a part of them in each lane.
    fn shares_of_run<A: Averaging<V>, V: Vector>(
        &self,
        view: &mut View<'_, A, V>,
        (block, run): (&LineBlock<'_, impl Fn(usize) -> Active>, Run),
        shares: &mut [f32],
    ) {
        let count = run.2.count;
        if count == 0 {
            shares.fill(0.0);
            return;
        }
        let subaperture = self.subaperture(count);
        let mut parts = self.parts(V::LANES, (block, run), 1, shares);
        let (segments, shares) = parts.used();
        // A lane without a segment keeps its zeros.
        let zero = view.zero;
        view.snapshot.fill(ComplexVector::from_real(zero));
        vectorize!(zero, {
            let extent = Given::<true> { count, subaperture };
            self.shares_of_lanes(view, segments, extent, shares);
        });
    }

    #[inline(always)]
    fn shares_of_lanes<A: Averaging<V>, V: Vector>(
        &self,
        view: &mut View<'_, A, V>,
        segments: &[Segment<'_>],
        extent: Given<true>,
        shares: &mut [&mut [f32]],
    ) {
        let half_window = extent.half_window(self.parameters());
        let pushes = Pushes::new(half_window, self.parameters().step());
        let counts = segments.iter().zip(shares.iter());
        let counts = counts.map(|(segment, shares)| pushes.count(segment, shares.len()));
        for push in 0..counts.max().unwrap_or(0) {
            let Some(zero_power) = self.push::<A, V, false>(view, segments, extent, push) else {
                continue;
            };
            let share = share::<A, V>(view, extent.subaperture, zero_power);
            for ((segment, shares), &share) in
                segments.iter().zip(shares.iter_mut()).zip(share.lanes())
            {
                let index = pushes.output(segment, push);
                if let Some(of_sample) = index.and_then(|index| shares.get_mut(index)) {
                    *of_sample = share;
                }
            }
        }
    }
}

/// The parameters of a method with the same covariance, not loaded.
const fn of_covariance(parameters: Parameters) -> Parameters {
    Parameters {
        method: Method::EsmvRank1,
        diagonal_loading: 0.0,
        sub_lines: 1,
        ..parameters
    }
}

/// `λ₁` over the trace of the matrix in the solver's panels, `1/L` to 1; 0 in the `zero_power` lanes.
#[inline(always)]
fn share<A: Averaging<V>, V: Vector>(
    view: &mut View<'_, A, V>,
    subaperture: usize,
    zero_power: V::Mask,
) -> V {
    let zero = view.zero.zero();
    let solver = &mut view.solver;
    let mut trace = zero;
    for i in 0..subaperture {
        let column = solver.matrix.get(panel(i / TILE) + i);
        if let Some(entry) = column.and_then(|column| column.get(i % TILE)) {
            trace = trace + entry.complex().re;
        }
    }
    let largest = first_eigenpair::<A, V>(zero, solver, subaperture, zero_power);
    let share = largest.unwrap_or(zero) / trace;
    let (least, one) = (zero.splat(1.0 / subaperture as f32), zero.splat(1.0));
    let share = V::select(share.less(one), share, one);
    let share = V::select(share.less(least), least, share);
    V::select(zero_power, zero, share)
}
