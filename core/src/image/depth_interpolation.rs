//! Envelopes at every sample, from lines with a depth step.
//!
//! A beamformed line is narrow-band around the carrier, so every second to fourth sample suffices. The samples are
//! shifted to baseband, `b[k] = z[k]·e^{−j2πf₀t}`, and interpolated by a polyphase filter with one row of taps for each
//! position between two samples of the line:
//!
//! `y[k·step + p] = Σ_t h_p[t]·b[k + t − 3]`, `h_p[t] ∝ sinc(u)·kaiser(u/4, β = 4)`, `u = p/step − t + 3`, `Σ_t h_p[t] = 1`.
//!
//! The first and the last sample continue the baseband beyond the line's ends. The envelope is `|y|`. At a computed
//! sample it is that sample's magnitude, bit for bit.

use super::Pooling;
use super::envelope::{check_signal, envelope, magnitude};
use super::pooling::{pool, pooled_envelope};
use crate::Error;
use crate::error::{check_length, finite};
use crate::geometry::Scan;
use crate::kaiser::Kaiser;
use crate::memory::Need;
use crate::sine::sin;
use core::f32::consts::TAU;
use core::num::NonZeroUsize;
use num_complex::Complex;

/// Taps of a row of the filter.
const TAPS: usize = 8;
/// Samples of a line that a row reads before the one that its outputs follow.
const BEFORE: usize = TAPS / 2 - 1;
/// The window's shape.
const BETA: f64 = 4.0;
/// The largest depth step.
const MOST: usize = 8;
/// Samples from one cosine to the next; between them the phase is a product.
const RESTART: usize = 16;

/// Interpolates lines with a [depth step](crate::beamform::Parameters::depth_step).
///
/// It computes the envelope at every sample from complex samples. For a pulse of 60 % bandwidth and an output rate
/// of four times its frequency, docs/reproduction.md gives the error in grey levels.
///
/// ```
/// use bonebeam::prelude::stages::*;
///
/// // A tone at the carrier, a quarter of a cycle a sample. The line has every second sample.
/// let interpolation = DepthInterpolation::new(9, 2, 0.25)?;
/// let tone = [1.0, -1.0, 1.0, -1.0, 1.0].map(|re| Complex::new(re, 0.0));
/// let mut scratch = [Complex::default(); 12];
/// assert_eq!(interpolation.need(1).complex, scratch.len());
/// let mut envelopes = [0.0; 9];
/// interpolation.envelope(&tone, (1, Pooling::Largest), &mut scratch, &mut envelopes)?;
/// assert!(envelopes.iter().all(|level| (level - 1.0).abs() < 1e-6));
/// # Ok::<(), bonebeam::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthInterpolation {
    samples: usize,
    step: NonZeroUsize,
    /// The carrier's phase from one sample of a line to the next, in 2⁻³² cycles.
    phase_step: u32,
    /// `e^{−jφ}` of that phase.
    factor: Complex<f32>,
    /// A row for each sample between two of a line.
    rows: [[f32; TAPS]; MOST - 1],
    /// `e^{jφ}` of the carrier from a sample of the line to each of these.
    between: [Complex<f32>; MOST - 1],
}

impl DepthInterpolation {
    /// Computes the filters for lines of every `depth_step`-th of `samples` samples.
    ///
    /// `cycles` is the carrier's number of cycles between two of the `samples`: centre frequency over output rate.
    ///
    /// Cost: eight sines and windows in f64 for each sample between two of a line, once.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a depth step outside 1 to 8, and for cycles that are not finite.
    pub const fn new(samples: usize, depth_step: usize, cycles: f64) -> Result<Self, Error> {
        let Some(step) = checked(depth_step) else {
            return Err(Error::parameter("depth_step", depth_step as f64, "1 to 8"));
        };
        if let Err(error) = finite("cycles of the carrier", cycles) {
            return Err(error);
        }
        let mut rows = [[0.0; TAPS]; MOST - 1];
        let mut between = [Complex::new(1.0, 0.0); MOST - 1];
        let mut k = 1;
        while k < depth_step {
            rows[k - 1] = row(k as f64 / depth_step as f64);
            between[k - 1] = phasor(fraction(cycles * k as f64));
            k += 1;
        }
        // Every sample needs no carrier.
        let part = match depth_step {
            1 => 0.0,
            _ => fraction(cycles * depth_step as f64),
        };
        let phase_step = (part * 4_294_967_296.0 + 0.5) as u64 as u32;
        let forward = match depth_step {
            1 => Complex::new(1.0, 0.0),
            _ => phasor(part),
        };
        Ok(DepthInterpolation {
            samples,
            step,
            phase_step,
            factor: Complex::new(forward.re, -forward.im),
            rows,
            between,
        })
    }

    /// Computes the filters for the lines of a scan.
    ///
    /// # Errors
    /// As [`DepthInterpolation::new`].
    pub const fn of(scan: &Scan<'_>, depth_step: usize) -> Result<Self, Error> {
        let p = scan.parameters();
        Self::new(
            scan.samples(),
            depth_step,
            p.centre_frequency / p.output_rate,
        )
    }

    /// The depth step.
    pub const fn depth_step(&self) -> usize {
        self.step.get()
    }

    /// Number of envelopes of a line.
    pub const fn samples(&self) -> usize {
        self.samples
    }

    /// Number of a line's complex samples.
    pub const fn line_samples(&self) -> usize {
        self.samples.div_ceil(self.step.get())
    }

    /// Scratch of [`DepthInterpolation::envelope`], complex numbers.
    ///
    /// None for a depth step of 1.
    pub const fn need(&self, sub_lines: usize) -> Need {
        Self::need_of(self.line_samples(), self.step.get(), sub_lines)
    }

    /// [`DepthInterpolation::need`] for lines of `line_samples` complex samples.
    pub(crate) const fn need_of(line_samples: usize, depth_step: usize, sub_lines: usize) -> Need {
        let padded = line_samples.saturating_add(TAPS - 1);
        Need::new(
            0,
            if depth_step == 1 {
                0
            } else {
                padded.saturating_mul(sub_lines)
            },
        )
    }

    /// Computes the envelopes of a line at all samples.
    ///
    /// `z[k·N + i]` is sub-line `i` of `N` at the line's sample `k`. `out` is [`envelope()`] of one sub-line, or
    /// [`pooled_envelope()`] of several interpolated sub-lines, in the unit of `z`.
    ///
    /// `scratch`: [`DepthInterpolation::need`], contents irrelevant.
    ///
    /// Order: phase factors of the baseband from `libm::sincosf` every 16 samples, and products between them; taps
    /// in ascending order from zero.
    ///
    /// Cost per sample and sub-line: 32 flops, a division and a root; per complex sample of the line 12 flops.
    ///
    /// # Errors
    /// [`Error::Length`]; [`Error::NonFinite`] with the index of the first bad number. `out` is then unchanged.
    pub fn envelope(
        &self,
        z: &[Complex<f32>],
        (sub_lines, pooling): (usize, Pooling),
        scratch: &mut [Complex<f32>],
        out: &mut [f32],
    ) -> Result<(), Error> {
        check_length("envelope output", out.len(), self.samples)?;
        if self.step.get() == 1 {
            return match sub_lines {
                1 => envelope(z, out),
                _ => pooled_envelope(z, sub_lines, pooling, out),
            };
        }
        let samples = self.line_samples();
        check_length("sub-lines", z.len(), samples.saturating_mul(sub_lines))?;
        check_length("scratch", scratch.len(), self.need(sub_lines).complex)?;
        check_signal(z)?;
        self.demodulate(z, sub_lines, scratch);
        let padded = samples + TAPS - 1;
        let of_samples = out.chunks_mut(self.step.get());
        let of_samples = of_samples.zip(z.chunks_exact(sub_lines.max(1)));
        for (k, (out, z)) in of_samples.enumerate() {
            let Some((own, between)) = out.split_first_mut() else {
                return Ok(());
            };
            *own = pool(pooling, z.iter().map(|&z| magnitude(z)));
            let basebands = scratch.chunks_exact(padded);
            let windows = basebands.filter_map(|baseband| baseband.get(k..)?.first_chunk());
            for (out, row) in between.iter_mut().zip(&self.rows) {
                let windows = windows.clone();
                *out = pool(
                    pooling,
                    windows.map(|window| magnitude(filtered(row, window))),
                );
            }
        }
        Ok(())
    }

    /// Interpolates a line `z`, with its carrier, at all samples.
    ///
    /// `out` has the unit of `z`. `scratch`: [`DepthInterpolation::need`] of one sub-line, contents irrelevant. The
    /// magnitude of `out` is [`DepthInterpolation::envelope`], except for rounding.
    ///
    /// Order: that of the envelope; then times the conjugate of the baseband's phase factor at the line's sample, and
    /// times the carrier's factor from that sample on.
    ///
    /// # Errors
    /// As [`DepthInterpolation::envelope`].
    pub fn line(
        &self,
        z: &[Complex<f32>],
        scratch: &mut [Complex<f32>],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        check_length("interpolated line", out.len(), self.samples)?;
        check_length("line", z.len(), self.line_samples())?;
        check_length("scratch", scratch.len(), self.need(1).complex)?;
        check_signal(z)?;
        if self.step.get() == 1 {
            for (out, &z) in out.iter_mut().zip(z) {
                *out = z;
            }
            return Ok(());
        }
        self.demodulate(z, 1, scratch);
        let mut phase = Complex::new(1.0, 0.0);
        for (k, (out, &z)) in out.chunks_mut(self.step.get()).zip(z).enumerate() {
            if k.is_multiple_of(RESTART) {
                phase = self.phase(k);
            }
            let window = scratch.get(k..).and_then(<[_]>::first_chunk);
            let (Some((own, others)), Some(window)) = (out.split_first_mut(), window) else {
                return Ok(());
            };
            *own = z;
            for ((out, row), between) in others.iter_mut().zip(&self.rows).zip(&self.between) {
                *out = filtered(row, window) * phase.conj() * between;
            }
            phase *= self.factor;
        }
        Ok(())
    }

    /// The baseband of each sub-line, one after the other, with its first and last sample repeated.
    fn demodulate(&self, z: &[Complex<f32>], sub_lines: usize, scratch: &mut [Complex<f32>]) {
        let padded = self.line_samples() + TAPS - 1;
        let mut phase = Complex::new(1.0, 0.0);
        for (k, z) in z.chunks_exact(sub_lines.max(1)).enumerate() {
            if k.is_multiple_of(RESTART) {
                phase = self.phase(k);
            }
            for (baseband, &z) in scratch.chunks_exact_mut(padded.max(1)).zip(z) {
                if let Some(baseband) = baseband.get_mut(k + BEFORE) {
                    *baseband = z * phase;
                }
            }
            phase *= self.factor;
        }
        for baseband in scratch.chunks_exact_mut(padded.max(1)) {
            let Some((before, rest)) = baseband.split_at_mut_checked(BEFORE) else {
                return;
            };
            let Some((own, behind)) = rest.split_at_mut_checked(padded + 1 - TAPS) else {
                return;
            };
            if let (Some(&first), Some(&last)) = (own.first(), own.last()) {
                before.fill(first);
                behind.fill(last);
            }
        }
    }

    /// `e^{−jφ}` of the carrier at a sample of the line.
    fn phase(&self, sample: usize) -> Complex<f32> {
        let cycles = self.phase_step.wrapping_mul(sample as u32) as i32;
        // 2⁻³² cycles.
        let angle = cycles as f32 * (TAU / 4_294_967_296.0);
        let (sine, cosine) = libm::sincosf(angle);
        Complex::new(cosine, -sine)
    }
}

const fn checked(depth_step: usize) -> Option<NonZeroUsize> {
    if depth_step > MOST {
        return None;
    }
    NonZeroUsize::new(depth_step)
}

/// Fractional part of a number of cycles. The casts truncate and saturate.
const fn fraction(cycles: f64) -> f64 {
    let part = cycles - cycles as i64 as f64;
    if part < 0.0 { part + 1.0 } else { part }
}

/// `e^{j2πx}` of a part of a cycle.
const fn phasor(part: f64) -> Complex<f32> {
    let angle = 2.0 * core::f64::consts::PI * part;
    let cosine = sin(angle + core::f64::consts::FRAC_PI_2);
    Complex::new(cosine as f32, sin(angle) as f32)
}

/// Taps for the position `part` of the way from one sample to the next.
const fn row(part: f64) -> [f32; TAPS] {
    let window = Kaiser::new(BETA);
    let mut values = [0.0; TAPS];
    let mut sum = 0.0;
    let mut tap = 0;
    while tap < TAPS {
        let from = part + BEFORE as f64 - tap as f64;
        let angle = core::f64::consts::PI * from;
        values[tap] = sin(angle) / angle * window.at(from / (TAPS / 2) as f64);
        sum += values[tap];
        tap += 1;
    }
    let mut row = [0.0; TAPS];
    tap = 0;
    while tap < TAPS {
        row[tap] = (values[tap] / sum) as f32;
        tap += 1;
    }
    row
}

/// The sum of products of taps and samples.
fn filtered(row: &[f32; TAPS], window: &[Complex<f32>; TAPS]) -> Complex<f32> {
    let mut sum = Complex::new(0.0, 0.0);
    for (&tap, &sample) in row.iter().zip(window) {
        sum += sample * tap;
    }
    sum
}

/// Prints the grid, not the filter.
#[cfg(feature = "defmt")]
impl defmt::Format for DepthInterpolation {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(
            f,
            "interpolation of {} samples by depth step {}",
            self.samples,
            self.depth_step()
        );
    }
}
