//! Recorded samples, RF or I/Q, of one frame or many.

use std::io::{Seek, Write};
use std::ops::Range;

use ndarray::{Array, Array3, Array4, ArrayView1, ArrayView3, Axis, Dimension, concatenate};
use num_complex::Complex;

use super::{npz, npz_writer, units, validate};
use crate::Result;
use crate::terminal::digits;

/// Recorded samples, [frame, transmit, element, sample].
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// RF, as the elements received it.
    Rf(Array4<f32>),
    /// RF in counts of a converter, as in a file of i16.
    ///
    /// [`Samples::into_float`] gives [`Samples::Rf`].
    Counts(Array4<i16>),
    /// I/Q in the base band: the analytic signal times e^(−j2π·f_demod·t).
    ///
    /// t counts from the same moment as the recording's `t0`.
    Iq {
        /// The samples.
        iq: Array4<Complex<f32>>,
        /// Demodulation frequency, Hz.
        f_demod: f64,
    },
}

/// Samples of one frame, [transmit, element, sample], by reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FrameSamples<'a> {
    /// See [`Samples::Rf`].
    Rf(ArrayView3<'a, f32>),
    /// See [`Samples::Counts`].
    Counts(ArrayView3<'a, i16>),
    /// See [`Samples::Iq`].
    Iq {
        /// The samples.
        iq: ArrayView3<'a, Complex<f32>>,
        /// Demodulation frequency, Hz.
        f_demod: f64,
    },
}

const AXES: [&str; 4] = ["frame", "transmit", "element", "sample"];

/// Reverses an axis, in standard layout.
pub(super) fn reverse<T: Clone, D: Dimension>(array: &mut Array<T, D>, axis: Axis) {
    array.invert_axis(axis);
    *array = array.as_standard_layout().into_owned();
}

impl From<Array3<f32>> for Samples {
    /// One frame of RF.
    fn from(rf: Array3<f32>) -> Self {
        Samples::Rf(rf.insert_axis(Axis(0)))
    }
}

impl FrameSamples<'_> {
    /// Numbers of transmits, elements and samples.
    pub fn dim(&self) -> (usize, usize, usize) {
        match self {
            FrameSamples::Rf(rf) => rf.dim(),
            FrameSamples::Counts(counts) => counts.dim(),
            FrameSamples::Iq { iq, .. } => iq.dim(),
        }
    }

    /// The same kind of samples without a frame, if the frames stay elsewhere.
    pub fn none(&self) -> Samples {
        let (transmits, elements, samples) = self.dim();
        let shape = (0, transmits, elements, samples);
        match *self {
            FrameSamples::Rf(_) => Samples::Rf(Array4::default(shape)),
            FrameSamples::Counts(_) => Samples::Counts(Array4::default(shape)),
            FrameSamples::Iq { f_demod, .. } => Samples::Iq {
                iq: Array4::default(shape),
                f_demod,
            },
        }
    }

    /// Checks that there is a sample, and that all are finite.
    pub(super) fn check(&self) -> std::result::Result<(), String> {
        match self {
            FrameSamples::Rf(rf) => validate::samples("rf", rf, &AXES[1..]),
            FrameSamples::Counts(counts) => validate::samples("rf", counts, &AXES[1..]),
            FrameSamples::Iq { iq, .. } => validate::samples("iq", iq, &AXES[1..]),
        }
    }
}

impl Samples {
    /// One frame of I/Q.
    pub fn iq(iq: Array3<Complex<f32>>, f_demod: f64) -> Self {
        Samples::Iq {
            iq: iq.insert_axis(Axis(0)),
            f_demod,
        }
    }

    /// Numbers of frames, transmits, elements and samples.
    pub fn dim(&self) -> (usize, usize, usize, usize) {
        match self {
            Samples::Rf(rf) => rf.dim(),
            Samples::Counts(counts) => counts.dim(),
            Samples::Iq { iq, .. } => iq.dim(),
        }
    }

    /// The number of frames.
    pub fn frames(&self) -> usize {
        self.dim().0
    }

    /// One frame, in place; `None` beyond the last.
    pub fn frame(&self, frame: usize) -> Option<FrameSamples<'_>> {
        (frame < self.frames()).then(|| match self {
            Samples::Rf(rf) => FrameSamples::Rf(rf.index_axis(Axis(0), frame)),
            Samples::Counts(counts) => FrameSamples::Counts(counts.index_axis(Axis(0), frame)),
            Samples::Iq { iq, f_demod } => FrameSamples::Iq {
                iq: iq.index_axis(Axis(0), frame),
                f_demod: *f_demod,
            },
        })
    }

    /// The RF of one frame in f32.
    ///
    /// `None` for counts, for I/Q and beyond the last frame.
    pub fn rf(&self, frame: usize) -> Option<ArrayView3<'_, f32>> {
        match self.frame(frame)? {
            FrameSamples::Rf(rf) => Some(rf),
            FrameSamples::Counts(_) | FrameSamples::Iq { .. } => None,
        }
    }

    /// Counts become RF in f32, of the same values; other samples do not change.
    pub fn into_float(self) -> Self {
        match self {
            Samples::Counts(counts) => Samples::Rf(counts.mapv(f32::from)),
            other => other,
        }
    }

    /// Keeps some frames and removes the others.
    ///
    /// # Panics
    /// If a frame does not exist.
    pub fn keep(&mut self, frames: Range<usize>) {
        match self {
            Samples::Rf(rf) => *rf = rf.slice_axis(Axis(0), frames.into()).to_owned(),
            Samples::Counts(counts) => {
                *counts = counts.slice_axis(Axis(0), frames.into()).to_owned();
            }
            Samples::Iq { iq, .. } => *iq = iq.slice_axis(Axis(0), frames.into()).to_owned(),
        }
    }

    /// Concatenates samples along the transmits of one recording.
    ///
    /// `None` without parts, or with parts of several kinds or shapes, or in counts.
    pub fn stacked(parts: Vec<Self>) -> Option<Self> {
        let rf = parts.iter().filter_map(|part| match part {
            Samples::Rf(rf) => Some(rf.view()),
            Samples::Counts(_) | Samples::Iq { .. } => None,
        });
        let rf: Vec<_> = rf.collect();
        if rf.len() == parts.len() {
            return concatenate(Axis(1), &rf).ok().map(Samples::Rf);
        }
        let iq = parts.iter().filter_map(|part| match part {
            Samples::Iq { iq, f_demod } => Some((iq.view(), *f_demod)),
            Samples::Rf(_) | Samples::Counts(_) => None,
        });
        let (iq, f_demod): (Vec<_>, Vec<_>) = iq.unzip();
        let f_demod = f_demod
            .first()
            .copied()
            .filter(|_| iq.len() == parts.len())?;
        let iq = concatenate(Axis(1), &iq).ok()?;
        Some(Samples::Iq { iq, f_demod })
    }

    /// Conjugates I/Q that was written with the opposite sign of the carrier.
    ///
    /// RF does not change.
    pub fn conjugate(self) -> Self {
        match self {
            Samples::Iq { iq, f_demod } => Samples::Iq {
                iq: iq.mapv_into(|z| z.conj()),
                f_demod,
            },
            rf => rf,
        }
    }

    /// The samples in normal form.
    ///
    /// I/Q with a negative demodulation frequency is conjugated, to have a positive one. Analytic samples that were
    /// not demodulated become RF, their real part.
    pub(super) fn normalised(self) -> Self {
        match self {
            Samples::Iq { iq, f_demod } if f_demod < 0.0 => {
                let f_demod = -f_demod;
                Samples::Iq { iq, f_demod }.conjugate()
            }
            Samples::Iq { iq, f_demod: 0.0 } => Samples::Rf(iq.mapv(|z| z.re)),
            other => other,
        }
    }

    /// Reverses the order of the elements.
    pub(super) fn flip(&mut self) {
        match self {
            Samples::Rf(rf) => reverse(rf, Axis(2)),
            Samples::Counts(counts) => reverse(counts, Axis(2)),
            Samples::Iq { iq, .. } => reverse(iq, Axis(2)),
        }
    }

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
        match self.frame(0) {
            Some(FrameSamples::Rf(rf)) => most(rf),
            Some(FrameSamples::Counts(counts)) => most(counts),
            Some(FrameSamples::Iq { iq, .. }) => most(iq),
            None => 0,
        }
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
        match self.frame(0) {
            Some(FrameSamples::Rf(rf)) => of(rf),
            Some(FrameSamples::Counts(counts)) => of(counts),
            Some(FrameSamples::Iq { iq, .. }) => of(iq),
            None => Vec::new(),
        }
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

    /// Size of the samples, bytes.
    pub fn bytes(&self) -> usize {
        match self {
            Samples::Rf(rf) => rf.len() * size_of::<f32>(),
            Samples::Counts(counts) => counts.len() * size_of::<i16>(),
            Samples::Iq { iq, .. } => iq.len() * size_of::<Complex<f32>>(),
        }
    }

    /// Key of the samples in a `.npz` file.
    pub fn key(&self) -> &'static str {
        match self {
            Samples::Rf(_) | Samples::Counts(_) => "rf",
            Samples::Iq { .. } => "iq",
        }
    }

    /// Shape and axes; a single frame has no frame axis.
    fn shape(&self) -> (Vec<usize>, &'static [&'static str]) {
        let (frames, transmits, elements, samples) = self.dim();
        if frames == 1 {
            return (vec![transmits, elements, samples], &AXES[1..]);
        }
        (vec![frames, transmits, elements, samples], &AXES)
    }

    /// Checks that `key` has as many values as the axis that it describes.
    ///
    /// Axes count from the frames, 0, to the samples, 3.
    pub(super) fn check_axis(
        &self,
        key: &str,
        count: usize,
        axis: usize,
        of: &str,
    ) -> std::result::Result<(), String> {
        let (shape, axes) = self.shape();
        let axis = axis + axes.len() - AXES.len();
        units::check_axis(key, count, (self.key(), &shape, axes), axis, of)
    }

    /// Checks that there is a sample, and that all are finite.
    pub(super) fn check(&self) -> std::result::Result<(), String> {
        match (self, self.frame(0)) {
            (_, Some(frame)) if self.frames() == 1 => frame.check(),
            (Samples::Rf(rf), _) => validate::samples("rf", rf, &AXES),
            (Samples::Counts(counts), _) => validate::samples("rf", counts, &AXES),
            (Samples::Iq { iq, .. }, _) => validate::samples("iq", iq, &AXES),
        }
    }

    /// Checks that the sampling rate `fs` covers the centre frequency.
    pub(super) fn check_band(&self, fs: f64, f0: f64) -> std::result::Result<(), String> {
        match *self {
            Samples::Rf(_) | Samples::Counts(_) if 2.0 * f0 >= fs => Err(format!(
                "`f0` is {} Hz; expected less than half the sampling rate `fs` of {} Hz; from a band-sampled \
                 record make I/Q (`iq`, `f_demod`)",
                digits(f0),
                digits(fs)
            )),
            Samples::Rf(_) | Samples::Counts(_) => Ok(()),
            Samples::Iq { f_demod, .. } => {
                validate::positive("f_demod", f_demod, "Hz")?;
                units::RATE.check("`f_demod`", f_demod)?;
                if 2.0 * (f0 - f_demod).abs() < fs {
                    return Ok(());
                }
                Err(format!(
                    "`f0` is {} Hz; expected less than half the sampling rate `fs` of {} Hz away from \
                     `f_demod` of {} Hz",
                    digits(f0),
                    digits(fs),
                    digits(f_demod)
                ))
            }
        }
    }

    /// Some frames, or all if the array is read whole, and their total number.
    ///
    /// All are finite.
    pub(super) fn from_npz(file: &mut npz::Reader, frames: Range<usize>) -> Result<(Self, usize)> {
        let axes = AXES[1..].join(", ");
        let (samples, held, are_finite) = match (file.has("rf"), file.has("iq")) {
            (true, true) => {
                return Err(
                    file.error("holds both `rf` and `iq`; expected the samples of one kind")
                );
            }
            (false, true) => {
                let found = file.complex_frames("iq", &axes, frames)?;
                let (iq, f_demod) = (found.array, file.scalar("f_demod")?);
                (Samples::Iq { iq, f_demod }, found.held, found.are_finite)
            }
            _ => match file.count_frames("rf", &axes, frames.clone())? {
                Some(found) => (Samples::Counts(found.array), found.held, found.are_finite),
                None => {
                    let found = file.real_frames("rf", &axes, frames)?;
                    (Samples::Rf(found.array), found.held, found.are_finite)
                }
            },
        };
        if !are_finite {
            samples.check().map_err(|message| file.error(message))?;
        }
        Ok((samples, held))
    }

    /// Begins the array of `frames` such frames in an archive.
    ///
    /// A single frame has no frame axis.
    pub(super) fn begin_npz<W: Write + Seek>(
        &self,
        frames: usize,
        npz: &mut npz_writer::Writer<W>,
    ) -> npz_writer::Written {
        let (_, transmits, elements, samples) = self.dim();
        let shape = [frames, transmits, elements, samples];
        let shape = if frames == 1 { &shape[1..] } else { &shape };
        match self {
            Samples::Rf(_) => npz.begin::<f32>("rf", shape),
            Samples::Counts(_) => npz.begin::<i16>("rf", shape),
            Samples::Iq { f_demod, .. } => {
                npz.add("f_demod", &ndarray::arr0(*f_demod))?;
                npz.begin::<Complex<f32>>("iq", shape)
            }
        }
    }

    /// Appends the samples of some frames.
    pub(super) fn append_npz<W: Write + Seek>(
        &self,
        frames: Range<usize>,
        npz: &mut npz_writer::Writer<W>,
    ) -> npz_writer::Written {
        match self {
            Samples::Rf(rf) => npz.append(&rf.slice_axis(Axis(0), frames.into())),
            Samples::Counts(counts) => npz.append(&counts.slice_axis(Axis(0), frames.into())),
            Samples::Iq { iq, .. } => npz.append(&iq.slice_axis(Axis(0), frames.into())),
        }
    }
}
