//! Band-limited interpolation and decimation by one tabulated windowed sinc.
//!
//! A value between recorded samples is `Σ_k x[k]·h(t − k)`, with h a Kaiser-windowed sinc. If the recorded rate is
//! above the output rate, its cut-off is a little above half the output rate. Reading at the output instants is
//! then a proper decimation, which keeps noise above the output band from aliasing (white noise falls by fs/output
//! rate, to 5 %). Records sampled at 2.5 times the output rate or more are first decimated (`decimator`) to 1.25 to
//! 2.5 times. The filter spans at least 12.8 output intervals (16 recorded ones if it only interpolates).
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
//! | 100 → 20 MHz | 5·10⁻⁴ | 0.013 |
//!
//! In the last two rows the error is the pulse's own content near and above the output's Nyquist frequency.
//! Decimation must remove it, equally for every element. The error that depends on the sub-sample phase, and so
//! disturbs the beamformer, is 2·10⁻⁵ and 8·10⁻⁵.

mod read;
mod single;

pub(super) use read::{Locator, TapPositions};

use super::decimator::Decimator;
use super::positive;
use crate::Error;
use crate::error::attempt;
use crate::kaiser::Kaiser;
use crate::simd::PARTIAL_SUMS;
use crate::sine::sin;

/// Maximum ratio of recorded to output rate.
pub const MAX_DECIMATION: usize = 16;
/// Maximum number of taps of the filter, in blocks of [`PARTIAL_SUMS`].
///
/// For a record more than [`ONE_BLOCK`] times as fast as the output.
const MAX_BLOCKS: usize = 2;
const ONE_BLOCK: f64 = 1.25;
/// The most taps.
pub(super) const MOST_TAPS: usize = MAX_BLOCKS * PARTIAL_SUMS;
/// Rows of the table per block of taps; between rows the value is interpolated linearly.
const ROWS: usize = 150;
const TABLE: usize = ROWS + MAX_BLOCKS;
/// Cut-off over half the output rate.
///
/// A short filter falls too slowly for the cut-off of a long one.
const CUT_OFF: [f64; MAX_BLOCKS] = [1.08, 1.02];

/// The tabulated filter. Built once; 9.7 KiB.
#[derive(Clone, Debug)]
pub(super) struct Interpolator {
    table: Table,
    /// Taps/16.
    blocks: usize,
    phases: usize,
    decimator: Decimator,
    /// Whether the table was computed in f32.
    single: bool,
}

/// Row-major [phase 0..=phases][tap], aligned to cache lines.
///
/// Row p holds h(k − (taps/2 − 1) − p/phases) at tap k. A register across two cache lines would take two loads.
#[derive(Clone, Debug)]
#[repr(align(64))]
struct Table([[f32; PARTIAL_SUMS]; TABLE]);

/// Cut-off of half the rate, and shape of the window.
struct Design {
    cutoff: f64,
    beta: f64,
}

impl Interpolator {
    /// No filter yet.
    pub(super) const NONE: Interpolator = Interpolator {
        table: Table([[0.0; PARTIAL_SUMS]; TABLE]),
        blocks: 1,
        phases: ROWS,
        decimator: Decimator::new(1.0),
        single: false,
    };

    /// Becomes the filter from `sampling_rate` to `output_rate` for a pulse around `centre_frequency`, Hz.
    ///
    /// With the rate fs of the record, decimated while it is at least 2.5·fout: 16 taps and 150 phases where
    /// fs ≤ 1.25·fout, else 32 and 75; cut-off κ = min(1, q·fout/fs) of fs/2 with q = 1.08, or 1.02 with 32
    /// taps (κ = 1 where fs ≤ fout and it only interpolates), h(u) = κ·sinc(κu)·kaiser(2u/taps, β). β
    /// follows Kaiser's design formula, within 4..10, for a transition from 1.425 f₀ to its mirror image
    /// at the cut-off, or from 1.5 f₀ to its image at fs where it only interpolates:
    /// A = 8 + 2.285·2π·(taps − 1)·(q·fout − 2.85f₀)/fs, or A = 8 + 2.285·2π·15·(fs − 3f₀)/fs;
    /// β = 0.1102·(A − 8.7).
    ///
    /// # Errors
    /// [`Error::Parameter`] unless all three are positive and finite and fs/fout at most
    /// [`MAX_DECIMATION`]; the filter is then as it was.
    pub(super) const fn set(
        &mut self,
        sampling_rate: f64,
        output_rate: f64,
        centre_frequency: f64,
    ) -> Result<(), Error> {
        let Design { cutoff, beta } =
            attempt!(self.design(sampling_rate, output_rate, centre_frequency));
        let taps = self.taps();
        let half = (taps / 2) as f64;
        let window = Kaiser::new(beta);
        let mut row = 0;
        while 2 * row <= self.phases {
            let fraction = row as f64 / self.phases as f64;
            let mut tap = 0;
            while tap < taps {
                let u = tap as f64 - (half - 1.0) - fraction;
                let value = (cutoff * sinc(cutoff * u) * window.at(u / half)) as f32;
                self.put(row, tap, value);
                tap += 1;
            }
            row += 1;
        }
        self.single = false;
        Ok(())
    }

    /// The same filter, computed in f32 in the order of [`single::Filter`].
    ///
    /// Its error is at most 5·10⁻⁷ of the largest tap. Its bits differ, and it takes far fewer instructions if f64 is
    /// in software.
    ///
    /// # Errors
    /// As [`Interpolator::set`].
    pub(super) fn set_in_f32(
        &mut self,
        sampling_rate: f64,
        output_rate: f64,
        centre_frequency: f64,
    ) -> Result<(), Error> {
        let Design { cutoff, beta } = self.design(sampling_rate, output_rate, centre_frequency)?;
        let taps = self.taps();
        let filter = single::Filter::new(cutoff as f32, beta as f32, (taps / 2) as f32);
        let phase = 1.0 / self.phases as f32;
        for row in 0..=self.phases / 2 {
            let fraction = row as f32 * phase;
            for tap in 0..taps {
                let position = tap as f32 - (taps / 2 - 1) as f32;
                self.put(row, tap, filter.at(position - fraction));
            }
        }
        self.single = true;
        Ok(())
    }

    /// Whether the table was computed in f32.
    pub(super) const fn is_single(&self) -> bool {
        self.single
    }

    /// Refuses rates that no filter is made for.
    pub(super) const fn check(
        sampling_rate: f64,
        output_rate: f64,
        centre_frequency: f64,
    ) -> Result<(), Error> {
        attempt!(positive("sampling_rate", sampling_rate));
        attempt!(positive("output_rate", output_rate));
        attempt!(positive("centre_frequency", centre_frequency));
        if sampling_rate / output_rate <= MAX_DECIMATION as f64 {
            return Ok(());
        }
        let expected = "at least a sixteenth of the sampling rate";
        Err(Error::parameter("output_rate", output_rate, expected))
    }

    /// Number of halvings, taps and phases, and their design values.
    const fn design(
        &mut self,
        sampling_rate: f64,
        output_rate: f64,
        centre_frequency: f64,
    ) -> Result<Design, Error> {
        attempt!(Self::check(sampling_rate, output_rate, centre_frequency));
        let ratio = sampling_rate / output_rate;
        self.decimator = Decimator::new(ratio);
        let rate = sampling_rate / (1 << self.decimator.halvings()) as f64;
        let after = rate / output_rate;
        self.blocks = if after > ONE_BLOCK { 2 } else { 1 };
        let (cutoff, clear) = if after > 1.0 {
            let cutoff = CUT_OFF[self.blocks - 1] / after;
            let clear = cutoff - 2.85 * centre_frequency / rate;
            (if cutoff < 1.0 { cutoff } else { 1.0 }, clear)
        } else {
            (1.0, 1.0 - 3.0 * centre_frequency / rate)
        };
        self.phases = ROWS / self.blocks;
        let beta = shape((self.taps() - 1) as f64 * clear);
        Ok(Design { cutoff, beta })
    }

    /// Writes a value and its mirror image: h is even, h(u) and h(−u).
    const fn put(&mut self, row: usize, tap: usize, value: f32) {
        let taps = self.taps();
        self.write(row * taps + tap, value);
        self.write((self.phases - row + 1) * taps - 1 - tap, value);
    }

    const fn write(&mut self, at: usize, value: f32) {
        // `get_mut` is not for constants.
        if let Some((_, [slot, ..])) = self.table.0.as_flattened_mut().split_at_mut_checked(at) {
            *slot = value;
        }
    }

    /// Taps of the filter: a value needs `taps()/2` samples on either side.
    pub(super) const fn taps(&self) -> usize {
        self.blocks * PARTIAL_SUMS
    }

    /// The taps at a fraction (0..1) between two samples, blended as for a read.
    pub(super) fn taps_at(&self, fraction: f32) -> impl Iterator<Item = f32> {
        let scaled = fraction * self.phases as f32;
        let row = (scaled as usize).min(self.phases - 1);
        let weight = scaled - row as f32;
        let mut rows = self.table.0.as_flattened().chunks_exact(self.taps().max(1));
        let here = rows.nth(row).unwrap_or_default();
        let next = rows.next().unwrap_or_default();
        let pairs = here.iter().zip(next);
        pairs.map(move |(here, next)| here + weight * (next - here))
    }

    /// Largest gain for samples of magnitude 1.
    ///
    /// It is that of the largest row, since a value between two rows is no larger than both.
    #[cfg(test)]
    pub(super) fn gain(&self) -> f64 {
        let rows = self.table.0.as_flattened().chunks_exact(self.taps());
        let sum = |row: &[f32]| row.iter().map(|&value| f64::from(value.abs())).sum();
        rows.map(sum).fold(0.0, f64::max)
    }

    /// How often the record is decimated before this filter.
    pub(super) const fn halvings(&self) -> usize {
        self.decimator.halvings()
    }

    /// The filters that decimate it.
    pub(super) fn decimator(&self) -> &Decimator {
        &self.decimator
    }
}

/// β of the Kaiser window for a transition of `transition` sampling rates times intervals.
const fn shape(transition: f64) -> f64 {
    let attenuation = 8.0 + 2.285 * 2.0 * core::f64::consts::PI * transition;
    let beta = 0.1102 * (attenuation - 8.7);
    if beta < 4.0 {
        4.0
    } else if beta > 10.0 {
        10.0
    } else {
        beta
    }
}

const fn sinc(x: f64) -> f64 {
    if x == 0.0 {
        return 1.0;
    }
    let angle = core::f64::consts::PI * x;
    sin(angle) / angle
}

#[cfg(test)]
mod tests;
