//! Band-limited interpolation and decimation in one filter: a Kaiser-windowed sinc, tabulated.
//!
//! A value between the recorded samples is `Σ_k x[k]·h(t − k)`, with h a windowed sinc whose cut-off
//! is half the output rate where that is lower than the recorded rate: reading at the output
//! instants is then a proper decimation, which keeps noise above the output band from folding into
//! it (white noise falls by fs/output rate). The filter spans [`LOBES`] output intervals (recorded
//! ones where the output rate is not lower).
//!
//! Worst error, relative to the pulse's peak, on a Gaussian pulse e^{−at²}·cos 2πf₀t of 5 MHz and
//! 60 % bandwidth at −6 dB, over all positions and sub-sample phases:
//!
//! | recorded → output | this filter | linear interpolation |
//! |---|---|---|
//! | 20 → 20 MHz | 1.3·10⁻³ | 0.31 |
//! | 40 → 40 MHz | 9·10⁻⁶ | 0.081 |
//! | 100 → 100 MHz | 1.0·10⁻⁵ | 0.013 |
//! | 40 → 20 MHz | 7·10⁻⁴ | 0.081 |
//! | 100 → 20 MHz | 7·10⁻⁴ | 0.013 |
//!
//! In the last two rows the error is the pulse's own content near and above the output's Nyquist
//! frequency, which the decimation must remove, alike for every element. What differs between
//! sub-sample phases, and so disturbs the beamformer, is 4·10⁻⁵ and 1.1·10⁻⁵.

use super::kaiser;
use crate::Error;
use crate::lanes::Lanes;

/// Filter length, in intervals of the lower of the two rates.
pub const LOBES: usize = 16;
/// The largest ratio of recorded to output rate.
pub const MAX_DECIMATION: usize = 16;
/// Table rows per interval of the lower rate; between rows the value is interpolated linearly.
const ROWS: usize = 128;
const TABLE: usize = (ROWS + MAX_DECIMATION) * LOBES;

/// The tabulated filter. Built once; 9 KiB.
#[derive(Clone, Debug)]
pub struct Interpolator {
    /// Row-major [phase 0..=phases][tap]; row p holds h(k − (taps/2 − 1) − p/phases) at tap k.
    table: [f32; TABLE],
    taps: usize,
    phases: usize,
}

impl Interpolator {
    /// RAM of the table, bytes.
    pub const BYTES: usize = size_of::<Self>();

    /// The filter from `sampling_rate` to `output_rate` for a pulse around `centre_frequency`, Hz.
    ///
    /// With r = ⌈fs/fout⌉ (at least 1): 16r taps, ⌊128/r⌋ phases, cut-off κ = min(1, fout/fs) of
    /// fs/2, h(u) = κ·sinc(κu)·kaiser(u/8r, β). β follows Kaiser's design formula for a transition
    /// from 1.5 f₀ to its image, within 4..10: A = 8 + 2.285·2π·15·(1 − 3f₀/min(fs, fout)),
    /// β = 0.1102·(A − 8.7).
    ///
    /// # Errors
    /// [`Error::Parameter`] unless all three are positive and finite and fs/fout at most
    /// [`MAX_DECIMATION`].
    pub fn new(sampling_rate: f64, output_rate: f64, centre_frequency: f64) -> Result<Self, Error> {
        super::positive("sampling_rate", sampling_rate)?;
        super::positive("output_rate", output_rate)?;
        super::positive("centre_frequency", centre_frequency)?;
        let ratio = sampling_rate / output_rate;
        if ratio > MAX_DECIMATION as f64 {
            let expected = "at least a sixteenth of the sampling rate";
            return Err(Error::Parameter {
                name: "output_rate",
                value: output_rate,
                expected,
            });
        }
        let (lower, cutoff, intervals) = if ratio > 1.0 {
            (
                output_rate,
                output_rate / sampling_rate,
                libm::ceil(ratio) as usize,
            )
        } else {
            (sampling_rate, 1.0, 1)
        };
        let beta = shape(lower, centre_frequency);
        let taps = LOBES * intervals;
        let phases = ROWS / intervals;
        let half = (taps / 2) as f64;
        let mut table = [0.0; TABLE];
        for (row, values) in table.chunks_exact_mut(taps).take(phases + 1).enumerate() {
            for (tap, value) in values.iter_mut().enumerate() {
                let u = tap as f64 - (half - 1.0) - row as f64 / phases as f64;
                *value = (cutoff * sinc(cutoff * u) * kaiser::window(u / half, beta)) as f32;
            }
        }
        Ok(Interpolator {
            table,
            taps,
            phases,
        })
    }

    /// Taps of the filter: a value needs `taps()/2` recorded samples on either side.
    pub fn taps(&self) -> usize {
        self.taps
    }

    /// The value at `whole + fraction` samples of `record`, 0 ≤ fraction < 1; samples outside the
    /// record read as 0.
    ///
    /// Order, f32: p = ⌊fraction·phases⌋, w the rest; two dot products with rows p and p+1, each
    /// as four partial sums over the taps k ≡ 0, 1, 2, 3 (mod 4) in ascending k, added as
    /// (s₀+s₁)+(s₂+s₃); then a + w·(b − a). Cost: 2·taps MACs.
    #[inline]
    pub(super) fn at(&self, record: &[f32], whole: i32, fraction: f32) -> f32 {
        let reach = (self.taps / 2) as i32;
        let first = whole.saturating_sub(reach - 1);
        let end = whole.saturating_add(reach);
        if end < 0 || first as i64 >= record.len() as i64 {
            return 0.0;
        }
        let scaled = fraction * self.phases as f32;
        // 0 ≤ scaled: the conversion is the floor.
        let phase = (scaled as u32 as usize).min(self.phases - 1);
        let weight = scaled - phase as f32;
        let rows = self
            .table
            .get(phase * self.taps..(phase + 2) * self.taps)
            .unwrap_or(&[]);
        let (row, next) = rows.split_at(rows.len() / 2);
        let inside = usize::try_from(first)
            .ok()
            .and_then(|f| record.get(f..f + self.taps));
        let (a, b) = match inside {
            Some(x) => dot_pair(row, next, x),
            None => {
                let mut padded = [0.0; LOBES * MAX_DECIMATION];
                for (k, value) in padded.iter_mut().enumerate().take(self.taps) {
                    let index = usize::try_from(i64::from(first) + k as i64);
                    *value = index
                        .ok()
                        .and_then(|i| record.get(i))
                        .copied()
                        .unwrap_or(0.0);
                }
                dot_pair(row, next, &padded[..self.taps])
            }
        };
        a + weight * (b - a)
    }
}

/// The dot products of two rows with the same samples, in the order that [`Interpolator::at`]
/// documents. The four partial sums are there for vector units; they fix the order for all.
#[inline(always)]
fn dot_pair(row: &[f32], next: &[f32], x: &[f32]) -> (f32, f32) {
    let mut a = Lanes::<4>::ZERO;
    let mut b = Lanes::<4>::ZERO;
    let (row, _) = row.as_chunks::<4>();
    let (next, _) = next.as_chunks::<4>();
    let (x, _) = x.as_chunks::<4>();
    for ((r, n), x) in row.iter().zip(next).zip(x) {
        a += Lanes(*r) * Lanes(*x);
        b += Lanes(*n) * Lanes(*x);
    }
    (fold(a.0), fold(b.0))
}

#[inline(always)]
fn fold(s: [f32; 4]) -> f32 {
    (s[0] + s[1]) + (s[2] + s[3])
}

/// β of the Kaiser window for a signal around `centre` sampled at `rate`.
fn shape(rate: f64, centre: f64) -> f64 {
    let transition = 1.0 - 3.0 * centre / rate;
    let attenuation = 8.0 + 2.285 * 2.0 * core::f64::consts::PI * 15.0 * transition;
    let beta = 0.1102 * (attenuation - 8.7);
    beta.clamp(4.0, 10.0)
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 {
        return 1.0;
    }
    let angle = core::f64::consts::PI * x;
    libm::sin(angle) / angle
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    const F0: f64 = 5e6;

    /// A Gaussian pulse of 5 MHz and 60 % bandwidth at −6 dB.
    fn pulse(t: f64) -> f64 {
        let a = PI * F0 * 0.6 * PI * F0 * 0.6 / (4.0 * libm::log(libm::pow(10.0, 6.0 / 20.0)));
        libm::exp(-a * t * t) * libm::cos(2.0 * PI * F0 * t)
    }

    /// Worst error of the filter, half the spread of its values over the sub-sample phases, and
    /// worst error of linear interpolation, over 100 times × 211 sub-sample phases. The peak is 1.
    fn errors(fs: f64, fout: f64) -> (f64, f64, f64) {
        let filter = Interpolator::new(fs, fout, F0).unwrap();
        let mut record = [0.0f32; 512];
        let (mut total, mut spread, mut linear) = (0.0f64, 0.0f64, 0.0f64);
        for step in 0..100 {
            let t = (f64::from(step) - 49.7) * 12e-9;
            let (mut low, mut high) = (f64::MAX, f64::MIN);
            for phase in 0..211 {
                let fraction = f64::from(phase) / 211.0;
                // The grid is laid so that t falls on sample 256 + fraction.
                let sample = |k: usize| pulse(t + (k as f64 - 256.0 - fraction) / fs);
                for (k, value) in record.iter_mut().enumerate().skip(215).take(83) {
                    *value = sample(k) as f32;
                }
                let value = f64::from(filter.at(&record, 256, fraction as f32));
                total = total.max(libm::fabs(value - pulse(t)));
                low = low.min(value);
                high = high.max(value);
                let straight = sample(256) * (1.0 - fraction) + sample(257) * fraction;
                linear = linear.max(libm::fabs(straight - pulse(t)));
            }
            spread = spread.max((high - low) / 2.0);
        }
        (total, spread, linear)
    }

    #[test]
    fn the_documented_errors_hold() {
        // (recorded, output, error, spread, linear): the figures of the module's documentation.
        for (fs, fout, error, spread, straight) in [
            (20e6, 20e6, 1.3e-3, 7e-4, 0.31),
            (40e6, 40e6, 9e-6, 6e-6, 0.081),
            (100e6, 100e6, 1.0e-5, 6e-6, 0.013),
            (40e6, 20e6, 7e-4, 4e-5, 0.081),
            (100e6, 20e6, 7e-4, 1.1e-5, 0.013),
        ] {
            let (e, s, l) = errors(fs, fout);
            assert!(e <= error, "{fs} -> {fout}: error {e}");
            assert!(s <= spread, "{fs} -> {fout}: spread {s}");
            assert!(l > 0.9 * straight && l < 1.1 * straight, "{fs}: linear {l}");
        }
    }

    #[test]
    fn what_would_fold_into_the_pulse_is_removed() {
        // At 20 MHz output, 15 MHz folds onto 5 MHz. The transition ends near 1.25 of the cut-off
        // (16 lobes); Kaiser's β = 5.9 promises about 60 dB beyond.
        for fs in [40e6, 100e6] {
            let filter = Interpolator::new(fs, 20e6, F0).unwrap();
            let mut record = [0.0f32; 512];
            for (k, value) in record.iter_mut().enumerate() {
                *value = libm::cos(2.0 * PI * 15e6 * k as f64 / fs) as f32;
            }
            for phase in 0..97 {
                let value = filter.at(&record, 256, phase as f32 / 97.0);
                assert!(libm::fabsf(value) < 1e-3, "{fs} at {phase}/97: {value}");
            }
        }
    }

    #[test]
    fn a_whole_position_returns_the_sample() {
        let filter = Interpolator::new(40e6, 40e6, F0).unwrap();
        let record: [f32; 40] = core::array::from_fn(|k| ((k * 37) % 11) as f32 - 5.0);
        for k in 0..40 {
            // The sinc's zeros are zero to the rounding of π in f64.
            assert!(libm::fabsf(filter.at(&record, k as i32, 0.0) - record[k]) < 1e-6);
        }
    }

    #[test]
    fn outside_the_record_is_zero() {
        let filter = Interpolator::new(40e6, 20e6, F0).unwrap();
        for whole in [i32::MIN, -1000, 1000, i32::MAX] {
            assert_eq!(filter.at(&[1.0; 20], whole, 0.5), 0.0);
        }
        // At the edge: as if zeros surrounded the record.
        let mut wide = [0.0; 120];
        wide[50..70].fill(1.0);
        for whole in -20..40 {
            let inside = filter.at(&[1.0; 20], whole, 0.3);
            assert_eq!(inside, filter.at(&wide, whole + 50, 0.3));
        }
    }

    #[test]
    fn every_ratio_fits_the_table() {
        for tenth in 1..=160 {
            let ratio = f64::from(tenth) / 10.0;
            let filter = Interpolator::new(ratio * 20e6, 20e6, F0).unwrap();
            // A constant is returned to the ripple of the filter, well under 1 %.
            let value = filter.at(&[1.0; 512], 256, 0.999_999_94);
            assert!(libm::fabsf(value - 1.0) < 0.01, "{ratio}: {value}");
        }
    }

    #[test]
    fn bad_rates_are_named() {
        let name = |fs, fout, f0| match Interpolator::new(fs, fout, f0) {
            Err(Error::Parameter { name, .. }) => name,
            other => panic!("{other:?}"),
        };
        assert_eq!(name(0.0, 20e6, F0), "sampling_rate");
        assert_eq!(name(f64::NAN, 20e6, F0), "sampling_rate");
        assert_eq!(name(40e6, -1.0, F0), "output_rate");
        assert_eq!(name(340e6, 20e6, F0), "output_rate");
        assert_eq!(name(f64::MAX, f64::MIN_POSITIVE, F0), "output_rate");
        assert_eq!(name(40e6, 20e6, f64::INFINITY), "centre_frequency");
    }
}
