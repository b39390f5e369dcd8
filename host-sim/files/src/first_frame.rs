//! What the first frame of a recording tells of mistakes.

use ndarray::{ArrayView1, ArrayView3, Axis};
use num_complex::Complex;

use super::samples::{FrameSamples, Samples, of_any};

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
            Samples::Iq { .. } => return None,
        }
        Some(zero)
    }

    fn zero_of_offset_binary(&self) -> Option<f32> {
        let mean = self.mean_if_positive()?;
        let zero = 2f64.powi(mean.log2().round() as i32);
        let is_half = (128.0..=8_388_608.0).contains(&zero) && (mean - zero).abs() <= 0.03 * zero;
        is_half.then_some(zero as f32)
    }

    /// Correlation of two transmits' records in the first frame, −1 to 1; NaN of silent ones.
    pub(super) fn likeness(&self, transmits: [usize; 2]) -> f64 {
        fn of<T: Copy>(
            frame: ArrayView3<'_, T>,
            [a, b]: [usize; 2],
            parts: impl Fn(T) -> [f64; 2],
        ) -> f64 {
            let sum = |a, b| -> f64 {
                let pairs = frame
                    .index_axis(Axis(0), a)
                    .into_iter()
                    .zip(frame.index_axis(Axis(0), b));
                pairs
                    .map(|(a, b)| {
                        let (a, b) = (parts(*a), parts(*b));
                        a[0] * b[0] + a[1] * b[1]
                    })
                    .sum()
            };
            sum(a, b) / (sum(a, a) * sum(b, b)).sqrt()
        }
        match self.frame(0) {
            Some(FrameSamples::Rf(rf)) => of(rf, transmits, |x| [x.into(), 0.0]),
            Some(FrameSamples::Counts(counts)) => of(counts, transmits, |x| [x.into(), 0.0]),
            Some(FrameSamples::Iq { iq, .. }) => of(iq, transmits, |z| [z.re.into(), z.im.into()]),
            None => f64::NAN,
        }
    }

    /// The mean of the first frame of RF if no sample is below 0, and they deviate by less than half of it.
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
            FrameSamples::Iq { .. } => None,
        };
        mean.filter(|&mean| mean > 0.0)
    }

    /// Power of the first frame of RF at twice and at half a frequency, over that at the frequency itself.
    ///
    /// It is that of Hann windows of eight periods without mean and slope, in at most 64 records. `None` without RF; 0
    /// beyond half the rate, and without a maximum there: the power of an edge falls with the square of the frequency.
    pub(super) fn harmonics(&self, f0: f64, fs: f64) -> Option<[f64; 2]> {
        /// At most 64.
        fn records<'a, T>(frame: &'a ArrayView3<'_, T>) -> impl Iterator<Item = ArrayView1<'a, T>> {
            let step = (frame.dim().0 * frame.dim().1).div_ceil(64).max(1);
            frame.rows().into_iter().step_by(step)
        }
        fn energy<T: Copy + Into<f64>>(frame: &ArrayView3<'_, T>) -> f64 {
            records(frame).flatten().map(|&v| v.into() * v.into()).sum()
        }
        fn power<T: Copy + Into<f64>>(frame: &ArrayView3<'_, T>, carrier: &[Complex<f64>]) -> f64 {
            let mut sum = 0.0;
            for record in records(frame) {
                for part in record.axis_chunks_iter(Axis(0), carrier.len()) {
                    if part.len() < carrier.len() {
                        continue;
                    }
                    let mixed = part
                        .iter()
                        .zip(carrier)
                        .map(|(&sample, carrier)| carrier * sample.into());
                    sum += mixed.sum::<Complex<f64>>().norm_sqr();
                }
            }
            sum
        }
        let frame = self.frame(0)?;
        let window = (8.0 * fs / f0).ceil();
        let power = |f: f64| {
            let turn = std::f64::consts::TAU;
            let hann = |n: f64| 0.5 - 0.5 * (turn * (n + 0.5) / window).cos();
            let mut carrier: Vec<Complex<f64>> = (0..window as usize)
                .map(|n| Complex::from_polar(hann(n as f64), turn * f / fs * n as f64))
                .collect();
            let middle = 0.5 * (window - 1.0);
            let mean = carrier.iter().sum::<Complex<f64>>() / window;
            let tilted = (0..)
                .zip(&carrier)
                .map(|(n, z)| z * (f64::from(n) - middle));
            let slope = tilted.sum::<Complex<f64>>() * 12.0 / (window * (window * window - 1.0));
            for (n, z) in (0..).zip(&mut carrier) {
                *z -= mean + slope * (f64::from(n) - middle);
            }
            match &frame {
                FrameSamples::Rf(rf) => power(rf, &carrier),
                FrameSamples::Counts(counts) => power(counts, &carrier),
                FrameSamples::Iq { .. } => 0.0,
            }
        };
        let all = match &frame {
            FrameSamples::Rf(rf) => energy(rf),
            FrameSamples::Counts(counts) => energy(counts),
            FrameSamples::Iq { .. } => return None,
        };
        let own = power(f0);
        let over = |f: f64| {
            let (between, beyond) = (0.5 * (f + f0), 1.5 * f - 0.5 * f0);
            match (power(f), 2.0 * f < fs && own > 0.0) {
                // Below a millionth of the amplitude all is rounding.
                (found, true) if found > power(between).max(power(beyond)).max(1e-12 * all) => {
                    found / own
                }
                _ => 0.0,
            }
        };
        Some([over(2.0 * f0), over(0.5 * f0)])
    }

    /// Largest number of elements that recorded a transmit of the first frame.
    pub(super) fn most_receivers(&self) -> usize {
        fn most<T: Copy + PartialEq + Default>(frame: ArrayView3<'_, T>) -> usize {
            let zero = T::default();
            let live = |records: ndarray::ArrayView2<'_, T>| {
                let records = records.outer_iter();
                records
                    .filter(|record| record.iter().any(|&v| v != zero))
                    .count()
            };
            frame.outer_iter().map(live).max().unwrap_or(0)
        }
        let frame = self.frame(0);
        frame.map_or(
            0,
            |frame| of_any!(FrameSamples, frame, records => most(records)),
        )
    }

    /// Elements of the first frame whose records are constant.
    pub fn dead(&self) -> Vec<usize> {
        fn of<T: Copy + PartialEq>(frame: ArrayView3<'_, T>) -> Vec<usize> {
            let is_constant = |record: ndarray::ArrayView1<'_, T>| {
                let first = record.first().copied();
                record.iter().all(|&value| Some(value) == first)
            };
            let elements = frame.axis_iter(Axis(1)).enumerate();
            let dead = elements.filter(|(_, records)| records.outer_iter().all(is_constant));
            dead.map(|(m, _)| m).collect()
        }
        let frame = self.frame(0);
        frame.map_or_else(
            Vec::new,
            |frame| of_any!(FrameSamples, frame, records => of(records)),
        )
    }

    /// Mean frequency of the first frame of I/Q, Hz.
    ///
    /// It follows from the phase from one sample to the next.
    pub(super) fn mean_frequency(&self, fs: f64) -> Option<f64> {
        let Some(FrameSamples::Iq { iq, .. }) = self.frame(0) else {
            return None;
        };
        let mut sum = Complex::new(0.0, 0.0);
        for line in iq.rows() {
            let next = line.iter().skip(1);
            for (a, b) in line.iter().zip(next) {
                sum += Complex::<f64>::new(b.re.into(), b.im.into())
                    * Complex::new(f64::from(a.re), -f64::from(a.im));
            }
        }
        (sum.norm() > 0.0).then(|| fs * sum.arg() / std::f64::consts::TAU)
    }
}
