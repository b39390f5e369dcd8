//! The kernel's driver: a segment in each lane, from aligned samples to `z`.
//!
//! Each stage (snapshot, lag sums, matrix, solver) is a function of its own, never inlined. The compiler then knows
//! that the arguments do not overlap, and keeps counters in registers. This saves a tenth of the instructions of MV
//! at 16/8 on a Cortex-M7, and a tenth to a sixth of the time of rank 1 with AVX-512.

use super::extent::{Constant, Extent, Given};
use super::methods::{Direct, weighted_sum};
use super::parameters::{Beamformer, Parameters};
use super::postfilter::postfilter;
use super::pushes::Pushes;
use super::segment::{Segment, SegmentGroup};
use super::sizes::Sizes;
use super::snapshot::{elements, snapshot};
use super::workspace::{View, Workspace, with_view};
use crate::Error;
use crate::covariance::diagonal_loading::DiagonalLoading;
use crate::covariance::lag_sums::lag_sums;
use crate::covariance::{Averaging, time_window};
use crate::error::check_length;
use crate::linalg::panels::PanelColumn;
use crate::linalg::size::{CONSTANTS, Size, small_known};
use crate::simd::{ComplexVector, Scalar, Vector, vectorize};
use core::ops::Range;
use num_complex::Complex;

impl Beamformer {
    /// Beamforms up to `V::LANES` segments, one in each lane.
    ///
    /// All have `count` active elements. `z[lane][i]` is computed sample `i` of the segment, counted from the first
    /// computed sample at or after `first_sample`; with a depth step of 1, sample `first_sample + i`.
    ///
    /// Segments may differ in beam, depth and length. A lane's bits depend neither on the other lanes nor on `V`. For
    /// `K > 0` they depend on the beginning of its segment, from which the time window's blocks are counted: pass the
    /// segments of [`constant_segments`] whole. The scale is that of the input: a unit signal from straight ahead gives
    /// 1 with DAS and MV. With `count = 0`, `z` is 0.
    ///
    /// [`constant_segments`]: super::constant_segments()
    ///
    /// Cost per sample and lane, in flops, with `P = count − L + 1`:
    ///
    /// - DAS: `2·count`.
    /// - Covariance of the other methods: `6(count·L − L²/2) + 4PL + 4L²` for any `K`, and three additions per number
    ///   for the time window. A segment of `n` samples needs `n + 2K` covariances.
    /// - MV adds `L³/3 + 3L²`.
    /// - Rank 1 adds `L³/3 + L²`, and `2L²` per Lanczos step (2 or 3 for an echo), or `4L³/3` if no eigenvalue stands
    ///   out.
    /// - The full eigensolver takes `4L³/3` and the QL steps. It serves the other methods, and lanes with a
    ///   singular matrix.
    ///
    /// Forward multiplies the costs of MV, rank 1 and the eigensolver by 4. RAM: the workspace.
    ///
    /// # Errors
    /// [`Error::Capacity`] for more segments than lanes, or if `count`, `L` or `2K+1` exceeds the workspace;
    /// [`Error::Length`] if `z` and `segments` differ in length; [`Error::Parameter`] if a line has no more than `K`
    /// samples or a segment is outside its line.
    #[inline]
    pub fn segments<V: Vector>(
        &self,
        workspace: &mut Workspace<'_, V>,
        segments: &[Segment<'_>],
        count: usize,
        z: &mut [&mut [Complex<f32>]],
    ) -> Result<(), Error> {
        let group = SegmentGroup { segments, count };
        let sizes = workspace.sizes();
        with_view!(workspace, view => self.segments_within(view, sizes, group, z))
    }

    /// [`Beamformer::segments`] with the workspace's sizes as an argument.
    ///
    /// See `fitting_segments`.
    #[inline(always)]
    pub(super) fn segments_within<A: Averaging<V>, V: Vector>(
        &self,
        view: &mut View<'_, A, V>,
        sizes: Sizes,
        group: SegmentGroup<'_, '_>,
        z: &mut [&mut [Complex<f32>]],
    ) -> Result<(), Error> {
        let SegmentGroup { segments, count } = group;
        if segments.len() > V::LANES {
            return Err(Error::capacity("segments", segments.len(), V::LANES));
        }
        check_length("z", z.len(), segments.len())?;
        for (segment, z) in segments.iter().zip(z.iter()) {
            let samples = self.parameters().step().span(segment.first_sample, z.len());
            self.check_segment(segment, count, samples)?;
        }
        if count == 0 {
            for z in z.iter_mut() {
                z.fill(Complex::new(0.0, 0.0));
            }
            return Ok(());
        }
        if let Some(direct) = self.parameters().method.direct() {
            self.direct_segments(&direct, view.zero, group, z);
            return Ok(());
        }
        let subaperture = self.check_sizes(count, sizes)?;
        let parameters = self.parameters();
        let half_window = parameters.temporal_half_window;
        // A constant, so that vectors are compiled for one shape only.
        if const { V::LANES == 1 } && half_window == 0 {
            if CONSTANTS && (count, subaperture) == (16, 8) && parameters.window().is_none() {
                self.fitting_segments(view, segments, Constant::<16, 8>, z);
            } else {
                let extent = Given::<false> { count, subaperture };
                self.fitting_segments(view, segments, extent, z);
            }
        } else {
            let extent = Given::<true> { count, subaperture };
            self.fitting_segments(view, segments, extent, z);
        }
        postfilter(
            (parameters.postfilter_of_lines(), parameters.step()),
            view.zero,
            group,
            z,
        );
        Ok(())
    }

    /// Segments of a method without covariance.
    #[cfg_attr(feature = "constants", inline(always))]
    pub(super) fn direct_segments<V: Vector>(
        &self,
        direct: &Direct,
        zero: V,
        group: SegmentGroup<'_, '_>,
        z: &mut [&mut [Complex<f32>]],
    ) {
        let (window, step) = (self.parameters().window(), self.parameters().step());
        for (segment, z) in group.segments.iter().zip(z.iter_mut()) {
            (direct.output)(segment, (group.count, step), window.as_ref(), z);
        }
        let of_lines = self.parameters().postfilter_of_lines();
        postfilter((of_lines, step), zero, group, z);
    }

    /// Segments that fit, with the vector's instructions.
    ///
    /// Not inlined: if sizes are constants, as those of a workspace in a [`Memory`](crate::Memory), the compiler
    /// knows from an argument that the subaperture is not longer. Compiled for each [`Extent`].
    #[inline(never)]
    fn fitting_segments<A: Averaging<V>, V: Vector>(
        &self,
        view: &mut View<'_, A, V>,
        segments: &[Segment<'_>],
        extent: impl Extent,
        z: &mut [&mut [Complex<f32>]],
    ) {
        // A lane without a segment keeps its zeros.
        let zero = view.zero;
        view.snapshot.fill(ComplexVector::from_real(zero));
        vectorize!(zero, self.lanes(view, segments, extent, z));
    }

    #[inline(always)]
    fn lanes<A: Averaging<V>, V: Vector>(
        &self,
        view: &mut View<'_, A, V>,
        segments: &[Segment<'_>],
        extent: impl Extent,
        z: &mut [&mut [Complex<f32>]],
    ) {
        let (half_window, subaperture) =
            (extent.half_window(self.parameters()), extent.subaperture());
        let pushes = Pushes::new(half_window, self.parameters().step());
        let mut most = 0;
        for (segment, z) in segments.iter().zip(z.iter()) {
            let count = pushes.count(segment, z.len());
            if count > most {
                most = count;
            }
        }
        let subapertures = extent.count().get() - subaperture.get() + 1;
        let gain = self.gain::<A, V>(subapertures);
        for push in 0..most {
            if let Some(zero_power) = self.push::<A, V, true>(view, segments, extent, push) {
                // The sample in the middle of the time window.
                let data = slot_of(push - half_window, half_window, subaperture.get());
                let data = view.ring.get(data).unwrap_or_default();
                let (zero, solver) = (view.zero, &mut view.solver);
                let method = self.parameters().method;
                let sum = weighted_sum::<A, V>(zero, method, solver, subaperture, data, zero_power);
                let gain = view.zero.splat(gain);
                let nothing = ComplexVector::from_real(view.zero);
                let value = ComplexVector::select(zero_power, nothing, sum.divide(gain));
                emit(segments, z, |of| pushes.output(of, push), value);
            }
        }
    }

    /// Divisor of the sum over the subapertures.
    #[inline(always)]
    pub(super) fn gain<A: Averaging<V>, V: Vector>(&self, subapertures: usize) -> f32 {
        match self.parameters().window() {
            None => A::gain(subapertures),
            Some(window) => A::gain(1) * window.total(subapertures),
        }
    }

    /// Adds the next sample of each segment to the covariance, [`Pushes::read`].
    ///
    /// If the time window of a computed sample is then complete, computes its loaded covariance, and returns the
    /// lanes without power. With `DATA`, keeps the subaperture sum of the sample, too.
    #[inline(always)]
    pub(super) fn push<A: Averaging<V>, V: Vector, const DATA: bool>(
        &self,
        view: &mut View<'_, A, V>,
        segments: &[Segment<'_>],
        extent: impl Extent,
        push: usize,
    ) -> Option<V::Mask> {
        let half_window = extent.half_window(self.parameters());
        let (count, subaperture) = (extent.count(), extent.subaperture());
        let View {
            zero,
            snapshot: active,
            ring,
            lags: window,
            solver,
            ..
        } = view;
        let zero = *zero;
        let data = slot_of(push, half_window, subaperture.get());
        let work = &mut *solver.work;
        let (Some(active), Some(sum), Some(data)) = (
            active.get_mut(..count.get()),
            work.get_mut(..subaperture.get()),
            ring.get_mut(data),
        ) else {
            return None;
        };
        let pushes = Pushes::new(half_window, self.parameters().step());
        let apodization = extent.apodization(self.parameters());
        let sample_index = pushes.read(push);
        match DATA {
            true => {
                snapshot::<A, V>(
                    (segments, sample_index),
                    apodization.as_ref(),
                    (count, subaperture),
                    active,
                    (sum, data),
                );
            }
            false => elements(zero, segments, sample_index, active),
        }
        let size = A::COVARIANCE.lag_count(subaperture.get());
        let lags = time_window::slot(window, size, half_window, push);
        lag_sums::<A, V>(active, (count, subaperture), work, lags);
        let (suffix, prefix) = time_window::window(window, size, half_window, push);
        if !pushes.is_due(segments, push) {
            return None;
        }
        let parameters = self.parameters();
        let matrix = &mut *solver.matrix;
        Some(small_known!(V, n = subaperture.get() => {
            loaded_matrix::<A, V>(zero, suffix, prefix, n, parameters, matrix)
        }))
    }

    /// Checks that the segment is within its line and the time window within the record.
    pub(super) fn check_segment(
        &self,
        segment: &Segment<'_>,
        count: usize,
        samples: usize,
    ) -> Result<(), Error> {
        let temporal_half_window = self.parameters().temporal_half_window;
        if temporal_half_window >= segment.line.samples() {
            return Err(Error::parameter(
                "temporal_half_window",
                temporal_half_window as f64,
                "fewer than the record's samples",
            ));
        }
        let (elements, record) = (segment.line.elements(), segment.line.samples());
        if segment.first_element > elements || count > elements - segment.first_element {
            let expected = "an active set within the line's elements";
            let value = segment.first_element as f64;
            return Err(Error::parameter("first element", value, expected));
        }
        if segment.first_sample > record || samples > record - segment.first_sample {
            let expected = "a segment within the line's samples";
            let value = segment.first_sample as f64;
            return Err(Error::parameter("first sample", value, expected));
        }
        let reach = |sample: usize| sample.saturating_add(temporal_half_window).min(record);
        let window = segment.first_sample.saturating_sub(temporal_half_window)
            ..reach(segment.first_sample + samples);
        if !segment.line.holds(window) {
            let expected = "a segment whose time windows lie within the line's block";
            let value = segment.first_sample as f64;
            return Err(Error::parameter("first sample", value, expected));
        }
        Ok(())
    }

    /// The subaperture of `count ≥ 1` active elements.
    ///
    /// Elements, subaperture and time window must be within `sizes`, of the same covariance.
    #[inline(always)]
    pub(super) fn check_sizes(&self, count: usize, sizes: Sizes) -> Result<usize, Error> {
        let within = |name, actual, capacity| {
            if actual <= capacity {
                return Ok(());
            }
            Err(Error::capacity(name, actual, capacity))
        };
        let covariance = self.parameters().covariance;
        if covariance != sizes.covariance {
            let expected = "that of the workspace";
            let value = covariance as u8 as f64;
            return Err(Error::parameter("covariance", value, expected));
        }
        let subaperture = self.subaperture(count);
        within("active elements", count, sizes.elements)?;
        within("subaperture", subaperture, sizes.subaperture)?;
        within(
            "temporal_half_window",
            self.parameters().temporal_half_window,
            sizes.temporal_half_window,
        )?;
        Ok(subaperture)
    }
}

/// Position of a push's subaperture sum in the ring of the last `K + 1`.
#[inline(always)]
fn slot_of(push: usize, temporal_half_window: usize, subaperture: usize) -> Range<usize> {
    let slot = push.checked_rem(temporal_half_window + 1).unwrap_or(0);
    slot * subaperture..(slot + 1) * subaperture
}

/// The loaded matrix from the lag sums of the time window's suffix and prefix.
///
/// Returns the lanes without power; all lanes if sums are missing.
#[inline(never)]
fn loaded_matrix<A: Averaging<V>, V: Vector>(
    zero: V,
    suffix: Option<&[ComplexVector<V>]>,
    prefix: &[ComplexVector<V>],
    subaperture: impl Size,
    parameters: &Parameters,
    matrix: &mut [PanelColumn<A::Scalar>],
) -> V::Mask {
    let loading = parameters.diagonal_loading;
    let zero_power = vectorize!(zero, {
        let prefix = subaperture.front(prefix, A::COVARIANCE.lag_count(subaperture.get()))?;
        match suffix {
            None => matrix_of::<A, V>(
                #[inline(always)]
                move |i| prefix.get(i).copied(),
                subaperture,
                loading,
                matrix,
            ),
            Some(suffix) => matrix_of::<A, V>(
                #[inline(always)]
                move |i| Some(*suffix.get(i)? + *prefix.get(i)?),
                subaperture,
                loading,
                matrix,
            ),
        }
    });
    match zero_power {
        Some(zero_power) => zero_power,
        None => zero.mask(|_| true),
    }
}

/// The loaded matrix from the lag sums `lag(index)`, and the lanes without power.
///
/// `lag` is passed by value: calls through a reference are not inlined (8 % of MV's time at 64/32/2).
#[inline(always)]
fn matrix_of<A: Averaging<V>, V: Vector>(
    lag: impl Fn(usize) -> Option<ComplexVector<V>> + Copy,
    subaperture: impl Size,
    loading: f32,
    matrix: &mut [PanelColumn<A::Scalar>],
) -> Option<V::Mask> {
    let trace = A::trace(lag, subaperture.get())?;
    let loading = DiagonalLoading::new(trace, subaperture.get(), loading);
    A::matrix(lag, subaperture, &loading, matrix)?;
    Some(loading.zero_power)
}

/// Writes a sample of each lane with an `index`, at the line's own scale.
#[inline(always)]
pub(super) fn emit<V: Vector>(
    segments: &[Segment<'_>],
    z: &mut [&mut [Complex<f32>]],
    index: impl Fn(&Segment<'_>) -> Option<usize>,
    value: ComplexVector<V>,
) {
    for (lane, (segment, z)) in segments.iter().zip(z).enumerate() {
        if let Some(z) = index(segment).and_then(|index| z.get_mut(index)) {
            *z = segment.line.unscale(value.lane(lane));
        }
    }
}
