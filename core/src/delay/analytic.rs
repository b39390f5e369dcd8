//! Analytic signal along depth, by an odd FIR Hilbert transformer.
//!
//! Its window is a Kaiser window. The real part is the signal itself. The imaginary part is `y[n] = Σ_j
//! h_j·(x[n−2j−1] − x[n+2j+1])`, h_j = 2/(π(2j+1))·kaiser((2j+1)/2N, β = 6), so that a cosine gives e^{+jωt}. The
//! even taps are zero and not computed.
//!
//! Worst error with the default length, relative to the peak of a Gaussian pulse of 5 MHz and 60 % bandwidth
//! (phase: where the envelope is above −20 dB):
//!
//! | output rate | taps (all) | imaginary part | envelope | phase, rad |
//! |---|---|---|---|---|
//! | 20 MHz | 31 | 2.8·10⁻⁴ | 2.5·10⁻⁴ | 1.0·10⁻³ |
//! | 40 MHz | 63 | 2.6·10⁻⁴ | 1.8·10⁻⁴ | 6·10⁻⁴ |
//! | 100 MHz | 159 | 2.6·10⁻⁴ | 1.8·10⁻⁴ | 6·10⁻⁴ |

use crate::Error;
use crate::error::{at_least_one, attempt};
use crate::kaiser::Kaiser;
use crate::simd::{Vector, load};

/// Maximum number of non-zero taps on one side of the Hilbert transformer.
pub const MAX_HILBERT_TAPS: usize = 64;
const BETA: f64 = 6.0;
/// Outputs whose sums are formed together, so that none waits for its last addition.
pub(super) const GROUP: usize = 8;

/// Number N of non-zero Hilbert taps on each side, for a pulse at an output rate.
///
/// `centre_frequency` and `output_rate` in Hz. N = ⌈2·output_rate/f₀⌉, almost four periods of f₀ on each side; from 1
/// to [`MAX_HILBERT_TAPS`].
///
/// ```
/// assert_eq!(bonebeam::delay::hilbert_taps(20e6, 5e6), 8);
/// ```
pub const fn hilbert_taps(output_rate: f64, centre_frequency: f64) -> usize {
    let wanted = 2.0 * (output_rate / centre_frequency);
    let mut count = 1;
    while count < MAX_HILBERT_TAPS && (count as f64) < wanted {
        count += 1;
    }
    count
}

/// Samples that N taps a side need before the first and after the last output, 2N − 1.
pub(super) const fn reach(count: usize) -> usize {
    (2 * count).saturating_sub(1)
}

/// A Hilbert transformer of N non-zero taps a side.
#[derive(Clone, Debug)]
pub(super) struct HilbertTransformer {
    taps: [f32; MAX_HILBERT_TAPS],
    count: usize,
}

impl HilbertTransformer {
    /// Refuses numbers of taps, as [`HilbertTransformer::new`].
    pub(super) const fn check(count: usize) -> Result<(), Error> {
        attempt!(at_least_one("hilbert taps", count));
        if count > MAX_HILBERT_TAPS {
            let capacity = MAX_HILBERT_TAPS;
            return Err(Error::capacity("hilbert taps", count, capacity));
        }
        Ok(())
    }

    /// `count` non-zero taps a side, N: 4N − 1 taps in all.
    ///
    /// # Errors
    /// [`Error::Parameter`] if `count` is 0, [`Error::Capacity`] if it exceeds [`MAX_HILBERT_TAPS`].
    pub(super) const fn new(count: usize) -> Result<Self, Error> {
        attempt!(Self::check(count));
        let mut taps = [0.0; MAX_HILBERT_TAPS];
        let window = Kaiser::new(BETA);
        let mut j = 0;
        while j < count {
            let k = (2 * j + 1) as f64;
            let window = window.at(k / (2 * count) as f64);
            taps[j] = (2.0 / (core::f64::consts::PI * k) * window) as f32;
            j += 1;
        }
        Ok(HilbertTransformer { taps, count })
    }

    /// Samples needed before the first and after the last output, 2N − 1.
    pub(super) fn reach(&self) -> usize {
        reach(self.count)
    }

    /// Largest gain for samples of magnitude 1.
    #[cfg(test)]
    pub(super) fn gain(&self) -> f64 {
        let sum: f64 = self.taps.iter().map(|&tap| f64::from(tap.abs())).sum();
        2.0 * sum
    }

    /// The imaginary parts of a group of `rows`, which begins at row [`Self::reach`].
    ///
    /// As many rows follow the last one.
    ///
    /// Order, f32: from 0, in ascending j, `y += h_j · (earlier − later)`. Cost: N MACs and N
    /// subtractions a sample.
    #[inline(always)]
    pub(super) fn quadrature<V: Vector>(&self, zero: V, rows: &[f32]) -> [V; GROUP] {
        let mut sums = [zero; GROUP];
        let Some(taps) = self.taps.get(..self.count) else {
            return sums;
        };
        let (reach, group) = (self.reach() * V::LANES, GROUP * V::LANES);
        // From the nearest rows on either side to the farthest, every second one.
        let before = rows.get(..(reach + group).saturating_sub(V::LANES));
        let behind = rows.get(reach + V::LANES..);
        let earlier = before.unwrap_or_default().windows(group).rev();
        let later = behind.unwrap_or_default().windows(group);
        let pairs = earlier
            .step_by(2 * V::LANES)
            .zip(later.step_by(2 * V::LANES));
        for (&tap, (earlier, later)) in taps.iter().zip(pairs) {
            let tap = zero.splat(tap);
            let pairs = earlier
                .chunks_exact(V::LANES)
                .zip(later.chunks_exact(V::LANES));
            for (sum, (earlier, later)) in sums.iter_mut().zip(pairs) {
                *sum = *sum + tap * (load(zero, earlier) - load(zero, later));
            }
        }
        sums
    }

    /// The imaginary part of the row [`Self::reach`] of `rows`.
    ///
    /// As many rows follow. The bits are those of [`Self::quadrature`].
    #[inline(always)]
    pub(super) fn quadrature_of_row<V: Vector>(&self, zero: V, rows: &[f32]) -> V {
        let mut sum = zero;
        let Some(taps) = self.taps.get(..self.count) else {
            return sum;
        };
        let reach = self.reach() * V::LANES;
        let Some((before, behind)) = rows.split_at_checked(reach) else {
            return sum;
        };
        let earlier = before.chunks_exact(V::LANES).rev().step_by(2);
        let later = behind.chunks_exact(V::LANES).skip(1).step_by(2);
        for (&tap, (earlier, later)) in taps.iter().zip(earlier.zip(later)) {
            let pair = load(zero, earlier) - load(zero, later);
            sum = sum + zero.splat(tap) * pair;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    const F0: f64 = 5e6;

    /// A Gaussian pulse of 5 MHz and 60 % bandwidth at −6 dB, its analytic signal by the Fourier
    /// integral over the positive frequencies.
    fn pulse(t: f64) -> (f64, f64) {
        let a = PI * F0 * 0.6 * PI * F0 * 0.6 / (4.0 * libm::log(libm::pow(10.0, 6.0 / 20.0)));
        let step = 50e3;
        let (mut re, mut im) = (0.0, 0.0);
        for k in 0..400 {
            let f = (f64::from(k) + 0.5) * step;
            // The cosine's spectrum: one Gaussian at +f₀, one at −f₀.
            let gaussian = |d: f64| libm::sqrt(PI / a) / 2.0 * libm::exp(-PI * PI * d * d / a);
            let density = 2.0 * (gaussian(f - F0) + gaussian(f + F0)) * step;
            re += density * libm::cos(2.0 * PI * f * t);
            im += density * libm::sin(2.0 * PI * f * t);
        }
        (re, im)
    }

    #[test]
    #[cfg_attr(miri, ignore = "a Fourier integral for each of 6000 samples")]
    fn the_documented_errors_hold() {
        // (rate, imaginary part, envelope, phase): the figures of the module's documentation.
        for (rate, imaginary, envelope, phase) in [
            (20e6, 2.8e-4, 2.5e-4, 1.0e-3),
            (40e6, 2.6e-4, 1.8e-4, 6e-4),
            (100e6, 2.6e-4, 1.8e-4, 6e-4),
        ] {
            let hilbert = HilbertTransformer::new(hilbert_taps(rate, F0)).unwrap();
            let reach = hilbert.reach();
            let (mut worst, mut worst_envelope, mut worst_phase) = (0.0f64, 0.0f64, 0.0f64);
            for shift in 0..5 {
                let mut exact = [(0.0, 0.0); 400];
                let mut line = [0.0f32; 400];
                for n in 0..400 {
                    exact[n] = pulse((n as f64 - 200.0 + f64::from(shift) / 5.0) / rate);
                    line[n] = exact[n].0 as f32;
                }
                let mut im = [0.0f32; 400];
                let outputs = 400 - 2 * reach;
                for (group, im) in im[..outputs].chunks_exact_mut(GROUP).enumerate() {
                    im.copy_from_slice(&hilbert.quadrature(0.0f32, &line[group * GROUP..]));
                }
                let outputs = outputs / GROUP * GROUP;
                for n in 0..outputs {
                    let (re, exact_im) = exact[n + reach];
                    let im = f64::from(im[n]);
                    let magnitude = libm::hypot(re, exact_im);
                    worst = worst.max(libm::fabs(im - exact_im));
                    worst_envelope =
                        worst_envelope.max(libm::fabs(libm::hypot(re, im) - magnitude));
                    if magnitude > 0.1 {
                        let phase = libm::atan2(im * re - re * exact_im, re * re + im * exact_im);
                        worst_phase = worst_phase.max(libm::fabs(phase));
                    }
                }
            }
            assert!(worst <= imaginary, "{rate}: {worst}");
            assert!(
                worst_envelope <= envelope,
                "{rate}: envelope {worst_envelope}"
            );
            assert!(worst_phase <= phase, "{rate}: phase {worst_phase}");
        }
    }

    #[test]
    fn a_cosine_turns_forwards() {
        let hilbert = HilbertTransformer::new(8).unwrap();
        let line: [f32; 72] = core::array::from_fn(|n| libm::cosf(n as f32 * 1.5));
        for n in 0..34 {
            let im = hilbert.quadrature(0.0f32, &line[n..])[0];
            let sine = libm::sinf((n + hilbert.reach()) as f32 * 1.5);
            // β = 6 gives a ripple near 10⁻³ in mid-band.
            assert!(libm::fabsf(im - sine) < 2e-3, "{n}: {im} for {sine}");
        }
    }

    #[test]
    fn parameters_are_checked() {
        assert!(matches!(
            HilbertTransformer::new(0),
            Err(Error::Parameter { .. })
        ));
        assert!(matches!(
            HilbertTransformer::new(65),
            Err(Error::Capacity { .. })
        ));
    }

    #[test]
    fn the_default_length_is_almost_four_periods() {
        // 31, 63 and 159 taps in all.
        let taps = [20e6, 40e6, 100e6].map(|rate| hilbert_taps(rate, F0));
        assert_eq!(taps, [8, 16, 40]);
        assert_eq!(hilbert_taps(20.1e6, F0), 9);
        assert_eq!(hilbert_taps(1e12, 1.0), MAX_HILBERT_TAPS);
        for (rate, f0) in [(0.0, 5e6), (f64::NAN, 5e6), (-1.0, 5e6)] {
            assert_eq!(hilbert_taps(rate, f0), 1);
        }
    }
}
