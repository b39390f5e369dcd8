//! Decimation by powers of two: half-band FIR filters, and a low-pass one for the last halving.
//!
//! A record 2.5 times as fast as the output, or more, is halved until it is slower than that. Each
//! halving is `y[j] = h_0·x[2j] + Σ_k h_k·(x[2j−k] + x[2j+k])`:
//!
//! - All but the last: a half-band filter, h_0 = 1/2 and h_k ∝ sin(πk/2)/(πk)·kaiser(k/8, β = 8.5)
//!   for k = 1, 3, 5, 7, that add up to 1/4; the other taps are zero. What lies below 0.08 of the
//!   record's rate is kept, and what would fold onto that is removed, both to 1.6·10⁻⁴.
//! - The last: a low-pass filter with its cut-off at 1.04 times half the output rate, so that what
//!   reads its output need not decimate. With q = 1.04·fout/f at the record's rate f:
//!   h_k ∝ sinc(qk)·kaiser(k/(P + 1), β = 6), k = 0..=P, P = ⌈7.2·f/fout⌉, that add up to 1 on both
//!   sides together. What lies below 0.7 of half the output rate is kept to 10⁻³, and what lies
//!   above 1.35 times that is removed to 6·10⁻⁴.
//!
//! Lanes are elements: a row holds a sample of each of them, and filters run along the rows, so
//! that no vector lies across two registers or cache lines. Records stream through, some rows at a
//! time; what a filter reaches back for stays in front of its new rows.

use super::fir::{GROUP, Symmetry, add_pairs, from_row};
use super::kaiser;
use crate::vector::{MOST_LANES, Vector, load, transpose};
use core::ops::Range;

/// Records this many times as fast as the output, or more, are halved.
const HALVED_FROM: f64 = 2.5;
/// How often, at most: from 16 to 2 times the output rate.
const MAX_HALVINGS: usize = 3;
/// Non-zero taps on one side of a half-band filter, how far they reach, the shape of its window.
const HALF_BAND: usize = 4;
const HALF_BAND_REACH: usize = 2 * HALF_BAND - 1;
const HALF_BAND_BETA: f64 = 8.5;
/// Output intervals that the low-pass filter reaches on either side, the shape of its window, and
/// how much higher than half the output rate its cut-off is.
const SPAN: f64 = 7.2;
const LOW_PASS_BETA: f64 = 6.0;
const CUT_OFF: f64 = 1.04;
/// How far the low-pass filter reaches at most: where it halves five times the output rate.
const LOW_PASS_REACH: usize = 36;
/// Samples in front of sample 0 of a halved record: half of what both filters reach.
pub(super) const MARGIN: usize = (HALF_BAND_REACH + LOW_PASS_REACH).div_ceil(2);
/// Samples that come out together.
const CHUNK: usize = 32;

/// The filters of all halvings.
#[derive(Clone, Debug)]
pub(super) struct Decimator {
    halvings: usize,
    half_band: [f32; HALF_BAND_REACH + 1],
    low_pass: [f32; LOW_PASS_REACH + 1],
    low_pass_reach: usize,
}

impl Decimator {
    /// The decimator of records sampled at `ratio` times the output rate, 16 at most.
    pub(super) fn new(ratio: f64) -> Self {
        let mut halvings = 0;
        let (mut before, mut after) = (ratio, ratio);
        while after >= HALVED_FROM {
            before = after;
            after /= 2.0;
            halvings += 1;
        }
        if halvings == 0 {
            before = HALVED_FROM;
        }
        // Below five times, so within the capacity.
        let low_pass_reach = libm::ceil(SPAN * before) as usize;
        Decimator {
            halvings,
            half_band: half_band(),
            low_pass: low_pass(CUT_OFF / before, low_pass_reach),
            low_pass_reach,
        }
    }

    /// How often the rate is halved.
    pub(super) fn halvings(&self) -> usize {
        self.halvings
    }

    /// Samples that a record of `samples` becomes, with [`MARGIN`] in front and all that the filters
    /// reach behind; 0 where it is not halved.
    pub(super) fn halved_len(&self, samples: usize) -> usize {
        let mut length = samples;
        for halving in 0..self.halvings {
            // Up to the last one that the filter reaches: ⌊(length − 1 + reach)/2⌋.
            length = (length - 1 + self.reach(halving)) / 2 + 1;
        }
        if self.halvings == 0 {
            return 0;
        }
        (MARGIN + length).next_multiple_of(CHUNK)
    }

    /// Rows that all halvings take, and what comes out of the last one before it is turned.
    pub(super) fn rows(&self) -> usize {
        let halvings = 0..self.halvings;
        halvings.fold(CHUNK, |rows, halving| rows + self.rows_of(halving))
    }

    /// How far a halving's filter reaches.
    fn reach(&self, halving: usize) -> usize {
        if halving + 1 < self.halvings {
            HALF_BAND_REACH
        } else {
            self.low_pass_reach
        }
    }

    /// Chunks after which all that the filters reach back for has passed: the low-pass filter's rows,
    /// and its first ones, ten at most, that the half-band filters made of too few.
    fn lead(&self) -> usize {
        (2 * self.low_pass_reach + 10).div_ceil(2 * CHUNK)
    }

    /// Rows that come out of a halving together.
    fn outputs(&self, halving: usize) -> usize {
        CHUNK << (self.halvings - 1 - halving)
    }

    /// Rows that a halving's filter lies over.
    fn rows_of(&self, halving: usize) -> usize {
        2 * self.outputs(halving) + 2 * self.reach(halving) - 1
    }

    /// Halves `records` of one length, one a lane, into `halved`, a line of
    /// [`Decimator::halved_len`] each, whose sample 0 is [`MARGIN`]. What is not recorded is 0. What
    /// is not `needed` of the lines may stay as it was. `rows`: [`Decimator::rows`] of them. Records
    /// that are not to be halved are left alone.
    ///
    /// Order, f32: `h_0·x[2j]`, then in ascending k, `+ h_k · (earlier + later)`.
    #[inline(always)]
    pub(super) fn decimate<V: Vector>(
        &self,
        zero: V,
        records: &[&[f32]; MOST_LANES],
        needed: Range<usize>,
        rows: &mut [f32],
        halved: &mut [f32],
    ) {
        if self.halvings == 0 {
            return;
        }
        let (slow, mut rest) = rows.split_at_mut(CHUNK * V::LANES);
        let mut buffers: [&mut [f32]; MAX_HALVINGS] = [&mut [], &mut [], &mut []];
        // In front of the record everything is 0, so filters may begin there on empty rows; elsewhere
        // they must have passed over what they reach back for.
        let begin = (needed.start / CHUNK).saturating_sub(self.lead()) * CHUNK;
        // The first sample, on the rows' axis, of a halving's first outputs, and then of its inputs.
        let mut first = begin as isize - MARGIN as isize;
        for (halving, buffer) in buffers.iter_mut().enumerate().take(self.halvings) {
            (*buffer, rest) = rest.split_at_mut(self.rows_of(halving) * V::LANES);
            buffer.fill(0.0);
        }
        for halving in (0..self.halvings).rev() {
            first = 2 * first + self.reach(halving) as isize - 1;
        }
        let length = self.halved_len(records[0].len());
        for chunk in (begin..needed.end.min(length)).step_by(CHUNK) {
            let new = &mut buffers[0][(2 * self.reach(0) - 1) * V::LANES..];
            gather(zero, records, first, new);
            first += 2 * self.outputs(0) as isize;
            for halving in 0..self.halvings - 1 {
                let (from, to) = buffers.split_at_mut(halving + 1);
                let (from, to) = (&mut *from[halving], &mut *to[0]);
                let new = &mut to[(2 * self.reach(halving + 1) - 1) * V::LANES..];
                filter(zero, from, (HALF_BAND_REACH, 2, &self.half_band), new);
                from.copy_within(2 * self.outputs(halving) * V::LANES.., 0);
            }
            let last = &mut *buffers[self.halvings - 1];
            let reach = self.low_pass_reach;
            filter(zero, last, (reach, 1, &self.low_pass[..=reach]), slow);
            last.copy_within(2 * CHUNK * V::LANES.., 0);
            for (at, block) in slow.chunks_exact(V::LANES * V::LANES).enumerate() {
                let mut square = [zero; MOST_LANES];
                for (samples, row) in square.iter_mut().zip(block.chunks_exact(V::LANES)) {
                    *samples = load(zero, row);
                }
                transpose(&mut square);
                for (line, y) in halved.chunks_exact_mut(length).zip(&square[..V::LANES]) {
                    line[chunk + at * V::LANES..][..V::LANES].copy_from_slice(y.lanes());
                }
            }
        }
    }
}

/// The half-band filter's taps from the middle on.
fn half_band() -> [f32; HALF_BAND_REACH + 1] {
    let mut taps = [0.0; HALF_BAND_REACH + 1];
    let mut sum = 0.0;
    for k in (1..=HALF_BAND_REACH).step_by(2) {
        let sign = if k % 4 == 1 { 1.0 } else { -1.0 };
        let window = kaiser::window(k as f64 / (2 * HALF_BAND) as f64, HALF_BAND_BETA);
        taps[k] = sign / (core::f64::consts::PI * k as f64) * window;
        sum += taps[k];
    }
    let mut taps = taps.map(|tap| (0.25 * tap / sum) as f32);
    taps[0] = 0.5;
    taps
}

/// The low-pass filter's taps from the middle on, `reach` on a side; its cut-off in half the
/// record's rate.
fn low_pass(cut_off: f64, reach: usize) -> [f32; LOW_PASS_REACH + 1] {
    let mut taps = [0.0; LOW_PASS_REACH + 1];
    let mut sum = 0.0;
    for (k, tap) in taps.iter_mut().enumerate().take(reach + 1) {
        let angle = core::f64::consts::PI * (cut_off * k as f64);
        let sinc = if k == 0 {
            1.0
        } else {
            libm::sin(angle) / angle
        };
        *tap = sinc * kaiser::window(k as f64 / (reach + 1) as f64, LOW_PASS_BETA);
        sum += if k == 0 { *tap } else { 2.0 * *tap };
    }
    taps.map(|tap| (tap / sum) as f32)
}

/// Outputs of a filter that reaches `reach`, as many as `outputs` has room for; `rows` begin with the
/// first one under it. Every `step`-th tap is used.
#[inline(always)]
fn filter<V: Vector>(
    zero: V,
    rows: &[f32],
    (reach, step, taps): (usize, usize, &[f32]),
    outputs: &mut [f32],
) {
    for (group, outputs) in outputs.chunks_exact_mut(GROUP * V::LANES).enumerate() {
        let rows = &rows[2 * group * GROUP * V::LANES..];
        let mut sums = [zero; GROUP];
        let middle = from_row::<V, 2>(rows, reach).chunks(2 * V::LANES);
        for (sum, x) in sums.iter_mut().zip(middle) {
            *sum = zero.splat(taps[0]) * load(zero, x);
        }
        let taps = (1..)
            .step_by(step)
            .zip(taps[1..].iter().step_by(step).copied());
        add_pairs::<V, 2>(&mut sums, rows, reach, Symmetry::Even, taps);
        for (output, sum) in outputs.chunks_exact_mut(V::LANES).zip(&sums) {
            output.copy_from_slice(sum.lanes());
        }
    }
}

/// The samples from `first` on, a row each.
#[inline(always)]
fn gather<V: Vector>(zero: V, records: &[&[f32]; MOST_LANES], first: isize, rows: &mut [f32]) {
    if V::LANES == 1 {
        // Nothing to be turned.
        let inside = usize::try_from(first).ok();
        let samples = inside.and_then(|first| records[0].get(first..first + rows.len()));
        if let Some(samples) = samples {
            rows.copy_from_slice(samples);
            return;
        }
    }
    for (block, rows) in rows.chunks_exact_mut(V::LANES * V::LANES).enumerate() {
        let first = first + (block * V::LANES) as isize;
        let mut square = [zero; MOST_LANES];
        for (samples, record) in square.iter_mut().zip(&records[..V::LANES]) {
            *samples = window(zero, record, first);
        }
        transpose(&mut square);
        for (row, samples) in rows.chunks_exact_mut(V::LANES).zip(&square) {
            row.copy_from_slice(samples.lanes());
        }
    }
}

/// The samples from `first` on; what is not there is 0.
#[inline(always)]
fn window<V: Vector>(zero: V, record: &[f32], first: isize) -> V {
    // In front of the record, indices wrap around, to where there is nothing either.
    let first = first as usize;
    match record.get(first..first.wrapping_add(V::LANES)) {
        Some(samples) => load(zero, samples),
        None => load(zero, &at_the_edge(record, first)),
    }
}

#[cold]
#[inline(never)]
fn at_the_edge(record: &[f32], first: usize) -> [f32; MOST_LANES] {
    let sample = |k| record.get(first.wrapping_add(k)).copied();
    core::array::from_fn(|k| sample(k).unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::PI;

    /// A record's samples after the halvings, from sample 0 on, and how many there are.
    fn decimated(decimator: &Decimator, record: &[f32]) -> ([f32; 700], usize) {
        let (mut rows, mut halved) = ([f32::NAN; 700], [f32::NAN; 700]);
        let length = decimator.halved_len(record.len());
        let rows = &mut rows[..decimator.rows()];
        let records = [record; MOST_LANES];
        decimator.decimate(0.0f32, &records, 0..length, rows, &mut halved[..length]);
        halved[..length].rotate_left(MARGIN);
        (halved, length)
    }

    #[test]
    fn keeps_what_is_low_and_removes_what_would_fold_onto_it() {
        for ratio in [2.5, 3.125, 4.0, 4.9, 5.0, 8.0, 12.0, 16.0] {
            let decimator = Decimator::new(ratio);
            let every = 1 << decimator.halvings();
            for part in 1..=40 {
                // In halves of the output rate, up to half the record's.
                let frequency = ratio * f64::from(part) / 40.0;
                let expected = match frequency {
                    f if f <= 0.7 => 1.0,
                    f if f >= 1.35 => 0.0,
                    _ => continue,
                };
                let wave = |k: usize| libm::cos(PI * frequency / ratio * k as f64 + 0.3);
                let record: [f32; 1000] = core::array::from_fn(|k| wave(k) as f32);
                let (halved, _) = decimated(&decimator, &record);
                for j in 36..1000 / every - 36 {
                    let error = f64::from(halved[j]) - expected * wave(every * j);
                    assert!(
                        libm::fabs(error) < 1.2e-3,
                        "{ratio} {frequency} at {j}: {error}"
                    );
                }
            }
        }
    }

    #[test]
    fn halves_down_to_between_1_25_and_2_5_times_the_output_rate() {
        for tenth in 1..=160 {
            let ratio = f64::from(tenth) / 10.0;
            let halvings = Decimator::new(ratio).halvings();
            let after = ratio / (1 << halvings) as f64;
            assert!(
                after < 2.5 && (halvings == 0 || after >= 1.25),
                "{ratio}: {halvings}"
            );
            assert!(halvings <= MAX_HALVINGS);
        }
    }

    #[test]
    fn an_impulse_loses_nothing_at_the_ends_and_short_records_fit() {
        for ratio in [2.5, 4.9, 5.0, 16.0] {
            let decimator = Decimator::new(ratio);
            let every = 1 << decimator.halvings();
            for samples in 1..100 {
                // As many impulses as come to one sample: their sum has no high frequencies.
                let mut record = [0.0; 100 + 8];
                record[samples - 1..][..every].fill(1.0);
                for record in [&record[..samples - 1 + every], &record] {
                    let (halved, length) = decimated(&decimator, record);
                    let mut sum = 0.0;
                    for &y in &halved[..length] {
                        sum += y;
                    }
                    assert!(libm::fabsf(sum - 1.0) < 2e-3, "{ratio} {samples}: {sum}");
                }
            }
        }
    }
}
