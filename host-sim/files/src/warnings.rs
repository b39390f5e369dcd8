//! Warnings about recordings that are accepted but probably mistaken.

use std::collections::HashMap;

use super::units;
use crate::terminal::digits;
use crate::{ChannelData, Survey, Transmits};

/// A focus beyond this, m, or a steering angle beyond the next, rad, gives a warning.
const FAR_FOCUS: f64 = 1.0;
const STEEP: f64 = 0.7;
/// An array wider than this, m, or with more elements than the next gives a warning.
const WIDE: f64 = 0.15;
const MANY: usize = 1024;

impl ChannelData {
    /// Warnings about input that is accepted but probably a mistake.
    ///
    /// Each is a sentence. The survey is that of the samples.
    pub fn warnings(&self, survey: &Survey) -> Vec<String> {
        let mut warnings = self.key_warnings();
        warnings.extend(self.offset(survey));
        warnings.extend(self.beside(survey));
        warnings.extend(self.silent(survey));
        warnings.extend(self.turned(survey));
        warnings.extend(self.opposite());
        warnings
    }

    /// Warns of RF that changes, but has no sample below 0.
    pub fn offset(&self, survey: &Survey) -> Option<String> {
        let mean = self.samples.mean_if_positive()?;
        if survey.dead().len() == self.element_x.len() {
            return None;
        }
        Some(format!(
            "no sample of the first frame is below 0, and their mean is {}; RF oscillates about 0: subtract the \
             converter's zero",
            digits(mean)
        ))
    }

    /// Those of [`ChannelData::warnings`] that do not depend on the samples' values.
    pub fn key_warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        match &self.transmits {
            Transmits::Focused { focus, .. } => {
                let far = |focus: &&f64| **focus > FAR_FOCUS;
                if let Some(focus) = focus.iter().find(far) {
                    let hint = units::LENGTH.hint(*focus);
                    warnings.push(format!("`tx_focus` is {} m{hint}", digits(*focus)));
                }
            }
            Transmits::Plane { angle } => {
                let steep = |angle: &&f64| angle.abs() > STEEP;
                if let Some(angle) = angle.iter().find(steep) {
                    warnings.push(format!(
                        "`tx_angle` is {} rad, which is {:.0} degrees; perhaps it is in degrees",
                        digits(*angle),
                        angle.to_degrees()
                    ));
                }
            }
            Transmits::VirtualSource { z, .. } => {
                if let Some(z) = z.iter().find(|z| z.abs() > FAR_FOCUS) {
                    let hint = units::LENGTH.hint(*z);
                    warnings.push(format!("`tx_source_z` is {} m{hint}", digits(*z)));
                }
            }
            Transmits::Element { .. } | Transmits::Delays { .. } => {}
        }
        let width = self.element_x[self.element_x.len() - 1] - self.element_x[0];
        let elements = self.element_x.len();
        if width > WIDE || elements > MANY {
            warnings.push(format!(
                "the array has {elements} elements over {} mm; perhaps the axes of the samples are in \
                 another order, or the pitch is wrong",
                digits(1e3 * width)
            ));
        }
        let samples = self.samples.dim().3;
        if samples < elements {
            warnings.push(format!(
                "the records have {samples} samples of {elements} elements; perhaps the axes of the samples are in \
                 another order"
            ));
        }
        warnings
    }

    /// Warns of RF at another multiple of `f0`, as of a harmonic that is received.
    fn beside(&self, survey: &Survey) -> Option<String> {
        let [twice, half] = survey.harmonics(self.f0, self.fs)?;
        let (found, ratio) = if twice > half {
            (2.0, twice)
        } else {
            (0.5, half)
        };
        (ratio > 4.0).then(|| {
            format!(
                "the RF has {} times more power at {} MHz than at `f0`, {} MHz; of a harmonic, `f0` is the received \
                 frequency",
                digits(ratio),
                digits(found * self.f0 / 1e6),
                digits(self.f0 / 1e6)
            )
        })
    }

    /// Warns of transmits that few elements recorded, for adaptive methods.
    pub fn few_receivers(&self, survey: &Survey) -> Option<String> {
        let (most, elements) = (survey.most_receivers, self.element_x.len());
        (most > 0 && 4 * most <= elements).then(|| {
            format!(
                "each transmit was recorded by at most {most} of {elements} elements; adaptive methods need an \
                 aperture in each: take --method das"
            )
        })
    }

    /// Warns of elements that recorded nothing in the first frame.
    fn silent(&self, survey: &Survey) -> Option<String> {
        let dead = survey.dead();
        if dead.len() == self.element_x.len() {
            return Some("every record of the first frame is constant, such as 0".into());
        }
        let first: Vec<String> = dead.iter().take(5).map(usize::to_string).collect();
        let more = if dead.len() > 5 { ", …" } else { "" };
        (!dead.is_empty()).then(|| {
            format!(
                "{} of {} elements recorded nothing but a constant, such as 0: {}{more}",
                dead.len(),
                self.element_x.len(),
                first.join(", ")
            )
        })
    }

    /// Warns of I/Q whose spectrum lies on the other side of the carrier.
    fn turned(&self, survey: &Survey) -> Option<String> {
        let expected = self.f0 - self.samples.f_demod()?;
        let found = survey.mean_frequency(self.fs)?;
        let is_turned = expected.abs() > 0.02 * self.f0
            && (found + expected).abs() < 0.5 * (found - expected).abs();
        is_turned.then(|| {
            format!(
                "the spectrum of the I/Q lies {} Hz from `f_demod`, where `f0` is {} Hz from it; perhaps it is the \
                 conjugate, which --iq-conjugate reverses",
                digits(found.round()),
                digits(expected)
            )
        })
    }

    /// Warns of a wave that was sent again with the opposite sign, as for pulse inversion.
    fn opposite(&self) -> Option<String> {
        let mut firsts = HashMap::new();
        (0..self.t0.len()).find_map(|k| {
            // Text, since the delay of a silent element, NaN, is not equal to itself.
            let wave = format!("{:#?} {}", self.transmits.only(&[k]), self.t0[k]);
            let first = *firsts.entry(wave).or_insert(k);
            (first != k && self.samples.likeness([first, k]) < -0.5).then(|| {
                format!(
                    "transmits {first} and {k} are the same wave with records of opposite sign, as of pulse inversion: \
                     their mean lacks the fundamental; keep one sign, or give the harmonic's frequency as `f0`"
                )
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array3;

    /// Plane-wave data of four elements with the given RF.
    fn data(fs: f64, f0: f64, rf: impl Fn(f64) -> f64) -> ChannelData {
        let rf = Array3::from_shape_fn((1, 4, 1600), |(.., n)| rf(n as f64 / fs) as f32);
        let x = (0..4).map(|m| 0.3e-3 * f64::from(m)).collect();
        let plane = Transmits::Plane { angle: vec![0.0] };
        ChannelData::linear(rf, x, plane, ([fs, f0], 1540.0))
    }

    #[test]
    fn only_a_harmonic_is_warned_of_as_one() {
        let pulse = |t: f64, f: f64| {
            let u = t - 10e-6;
            (-(u * 1.2e6).powi(2)).exp() * (std::f64::consts::TAU * f * u).cos()
        };
        for fs in [24e6, 31.25e6, 62.5e6, 40.3e6] {
            let says = |rf: &dyn Fn(f64) -> f64| {
                let data = data(fs, 5e6, rf);
                data.beside(&data.samples.survey()).is_some()
            };
            for f in [2.4e6, 9.6e6] {
                assert!(says(&|t| 7.0 + pulse(t, f)), "{f} at {fs}");
            }
            assert!(!says(&|_| 7.0), "constant, {fs}");
            assert!(!says(&|t| 1e5 * t), "ramp, {fs}");
            assert!(!says(&|t| 50.0 + pulse(t, 5e6)), "offset, {fs}");
            assert!(!says(&|t| 2e4 * t + pulse(t, 5e6)), "drift, {fs}");
            // Attenuated on the way, as by a centimetre of bone or five of tissue.
            assert!(!says(&|t| pulse(t, 3.9e6)), "downshifted, {fs}");
        }
    }
}
