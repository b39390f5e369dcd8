//! Read positions of an element at a line's beginning, by integers.
//!
//! [`Flight::at`] takes a dozen operations in f64 for each output sample: 1,800 instructions with f64 in software. Here,
//! 200 approximate the same depth and position. A sample is `None` unless every number within the error rounds to the
//! same f32, so that bits are those of f64.
//!
//! With s = rate·t/2 samples, a position is √((s − a)² + q) + (b + slope·s). Both s and the second term grow evenly. The
//! root is d + r/2d, with d a root in f32 and r = (s − a)² + q − d² in integers.
//!
//! Errors, if the terms' sizes have the sum S < 2¹¹ samples, and 2⁴ ≤ d ≤ 2¹⁰: d errs by δ = 2⁻²²·d and 2⁻¹⁹. So r/2d
//! leaves δ²/2d, and has two roundings of f32, 2⁻²³·δ: together 2⁻⁴⁴·d + 2⁻³⁹. The ten roundings of f64 are below
//! 2⁻⁴⁸·S. Integers are cut: r to 2⁻³², which makes 2⁻³⁷, and growth to 2⁻⁴⁸ a sample. The bound is
//! 2⁻³⁶ + 2⁻⁴³·S + 2⁻⁴⁷ a sample; half of it was seen in 4·10⁸ random positions.

use crate::delay::flight::{CentreSample, Flight};
use crate::instructions::sqrt;

/// Bounds of the root, in samples.
const SMALLEST_ROOT: f32 = 16.0;
const LARGEST_ROOT: f32 = 1024.0;
/// Bound of the sum of all terms, in samples and in metres.
const LARGEST: [f64; 2] = [2048.0, 0.25];
/// Bound of a depth's error, in 2⁻⁶⁴ m.
const DEPTH_ERROR: u64 = 1 << 24;

/// Read position of an element at the line's beginning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Centre {
    /// z, m; 0 if nothing can be read.
    pub depth: f32,
    /// Whole samples.
    pub whole: f32,
    /// The rest, in samples.
    pub fraction: f32,
}

/// A number that grows evenly: its next value, and its growth per sample.
#[derive(Clone, Copy)]
struct Even(i64, i64);

/// The positions of consecutive output samples.
pub(super) struct Steps {
    /// z, in 2⁻⁶⁴ m.
    depth: Even,
    /// b + slope·s, in 2⁻⁴⁸ samples.
    straight: Even,
    circle: Option<Circle>,
    /// Bound of a position's error, in 2⁻⁶⁴ samples.
    error: u64,
}

/// The root's terms.
struct Circle {
    /// s − a, in 2⁻⁴⁸ samples.
    along: Even,
    /// q, in 2⁻⁴⁰ samples², and as f32.
    square: (i64, f32),
}

impl Centre {
    /// [`Flight::at`] as f32.
    #[inline(always)]
    pub fn at(flight: &Flight, n: f64) -> Self {
        let CentreSample {
            depth, position, ..
        } = flight.at(n);
        let near = position > -super::FAR && position < super::FAR;
        let floor = if near { libm::floor(position) } else { 0.0 };
        Centre {
            depth: if near { depth as f32 } else { 0.0 },
            whole: floor as f32,
            fraction: if near { (position - floor) as f32 } else { 0.0 },
        }
    }
}

impl Steps {
    /// The positions of `count` output samples from `first` on, if within the bounds.
    pub fn new(flight: &Flight, first: f64, count: usize) -> Option<Self> {
        let ([offset, slope], circle) = flight.transmit.parts()?;
        let c = flight.sound_speed;
        let a_metre = flight.rate / c;
        // Nothing is lost by an underflow.
        if !(c > 1.0 && c < 1e6 && a_metre < 1e9) {
            return None;
        }
        // s: its growth, its first value, and its last less the first.
        let growth = 0.5 * flight.rate / flight.output_rate;
        let start = 0.5 * flight.rate * flight.output_start;
        let s = start + first * growth;
        let way = count as f64 * growth;
        let (t0, offset) = (flight.t0 * flight.rate, offset * a_metre);
        let [along, square] = circle.map_or([0.0; 2], |[along, square]| {
            [along * a_metre, square * a_metre * a_metre]
        });
        let root = f64::from(sqrt(square as f32));
        let size: f64 = [start, s, way, t0, offset, along, root]
            .map(f64::abs)
            .iter()
            .sum();
        let [samples, metres] = LARGEST;
        if !(size < samples && size < metres * a_metre) {
            return None;
        }
        let unit = (1u64 << 48) as f64;
        let even = |first: f64, growth: f64| Even((first * unit) as i64, (growth * unit) as i64);
        let to_depth = 65536.0 / a_metre;
        Some(Steps {
            depth: even(s * to_depth, growth * to_depth),
            straight: even(offset - t0 + (1.0 + slope) * s, (1.0 + slope) * growth),
            circle: circle.map(|_| Circle {
                along: even(s - along, growth),
                square: ((square * (1u64 << 40) as f64) as i64, square as f32),
            }),
            error: (1 << 28) + ((size as u64) << 21) + ((count as u64) << 17),
        })
    }

    /// The next position, if it is certain.
    #[inline(always)]
    pub fn next(&mut self) -> Option<Centre> {
        let (depth, mut position) = (self.depth.next(), self.straight.next());
        if let Some(circle) = &mut self.circle {
            position += circle.next()?;
        }
        Some(Centre {
            depth: rounded(u64::try_from(depth).ok()?, DEPTH_ERROR)?,
            whole: (position >> 48) as i32 as f32,
            fraction: rounded((position << 16) as u64, self.error)?,
        })
    }
}

impl Even {
    #[inline(always)]
    fn next(&mut self) -> i64 {
        let value = self.0;
        self.0 = value.wrapping_add(self.1);
        value
    }
}

impl Circle {
    /// The root, in 2⁻⁴⁸ samples.
    #[inline(always)]
    fn next(&mut self) -> Option<i64> {
        const UNIT: f32 = (1 << 20) as f32;
        let along = self.along.next();
        let (square, of_f32) = self.square;
        // In 2⁻²⁰ samples, and the rest in 2⁻⁴⁰.
        let (whole, part) = ((along >> 28) as i32, (along >> 8) as i32 & ((1 << 20) - 1));
        let x = whole as f32 * (1.0 / UNIT);
        let root = sqrt(x * x + of_f32);
        if !(SMALLEST_ROOT..=LARGEST_ROOT).contains(&root) {
            return None;
        }
        let d = (root * UNIT) as i32;
        let product = |a: i32, b: i32| i64::from(a) * i64::from(b);
        let rest = product(whole, whole) - product(d, d) + square + (product(whole, part) >> 19);
        let correction = ((rest >> 8) as i32 as f32 * 128.0 / root) as i32;
        Some((i64::from(d) << 28) + (i64::from(correction) << 8))
    }
}

/// `x·2⁻⁶⁴` as f32, if all numbers less than `error` away round to the same one.
#[inline(always)]
fn rounded(x: u64, error: u64) -> Option<f32> {
    let zeros = x.leading_zeros();
    if zeros > 31 {
        return None;
    }
    let (x, error) = (x << zeros, error << zeros);
    // To 24 bits, of which a float has as many.
    let round = |x: u64| ((x >> 39) as u32 + 1) >> 1;
    let rounded = round(x.checked_sub(error)?);
    let same = rounded == round(x.checked_add(error)?);
    same.then(|| rounded as f32 * f32::from_bits((127 - 24 - zeros) << 23))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::delay_law::TransmitDelay;
    use crate::geometry::{Array, Ray, TransmitLaw};
    use rand::{RngExt, SeedableRng, rngs::ChaCha8Rng};

    /// Random lines: nearly all samples are certain, and all of these have the bits of f64.
    #[test]
    fn certain_positions_are_those_of_f64() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        let (mut certain, mut all) = (0, 0);
        for case in (0..4000).step_by(crate::step(500)) {
            let mut between = |low: f64, high: f64| random.random_range(low..high);
            let ray = match case % 2 {
                0 => Ray::down(between(-0.02, 0.02)),
                _ => Ray::new(
                    between(-0.02, 0.02),
                    between(-0.01, 0.01),
                    between(-0.7, 0.7),
                ),
            };
            let x = between(-0.02, 0.02);
            let law = match case % 4 {
                0 => TransmitLaw::Focused,
                1 => TransmitLaw::Plane {
                    angle: between(-0.4, 0.4),
                },
                2 => TransmitLaw::Element { x, z: 0.0 },
                _ => TransmitLaw::VirtualSource {
                    x,
                    z: between(-0.03, 0.0),
                },
            };
            let c = between(1400.0, 1650.0);
            let law = TransmitDelay::new(law, &ray, &Array::linear(4, 0.3e-3), c).unwrap();
            let output_rate = between(4e6, 50e6);
            let flight = Flight {
                transmit: &law,
                t0: between(-2e-6, 2e-6),
                sound_speed: c,
                output_start: between(-1e-6, 2e-5),
                output_rate,
                rate: output_rate * between(0.5, 2.0),
            };
            let first = between(-40.0, 200.0) as i32;
            let count = 300;
            let Some(mut steps) = Steps::new(&flight, f64::from(first), count) else {
                continue;
            };
            for n in 0..count as i32 {
                all += 1;
                if let Some(centre) = steps.next() {
                    certain += 1;
                    let exact = Centre::at(&flight, f64::from(first + n));
                    let bits = |c: Centre| [c.depth, c.whole, c.fraction].map(f32::to_bits);
                    assert_eq!(
                        bits(centre),
                        bits(exact),
                        "{case} {n}: {centre:?} {exact:?}"
                    );
                }
            }
        }
        assert!(certain > all / 100 * 90, "{certain} of {all}");
        assert!(all > 100, "{all}");
    }
}
