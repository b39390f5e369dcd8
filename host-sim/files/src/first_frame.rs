//! What the first frame of a recording tells of mistakes.

use ndarray::ArrayView3;

use super::samples::{FrameSamples, Samples};
use super::survey::Survey;

impl Samples {
    /// Makes offset binary RF oscillate about 0; returns the value that was its zero.
    ///
    /// Offset binary has no sample below 0, and a mean within 3 % of 128, 256, …, 2²³ in each frame: half the range of
    /// the converter.
    pub fn centre(&mut self) -> Option<f32> {
        let zero = self.zero_of_offset_binary()?;
        match self {
            Samples::Rf(rf) => rf.mapv_inplace(|sample| sample - zero),
            Samples::Counts(counts) => {
                counts.mapv_inplace(|count| count.wrapping_sub(zero as i32 as i16))
            }
            Samples::Iq { .. } | Samples::Stored(_) => return None,
        }
        Some(zero)
    }

    fn zero_of_offset_binary(&self) -> Option<f32> {
        let mean = self.mean_if_positive()?;
        let zero = 2f64.powi(mean.log2().round() as i32);
        let is_half = (128.0..=8_388_608.0).contains(&zero) && (mean - zero).abs() <= 0.03 * zero;
        is_half.then_some(zero as f32)
    }

    /// What is known of the samples of the first frame.
    pub fn survey(&self) -> Survey {
        let (_, transmits, elements, _) = self.dim();
        let mut survey = Survey::new([transmits, elements]);
        match self.frame(0) {
            Some(FrameSamples::Rf(rf)) => rf.outer_iter().for_each(|rf| survey.add_rf(rf)),
            Some(FrameSamples::Counts(rf)) => rf.outer_iter().for_each(|rf| survey.add_rf(rf)),
            Some(FrameSamples::Iq { iq, .. }) => iq.outer_iter().for_each(|iq| survey.add_iq(iq)),
            Some(FrameSamples::Stored(stored)) => return stored.survey.clone(),
            None => {}
        }
        survey
    }

    /// Correlation of two transmits' records in the first frame, −1 to 1.
    ///
    /// NaN of silent ones, and of those that cannot be read.
    pub(super) fn likeness(&self, [a, b]: [usize; 2]) -> f64 {
        fn of<T: Copy>(
            a: ArrayView3<'_, T>,
            b: ArrayView3<'_, T>,
            parts: impl Fn(T) -> [f64; 2],
        ) -> f64 {
            let sum = |a: ArrayView3<'_, T>, b: ArrayView3<'_, T>| -> f64 {
                let pairs = a.into_iter().zip(b).map(|(a, b)| (parts(*a), parts(*b)));
                pairs.map(|(a, b)| a[0] * b[0] + a[1] * b[1]).sum()
            };
            sum(a, b) / (sum(a, a) * sum(b, b)).sqrt()
        }
        let of_two = |a: FrameSamples<'_>, b: FrameSamples<'_>| match (a, b) {
            (FrameSamples::Rf(a), FrameSamples::Rf(b)) => of(a, b, |x| [x.into(), 0.0]),
            (FrameSamples::Counts(a), FrameSamples::Counts(b)) => of(a, b, |x| [x.into(), 0.0]),
            (FrameSamples::Iq { iq: a, .. }, FrameSamples::Iq { iq: b, .. }) => {
                of(a, b, |z| [z.re.into(), z.im.into()])
            }
            _ => f64::NAN,
        };
        let Some(frame) = self.frame(0) else {
            return f64::NAN;
        };
        let both = frame.with_transmit(a, |a| frame.with_transmit(b, |b| of_two(a, b)));
        both.and_then(|both| both).unwrap_or(f64::NAN)
    }

    /// The mean of the first frame of RF if no sample is below 0, and they deviate by less than half of it.
    ///
    /// A frame is left in its file only if a sample is below 0.
    pub(super) fn mean_if_positive(&self) -> Option<f64> {
        fn mean<T: Copy + Into<f64>>(frame: ArrayView3<'_, T>) -> Option<f64> {
            let (mut sum, mut squares) = (0.0, 0.0);
            for &sample in frame {
                let sample = sample.into();
                if sample < 0.0 {
                    return None;
                }
                sum += sample;
                squares += sample * sample;
            }
            let count = frame.len() as f64;
            (squares * count < 1.25 * sum * sum).then_some(sum / count)
        }
        let mean = match self.frame(0)? {
            FrameSamples::Rf(rf) => mean(rf),
            FrameSamples::Counts(counts) => mean(counts),
            FrameSamples::Iq { .. } | FrameSamples::Stored(_) => None,
        };
        mean.filter(|&mean| mean > 0.0)
    }
}
