//! Steering vectors and sums of subapertures for the directions of sub-lines.

use crate::beamform::apodization::Window;
use crate::beamform::parameters::Parameters;
use crate::beamform::postfilter::{Elements, Postfilter, factor};
use crate::beamform::pushes::Place;
use crate::beamform::segment::SteeredSegments;
use crate::beamform::workspace::Directions;
use crate::covariance::Averaging;
use crate::covariance::lag_sums::subaperture_sum;
use crate::linalg::panels::TILE;
use crate::simd::{ComplexVector, Scalar, Vector};
use num_complex::Complex;

/// A sample of the segments.
#[derive(Clone, Copy)]
pub(super) struct Sample<'s, 'a, V> {
    pub(super) lines: SteeredSegments<'s, 'a>,
    pub(super) place: Place,
    pub(super) active: &'s [ComplexVector<V>],
    pub(super) subaperture: usize,
}

/// A complex number as a vector of one lane.
pub(super) fn number(value: Complex<f32>) -> ComplexVector<f32> {
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

/// For each sub-line of a sample of the segments: the steering vector and the sum of the subapertures with phases, in
/// the solver's coordinates, and `e^{−jφ_c}`, times the postfilter's factor.
///
/// Order: `y_m = e^{−js(m−centre)}·x_m`; their subaperture sums slide as those of the line; sum `i` times `a_i`.
#[inline(never)]
pub(super) fn steer<A: Averaging<V>, V: Vector>(
    zero: V,
    sample: Sample<'_, '_, V>,
    (parameters, window): (&Parameters, Option<&Window>),
    directions: &mut Directions<'_, A::Scalar, V>,
) {
    let Sample {
        lines,
        place,
        active,
        subaperture,
    } = sample;
    zero.vectorize(
        #[inline(always)]
        || {
            let padded = subaperture.next_multiple_of(TILE);
            let rows = directions.steering.chunks_exact_mut(padded.max(1));
            let data = directions.data.chunks_exact_mut(subaperture.max(1));
            let phases = directions.phases.iter_mut();
            let power = match parameters.postfilter {
                Postfilter::None => zero,
                _ => power_of(zero, active),
            };
            for (k, ((row, data), slot)) in rows.zip(data).zip(phases).enumerate() {
                if k >= parameters.sub_lines {
                    break;
                }
                let [half, phase] = direction(zero, lines, place, k);
                let (Some(rotated), Some(sums)) = (
                    directions.rotated.get_mut(..active.len()),
                    directions.sums.get_mut(..subaperture),
                ) else {
                    return;
                };
                rotate(half, active, directions.powers_of_step, rotated);
                *slot = match parameters.postfilter {
                    Postfilter::None => phase,
                    _ => phase.scale(factor_of(parameters, rotated, power)),
                };
                match window {
                    None => subaperture_sum(zero, rotated, sums),
                    Some(window) => window.subaperture_sum(zero, rotated, sums),
                }
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

/// The factor of a postfilter, of the elements with phases and of their power.
#[inline(never)]
fn factor_of<V: Vector>(parameters: &Parameters, rotated: &[ComplexVector<V>], power: V) -> V {
    power.vectorize(
        #[inline(always)]
        || {
            let mut sum = ComplexVector::from_real(power.zero());
            for &y in rotated {
                sum = sum + y;
            }
            factor(
                parameters.postfilter_of_lines(),
                (sum, power),
                &Rotated(rotated),
            )
        },
    )
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

/// The direction of sub-line `k` at a sample of each lane's segment.
#[inline(always)]
fn direction<V: Vector>(
    zero: V,
    lines: SteeredSegments<'_, '_>,
    place: Place,
    k: usize,
) -> [ComplexVector<V>; 2] {
    let mut direction = [ComplexVector::from_real(zero.splat(1.0)); 2];
    let segments = lines.segments.iter().zip(lines.steering);
    for (lane, (segment, steering)) in segments.enumerate() {
        let [half, phase] = steering.direction(place.sample(segment).unwrap_or(0), k);
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
