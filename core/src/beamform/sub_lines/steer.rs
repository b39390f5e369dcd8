//! Steering vectors and sums of subapertures for the directions of sub-lines.

use crate::beamform::apodization::Window;
use crate::beamform::parameters::Parameters;
use crate::beamform::postfilter::{Elements, Postfilter, factor};
use crate::beamform::pushes::SampleIndex;
use crate::beamform::segment::SteeredSegments;
use crate::beamform::workspace::Directions;
use crate::covariance::Averaging;
use crate::covariance::lag_sums::subaperture_sum;
use crate::linalg::panels::TILE;
use crate::linalg::size::{Size, small_known};
use crate::simd::{ComplexVector, Scalar, Vector, vectorize};
use num_complex::Complex;

/// A sample of the segments.
#[derive(Clone, Copy)]
pub(super) struct Sample<'s, 'a, V> {
    pub(super) lines: SteeredSegments<'s, 'a>,
    pub(super) sample_index: SampleIndex,
    pub(super) active: &'s [ComplexVector<V>],
}

/// A complex number as a vector of one lane.
pub(super) fn number(value: Complex<f32>) -> ComplexVector<f32> {
    ComplexVector::new(value.re, value.im)
}

/// Powers of `e^{js}` from the middle element outwards.
///
/// `e^{jsk}`, or `e^{js(k+1/2)}` for an even number of elements. Order: the first four one after the other, times
/// `e^{js}`; each later one is that four before it, times `e^{4js}`, the square of the square. Rounding then adds
/// up a quarter as far, and four products do not wait for each other.
pub(super) struct Powers<V> {
    next: [ComplexVector<V>; TILE],
    step: ComplexVector<V>,
    index: usize,
}

impl<V: Vector> Powers<V> {
    #[inline(always)]
    pub(super) fn new(half: ComplexVector<V>, elements: usize) -> Self {
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
    pub(super) fn next(&mut self) -> ComplexVector<V> {
        let next = &mut self.next[self.index % TILE];
        let power = *next;
        *next = power.mul(self.step);
        self.index += 1;
        power
    }

    /// Powers `tile·4` and the three behind; `tile` counts from 0, one more with each call.
    #[inline(always)]
    fn tile(&mut self, tile: usize) -> [ComplexVector<V>; TILE] {
        if tile > 0 {
            for next in &mut self.next {
                *next = next.mul(self.step);
            }
        }
        self.next
    }

    #[inline(always)]
    fn fill(mut self, powers: &mut [ComplexVector<V>]) {
        for (tile, powers) in powers.chunks_mut(TILE).enumerate() {
            for (power, next) in powers.iter_mut().zip(self.tile(tile)) {
                *power = next;
            }
        }
    }
}

/// For each sub-line of a sample of the segments: the steering vector and the sum of the subapertures with phases, in
/// the solver's coordinates, and `e^{−jφ_c}`, times the postfilter's factor.
///
/// Order: `y_m = e^{−js(m−centre)}·x_m`; their subaperture sums slide as those of the line; sum `i` times `a_i`.
///
/// Its stages are separate functions: a single loop spills each stage's counters (a third of the instructions on a
/// Cortex-M7).
#[inline(always)]
pub(super) fn steer<A: Averaging<V>, V: Vector>(
    zero: V,
    sample: Sample<'_, '_, V>,
    (count, n): (impl Size, impl Size),
    (parameters, window): (&Parameters, Option<&Window>),
    directions: &mut Directions<'_, A::Scalar, V>,
) {
    let Sample {
        lines,
        sample_index,
        active,
    } = sample;
    let subaperture = n.get();
    let Directions {
        powers_of_step,
        rotated,
        sums,
        data,
        steering,
        phases,
        answers,
        ..
    } = directions;
    let padded = subaperture.next_multiple_of(TILE);
    let rows = steering.chunks_exact_mut(padded.max(1));
    let data = data.chunks_exact_mut(subaperture.max(1));
    let (Some(rotated), Some(sums)) =
        (rotated.get_mut(..active.len()), sums.get_mut(..subaperture))
    else {
        return;
    };
    let power = match parameters.postfilter {
        Postfilter::None => zero,
        _ => power_of(zero, active),
    };
    let (Some(halves), Some(phases)) = (
        answers.get_mut(..parameters.sub_lines),
        phases.get_mut(..parameters.sub_lines),
    ) else {
        return;
    };
    let mut single = match (lines.segments, lines.steering) {
        ([segment, ..], [steering, ..]) if V::LANES == 1 => steering
            .at(sample_index.sample(segment).unwrap_or(0))
            .iter(),
        _ => {
            look_up(zero, lines, sample_index, (halves, phases));
            [].iter()
        }
    };
    let directions = halves.iter_mut().zip(phases);
    for ((half, phase), (row, data)) in directions.zip(rows.zip(data)) {
        if let Some(&[of_half, of_phase]) = single.next() {
            half.set_lane(0, of_half);
            phase.set_lane(0, of_phase);
        }
        let half = *half;
        if (count.known(), n.known()) == (Some(16), Some(8))
            && parameters.postfilter == Postfilter::None
        {
            direction::<A, V, 16, 8>(half, active, row, data);
            continue;
        }
        let outwards = active.len().div_ceil(2);
        small_known!(V, n = outwards => rotate((half, n), active, powers_of_step, rotated));
        if parameters.postfilter != Postfilter::None {
            *phase = phase.scale(factor_of(parameters, rotated, power));
        }
        small_known!(V, n = subaperture => sum::<A, V>(
            (half, n),
            rotated,
            window,
            powers_of_step,
            sums,
            row,
            data,
        ));
    }
}

/// [`rotate`] and [`sum`] of `M` elements in subapertures of `L`, both even, in registers.
#[inline(never)]
fn direction<A: Averaging<V>, V: Vector, const M: usize, const L: usize>(
    half: ComplexVector<V>,
    active: &[ComplexVector<V>],
    steering: &mut [A::Scalar],
    data: &mut [ComplexVector<V>],
) {
    vectorize!(half.re, {
        let (Some(active), Some(steering), Some(data)) = (
            active.first_chunk::<M>(),
            steering.first_chunk_mut::<L>(),
            data.first_chunk_mut::<L>(),
        ) else {
            return;
        };
        let mut powers = [half; M];
        let (mut rotated, mut sums) = ([half; M], [half; L]);
        Powers::new(half, M).fill(&mut powers[..M / 2]);
        for k in 0..M / 2 {
            let (left, right) = (M / 2 - 1 - k, M / 2 + k);
            rotated[left] = active[left].mul(powers[k]);
            rotated[right] = active[right].mul_conj(powers[k]);
        }
        subaperture_sum(half.re.zero(), &rotated, &mut sums);
        A::steered(&powers[..L / 2], &sums, steering, data);
    });
}

/// The factor of a postfilter, of the elements with phases and of their power.
#[inline(never)]
fn factor_of<V: Vector>(parameters: &Parameters, rotated: &[ComplexVector<V>], power: V) -> V {
    vectorize!(power, {
        let mut sum = ComplexVector::from_real(power.zero());
        for &y in rotated {
            sum = sum + y;
        }
        factor(
            parameters.postfilter_of_lines(),
            (sum, power),
            &Rotated(rotated),
        )
    })
}

/// The elements with phases.
struct Rotated<'a, V>(&'a [ComplexVector<V>]);

impl<V: Vector> Elements<V> for Rotated<'_, V> {
    #[inline(always)]
    fn count(&self) -> usize {
        self.0.len()
    }

    #[inline(always)]
    fn each(&self, mut take: impl FnMut(usize, ComplexVector<V>)) {
        for (m, &y) in self.0.iter().enumerate() {
            take(m, y);
        }
    }
}

/// `e^{js/2}` and `e^{−jφ_c}` of each sub-line at a sample of the lanes' segments.
#[inline(never)]
fn look_up<V: Vector>(
    zero: V,
    lines: SteeredSegments<'_, '_>,
    sample_index: SampleIndex,
    (halves, phases): (&mut [ComplexVector<V>], &mut [ComplexVector<V>]),
) {
    // Lanes without a segment point straight ahead.
    let ahead = ComplexVector::from_real(zero.splat(1.0));
    if lines.segments.len() < V::LANES {
        halves.fill(ahead);
        phases.fill(ahead);
    }
    let segments = lines.segments.iter().zip(lines.steering);
    for (lane, (segment, steering)) in segments.enumerate() {
        let directions = steering.at(sample_index.sample(segment).unwrap_or(0));
        let slots = halves.iter_mut().zip(phases.iter_mut());
        for ((half, phase), &[of_half, of_phase]) in slots.zip(directions) {
            half.set_lane(lane, of_half);
            phase.set_lane(lane, of_phase);
        }
    }
}

/// `y_m = e^{−js(m−centre)}·x_m`, and the powers of `e^{js}` that this takes, as many as `outwards`.
#[inline(never)]
fn rotate<V: Vector>(
    (half, outwards): (ComplexVector<V>, impl Size),
    active: &[ComplexVector<V>],
    powers: &mut [ComplexVector<V>],
    rotated: &mut [ComplexVector<V>],
) {
    vectorize!(half.re, {
        let mut next = Powers::new(half, active.len());
        // The middle element of an odd number is the first on either side; the right side's is kept.
        let (middle, outwards) = (active.len() / 2, outwards.get());
        let (Some(left), Some(right), Some(powers)) = (
            active.get(..outwards),
            active.get(middle..).and_then(|right| right.get(..outwards)),
            powers.get_mut(..outwards),
        ) else {
            return;
        };
        if rotated.len() != active.len() {
            return;
        }
        let (tiles, rest) = powers.as_chunks_mut::<TILE>();
        let whole = tiles.len();
        let (left_rest, left) = left.as_rchunks::<TILE>();
        let (right, right_rest) = right.as_chunks::<TILE>();
        let pairs = left.iter().rev().zip(right).zip(tiles);
        for (tile, ((left, right), powers)) in pairs.enumerate() {
            let tile_of = next.tile(tile);
            *powers = tile_of;
            let before = outwards - TILE * (tile + 1);
            if let Some(turned) = rotated.get_mut(before..before + TILE) {
                for k in 0..TILE {
                    turned[TILE - 1 - k] = left[TILE - 1 - k].mul(tile_of[k]);
                }
            }
            let behind = middle + TILE * tile;
            if let Some(turned) = rotated.get_mut(behind..behind + TILE) {
                for k in 0..TILE {
                    turned[k] = right[k].mul_conj(tile_of[k]);
                }
            }
        }
        let behind = active.len() - right_rest.len();
        let last = if rest.is_empty() {
            next.next
        } else {
            next.tile(whole)
        };
        for (power, &next) in rest.iter_mut().zip(&last) {
            *power = next;
        }
        for ((y, x), power) in rotated.iter_mut().zip(left_rest).rev().zip(last) {
            *y = x.mul(power);
        }
        let turned = rotated.get_mut(behind..).unwrap_or_default();
        for ((y, x), power) in turned.iter_mut().zip(right_rest).zip(last) {
            *y = x.mul_conj(power);
        }
    });
}

/// The steering vector `a_i = e^{js(i−(L−1)/2)}` and the sum of the subapertures, times it, in the solver's coordinates.
///
/// `powers` are those for `count` elements, which serve if those of the subaperture are the same.
#[inline(never)]
fn sum<A: Averaging<V>, V: Vector>(
    (half, n): (ComplexVector<V>, impl Size),
    rotated: &[ComplexVector<V>],
    window: Option<&Window>,
    powers: &mut [ComplexVector<V>],
    sums: &mut [ComplexVector<V>],
    steering: &mut [A::Scalar],
    data: &mut [ComplexVector<V>],
) {
    vectorize!(half.re, {
        let (length, count) = (n.get(), rotated.len());
        let (Some(sums), Some(steering), Some(data)) = (
            n.front_mut(sums, length),
            n.front_mut(steering, length.next_multiple_of(TILE)),
            n.front_mut(data, length),
        ) else {
            return;
        };
        match window {
            None => subaperture_sum(half.re.zero(), rotated, sums),
            Some(window) => window.subaperture_sum(half.re.zero(), rotated, sums),
        }
        let Some(powers) = powers.get_mut(..sums.len().div_ceil(2)) else {
            return;
        };
        if count % 2 != sums.len() % 2 {
            Powers::new(half, sums.len()).fill(powers);
        }
        A::steered(powers, sums, steering, data);
    });
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
