//! Sub-lines: several directions of a line from its one covariance.
//!
//! Covariance, factor and eigenvectors are those of the line. A direction is a steering vector
//! `a_i = e^{js(i−(L−1)/2)}` and a sum of the subapertures with phases; both come from the powers of `e^{js}`.

use super::aligned_line::AlignedLine;
use super::line::LineBlock;
use super::methods::{Shape, answers};
use super::parameters::{Beamformer, Parameters};
use super::postfilter::{Postfilter, coherence_of};
use super::segment::{Segment, SegmentGroup, constant_segments, segments_within};
use super::segments::emit;
use super::sizes::Sizes;
use super::snapshot::gather;
use super::workspace::{Directions, Workspace};
use crate::Error;
use crate::covariance::Averaging;
use crate::covariance::lag_sums::subaperture_sum;
use crate::error::check_length;
use crate::geometry::{Active, Steering};
use crate::linalg::panels::TILE;
use crate::simd::{ComplexVector, Scalar, Vector};
use num_complex::Complex;

/// Segments with the directions of their lines' sub-lines.
#[derive(Clone, Copy, Debug)]
pub struct SteeredSegments<'s, 'a> {
    /// Up to one a lane.
    pub segments: &'s [Segment<'a>],
    /// The directions of each segment's line, from the line's first sample on.
    pub steering: &'s [Steering<'a>],
}

impl Beamformer {
    /// Beamforms the sub-lines of one beam: `z[n·N + k]` is sub-line `k` of sample `n`, with
    /// `N` = [`Parameters::sub_lines`]. With one sub-line that is [`Beamformer::line`].
    ///
    /// [`Parameters::sub_lines`]: super::Parameters::sub_lines
    ///
    /// # Errors
    /// As [`Beamformer::sub_line_segments`]; [`Error::Length`] where `z` is not `N` times as long as the line.
    #[inline]
    pub fn sub_lines<A: Averaging<f32>>(
        &self,
        workspace: &mut Workspace<'_, A>,
        (line, steering): (AlignedLine<'_>, Steering<'_>),
        active: impl Fn(usize) -> Active,
        z: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let samples = line.samples();
        let count = self.parameters().sub_lines;
        check_length("z", z.len(), samples.saturating_mul(count))?;
        let block = LineBlock {
            line,
            first: 0,
            active,
            adaptive: 0..samples,
        };
        let sizes = workspace.sizes;
        self.sub_line_block(workspace, sizes, (&block, steering), z)
    }

    /// The sub-lines of a block of `z.len()/N` samples.
    pub(crate) fn sub_line_block<A: Averaging<f32>>(
        &self,
        workspace: &mut Workspace<'_, A>,
        sizes: Sizes,
        (block, steering): (&LineBlock<'_, impl Fn(usize) -> Active>, Steering<'_>),
        z: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let parameters = self.parameters();
        let (count, half_window) = (parameters.sub_lines, parameters.temporal_half_window);
        let samples = z.len().checked_div(count).unwrap_or(0);
        let active = |sample| block.active(sample);
        let within = || segments_within(samples, active, block.adaptive.clone(), half_window);
        // All is checked before anything is put out.
        for (first, length, set) in constant_segments(samples, active) {
            self.check_segment(&block.segment(first, set), set.count, length)?;
        }
        for (.., set) in within().filter(|(.., set)| set.count > 0) {
            if parameters.method.direct().is_none() {
                self.check_sizes(set.count, sizes)?;
            }
        }
        for (first, length, set) in within() {
            let out = z.get_mut(first * count..(first + length) * count);
            let lines = SteeredSegments {
                segments: &[block.segment(first, set)],
                steering: &[steering],
            };
            let out = &mut [out.unwrap_or_default()];
            self.sub_lines_within(workspace, sizes, (lines, set.count), out)?;
        }
        // Over what came with a segment above the samples wanted, too.
        let start = block.adaptive.start.min(samples);
        let end = block.adaptive.end.min(samples).max(start);
        for rest in [0..start, end..samples] {
            for (first, length, set) in constant_segments(rest.len(), |n| active(rest.start + n)) {
                let first = rest.start + first;
                let out = z.get_mut(first * count..(first + length) * count);
                let segment = block.segment(first, set);
                self.das_sub_lines(&segment, steering, set.count, out.unwrap_or_default());
            }
        }
        Ok(())
    }

    /// [`Beamformer::segments`] of the sub-lines: `z[lane][i·N + k]` is sub-line `k` of sample `first_sample + i`.
    /// With one sub-line that is [`Beamformer::segments`].
    ///
    /// With the direction `s`, `φ_c` of a sub-line at a sample ([`Steering`]) and `a_i = e^{js(i−(L−1)/2)}`,
    /// `z = e^{−jφ_c}·(1/P)·Σ_p e^{−js(p−(P−1)/2)}·wᴴX̄_p`, where `w` is made of `a` and of the line's own
    /// covariance, as the method says; the rank of ESMV by β is that of the direction. DAS is the mean of
    /// `e^{−j(φ_c+s(m−centre))}·x_m`. A coherence factor is that of those samples.
    ///
    /// Cost a sample, lane and sub-line beyond that of the line, in flops: `14·count + 20·L` for the sum; MV `2L²`
    /// for a solve forward and one backward, rank 1 `L²` for the one forward, the full eigensolver `4L²` and
    /// its rotations. Forward multiplies these by 4. RAM: the workspace, of [`Sizes::sub_lines`].
    ///
    /// # Errors
    /// As [`Beamformer::segments`]; [`Error::Capacity`] for more sub-lines than the workspace has;
    /// [`Error::Parameter`] for steering of another number of sub-lines, or of fewer samples than a segment has.
    #[inline]
    pub fn sub_line_segments<A: Averaging<V>, V: Vector>(
        &self,
        workspace: &mut Workspace<'_, A, V>,
        lines: SteeredSegments<'_, '_>,
        count: usize,
        z: &mut [&mut [Complex<f32>]],
    ) -> Result<(), Error> {
        self.sub_lines_within(workspace, workspace.sizes, (lines, count), z)
    }

    #[inline(always)]
    fn sub_lines_within<A: Averaging<V>, V: Vector>(
        &self,
        workspace: &mut Workspace<'_, A, V>,
        sizes: Sizes,
        (lines, count): (SteeredSegments<'_, '_>, usize),
        z: &mut [&mut [Complex<f32>]],
    ) -> Result<(), Error> {
        let SteeredSegments { segments, steering } = lines;
        let parameters = self.parameters();
        let sub_lines = parameters.sub_lines;
        if sub_lines <= 1 {
            let group = SegmentGroup { segments, count };
            return self.segments_within(workspace, sizes, group, z);
        }
        if segments.len() > V::LANES {
            return Err(Error::Capacity {
                name: "segments",
                actual: segments.len(),
                capacity: V::LANES,
            });
        }
        check_length("z", z.len(), segments.len())?;
        check_length("steering", steering.len(), segments.len())?;
        for ((segment, steering), z) in segments.iter().zip(steering).zip(z.iter()) {
            let samples = z.len().checked_div(sub_lines).unwrap_or(0);
            check_length("z", z.len(), samples.saturating_mul(sub_lines))?;
            self.check_segment(segment, count, samples)?;
            check_steering(steering, segment, samples, sub_lines)?;
        }
        if count == 0 || parameters.method.direct().is_some() {
            for ((segment, &steering), z) in segments.iter().zip(steering).zip(z.iter_mut()) {
                self.das_sub_lines(segment, steering, count, z);
            }
            return Ok(());
        }
        let subaperture = self.check_sizes(count, sizes)?;
        if sub_lines > sizes.sub_lines {
            return Err(Error::Capacity {
                name: "sub_lines",
                actual: sub_lines,
                capacity: sizes.sub_lines,
            });
        }
        self.fitting_sub_lines(workspace, (lines, count), subaperture, z);
        Ok(())
    }

    /// Segments that fit, with the vector's instructions: see `fitting_segments`.
    #[inline(never)]
    fn fitting_sub_lines<A: Averaging<V>, V: Vector>(
        &self,
        workspace: &mut Workspace<'_, A, V>,
        (lines, count): (SteeredSegments<'_, '_>, usize),
        subaperture: usize,
        z: &mut [&mut [Complex<f32>]],
    ) {
        let zero = workspace.zero;
        workspace.snapshot.fill(ComplexVector::from_real(zero));
        zero.vectorize(
            #[inline(always)]
            || self.sub_line_lanes(workspace, (lines, count), subaperture, z),
        );
    }

    #[inline(always)]
    fn sub_line_lanes<A: Averaging<V>, V: Vector>(
        &self,
        workspace: &mut Workspace<'_, A, V>,
        (lines, count): (SteeredSegments<'_, '_>, usize),
        subaperture: usize,
        z: &mut [&mut [Complex<f32>]],
    ) {
        let parameters = self.parameters();
        let (half_window, sub_lines) = (parameters.temporal_half_window, parameters.sub_lines);
        let segments = lines.segments;
        let group = SegmentGroup { segments, count };
        let mut longest = 0;
        for z in z.iter() {
            let samples = z.len().checked_div(sub_lines).unwrap_or(0);
            if samples > longest {
                longest = samples;
            }
        }
        for push in 0..longest + 2 * half_window {
            let Some(zero_power) = self.push(workspace, group, subaperture, push) else {
                continue;
            };
            let i = push - 2 * half_window;
            let Workspace {
                zero,
                snapshot: active,
                solver,
                directions,
                ..
            } = &mut *workspace;
            let zero = *zero;
            let Some(active) = active.get_mut(..count) else {
                return;
            };
            if half_window > 0 {
                // The sample that was pushed last lies `K` further on.
                gather(zero, segments, i as isize, 0, active);
            }
            steer::<A, V>(
                zero,
                (lines, i),
                active,
                (parameters, subaperture),
                directions,
            );
            let shape = Shape {
                sub_lines,
                subaperture,
            };
            answers::<A, V>(
                zero,
                parameters.method,
                solver,
                directions,
                (shape, zero_power),
            );
            let gain = zero.splat(A::gain(count - subaperture + 1));
            let nothing = ComplexVector::from_real(zero);
            let answers = directions.answers.iter().zip(&*directions.phases);
            for (k, (&sum, &phase)) in answers.enumerate().take(sub_lines) {
                let value = ComplexVector::select(zero_power, nothing, sum.divide(gain));
                emit(segments, z, i * sub_lines + k, value.mul(phase));
            }
        }
    }

    /// The sub-lines of a segment by DAS.
    ///
    /// Order: the samples from the middle outwards, of two at the same distance the right one first, added from zero,
    /// at the line's working scale; divided by their number, then turned by `e^{−jφ_c}`.
    pub(super) fn das_sub_lines(
        &self,
        segment: &Segment<'_>,
        steering: Steering<'_>,
        count: usize,
        z: &mut [Complex<f32>],
    ) {
        let Parameters {
            sub_lines,
            postfilter,
            ..
        } = *self.parameters();
        let line = &segment.line;
        let scale = line.scale();
        let samples = line.samples_from(segment.first_sample);
        let snapshots = samples.chunks_exact(line.elements());
        z.fill(Complex::new(0.0, 0.0));
        for (i, (z, snapshot)) in z
            .chunks_exact_mut(sub_lines.max(1))
            .zip(snapshots)
            .enumerate()
        {
            let active = snapshot.get(segment.first_element..);
            let active = active.and_then(|active| active.get(..count));
            let Some(active) = active.filter(|active| !active.is_empty()) else {
                return;
            };
            for (k, z) in z.iter_mut().enumerate() {
                let [half, phase] = steering.direction(segment.first_sample + i, k);
                let sum = steered_sum(active, scale, half);
                let factor = match postfilter {
                    Postfilter::None | Postfilter::GeneralizedCoherenceFactor => 1.0,
                    Postfilter::CoherenceFactor => {
                        let mut power = 0.0;
                        for &x in active {
                            power += (x * scale).norm_sqr();
                        }
                        coherence_of(number(sum), power, count)
                    }
                };
                *z = line.unscale((sum / count as f32) * (phase * factor));
            }
        }
    }
}

/// `Σ e^{−js(m−centre)}·x_m` at a scale, from `e^{js/2}`.
fn steered_sum(active: &[Complex<f32>], scale: f32, half: Complex<f32>) -> Complex<f32> {
    let mut sum = Complex::new(0.0, 0.0);
    let half = number(half);
    let mut powers = Powers::new(half, active.len());
    let (left, right) = active.split_at(active.len() / 2);
    let mut left = left.iter().rev();
    let mut right = right.iter();
    if active.len() % 2 == 1
        && let Some(&middle) = right.next()
    {
        sum += middle * scale;
        powers.next();
    }
    for (&right, &left) in right.zip(left.by_ref()) {
        let power = powers.next().lane(0);
        sum += right * scale * power.conj();
        sum += left * scale * power;
    }
    sum
}

/// A complex number as a vector of one lane.
fn number(value: Complex<f32>) -> ComplexVector<f32> {
    ComplexVector {
        re: value.re,
        im: value.im,
    }
}

/// The powers of `e^{js}` from the middle of so many elements outwards: `e^{jsk}`, or `e^{js(k+1/2)}` of an even
/// number.
///
/// Order: the first four one after the other, times `e^{js}`; each later one is that four before it, times
/// `e^{4js}`, the square of the square. So rounding adds up a quarter as far, and four do not wait for each other.
struct Powers<V> {
    next: [ComplexVector<V>; TILE],
    step: ComplexVector<V>,
    index: usize,
}

impl<V: Vector> Powers<V> {
    #[inline(always)]
    fn new(half: ComplexVector<V>, elements: usize) -> Self {
        let step = half.mul(half);
        let first = if elements % 2 == 1 {
            ComplexVector::from_real(half.re.splat(1.0))
        } else {
            half
        };
        let second = first.mul(step);
        let third = second.mul(step);
        let square = step.mul(step);
        Powers {
            next: [first, second, third, third.mul(step)],
            step: square.mul(square),
            index: 0,
        }
    }

    #[inline(always)]
    fn next(&mut self) -> ComplexVector<V> {
        let next = &mut self.next[self.index % TILE];
        let power = *next;
        *next = power.mul(self.step);
        self.index += 1;
        power
    }

    #[inline(always)]
    fn fill(mut self, powers: &mut [ComplexVector<V>]) {
        for powers in powers.chunks_mut(TILE) {
            for (power, next) in powers.iter_mut().zip(&mut self.next) {
                *power = *next;
                *next = next.mul(self.step);
            }
        }
    }
}

/// For each sub-line of sample `i` of the segments: the steering vector and the sum of the subapertures with phases, in
/// the solver's coordinates, and `e^{−jφ_c}`, times the postfilter's factor.
///
/// Order: `y_m = e^{−js(m−centre)}·x_m`; their subaperture sums slide as those of the line; sum `i` times `a_i`.
#[inline(never)]
fn steer<A: Averaging<V>, V: Vector>(
    zero: V,
    (lines, i): (SteeredSegments<'_, '_>, usize),
    active: &[ComplexVector<V>],
    shape: (&Parameters, usize),
    directions: &mut Directions<'_, A::Scalar, V>,
) {
    zero.vectorize(
        #[inline(always)]
        || {
            let (parameters, subaperture) = shape;
            let padded = subaperture.next_multiple_of(TILE);
            let rows = directions.steering.chunks_exact_mut(padded.max(1));
            let data = directions.data.chunks_exact_mut(subaperture.max(1));
            let phases = directions.phases.iter_mut();
            let power = match parameters.postfilter {
                Postfilter::None | Postfilter::GeneralizedCoherenceFactor => zero,
                Postfilter::CoherenceFactor => power_of(zero, active),
            };
            for (k, ((row, data), slot)) in rows.zip(data).zip(phases).enumerate() {
                if k >= parameters.sub_lines {
                    break;
                }
                let [half, phase] = direction(zero, lines, i, k);
                let (Some(rotated), Some(sums)) = (
                    directions.rotated.get_mut(..active.len()),
                    directions.sums.get_mut(..subaperture),
                ) else {
                    return;
                };
                rotate(half, active, directions.powers_of_step, rotated);
                *slot = match parameters.postfilter {
                    Postfilter::None | Postfilter::GeneralizedCoherenceFactor => phase,
                    Postfilter::CoherenceFactor => {
                        let mut sum = ComplexVector::from_real(zero);
                        for &y in &*rotated {
                            sum = sum + y;
                        }
                        phase.scale(coherence_of(sum, power, active.len()))
                    }
                };
                subaperture_sum(zero, rotated, sums);
                let Some(vector) = rotated.get_mut(..subaperture) else {
                    return;
                };
                steering_vector(half, directions.powers_of_step, active.len(), vector);
                for (sum, &a) in sums.iter_mut().zip(&*vector) {
                    *sum = a.mul(*sum);
                }
                A::steered(vector, row);
                A::data(sums, data);
            }
        },
    );
}

/// The direction of sub-line `k` at sample `i` of each lane's segment.
#[inline(always)]
fn direction<V: Vector>(
    zero: V,
    lines: SteeredSegments<'_, '_>,
    i: usize,
    k: usize,
) -> [ComplexVector<V>; 2] {
    let mut direction = [ComplexVector::from_real(zero.splat(1.0)); 2];
    let segments = lines.segments.iter().zip(lines.steering);
    for (lane, (segment, steering)) in segments.enumerate() {
        let [half, phase] = steering.direction(segment.first_sample + i, k);
        direction[0].set_lane(lane, half);
        direction[1].set_lane(lane, phase);
    }
    direction
}

/// `y_m = e^{−js(m−centre)}·x_m`, and the powers of `e^{js}` that this takes.
#[inline(always)]
fn rotate<V: Vector>(
    half: ComplexVector<V>,
    active: &[ComplexVector<V>],
    powers: &mut [ComplexVector<V>],
    rotated: &mut [ComplexVector<V>],
) {
    let count = active.len();
    let Some(powers) = powers.get_mut(..count.div_ceil(2)) else {
        return;
    };
    Powers::new(half, count).fill(powers);
    let (Some((low, high)), Some((to_low, to_high))) = (
        active.split_at_checked(count / 2),
        rotated.split_at_mut_checked(count / 2),
    ) else {
        return;
    };
    for ((y, x), &power) in to_high.iter_mut().zip(high).zip(&*powers) {
        *y = x.mul_conj(power);
    }
    let outwards = to_low.iter_mut().zip(low).rev();
    for ((y, x), &power) in outwards.zip(powers.iter().skip(count % 2)) {
        *y = x.mul(power);
    }
}

/// `a_i = e^{js(i−(L−1)/2)}`, by the powers for `count` elements if those are the same.
#[inline(always)]
fn steering_vector<V: Vector>(
    half: ComplexVector<V>,
    powers: &mut [ComplexVector<V>],
    count: usize,
    a: &mut [ComplexVector<V>],
) {
    let subaperture = a.len();
    let Some(powers) = powers.get_mut(..subaperture.div_ceil(2)) else {
        return;
    };
    if count % 2 != subaperture % 2 {
        Powers::new(half, subaperture).fill(powers);
    }
    let Some((low, high)) = a.split_at_mut_checked(subaperture / 2) else {
        return;
    };
    for (a, &power) in high.iter_mut().zip(&*powers) {
        *a = power;
    }
    let outwards = low.iter_mut().rev();
    for (a, power) in outwards.zip(powers.iter().skip(subaperture % 2)) {
        *a = power.conj();
    }
}

/// `Σ|x_m|²`, ascending from zero.
#[inline(always)]
fn power_of<V: Vector>(zero: V, active: &[ComplexVector<V>]) -> V {
    let mut power = zero.zero();
    for x in active {
        power = power + x.norm_sqr();
    }
    power
}

/// The directions have as many sub-lines as the beamformer, and samples for the segment.
fn check_steering(
    steering: &Steering<'_>,
    segment: &Segment<'_>,
    samples: usize,
    sub_lines: usize,
) -> Result<(), Error> {
    if steering.sub_lines() != sub_lines {
        return Err(Error::Parameter {
            name: "sub_lines of the steering",
            value: steering.sub_lines() as f64,
            expected: "those of the beamformer",
        });
    }
    let end = segment.first_sample.saturating_add(samples);
    if steering.samples() < end {
        return Err(Error::Length {
            name: "samples of the steering",
            actual: steering.samples(),
            expected: end,
        });
    }
    Ok(())
}
