//! Receive apodization: a window over the active aperture.

use super::aligned_line::AlignedLine;
use super::segment::Segment;
use super::table::{Parameter, choices};
use crate::geometry::DepthStep;
use crate::simd::{ComplexVector, Scalar, Vector};
use core::f32::consts::PI;
use num_complex::Complex;

choices! {
    /// Receive apodization: a window across the active aperture.
    ///
    /// The window is a function of `t` from −1 to 1. [`Method::Das`](super::Method::Das) weights the elements.
    /// Every other method weights its subapertures: `Σ v_l wᴴX̄_l` with the window as `v`, in place of the mean
    /// over `l`. Both divide by the sum of the weights, so that a unit on-axis signal gives 1. Covariance, adaptive
    /// weights and postfilter do not change.
    Apodization {
        /// No apodization: equal weights.
        None, "none", "no apodization";
        /// Hann window `(1 + cos πt)/2`.
        Hann, "hann", "Hann";
        /// Hamming window `0.54 + 0.46·cos πt`.
        Hamming, "hamming", "Hamming";
        /// Tukey window: 1 in the middle, Hann ends over `tukey_taper` of the aperture.
        Tukey, "tukey", "Tukey";
    }
}

impl Apodization {
    /// The window's weight `index` of `count`, 0 to 1, as the beamformers use it.
    ///
    /// It serves transmit weights, too.
    ///
    /// ```
    /// use bonebeam::beamform::Apodization;
    ///
    /// let weights = [0, 1, 2].map(|transmit| Apodization::Hamming.weight(0.5, transmit, 3));
    /// assert!(weights[1] == 1.0 && weights[0] == weights[2] && (weights[0] - 0.31).abs() < 1e-6);
    /// ```
    pub fn weight(self, tukey_taper: f32, index: usize, count: usize) -> f32 {
        match Window::new(self, tukey_taper) {
            Some(window) => window.weight(index, count),
            None => 1.0,
        }
    }
}

/// A window `edge + (1 − edge)·(1 + cos πu)/2`, with `u` from 0 to 1 over the outer share `taper` of the aperture
/// and 0 within.
#[derive(Clone, Copy)]
pub(super) struct Window {
    taper: f32,
    edge: f32,
}

/// Elements whose weights are kept for all samples of a segment.
const BLOCK: usize = 8;

impl Window {
    /// The window of an apodization; `None` for equal weights.
    #[inline(always)]
    pub(super) fn new(apodization: Apodization, tukey_taper: f32) -> Option<Self> {
        let (taper, edge) = match apodization {
            Apodization::None => return None,
            Apodization::Hann => (1.0, 0.0),
            Apodization::Hamming => (1.0, 0.08),
            Apodization::Tukey => (tukey_taper, 0.0),
        };
        Some(Window { taper, edge })
    }

    /// The weight of place `index` of `count`: the window at `t = (2·index + 1 − count)/count`, the middle of the place.
    pub(super) fn weight(&self, index: usize, count: usize) -> f32 {
        let middle = index.saturating_mul(2).saturating_add(1);
        let from_middle = middle.abs_diff(count) as f32 / count as f32;
        // 0 without a taper, whatever its sign.
        let within = from_middle - (1.0 - self.taper);
        if within > 0.0 {
            let u = within / self.taper;
            let u = if u < 1.0 { u } else { 1.0 };
            self.edge + (1.0 - self.edge) * (0.5 + 0.5 * libm::cosf(PI * u))
        } else {
            1.0
        }
    }

    /// The sum of the weights of all places, in ascending order from zero.
    pub(super) fn total(&self, count: usize) -> f32 {
        (0..count).fold(0.0, |sum, index| sum + self.weight(index, count))
    }

    /// The weights of DAS: the window divided by its sum.
    pub(super) fn weights(&self, weights: &mut [Complex<f32>]) {
        let count = weights.len();
        let total = self.total(count);
        for (index, weight) in weights.iter_mut().enumerate() {
            *weight = Complex::new(self.weight(index, count) / total, 0.0);
        }
    }

    /// Apodized DAS of the segment's `count` active elements. Each output is the weighted sum, in ascending order from
    /// zero and at the line's working scale, divided by the sum of the weights.
    ///
    /// Cost: `4·count` flops per sample, and one cosine per element for the whole segment.
    #[inline(never)]
    pub(super) fn das(
        &self,
        segment: &Segment<'_>,
        (count, step): (usize, DepthStep),
        z: &mut [Complex<f32>],
    ) {
        let line: &AlignedLine<'_> = &segment.line;
        let scale = line.scale();
        z.fill(Complex::new(0.0, 0.0));
        for first in (0..count).step_by(BLOCK) {
            let mut weights = [0.0; BLOCK];
            let Some(weights) = weights.get_mut(..(count - first).min(BLOCK)) else {
                return;
            };
            for (k, weight) in weights.iter_mut().enumerate() {
                *weight = self.weight(first + k, count);
            }
            let add = |(z, snapshot): (&mut Complex<f32>, &[Complex<f32>])| {
                let elements = snapshot.get(segment.first_element + first..);
                for (&x, &mut weight) in elements.unwrap_or_default().iter().zip(&mut *weights) {
                    *z += x * scale * weight;
                }
            };
            match step.get() {
                1 => z.iter_mut().zip(segment.all_snapshots()).for_each(add),
                _ => z.iter_mut().zip(segment.snapshots(step)).for_each(add),
            }
        }
        let total = self.total(count);
        for z in z {
            *z = line.unscale(*z / total);
        }
    }

    /// `s[i] = Σ_l v_l·x[l+i]`: the weighted sum of the subapertures' snapshots, in ascending order from zero.
    ///
    /// Cost: `4·P·L` flops and `P` cosines for `P` subapertures of `L` elements.
    #[inline(always)]
    pub(super) fn subaperture_sum<V: Vector>(
        &self,
        zero: V,
        x: &[ComplexVector<V>],
        s: &mut [ComplexVector<V>],
    ) {
        let subapertures = x.len() - s.len() + 1;
        s.fill(ComplexVector::from_real(zero));
        for l in 0..subapertures {
            let weight = zero.splat(self.weight(l, subapertures));
            for (s, &x) in s.iter_mut().zip(x.get(l..).unwrap_or_default()) {
                *s = *s + x.scale(weight);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(apodization: Apodization, taper: f32) -> Window {
        Window::new(apodization, taper).expect("a window")
    }

    /// Four elements are at ±1/4 and ±3/4: `cos π/4` and `cos 3π/4` are `±√½`.
    #[test]
    fn four_elements_have_the_weights_of_the_formulas() {
        let root = core::f32::consts::FRAC_1_SQRT_2;
        let (outer, inner) = ((1.0 - root) / 2.0, (1.0 + root) / 2.0);
        let hamming = |hann: f32| 0.08 + 0.92 * hann;
        for (apodization, taper, expected) in [
            (Apodization::Hann, 0.5, [outer, inner, inner, outer]),
            (
                Apodization::Hamming,
                0.5,
                [outer, inner, inner, outer].map(hamming),
            ),
            // The taper begins at 1/2: ±3/4 is half of it.
            (Apodization::Tukey, 0.5, [0.5, 1.0, 1.0, 0.5]),
            (Apodization::Tukey, 1.0, [outer, inner, inner, outer]),
            (Apodization::Tukey, 0.0, [1.0; 4]),
            (Apodization::Tukey, -0.0, [1.0; 4]),
        ] {
            let window = window(apodization, taper);
            for (index, expected) in expected.into_iter().enumerate() {
                let weight = window.weight(index, 4);
                assert!(
                    (weight - expected).abs() < 2e-7,
                    "{apodization:?} {taper}: {weight}"
                );
            }
            assert!((window.total(4) - expected.iter().sum::<f32>()).abs() < 1e-6);
        }
    }

    /// No active element is left out.
    #[test]
    fn weights_are_symmetric_above_zero_and_at_most_one() {
        for apodization in Apodization::EXAMPLES {
            for count in (1..=400).step_by(crate::step(57)) {
                let Some(window) = Window::new(apodization, 0.3) else {
                    continue;
                };
                for index in 0..count {
                    let weight = window.weight(index, count);
                    assert!(
                        weight > 0.0 && weight <= 1.0,
                        "{apodization:?} {index} {count}"
                    );
                    assert_eq!(weight, window.weight(count - 1 - index, count));
                }
            }
        }
    }
}
