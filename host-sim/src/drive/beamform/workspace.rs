//! A thread's memory for the core's beamformer, whatever its lanes and its capacities.

use bonebeam::Error as CoreError;
use bonebeam::beamform::{Beamformer, Run, Workspace};
use bonebeam::covariance::{Averaging, Covariance, Forward, ForwardBackward};
use bonebeam::simd::{InstructionSet, Task, Vector};
use num_complex::Complex;

use super::{MAX_ELEMENTS, MAX_SUBAPERTURE, MAX_TEMPORAL};

/// A workspace of the core, of a type that is chosen at run time.
pub(crate) trait AnyWorkspace: Send {
    /// How many runs it takes at a time.
    fn lanes(&self) -> usize;

    /// See [`Beamformer::runs`].
    ///
    /// # Errors
    /// What the core refuses.
    fn runs(
        &mut self,
        beamformer: &Beamformer,
        runs: &[Run<'_>],
        count: usize,
        z: &mut [&mut [Complex<f32>]],
    ) -> Result<(), CoreError>;
}

impl<A, V, const M: usize, const L: usize, const ROWS: usize> AnyWorkspace
    for Workspace<A, V, M, L, ROWS>
where
    A: Averaging<V>,
    V: Vector,
{
    fn lanes(&self) -> usize {
        V::LANES
    }

    fn runs(
        &mut self,
        beamformer: &Beamformer,
        runs: &[Run<'_>],
        count: usize,
        z: &mut [&mut [Complex<f32>]],
    ) -> Result<(), CoreError> {
        beamformer.runs(self, runs, count, z)
    }
}

/// Which of the workspaces that are compiled in: the smallest one that fits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Capacity {
    /// The covariance in use.
    pub covariance: Covariance,
    /// The longest subaperture.
    pub subaperture: usize,
    /// The temporal half-window `K`.
    pub temporal_half_window: usize,
}

impl Capacity {
    /// A workspace of up to 80 MB; made on the stack before it moves to the heap.
    pub fn workspace(self, set: InstructionSet) -> Box<dyn AnyWorkspace> {
        set.dispatch(self)
    }

    fn averaging<A: Averaging<V> + 'static, V: Vector>(self, zero: V) -> Box<dyn AnyWorkspace> {
        const SMALL: usize = window_rows(64, 2);
        const MEDIUM: usize = window_rows(64, 10);
        const LARGE: usize = window_rows(MAX_SUBAPERTURE, MAX_TEMPORAL);
        match (self.subaperture, self.temporal_half_window) {
            (..=64, ..=2) => boxed::<A, V, 64, SMALL>(zero),
            (..=64, ..=10) => boxed::<A, V, 64, MEDIUM>(zero),
            _ => boxed::<A, V, MAX_SUBAPERTURE, LARGE>(zero),
        }
    }
}

/// A function of its own for each: whoever enters a function touches its whole frame, and the largest
/// workspace's would be part of the caller's.
#[inline(never)]
fn boxed<A, V, const L: usize, const ROWS: usize>(zero: V) -> Box<dyn AnyWorkspace>
where
    A: Averaging<V> + 'static,
    V: Vector,
{
    Box::new(Workspace::<A, V, MAX_ELEMENTS, L, ROWS>::over(zero))
}

impl Task for Capacity {
    type Output = Box<dyn AnyWorkspace>;

    fn run<V: Vector>(self, zero: V) -> Box<dyn AnyWorkspace> {
        match self.covariance {
            Covariance::Forward => self.averaging::<Forward, V>(zero),
            Covariance::ForwardBackward => self.averaging::<ForwardBackward, V>(zero),
        }
    }
}

/// Rows of a workspace for windows of up to `2·temporal + 1` samples, whichever the covariance.
const fn window_rows(subaperture: usize, temporal_half_window: usize) -> usize {
    let (forward, both) = (
        Forward::window_rows(subaperture, temporal_half_window),
        ForwardBackward::window_rows(subaperture, temporal_half_window),
    );
    if forward > both { forward } else { both }
}
