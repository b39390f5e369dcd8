//! Sub-lines: several directions of a line from its one covariance.
//!
//! Sub-lines share covariance, factor and eigenvectors of the line. A direction is a steering vector `a_i =
//! e^{js(i−(L−1)/2)}` and a phased sum of the subapertures; both come from the powers of `e^{js}`.

mod das;
mod steer;

use super::aligned_line::AlignedLine;
use super::compiled::SUB_LINES;
use super::extent::{Constant, Extent, Given};
use super::line::LineBlock;
use super::methods::{Shape, answers};
use super::parameters::{Beamformer, Parameters};
use super::pushes::Pushes;
use super::segment::{Segment, SegmentGroup, SteeredSegments, constant_segments, segments_within};
use super::segments::emit;
use super::sizes::Sizes;
use super::snapshot::elements;
use super::workspace::{View, Workspace, with_view};
use crate::Error;
use crate::covariance::{Averaging, Covariance};
use crate::error::check_length;
use crate::geometry::{Active, Steering};
use crate::linalg::size::{CONSTANTS, Size};
use crate::simd::{ComplexVector, MOST_LANES, Scalar, Vector, vectorize};
use num_complex::Complex;
use steer::{Sample, steer};

impl Beamformer {
    /// Beamforms the sub-lines of one beam.
    ///
    /// `z[n·N + k]` is sub-line `k` of computed sample `n`, with `N` = [`Parameters::sub_lines`]. With one sub-line
    /// the result is that of [`Beamformer::line`].
    ///
    /// [`Parameters::sub_lines`]: super::Parameters::sub_lines
    ///
    /// # Errors
    /// As [`Beamformer::sub_line_segments`]; [`Error::Length`] unless `z` has `N` times
    /// [`Beamformer::line_samples`] numbers.
    #[inline]
    pub fn sub_lines<V: Vector>(
        &self,
        workspace: &mut Workspace<'_, V>,
        (line, steering): (AlignedLine<'_>, Steering<'_>),
        active: impl Fn(usize) -> Active,
        z: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let samples = line.samples();
        let count = self.parameters().sub_lines;
        let outputs = self.line_samples(samples);
        check_length("z", z.len(), outputs.saturating_mul(count))?;
        let block = LineBlock {
            line,
            first: 0,
            samples,
            active,
            adaptive: 0..samples,
        };
        let sizes = workspace.sizes();
        self.check_block(sizes, &block)?;
        with_view!(workspace, view => self.sub_line_block(view, sizes, (&block, steering), z))
    }

    /// The sub-lines of a block's computed samples, checked as those of [`Beamformer::block`].
    pub(crate) fn sub_line_block<A: Averaging<V>, V: Vector>(
        &self,
        view: &mut View<'_, A, V>,
        sizes: Sizes,
        (block, steering): (&LineBlock<'_, impl Fn(usize) -> Active>, Steering<'_>),
        z: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        if !SUB_LINES {
            return self.block(view, sizes, block, z);
        }
        let parameters = self.parameters();
        let (count, half_window) = (parameters.sub_lines, parameters.temporal_half_window);
        let (samples, step) = (block.samples, parameters.step());
        let of = |samples| {
            let outputs = block.outputs(step, samples);
            outputs.start * count..outputs.end * count
        };
        let active = |sample| block.active(sample);
        let within = segments_within(samples, active, block.adaptive.clone(), half_window);
        for (first, length, set) in within {
            let out = z.get_mut(of(first..first + length)).unwrap_or_default();
            if V::LANES == 1 {
                let (segments, steering) = ([block.segment(first, set)], [steering]);
                let lines = SteeredSegments::new(&segments, &steering);
                self.sub_lines_within(view, sizes, (lines, set.count), &mut [out])?;
                continue;
            }
            let mut parts = self.parts(V::LANES, (block, (first, length, set)), count, out);
            let (segments, out) = parts.used();
            let steering = [steering; MOST_LANES];
            let lines =
                SteeredSegments::new(segments, steering.get(..segments.len()).unwrap_or_default());
            self.sub_lines_within(view, sizes, (lines, set.count), out)?;
        }
        // DAS also overwrites the unwanted samples above a segment.
        let start = block.adaptive.start.min(samples);
        let end = block.adaptive.end.min(samples).max(start);
        for rest in [0..start, end..samples] {
            for (first, length, set) in constant_segments(rest.len(), |n| active(rest.start + n)) {
                let first = rest.start + first;
                let out = z.get_mut(of(first..first + length));
                let segment = block.segment(first, set);
                self.das_sub_lines(&segment, steering, set.count, out.unwrap_or_default());
            }
        }
        Ok(())
    }

    /// Beamforms the sub-lines of segments.
    ///
    /// `z[lane][i·N + k]` is sub-line `k` of computed sample `i`. With one sub-line the result is that of
    /// [`Beamformer::segments`].
    ///
    /// Let `s`, `φ_c` be the direction of a sub-line at a sample ([`Steering`]), and `a_i = e^{js(i−(L−1)/2)}`. Then
    /// `z = e^{−jφ_c}·(1/P)·Σ_p e^{−js(p−(P−1)/2)}·wᴴX̄_p`, where the method computes `w` from `a` and the line's own
    /// covariance. ESMV by β finds the rank of each direction. DAS is the mean of `e^{−j(φ_c+s(m−centre))}·x_m`. A
    /// postfilter uses these phased samples. An apodization weights the elements of DAS, and the subapertures of other
    /// methods.
    ///
    /// Additional cost per sample, lane and sub-line, in flops: `14·count + 20·L` for the sum; for MV `2L²` (a forward
    /// and a backward solve), for rank 1 `L²` (the forward solve), for the full eigensolver `4L²` and its rotations.
    /// Forward multiplies these by 4. An apodization adds `4·P·L` flops and `P` cosines. RAM: the workspace, of
    /// [`Sizes::sub_lines`].
    ///
    /// # Errors
    /// As [`Beamformer::segments`]; [`Error::Capacity`] for more sub-lines than the workspace has;
    /// [`Error::Parameter`] for steering with another number of sub-lines, or without directions at a computed sample;
    /// [`Error::Length`] for steering with fewer samples than a segment.
    #[inline]
    pub fn sub_line_segments<V: Vector>(
        &self,
        workspace: &mut Workspace<'_, V>,
        lines: SteeredSegments<'_, '_>,
        count: usize,
        z: &mut [&mut [Complex<f32>]],
    ) -> Result<(), Error> {
        let sizes = workspace.sizes();
        with_view!(workspace, view => self.sub_lines_within(view, sizes, (lines, count), z))
    }

    #[inline(always)]
    fn sub_lines_within<A: Averaging<V>, V: Vector>(
        &self,
        view: &mut View<'_, A, V>,
        sizes: Sizes,
        (lines, count): (SteeredSegments<'_, '_>, usize),
        z: &mut [&mut [Complex<f32>]],
    ) -> Result<(), Error> {
        let SteeredSegments { segments, steering } = lines;
        let parameters = self.parameters();
        let sub_lines = parameters.sub_lines;
        if sub_lines <= 1 || !SUB_LINES {
            let group = SegmentGroup { segments, count };
            return self.segments_within(view, sizes, group, z);
        }
        if segments.len() > V::LANES {
            return Err(Error::capacity("segments", segments.len(), V::LANES));
        }
        check_length("z", z.len(), segments.len())?;
        check_length("steering", steering.len(), segments.len())?;
        for ((segment, steering), z) in segments.iter().zip(steering).zip(z.iter()) {
            let outputs = z.len().checked_div(sub_lines).unwrap_or(0);
            check_length("z", z.len(), outputs.saturating_mul(sub_lines))?;
            let samples = parameters.step().span(segment.first_sample, outputs);
            self.check_segment(segment, count, samples)?;
            check_steering(steering, segment, samples, parameters)?;
        }
        if count == 0 || parameters.method.direct().is_some() {
            for ((segment, &steering), z) in segments.iter().zip(steering).zip(z.iter_mut()) {
                self.das_sub_lines(segment, steering, count, z);
            }
            return Ok(());
        }
        let subaperture = self.check_sizes(count, sizes)?;
        if sub_lines > sizes.sub_lines {
            return Err(Error::capacity("sub_lines", sub_lines, sizes.sub_lines));
        }
        if const { V::LANES == 1 } && parameters.temporal_half_window == 0 {
            let forward_backward = matches!(A::COVARIANCE, Covariance::ForwardBackward);
            let known = (count, subaperture) == (16, 8) && parameters.window().is_none();
            if CONSTANTS && forward_backward && known {
                self.fitting_sub_lines(view, lines, Constant::<16, 8>, z);
            } else {
                let extent = Given::<false> { count, subaperture };
                self.fitting_sub_lines(view, lines, extent, z);
            }
        } else {
            let extent = Given::<true> { count, subaperture };
            self.fitting_sub_lines(view, lines, extent, z);
        }
        Ok(())
    }

    /// Segments that fit, with the vector's instructions: see `fitting_segments`.
    #[inline(never)]
    fn fitting_sub_lines<A: Averaging<V>, V: Vector>(
        &self,
        view: &mut View<'_, A, V>,
        lines: SteeredSegments<'_, '_>,
        extent: impl Extent,
        z: &mut [&mut [Complex<f32>]],
    ) {
        let zero = view.zero;
        view.snapshot.fill(ComplexVector::from_real(zero));
        vectorize!(zero, self.sub_line_lanes(view, lines, extent, z));
    }

    #[inline(always)]
    fn sub_line_lanes<A: Averaging<V>, V: Vector>(
        &self,
        view: &mut View<'_, A, V>,
        lines: SteeredSegments<'_, '_>,
        extent: impl Extent,
        z: &mut [&mut [Complex<f32>]],
    ) {
        let parameters = self.parameters();
        let (count, subaperture) = (extent.count().get(), extent.subaperture().get());
        let (half_window, sub_lines) = (extent.half_window(parameters), parameters.sub_lines);
        let segments = lines.segments;
        let pushes = Pushes::new(half_window, parameters.step());
        let mut most = 0;
        for (segment, z) in segments.iter().zip(z.iter()) {
            let count = pushes.count(segment, z.len().checked_div(sub_lines).unwrap_or(0));
            if count > most {
                most = count;
            }
        }
        let window = extent.apodization(parameters);
        let gain = self.gain::<A, V>(count - subaperture + 1);
        for push in 0..most {
            let Some(zero_power) = self.push::<A, V, false>(view, segments, extent, push) else {
                continue;
            };
            let sample_index = pushes.complete(push);
            let View {
                zero,
                snapshot: active,
                solver,
                directions,
                ..
            } = &mut *view;
            let zero = *zero;
            let Some(active) = active.get_mut(..count) else {
                return;
            };
            if half_window > 0 {
                // The last pushed sample is `K` samples further on.
                elements(zero, segments, sample_index, active);
            }
            let sample = Sample {
                lines,
                sample_index,
                active,
            };
            let sizes = (extent.count(), extent.subaperture());
            let applied = (parameters, window.as_ref());
            steer::<A, V>(zero, sample, sizes, applied, directions);
            let shape = Shape {
                sub_lines,
                subaperture,
            };
            answers::<A, V>(
                zero,
                parameters.method,
                solver,
                directions,
                (shape, extent.subaperture(), zero_power),
            );
            let gain = zero.splat(gain);
            let nothing = ComplexVector::from_real(zero);
            let answers = directions.answers.iter().zip(&*directions.phases);
            if V::LANES == 1 {
                let ([segment, ..], [z, ..]) = (segments, &mut *z) else {
                    return;
                };
                let (line, first) = (segment.line, pushes.output(segment, push));
                let first = first.map_or(z.len(), |output| output * sub_lines);
                let z = z.get_mut(first..).unwrap_or_default();
                for (z, (&sum, &phase)) in z.iter_mut().zip(answers).take(sub_lines) {
                    let value = ComplexVector::select(zero_power, nothing, sum.divide(gain));
                    *z = line.unscale(value.mul(phase).lane(0));
                }
                continue;
            }
            for (k, (&sum, &phase)) in answers.enumerate().take(sub_lines) {
                let value = ComplexVector::select(zero_power, nothing, sum.divide(gain));
                emit(
                    segments,
                    z,
                    |of| Some(pushes.output(of, push)? * sub_lines + k),
                    value.mul(phase),
                );
            }
        }
    }
}

/// The directions have as many sub-lines as the beamformer, its computed samples, and samples for the segment.
fn check_steering(
    steering: &Steering<'_>,
    segment: &Segment<'_>,
    samples: usize,
    parameters: &Parameters,
) -> Result<(), Error> {
    let step = steering.step().get();
    if !parameters.step().get().is_multiple_of(step) {
        let expected = "that of the beamformer, or a divisor of it";
        let value = step as f64;
        return Err(Error::parameter(
            "depth_step of the steering",
            value,
            expected,
        ));
    }
    if steering.sub_lines() != parameters.sub_lines {
        return Err(Error::parameter(
            "sub_lines of the steering",
            steering.sub_lines() as f64,
            "those of the beamformer",
        ));
    }
    let end = segment.first_sample.saturating_add(samples);
    if steering.samples() < end {
        return Err(Error::length(
            "samples of the steering",
            steering.samples(),
            end,
        ));
    }
    Ok(())
}

#[cfg(all(feature = "eigenspace", feature = "postfilters", feature = "sub-lines"))]
#[cfg(test)]
mod tests {
    use super::*;
    use crate::beamform::{Method, Parameters, Postfilter};
    use crate::covariance::ForwardBackward;
    use crate::memory::Scratch;
    use std::vec;
    use std::vec::Vec;

    const SAMPLES: usize = 5;

    /// Sub-lines of 16 elements in subapertures of 8 over an extent.
    fn of_extent(parameters: Parameters, extent: impl Extent) -> Vec<[u32; 2]> {
        let count = parameters.sub_lines;
        let number = |k: usize| Complex::new((7 * k % 31) as f32 - 15.0, (11 * k % 37) as f32);
        let x: Vec<_> = (0..SAMPLES * 16).map(number).collect();
        let directions: Vec<_> = (0..2 * SAMPLES * count)
            .map(|k| Complex::new((0.01 * k as f32).cos(), (0.01 * k as f32).sin()))
            .collect();
        let beamformer = Beamformer::new(parameters).unwrap();
        let sizes = beamformer.sizes(16);
        let need = sizes.need();
        let (mut real, mut complex) = (vec![0.0; need.real], vec![Complex::ZERO; need.complex]);
        let scratch = Scratch::new(&mut real, &mut complex);
        let mut view = View::<ForwardBackward, f32>::new(0.0, sizes, scratch);
        let segments = [Segment::new(AlignedLine::new(&x, 16).unwrap(), 0, 0)];
        let steering = [Steering::of(&directions, count)];
        let lines = SteeredSegments::new(&segments, &steering);
        let mut z = vec![Complex::ZERO; SAMPLES * count];
        beamformer.fitting_sub_lines(&mut view, lines, extent, &mut [&mut z]);
        let bits = |z: &Complex<f32>| [z.re.to_bits(), z.im.to_bits()];
        z.iter().map(bits).collect()
    }

    #[test]
    fn a_constant_extent_has_the_bits_of_a_given_one() {
        let given = Given::<false> {
            count: 16,
            subaperture: 8,
        };
        let methods = [
            Method::Mv,
            Method::EsmvRank1,
            Method::EsmvRank1Steps(8),
            Method::EsmvBeta(0.1),
        ];
        for method in methods {
            for postfilter in [Postfilter::None, Postfilter::CoherenceFactor] {
                for sub_lines in [2, 4, 8] {
                    let parameters = Parameters {
                        postfilter,
                        sub_lines,
                        ..Parameters::of(method)
                    };
                    let constant = of_extent(parameters, Constant::<16, 8>);
                    assert_eq!(constant, of_extent(parameters, given), "{parameters:?}");
                    assert!(constant.iter().all(|&[re, _]| re != 0), "{parameters:?}");
                }
            }
        }
    }
}
