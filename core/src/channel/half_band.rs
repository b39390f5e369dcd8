//! Halving the rate of a record: an FIR half-band low-pass filter.
//!
//! `y[j] = x[2j]/2 + Σ_i h_i·(x[2j−2i−1] + x[2j+2i+1])`, six taps h_i ∝ sin(πk/2)/(πk)·kaiser(k/12,
//! β = 8), k = 2i+1, that add up to 1/4: a halved sample costs 7 products for 23 taps, since every
//! other tap of a half-band filter is zero. What lies below a tenth of the record's rate is kept,
//! and what would fold onto that is removed, both to 10⁻⁴; below an eighth, to 10⁻³. Halved are
//! records sampled at four times the output rate or more, of which half the output rate is an eighth
//! at most (a tenth for the paper's 100 → 20 MHz).

use super::{kaiser, load};
use crate::vector::Vector;

/// Non-zero taps on one side.
const TAPS: usize = 6;
const BETA: f64 = 8.0;
/// Samples in front of sample 0 of a halved record. The filter reaches 11 samples of what it
/// halves, so ⌈(m + 11)/2⌉ where that has m in front: 6, 9, 10, 11, 11 … after each halving.
pub(super) const MARGIN: usize = 12;
/// Outputs a step, at least: a later step reads from 2·first − 24 on, when all in front of first has
/// been written.
pub(super) const MIN_STEP: usize = 24;
/// What a step's pairs of samples exceed its outputs by.
const OVERLAP: usize = 2 * TAPS - 1;

/// The half-band filter.
#[derive(Clone, Debug)]
pub(super) struct HalfBand {
    taps: [f32; TAPS],
}

impl HalfBand {
    pub(super) fn new() -> Self {
        let mut taps = [0.0; TAPS];
        let mut sum = 0.0;
        for (i, tap) in taps.iter_mut().enumerate() {
            let k = (2 * i + 1) as f64;
            let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
            let window = kaiser::window(k / (2 * TAPS) as f64, BETA);
            *tap = sign / (core::f64::consts::PI * k) * window;
            sum += *tap;
        }
        HalfBand {
            taps: taps.map(|tap| (0.25 * tap / sum) as f32),
        }
    }

    /// Halves `record`, of which nothing lies in front of sample 0, into `halved`, whose sample 0
    /// is [`MARGIN`]; returns how many of `halved` are used. Outside, both are 0. `pairs` has
    /// [`pairs_len`] values, of [`MIN_STEP`] outputs or more.
    ///
    /// Order, f32: x[2j]/2, then in ascending i, `+ h_i · (earlier + later)`.
    #[inline(always)]
    pub(super) fn halve<V: Vector>(
        &self,
        zero: V,
        record: &[f32],
        halved: &mut [f32],
        pairs: &mut [f32],
    ) -> usize {
        let (even, odd) = pairs.split_at_mut(pairs.len() / 2);
        let length = halved_len(record.len());
        for (step, y) in halved[..length]
            .chunks_mut(even.len() - OVERLAP)
            .enumerate()
        {
            split(record, 0, step * (even.len() - OVERLAP), even, odd);
            self.step(zero, even, odd, y);
        }
        length
    }

    /// Halves the first `length` samples of `halved` once more, in place: each step's outputs lie in
    /// front of all that later ones read.
    #[inline(always)]
    pub(super) fn halve_again<V: Vector>(
        &self,
        zero: V,
        halved: &mut [f32],
        length: usize,
        pairs: &mut [f32],
    ) -> usize {
        let (even, odd) = pairs.split_at_mut(pairs.len() / 2);
        let again = halved_len(length - MARGIN);
        let outputs = even.len() - OVERLAP;
        for first in (0..again).step_by(outputs) {
            split(&halved[..length], MARGIN, first, even, odd);
            let end = (first + outputs).min(again);
            self.step(zero, even, odd, &mut halved[first..end]);
        }
        again
    }

    /// The outputs of a step.
    #[inline(always)]
    fn step<V: Vector>(&self, zero: V, even: &[f32], odd: &[f32], y: &mut [f32]) {
        let mut at = TAPS;
        let mut vectors = y.chunks_exact_mut(V::LANES);
        for y in &mut vectors {
            y.copy_from_slice(self.vector(zero, even, odd, at).lanes());
            at += V::LANES;
        }
        let rest = vectors.into_remainder();
        if !rest.is_empty() {
            rest.copy_from_slice(&self.vector(zero, even, odd, at).lanes()[..rest.len()]);
        }
    }

    /// A vector of outputs, of which the first has `even[at]` in its middle.
    #[inline(always)]
    fn vector<V: Vector>(&self, zero: V, even: &[f32], odd: &[f32], at: usize) -> V {
        let mut sum = zero.splat(0.5) * load(zero, &even[at..]);
        for (t, &tap) in self.taps.iter().enumerate() {
            let earlier = load(zero, &odd[at - 1 - t..]);
            let later = load(zero, &odd[at + t..]);
            sum = sum + zero.splat(tap) * (earlier + later);
        }
        sum
    }
}

/// The even and the odd samples under the filter for the outputs from the one in `halved[first]`;
/// sample 0 of `record` is `record[origin]`, outside it is 0. The first is 2·TAPS before the
/// output's.
#[inline(always)]
fn split(record: &[f32], origin: usize, first: usize, even: &mut [f32], odd: &mut [f32]) {
    // In pairs from the record's beginning, all even.
    let before = MARGIN + TAPS;
    let from = first + origin / 2;
    let skipped = before.saturating_sub(from).min(even.len());
    let record = record.get(2 * from.saturating_sub(before)..).unwrap_or(&[]);
    let room = even.len() - skipped;
    let inside = &record[..record.len().min(2 * room)];
    let (pairs, last) = inside.as_chunks::<2>();
    if skipped + pairs.len() < even.len() {
        even.fill(0.0);
        odd.fill(0.0);
        if let Some(&last) = last.first() {
            even[skipped + pairs.len()] = last;
        }
    }
    for ((pair, even), odd) in pairs
        .iter()
        .zip(&mut even[skipped..])
        .zip(&mut odd[skipped..])
    {
        *even = pair[0];
        *odd = pair[1];
    }
    if skipped > 0 {
        even[..skipped].fill(0.0);
        odd[..skipped].fill(0.0);
    }
}

/// Values that the samples of a step of `outputs` take, a multiple of the lanes.
pub(super) const fn pairs_len(outputs: usize) -> usize {
    2 * (outputs + OVERLAP)
}

/// The samples of `halved` that any number of halvings of a record of `samples` takes.
pub(super) fn buffer_len(samples: usize) -> usize {
    // Short records grow, up to the margins of both sides.
    halved_len(samples).max(2 * MARGIN)
}

/// How long a record becomes, with the margins, of whose samples `from0` are sample 0 and later.
fn halved_len(from0: usize) -> usize {
    // The last one that the filter reaches: ⌊(from0 − 1 + 11)/2⌋.
    MARGIN + (from0 + 2 * TAPS - 2) / 2 + 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    #[test]
    fn keeps_what_is_low_and_removes_what_would_fold_onto_it() {
        let half_band = HalfBand::new();
        let (mut halved, mut pairs) = ([0.0; 150], [0.0; pairs_len(MIN_STEP)]);
        for fraction in 0..=25 {
            let low = f64::from(fraction) / 200.0;
            let tolerance = if low <= 0.1 { 1e-4 } else { 1e-3 };
            for (frequency, kept) in [(low, 1.0), (0.5 - low, 0.0)] {
                let wave = |k: usize| libm::cos(2.0 * PI * frequency * k as f64 + 0.3);
                let record: [f32; 250] = core::array::from_fn(|k| wave(k) as f32);
                let length = half_band.halve(0.0f32, &record, &mut halved, &mut pairs);
                assert_eq!(length, MARGIN + 131);
                for j in 10..110 {
                    let error = f64::from(halved[MARGIN + j]) - kept * wave(2 * j);
                    assert!(libm::fabs(error) < tolerance, "{frequency} at {j}: {error}");
                }
            }
        }
    }

    #[test]
    fn an_impulse_reaches_into_the_margins_and_short_records_fit() {
        let half_band = HalfBand::new();
        let mut pairs = [0.0; pairs_len(MIN_STEP)];
        for samples in 1..40 {
            let mut halved = [0.0; 60];
            let mut record = [0.0; 40];
            record[samples - 1] = 1.0;
            let record = &record[..samples];
            let halved = &mut halved[..buffer_len(samples)];
            let mut length = half_band.halve(0.0f32, record, halved, &mut pairs);
            for _ in 0..3 {
                // Nothing is lost: a half-band filter halves the sum of what has no high frequencies.
                length = half_band.halve_again(0.0f32, halved, length, &mut pairs);
            }
            let mut sum = 0.0;
            for &y in &halved[..length] {
                sum += y;
            }
            assert!(libm::fabsf(sum - 1.0 / 16.0) < 1e-3, "{samples}: {sum}");
        }
    }
}
