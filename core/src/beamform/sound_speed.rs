//! Sound speed from the coherence of echoes that are aligned at trial speeds.
//!
//! At the right speed the echoes of all elements agree. R. Mallart and M. Fink, Adaptive focusing in scattering media
//! through sound-speed inhomogeneities, J. Acoust. Soc. Am. 96, 3721–3732, 1994, have the coherence factor as the
//! measure of focusing.

use super::AlignedLine;
use super::coherence::{active_of, check_active};
use crate::Error;
use crate::error::{attempt, finite, positive};
use crate::geometry::Active;

/// Groups of lines, whose scatter gives the estimate's deviation.
pub const GROUPS: usize = 8;

/// Coherence of lines at `N` trial speeds, evenly spaced.
///
/// A scanner aligns a few lines at each of the speeds, one line of a frame after the other, and keeps its own speed
/// meanwhile. Depths are given by their [two-way time](crate::geometry::Depth::Seconds), so that each trial has the
/// same echoes; [`Delay::set`](crate::delay::Delay::set) changes the speed of a stage in place, and keeps its filters.
/// Seven trials 40 m/s apart are tested.
///
/// RAM: `4·N·8` bytes and two numbers. Cost: `8·M + 4` flops a sample with `M` active elements, beside its alignment.
/// It is the mean speed between array and echoes. The waves should be compounded ones, of single elements or plane:
/// above its focus a focused beam is wide, and echoes from beside the line raised the speed by 20 to 35 m/s in simulations. Tissue that
/// delays elements unevenly widens the peak and moves it.
///
/// ```
/// use bonebeam::prelude::stages::*;
/// use bonebeam::beamform::SpeedTrials;
///
/// // An echo from 20 mm at 1500 m/s, on 32 elements; 4 MHz.
/// let aligned_at = |speed: f64| {
///     let mut x = [Complex::new(0.0, 0.0); 32];
///     for (m, x) in x.iter_mut().enumerate() {
///         let side = 0.3e-3 * (m as f64 - 15.5);
///         let way = |c: f64| f64::hypot(20e-3 / 1500.0 * c, side) / c;
///         let phase = core::f64::consts::TAU * 4e6 * (way(speed) - way(1500.0));
///         *x = Complex::new(phase.cos() as f32, phase.sin() as f32);
///     }
///     x
/// };
/// let mut trials = SpeedTrials::<5>::new(1440.0, 40.0)?;
/// for trial in 0..5 {
///     let x = aligned_at(trials.speed(trial));
///     let all = |_| Active { first: 0, count: 32 };
///     trials.add(0, trial, AlignedLine::new(&x, 32)?, all, 16)?;
/// }
/// let found = trials.estimate().expect("a peak");
/// assert!((found.speed - 1500.0).abs() < 1.0);
/// # Ok::<(), bonebeam::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SpeedTrials<const N: usize> {
    first: f64,
    step: f64,
    /// Sums of squared coherence factors, `[group][trial]`.
    sums: [[f32; N]; GROUPS],
}

/// An estimated sound speed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SoundSpeed {
    /// The speed, m/s.
    pub speed: f64,
    /// Its standard deviation by the scatter of the groups, m/s.
    ///
    /// Infinite with a single group.
    pub deviation: f64,
}

impl<const N: usize> SpeedTrials<N> {
    /// No echoes yet, at the speeds `first + k·step`, m/s.
    ///
    /// # Errors
    /// [`Error::Parameter`] for fewer than three trials, a speed or step of 0 or less, or one that is not finite.
    pub const fn new(first: f64, step: f64) -> Result<Self, Error> {
        if N < 3 {
            return Err(Error::parameter("trials", N as f64, "at least three"));
        }
        attempt!(positive("first", first));
        attempt!(positive("step", step));
        let trials = SpeedTrials {
            first,
            step,
            sums: [[0.0; N]; GROUPS],
        };
        attempt!(finite("last", trials.speed(N)));
        Ok(trials)
    }

    /// The speed of a trial, m/s.
    pub const fn speed(&self, trial: usize) -> f64 {
        self.first + trial as f64 * self.step
    }

    /// The squared coherence factors of all lines at a trial, added up.
    ///
    /// 0 for a trial that is not one.
    pub fn coherence(&self, trial: usize) -> f64 {
        self.without(GROUPS, trial)
    }

    /// The same without a group.
    fn without(&self, group: usize, trial: usize) -> f64 {
        let kept = (0..).zip(&self.sums).filter(|(own, _)| *own != group);
        kept.fold(0.0, |sum, (_, sums)| {
            sum + f64::from(sums.get(trial).copied().unwrap_or(0.0))
        })
    }

    /// Adds a line that is aligned at the speed of a trial.
    ///
    /// Lines side by side belong to one `group`, counted round from 0. Each line is added to all trials, with the same
    /// active sets and `block`: the samples whose powers are added for a coherence factor
    /// `Σ|Σ x_m|²/Σ M·Σ|x_m|²`, two wavelengths or so. Sums are in ascending order of elements, samples and blocks.
    ///
    /// # Errors
    /// [`Error::Parameter`] for a trial that is not one, a block of 0 samples, or an active set beyond the line's
    /// elements.
    pub fn add(
        &mut self,
        group: usize,
        trial: usize,
        line: AlignedLine<'_>,
        active: impl Fn(usize) -> Active,
        block: usize,
    ) -> Result<(), Error> {
        if block == 0 {
            return Err(Error::parameter("block", 0.0, "at least one sample"));
        }
        check_active(line, &active)?;
        let sums = self.sums.get_mut(group % GROUPS);
        let Some(sum) = sums.and_then(|sums| sums.get_mut(trial)) else {
            return Err(Error::parameter("trial", trial as f64, "one of the trials"));
        };
        let mut first = 0;
        while first < line.samples() {
            let end = first.saturating_add(block).min(line.samples());
            let factor = coherence_factor(line, &active, first..end);
            *sum += factor * factor;
            first = end;
        }
        Ok(())
    }

    /// The speed at the peak of the coherence, by a parabola over three trials.
    ///
    /// `None` without echoes, if the peak is not between the trials, or if its deviation is more than their step.
    pub fn estimate(&self) -> Option<SoundSpeed> {
        let mut best = 0;
        for trial in 1..N {
            if self.coherence(trial) > self.coherence(best) {
                best = trial;
            }
        }
        if best == 0 || best + 1 >= N {
            return None;
        }
        // In steps from the best trial.
        let peak = |left_out: usize| {
            let of = |trial| self.without(left_out, trial);
            let [before, at, after] = [of(best - 1), of(best), of(best + 1)];
            let bend = before - 2.0 * at + after;
            (bend < 0.0).then(|| 0.5 * (before - after) / bend)
        };
        let offset = peak(GROUPS)?;
        let (mut count, mut squares) = (0.0, 0.0);
        for (group, sums) in self.sums.iter().enumerate() {
            if sums.iter().any(|&sum| sum > 0.0) {
                let off = peak(group).unwrap_or(offset) - offset;
                (count, squares) = (count + 1.0, squares + off * off);
            }
        }
        // The jackknife's variance.
        let deviation = match count > 1.0 {
            true => self.step * libm::sqrt(squares * (count - 1.0) / count),
            false => f64::INFINITY,
        };
        let is_sure = count <= 1.0 || deviation <= self.step;
        is_sure.then(|| SoundSpeed {
            speed: self.speed(best) + offset * self.step,
            deviation,
        })
    }
}

/// The coherence factor of some samples, 0 to 1; 0 without power.
fn coherence_factor(
    line: AlignedLine<'_>,
    active: impl Fn(usize) -> Active,
    samples: core::ops::Range<usize>,
) -> f32 {
    let [mut coherent, mut all] = [0.0; 2];
    for sample in samples {
        let set = active(sample);
        let (mut re, mut im, mut power) = (0.0, 0.0, 0.0);
        for x in active_of(line, sample, set) {
            let x = x * line.scale();
            re += x.re;
            im += x.im;
            power += x.norm_sqr();
        }
        coherent += re * re + im * im;
        all += set.count as f32 * power;
    }
    if all > 0.0 { coherent / all } else { 0.0 }
}
