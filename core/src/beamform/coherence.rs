//! Short-lag coherence of a line.
//!
//! It tells echoes of tissue from clutter and noise.

use super::aligned_line::AlignedLine;
use crate::Error;
use crate::error::check_length;
use crate::geometry::{Active, Axis};
use crate::memory::{Need, Scratch};
use num_complex::Complex;

/// Short-lag coherence of each sample of a line, from −1 to 1.
///
/// It is `Σ Re(x_i·x̄_j)/Σ ½(|x_i|² + |x_j|²)` over pairs of active elements and the time window: each fourth active
/// element `i` with the next four, `j = i + 1` to `i + 4`. Equal echoes on all elements give 1, independent noise
/// about 0, and silence or a single element 0. A factor common to all samples has no effect.
///
/// After Lediju et al., *Short-lag spatial coherence of backscattered echoes* (2011), with one normalisation for all
/// pairs.
///
/// ```
/// use bonebeam::prelude::stages::*;
///
/// // Three samples of eight elements: an echo, its sign changing along the array, nothing.
/// let mut x = [Complex::new(0.0, 0.0); 24];
/// x[..8].fill(Complex::new(0.5, -2.0));
/// for (m, x) in x[8..16].iter_mut().enumerate() {
///     *x = Complex::new(if m % 4 < 2 { 1.0 } else { -1.0 }, 0.0);
/// }
/// let line = AlignedLine::new(&x, 8)?;
/// let all = |_| Active { first: 0, count: 8 };
///
/// let coherence = ShortLagCoherence { temporal_half_window: 0 };
/// let mut real = vec![0.0; coherence.need().real];
/// let mut out = [0.0; 3];
/// coherence.line(line, all, Scratch { real: &mut real, complex: &mut [] }, &mut out)?;
/// assert_eq!(out, [1.0, -1.0 / 7.0, 0.0]);
/// # Ok::<(), bonebeam::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShortLagCoherence {
    /// `K`: the time window of sample `n` is `n−K..=n+K`, clamped to the line.
    pub temporal_half_window: usize,
}

/// Distance of the elements that begin pairs.
const EVERY: usize = 4;
/// Largest lag of a pair, elements.
const LAGS: usize = 4;

/// Sums over a sample's pairs: the products' real parts, and both powers.
pub type CoherenceSums = [f32; 2];

impl ShortLagCoherence {
    /// The time window that reaches `half_window` m of depth to both sides.
    ///
    /// The window is shorter than lines of these `samples`. A length below 0 counts as 0.
    ///
    /// ```
    /// use bonebeam::prelude::stages::*;
    ///
    /// let samples = Axis { first: 0.0, step: 0.0385e-3, count: 1024 };
    /// assert_eq!(ShortLagCoherence::over(0.4e-3, &samples).temporal_half_window, 10);
    /// ```
    pub const fn over(half_window: f64, samples: &Axis) -> Self {
        // The cast truncates and saturates.
        let half_window = (half_window / samples.step + 0.5) as usize;
        let longest = samples.count.saturating_sub(1);
        ShortLagCoherence {
            temporal_half_window: if half_window < longest {
                half_window
            } else {
                longest
            },
        }
    }

    /// Memory of [`ShortLagCoherence::line`]: `2·(2K + 1)` real numbers.
    pub const fn need(&self) -> Need {
        let window = self.temporal_half_window.saturating_mul(2);
        Need::real(window.saturating_add(1).saturating_mul(2))
    }

    /// The coherence of every sample of a whole line, with the active sets `active(n)`.
    ///
    /// A depth step has no effect. Each sample has the pairs of its own active set. `active` is called twice for
    /// each sample: the whole line is checked before any output. Sums are at the line's working scale, in ascending
    /// order of elements, lags and samples.
    ///
    /// Cost: `8·M + 4·K` flops a sample with `M` active elements.
    ///
    /// # Errors
    /// [`Error::Length`] unless `coherence` has a number for each sample, or if `scratch` is shorter than
    /// [`ShortLagCoherence::need`]. [`Error::Parameter`] for a time window longer than the line, an active set beyond its
    /// elements, or a block of a line.
    pub fn line(
        &self,
        line: AlignedLine<'_>,
        active: impl Fn(usize) -> Active,
        scratch: Scratch<'_>,
        coherence: &mut [f32],
    ) -> Result<(), Error> {
        self.check(line, &active)?;
        check_length("coherence", coherence.len(), line.samples())?;
        scratch.check(self.need())?;
        let mut samples = CoherenceOfLine::new(*self, scratch.real);
        let mut out = coherence.iter_mut();
        samples.block(line, active, |value| {
            if let Some(out) = out.next() {
                *out = value;
            }
        });
        Ok(())
    }

    /// The sums of a line's samples from `first` on, which have one active set.
    ///
    /// For lines that come in blocks, in any order. A sample that the block does not have is silence.
    pub fn sums(line: AlignedLine<'_>, first: usize, active: Active, out: &mut [CoherenceSums]) {
        for (sample, out) in (first..).zip(out) {
            *out = sums(active_of(line, sample, active), line.scale());
        }
    }

    /// The coherence of a whole line from the sums of its samples.
    ///
    /// It has the bits of [`ShortLagCoherence::line`]. Both have a number for each sample.
    pub fn of_sums(&self, line: &[CoherenceSums], coherence: &mut [f32]) {
        for (sample, out) in coherence.iter_mut().enumerate() {
            let end = sample
                .saturating_add(self.temporal_half_window)
                .saturating_add(1);
            let first = sample.saturating_sub(self.temporal_half_window);
            let window = line.get(first..end.min(line.len()));
            *out = ratio(window.unwrap_or_default().iter());
        }
    }

    /// Refuses a time window longer than a line of `samples`.
    pub(crate) fn check_window(&self, samples: usize) -> Result<(), Error> {
        if self.temporal_half_window < samples {
            return Ok(());
        }
        let expected = "fewer than the line's samples";
        let value = self.temporal_half_window as f64;
        Err(Error::parameter("temporal_half_window", value, expected))
    }

    fn check(&self, line: AlignedLine<'_>, active: impl Fn(usize) -> Active) -> Result<(), Error> {
        let samples = line.samples();
        if !line.holds(0..samples) {
            return Err(Error::parameter("samples", samples as f64, "a whole line"));
        }
        self.check_window(samples)?;
        check_active(line, active)
    }
}

/// The coherence of a line whose aligned samples come in blocks.
pub(crate) struct CoherenceOfLine<'m> {
    half_window: usize,
    /// The sums of the last samples, as many as the time window.
    window: &'m mut [CoherenceSums],
    /// Place of the oldest, which the next one replaces.
    oldest: usize,
    /// The next sample of the line.
    next: usize,
}

impl<'m> CoherenceOfLine<'m> {
    /// The beginning of a line, with memory of [`ShortLagCoherence::need`].
    pub(crate) fn new(coherence: ShortLagCoherence, memory: &'m mut [f32]) -> Self {
        let window = memory.get_mut(..coherence.need().real).unwrap_or_default();
        let (window, _) = window.as_chunks_mut::<2>();
        // Samples outside the line count as silence.
        window.fill([0.0; 2]);
        CoherenceOfLine {
            half_window: coherence.temporal_half_window,
            window,
            oldest: 0,
            next: 0,
        }
    }

    /// Takes the samples of `line` that have not come yet.
    ///
    /// `put` gets the next values of the line, up to half a window before the block's end. The last block completes
    /// the line.
    #[inline(always)]
    pub(crate) fn block(
        &mut self,
        line: AlignedLine<'_>,
        active: impl Fn(usize) -> Active,
        mut put: impl FnMut(f32),
    ) {
        let behind = match line.end() < line.samples() {
            true => 0,
            false => self.half_window,
        };
        for sample in self.next..line.end().saturating_add(behind) {
            let set = match sample < line.samples() {
                true => active(sample),
                false => Active::new(0, 0),
            };
            let value = self.push(line, sample, set);
            if sample >= self.half_window {
                put(value);
            }
        }
        self.next = line.end();
    }

    /// Takes the next sample; returns the coherence of the sample half a window before it.
    ///
    /// A separate function: one copy for all kinds of lines.
    #[inline(never)]
    fn push(&mut self, line: AlignedLine<'_>, sample: usize, active: Active) -> f32 {
        if let Some(place) = self.window.get_mut(self.oldest) {
            *place = sums(active_of(line, sample, active), line.scale());
        }
        self.oldest = match self.oldest + 1 {
            next if next < self.window.len() => next,
            _ => 0,
        };
        let (newer, older) = self
            .window
            .split_at_checked(self.oldest)
            .unwrap_or_default();
        ratio(older.iter().chain(newer))
    }
}

/// Refuses active sets beyond a line's elements.
pub(super) fn check_active(
    line: AlignedLine<'_>,
    active: impl Fn(usize) -> Active,
) -> Result<(), Error> {
    let beyond = |set: &Active| set.first.saturating_add(set.count) > line.elements();
    match (0..line.samples()).map(active).find(beyond) {
        Some(Active { first, .. }) => {
            let expected = "an active set within the line's elements";
            Err(Error::parameter("first element", first as f64, expected))
        }
        None => Ok(()),
    }
}

/// The active elements of a sample; none of a sample that is not present.
#[inline(always)]
pub(super) fn active_of(line: AlignedLine<'_>, sample: usize, active: Active) -> &[Complex<f32>] {
    let elements = line.samples_from(sample).get(active.first..);
    let elements = elements.and_then(|elements| elements.get(..active.count));
    elements.unwrap_or_default()
}

/// The sums over the pairs of a sample's active elements.
fn sums(active: &[Complex<f32>], scale: f32) -> CoherenceSums {
    let [mut products, mut powers] = [0.0; 2];
    let mut rest = active;
    while let [x, after @ ..] = rest {
        let x = x * scale;
        let power = x.norm_sqr();
        for y in after.iter().take(LAGS) {
            let y = y * scale;
            products += x.re * y.re + x.im * y.im;
            powers += power + y.norm_sqr();
        }
        rest = after.get(EVERY - 1..).unwrap_or_default();
    }
    [products, powers]
}

/// Twice the products over the powers; 0 without power. Rounding beyond ±1 is clipped.
fn ratio<'s>(window: impl Iterator<Item = &'s CoherenceSums>) -> f32 {
    // Both parts of the ring in turn: fewer instructions than a loop over them.
    let add = |[products, powers]: CoherenceSums, sums: &CoherenceSums| {
        [products + sums[0], powers + sums[1]]
    };
    let [products, powers] = window.fold([0.0; 2], add);
    if powers > 0.0 {
        match (products + products) / powers {
            above if above > 1.0 => 1.0,
            below if below < -1.0 => -1.0,
            ratio => ratio,
        }
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec;
    use std::vec::Vec;

    /// The coherence of a line whose elements are all active.
    fn of(x: &[Complex<f32>], elements: usize, temporal_half_window: usize) -> Vec<f32> {
        let line = AlignedLine::new(x, elements).expect("finite");
        let all = |_| Active::new(0, elements);
        let coherence = ShortLagCoherence {
            temporal_half_window,
        };
        let mut real = vec![f32::NAN; coherence.need().real];
        let mut out = vec![f32::NAN; line.samples()];
        let scratch = Scratch::new(&mut real, &mut []);
        let done = coherence.line(line, all, scratch, &mut out);
        done.map(|()| out).expect("a valid line")
    }

    /// Independent numbers of −1 to 1, with a mean of 0.
    fn noise(count: usize) -> Vec<Complex<f32>> {
        let mut state = 7u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 23) as f32 - 1.0
        };
        (0..count).map(|_| Complex::new(next(), next())).collect()
    }

    #[test]
    fn equal_echoes_are_wholly_coherent_and_opposite_ones_the_reverse() {
        for (elements, window) in [(2, 0), (8, 1), (13, 3), (64, 2)] {
            let echo = noise(20);
            let equal: Vec<_> = echo.iter().flat_map(|&x| vec![x; elements]).collect();
            assert_eq!(of(&equal, elements, window), [1.0; 20]);
        }
        let opposite: Vec<_> = noise(20).iter().flat_map(|&x| [x, -x]).collect();
        assert_eq!(of(&opposite, 2, 1), [-1.0; 20]);
    }

    #[test]
    fn silence_and_single_elements_have_no_coherence() {
        assert_eq!(of(&[Complex::new(0.0, 0.0); 40], 8, 1), [0.0; 5]);
        assert_eq!(of(&noise(5), 1, 0), [0.0; 5]);
    }

    #[test]
    fn a_common_factor_has_no_effect() {
        let mut x = noise(40 * 16);
        for sample in x.chunks_mut(16) {
            sample
                .iter_mut()
                .for_each(|x| *x += Complex::new(0.5, 0.25));
        }
        let times = |factor: Complex<f32>| {
            let scaled: Vec<_> = x.iter().map(|x| x * factor).collect();
            of(&scaled, 16, 2)
        };
        let one = times(Complex::new(1.0, 0.0));
        for power in [1e-30f32, 1e30].map(|x| f32::from_bits(x.to_bits() & 0x7f80_0000)) {
            assert_eq!(times(Complex::new(power, 0.0)), one);
        }
        for (found, expected) in times(Complex::new(-0.3, 1.7)).iter().zip(&one) {
            assert!((found - expected).abs() < 1e-5, "{found}, {expected}");
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let x = noise(24);
        let coherence = ShortLagCoherence {
            temporal_half_window: 1,
        };
        let run = |coherence: ShortLagCoherence, count, real: usize, out: usize, whole: bool| {
            let line = AlignedLine::new(&x, 8).expect("finite");
            let line = if whole {
                line
            } else {
                line.of_line(1, 9).expect("within")
            };
            let (mut real, mut out) = (vec![0.0; real], vec![0.0; out]);
            let scratch = Scratch::new(&mut real, &mut []);
            coherence.line(line, |_| Active::new(1, count), scratch, &mut out)
        };
        assert_eq!(coherence.need(), Need::real(6));
        assert_eq!(run(coherence, 7, 6, 3, true), Ok(()));
        assert!(run(coherence, 8, 6, 3, true).is_err());
        assert!(run(coherence, usize::MAX, 6, 3, true).is_err());
        assert!(run(coherence, 7, 5, 3, true).is_err());
        assert!(run(coherence, 7, 6, 2, true).is_err());
        assert!(run(coherence, 7, 6, 9, false).is_err());
        for temporal_half_window in [3, usize::MAX] {
            let longer = ShortLagCoherence {
                temporal_half_window,
            };
            assert!(run(longer, 7, 100, 3, true).is_err());
        }
    }
}
