//! Interpolation of I/Q samples.
//!
//! Worst error relative to the pulse's peak, on a Gaussian pulse of bandwidth B at −6 dB, by the record's rate over
//! B:
//!
//! | fs/B | linear | cubic | sinc |
//! |---|---|---|---|
//! | 3.33 | 7.8·10⁻² | 2.3·10⁻² | 8.0·10⁻⁴ |
//! | 5 | 3.6·10⁻² | 5.2·10⁻³ | 3.5·10⁻⁴ |
//! | 8 | 1.4·10⁻² | 8.4·10⁻⁴ | 3.4·10⁻⁴ |
//! | 13.3 | 5.1·10⁻³ | 1.2·10⁻⁴ | 3.4·10⁻⁴ |
//! | 32 | 8.8·10⁻⁴ | 3.6·10⁻⁶ | 3.2·10⁻⁴ |

use super::taps::{Taps, Values, columns, load_quarters, load_taps, side_by_side};
use crate::Complex;
use crate::kaiser::Kaiser;
use crate::simd::{ComplexVector, MOST_LANES, Vector};
use crate::sine::sin;
use core::f64::consts::PI;

/// Interpolation between two I/Q samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum IqInterpolation {
    /// Linear interpolation.
    Linear,
    /// Cubic polynomial through the two samples and their neighbours.
    Cubic,
    /// Windowed sinc of 12 taps.
    Sinc,
    /// Linear interpolation in fixed point; carrier phase from a table.
    ///
    /// For processors without f64, at about a third of the instructions of [`IqInterpolation::Linear`]. Limits: samples
    /// are counts, f_demod is below twice the sampling rate, records have up to 65 536 samples of 4096 elements, and
    /// the path from an element to the line is below 8191 samples. The phase error is up to 7.7·10⁻⁴ + 10⁻⁴·f_demod/fs
    /// rad, in addition to the error of linear interpolation.
    LinearFixed,
}

impl IqInterpolation {
    /// The cheapest interpolation with an error of at most 10⁻³ of the peak.
    ///
    /// For a pulse of `bandwidth` (at −6 dB, two-sided), both in Hz: linear from a rate of 32 bandwidths on, cubic from
    /// 8 on, else the sinc. Below 3.3 bandwidths the error of the sinc exceeds 10⁻³.
    ///
    /// ```
    /// use bonebeam::delay::IqInterpolation;
    ///
    /// // 60 % of 5 MHz.
    /// assert_eq!(IqInterpolation::for_band(10e6, 3e6), IqInterpolation::Sinc);
    /// assert_eq!(IqInterpolation::for_band(25e6, 3e6), IqInterpolation::Cubic);
    /// assert_eq!(IqInterpolation::for_band(100e6, 3e6), IqInterpolation::Linear);
    /// ```
    pub const fn for_band(sampling_rate: f64, bandwidth: f64) -> Self {
        if sampling_rate >= 32.0 * bandwidth {
            IqInterpolation::Linear
        } else if sampling_rate >= 8.0 * bandwidth {
            IqInterpolation::Cubic
        } else {
            IqInterpolation::Sinc
        }
    }
}

/// Interpolates the samples around positions, an element in each lane.
pub(super) trait Read<const TAPS: usize> {
    /// The value in every lane, at the fraction `weight` (0..1) of a sample after tap `TAPS/2 − 1`.
    fn one<V: Vector>(&self, weight: V, taps: &[Complex<f32>; TAPS]) -> ComplexVector<V>;

    /// The values at the first depths of a chunk, one a weight.
    fn read<V: Vector>(&self, weights: &[V], taps: &impl Taps, memory: &mut Values<V>);
}

/// The same numbers in every lane.
#[inline(always)]
fn splat<V: Vector, const N: usize>(zero: V, values: &[Complex<f32>; N]) -> [ComplexVector<V>; N] {
    values.map(
        #[inline(always)]
        |value| ComplexVector::new(zero.splat(value.re), zero.splat(value.im)),
    )
}

pub(super) struct Linear;

impl Linear {
    /// `a + weight·(b − a)`.
    #[inline(always)]
    fn value<V: Vector>(weight: V, [a, b]: [ComplexVector<V>; 2]) -> ComplexVector<V> {
        ComplexVector::new(a.re + weight * (b.re - a.re), a.im + weight * (b.im - a.im))
    }
}

impl Read<2> for Linear {
    #[inline(always)]
    fn one<V: Vector>(&self, weight: V, taps: &[Complex<f32>; 2]) -> ComplexVector<V> {
        Self::value(weight, splat(weight, taps))
    }

    #[inline(always)]
    fn read<V: Vector>(&self, weights: &[V], taps: &impl Taps, memory: &mut Values<V>) {
        memory.by_pairs::<2, 1>(weights, taps, Self::value);
    }
}

pub(super) struct Cubic;

impl Cubic {
    /// Lagrange's: with u = weight, p = u·(u − 1), q = (u + 1)·(u − 2), the weights are
    /// −p·(u − 2)/6, q·(u − 1)/2, −q·u/2 and p·(u + 1)/6; sums (a + b) + (c + d).
    #[inline(always)]
    fn value<V: Vector>(u: V, [a, b, c, d]: [ComplexVector<V>; 4]) -> ComplexVector<V> {
        let (one, two) = (u.splat(1.0), u.splat(2.0));
        let p = u.splat(1.0 / 6.0) * (u * (u - one));
        let q = u.splat(0.5) * ((u + one) * (u - two));
        let [f, g, h, i] = [p * (two - u), q * (u - one), -(q * u), p * (u + one)];
        ComplexVector::new(
            (f * a.re + g * b.re) + (h * c.re + i * d.re),
            (f * a.im + g * b.im) + (h * c.im + i * d.im),
        )
    }
}

impl Read<4> for Cubic {
    #[inline(always)]
    fn one<V: Vector>(&self, weight: V, taps: &[Complex<f32>; 4]) -> ComplexVector<V> {
        Self::value(weight, splat(weight, taps))
    }

    #[inline(always)]
    fn read<V: Vector>(&self, weights: &[V], taps: &impl Taps, memory: &mut Values<V>) {
        memory.by_pairs::<4, 2>(weights, taps, Self::value);
    }
}

/// Taps of the sinc.
pub(super) const TAPS: usize = 12;
/// Rows of its table per sample; between rows the value is interpolated linearly.
const PHASES: usize = 64;
/// Sums that its products are added in.
const SUMS: usize = 4;
/// The shape of its Kaiser window.
const BETA: f64 = 6.0;

/// The tabulated sinc, 3 KiB: row p has `sinc(u)·kaiser(u/6, 6)` at tap k, u = k − 5 − p/64.
pub(super) struct Sinc {
    table: [[f32; TAPS]; PHASES + 1],
}

/// The same for all parameters, and so a constant.
pub(super) static SINC: Sinc = Sinc::new();

// The size that docs/memory.md states.
const _: () = assert!(size_of::<Sinc>() == 3120);

impl Sinc {
    const fn new() -> Self {
        let half = (TAPS / 2) as f64;
        let window = Kaiser::new(BETA);
        let mut table = [[0.0; TAPS]; PHASES + 1];
        let mut row = 0;
        while row <= PHASES {
            let mut tap = 0;
            while tap < TAPS {
                let u = tap as f64 - (half - 1.0) - row as f64 / PHASES as f64;
                let sinc = if u == 0.0 {
                    1.0
                } else {
                    sin(PI * u) / (PI * u)
                };
                table[row][tap] = (sinc * window.at(u / half)) as f32;
                tap += 1;
            }
            row += 1;
        }
        Sinc { table }
    }
}

impl Sinc {
    /// s = 64·weight; the row is ⌊s⌋, at most 63; a tap is `row + (s − ⌊s⌋)·(next − row)`. Products are
    /// added in four sums, of taps 0, 4 and 8, and so on; then `(s₀ + s₂) + (s₁ + s₃)`.
    #[inline(always)]
    fn value(&self, samples: &[Complex<f32>; TAPS], weight: f32) -> Complex<f32> {
        let s = weight * PHASES as f32;
        // A weight is at least 0 and below 1, so that the cast rounds down.
        let at = (s as usize).min(PHASES - 1);
        let part = s - at as f32;
        let none = [0.0; TAPS];
        let row = self.table.get(at).unwrap_or(&none);
        let next = self.table.get(at + 1).unwrap_or(&none);
        let (mut re, mut im) = ([0.0; SUMS], [0.0; SUMS]);
        let [row, next] = [row, next].map(|taps| taps.as_chunks::<SUMS>().0);
        let samples = samples.as_chunks::<SUMS>().0;
        for ((row, next), samples) in row.iter().zip(next).zip(samples) {
            for j in 0..SUMS {
                let tap = row[j] + part * (next[j] - row[j]);
                re[j] += tap * samples[j].re;
                im[j] += tap * samples[j].im;
            }
        }
        let sum = |[a, b, c, d]: [f32; SUMS]| (a + c) + (b + d);
        Complex::new(sum(re), sum(im))
    }
}

impl Sinc {
    /// [`Sinc::value`] of all lanes at the n-th depth.
    #[inline(always)]
    fn values<V: Vector>(&self, weight: V, taps: &impl Taps, n: usize) -> ComplexVector<V> {
        let zero = weight.zero();
        let mut loaded = [[zero; 4]; TAPS / 2];
        load_taps::<V, TAPS, { TAPS / 2 }>(zero, taps, n, &mut loaded);
        let s = weight * zero.splat(PHASES as f32);
        let mut rows = [0i32; MOST_LANES];
        s.truncate(&mut rows);
        let mut floor = zero;
        for (floor, row) in floor.lanes_mut().iter_mut().zip(&mut rows) {
            *row = if *row < PHASES as i32 {
                *row
            } else {
                PHASES as i32 - 1
            };
            *floor = *row as f32;
        }
        let part = s - floor;
        // A row and the next one.
        let mut table = [[zero; 4]; TAPS / 2];
        let found = load_quarters(
            zero,
            &mut table,
            #[inline(always)]
            |lane| {
                let first = *rows.get(lane)? as usize * TAPS;
                let pair = self.table.as_flattened().get(first..first + 2 * TAPS)?;
                let (fours, _) = pair.as_chunks::<4>();
                fours.first_chunk::<{ TAPS / 2 }>().copied()
            },
        );
        if found.is_none() {
            return ComplexVector::from_real(zero);
        }
        let samples: [ComplexVector<V>; TAPS] = side_by_side(&loaded);
        let samples = samples.as_chunks::<SUMS>().0;
        let mut sums = [ComplexVector::from_real(zero); SUMS];
        for four in 0..TAPS / SUMS {
            let (row, next) = (columns(table[four]), columns(table[four + TAPS / SUMS]));
            for (j, (sum, sample)) in sums.iter_mut().zip(&samples[four]).enumerate() {
                let tap = row[j] + part * (next[j] - row[j]);
                sum.re = sum.re + tap * sample.re;
                sum.im = sum.im + tap * sample.im;
            }
        }
        let [a, b, c, d] = sums;
        (a + c) + (b + d)
    }
}

impl Read<TAPS> for Sinc {
    #[inline(always)]
    fn one<V: Vector>(&self, weight: V, taps: &[Complex<f32>; TAPS]) -> ComplexVector<V> {
        let [value] = splat(weight, &[self.value(taps, weight.lanes()[0])]);
        value
    }

    #[inline(always)]
    fn read<V: Vector>(&self, weights: &[V], taps: &impl Taps, memory: &mut Values<V>) {
        for (n, (&weight, value)) in weights.iter().zip(&mut memory.values).enumerate() {
            *value = self.values(weight, taps, n);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kaiser;

    /// The worst error over sub-sample phases and positions, of a Gaussian envelope whose peak is 1.
    fn error<const TAPS: usize>(read: &impl Read<TAPS>, ratio: f64) -> f64 {
        // e^(−a·t²), t in samples, of −6 dB at ±B/2.
        let a = (PI / ratio) * (PI / ratio) / (4.0 * libm::log(libm::pow(10.0, 6.0 / 20.0)));
        let pulse = |t: f64| libm::exp(-a * t * t);
        let mut worst = 0.0f64;
        for phase in (0..40).step_by(crate::step(10)) {
            let weight = f64::from(phase) / 40.0;
            for position in (-200..200).step_by(crate::step(20)) {
                let t = f64::from(position) * 0.05;
                let sample = |k: usize| {
                    let at = t - weight + k as f64 - (TAPS / 2 - 1) as f64;
                    let envelope = pulse(at) as f32;
                    Complex::new(envelope, -0.5 * envelope)
                };
                let samples: [Complex<f32>; TAPS] = core::array::from_fn(sample);
                let value = read.one(weight as f32, &samples).lane(0);
                worst = worst.max(libm::fabs(f64::from(value.re) - pulse(t)));
                worst = worst.max(2.0 * libm::fabs(f64::from(value.im) + 0.5 * pulse(t)));
            }
        }
        worst
    }

    #[test]
    fn the_documented_errors_hold() {
        for (ratio, linear, cubic, sinc) in [
            (10.0 / 3.0, 7.8e-2, 2.3e-2, 8.0e-4),
            (5.0, 3.6e-2, 5.2e-3, 3.5e-4),
            (8.0, 1.4e-2, 8.4e-4, 3.4e-4),
            (40.0 / 3.0, 5.1e-3, 1.2e-4, 3.4e-4),
            (32.0, 8.8e-4, 3.6e-6, 3.2e-4),
        ] {
            let found = [
                error(&Linear, ratio),
                error(&Cubic, ratio),
                error(&SINC, ratio),
            ];
            for (found, documented) in found.iter().zip([linear, cubic, sinc]) {
                assert!(
                    *found <= documented && *found > 0.8 * documented,
                    "{ratio}: {found} {documented}"
                );
            }
        }
    }

    #[test]
    fn a_whole_position_returns_the_sample() {
        let samples: [Complex<f32>; TAPS] =
            core::array::from_fn(|k| Complex::new(k as f32, 1.0 - k as f32));
        let near = |value: Complex<f32>, sample: Complex<f32>| (value - sample).norm() < 1e-5;
        assert!(near(SINC.one(0.0f32, &samples).lane(0), samples[5]));
        let taps = [2, 3, 7, 1].map(|k| samples[k]);
        assert_eq!(Cubic.one(0.0f32, &taps).lane(0), samples[3]);
        let taps = [samples[2], samples[3]];
        assert_eq!(Linear.one(0.0f32, &taps).lane(0), samples[2]);
    }

    #[test]
    fn the_sinc_is_that_of_libms_functions() {
        for (row, taps) in SINC.table.iter().enumerate() {
            for (tap, value) in taps.iter().enumerate() {
                let u = tap as f64 - 5.0 - row as f64 / 64.0;
                let sinc = if u == 0.0 {
                    1.0
                } else {
                    libm::sin(PI * u) / (PI * u)
                };
                let exact = (sinc * kaiser::tests::plain(u / 6.0, 6.0)) as f32;
                assert_eq!(value.to_bits(), exact.to_bits(), "{row} {tap}");
            }
        }
    }
}
