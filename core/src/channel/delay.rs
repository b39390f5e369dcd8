//! One image column of one transmit: RF → delayed analytic samples (dynamic receive focusing).
//!
//! Output sample n lies at depth z = c·t/2, t = start + n/fout. Each active element is read there at
//! (τ_tx + τ_rx − t0)·fs ([`delay_law`](super::delay_law)) through the filter that interpolates and
//! decimates ([`interpolate`](super::interpolate)); then the analytic signal is formed along depth
//! at the output rate ([`analytic`](super::analytic)). The column is computed a Hilbert reach beyond
//! both ends, so that its first and last samples are as good as the others.

use super::analytic::HilbertTransformer;
use super::aperture::Active;
use super::delay_law::{ReceiveLag, TransmitDelay, TransmitLaw};
use super::interpolate::Interpolator;
use super::{at_least_one, finite, positive};
use crate::error::check_length;
use crate::{Complex, Error};

/// The largest magnitude accepted in the RF, so that no sum can overflow: the filters multiply it by
/// less than 10, and adding that to the largest float is lost in its last place.
pub const MAX_MAGNITUDE: f32 = 1e30;
/// The most samples in a record or a column: every index must be exact in f32.
pub const MAX_SAMPLES: usize = 1 << 22;
/// Positions on the axis beyond ± this many samples read 0.
const FAR: f64 = (1 << 23) as f64;

/// Shapes and rates of a delay stage. SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DelayParameters {
    /// Speed of sound c, m/s.
    pub sound_speed: f64,
    /// Sampling rate of the record fs, Hz.
    pub sampling_rate: f64,
    /// Centre frequency of the pulse f₀, Hz: shapes the filter, sets no limit.
    pub centre_frequency: f64,
    /// Output rate fout, Hz, at least fs/16.
    pub output_rate: f64,
    /// Two-way time of output sample 0, s.
    pub output_start: f64,
    /// Output samples, 1..=[`MAX_SAMPLES`].
    pub output_samples: usize,
    /// Elements of the array.
    pub elements: usize,
    /// Samples of each element's record, 1..=[`MAX_SAMPLES`].
    pub record_samples: usize,
}

/// What to do with the column that `out` holds already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Store {
    /// Overwrite it; elements that are not active become 0.
    Replace,
    /// Add to it, to compound several transmits coherently; other elements stay as they are.
    Add,
}

/// One column of one transmit.
#[derive(Clone, Copy, Debug)]
pub struct Column<'a> {
    /// The transmit's delay law.
    pub law: TransmitLaw,
    /// Time of record sample 0 from the moment the wave would pass the law's origin, s.
    pub t0: f64,
    /// Lateral position of the column, m.
    pub x: f64,
    /// Lateral position of each element, m.
    pub element_x: &'a [f64],
    /// Elements to compute: the active ones of the deepest sample include all shallower ones'.
    pub active: Active,
    /// Overwrite or add.
    pub store: Store,
}

/// A delay stage: validated parameters and their two filters.
#[derive(Clone, Debug)]
pub struct Delay {
    parameters: DelayParameters,
    interpolator: Interpolator,
    hilbert: HilbertTransformer,
}

impl Delay {
    /// RAM of the stage, bytes (about 9.5 KiB, nearly all of it the interpolation table).
    pub const BYTES: usize = size_of::<Self>();

    /// A stage for `parameters` with a Hilbert transformer of the caller's length
    /// ([`HilbertTransformer::for_pulse`] is a sound choice).
    ///
    /// # Errors
    /// [`Error::Parameter`] or [`Error::Capacity`], naming the parameter that is out of range.
    pub fn new(parameters: DelayParameters, hilbert: HilbertTransformer) -> Result<Self, Error> {
        let p = &parameters;
        positive("sound_speed", p.sound_speed)?;
        finite("output_start", p.output_start)?;
        for (name, samples) in [
            ("output_samples", p.output_samples),
            ("record_samples", p.record_samples),
        ] {
            at_least_one(name, samples)?;
            if samples > MAX_SAMPLES {
                return Err(Error::Capacity {
                    name,
                    actual: samples,
                    capacity: MAX_SAMPLES,
                });
            }
        }
        at_least_one("elements", p.elements)?;
        let longest = p.output_samples.max(p.record_samples);
        let capacity = usize::MAX / longest;
        if p.elements > capacity {
            return Err(Error::Capacity {
                name: "elements",
                actual: p.elements,
                capacity,
            });
        }
        let interpolator = Interpolator::new(p.sampling_rate, p.output_rate, p.centre_frequency)?;
        Ok(Delay {
            parameters,
            interpolator,
            hilbert,
        })
    }

    /// The parameters.
    pub fn parameters(&self) -> &DelayParameters {
        &self.parameters
    }

    /// Length of the scratch slice of [`Delay::column`], f32: 5·output_samples + 8·reach, with the
    /// reach of the Hilbert transformer.
    pub fn scratch_len(&self) -> usize {
        4 * self.line_len() + self.parameters.output_samples
    }

    /// Output samples with the margins.
    fn line_len(&self) -> usize {
        self.parameters.output_samples + 2 * self.hilbert.reach()
    }

    /// The delayed analytic samples of one column.
    ///
    /// `rf`: row-major `[element][record sample]`. `scratch`: [`Delay::scratch_len`] values, contents
    /// irrelevant. `out`: row-major `[output sample][element]`, the scale of the RF. Samples outside
    /// the record, and depths z ≤ 0, read as 0.
    ///
    /// Order of operations. Per depth, f64, with n from −reach: t = start + n/fout; z = c·t/2;
    /// p = ((τ_tx(z) + z/c) − t0)·fs; then z, ⌊p⌋ and p − ⌊p⌋ as f32. Per element, f32:
    /// q = (p − ⌊p⌋) + lag(z); the record is read at ⌊p⌋ + ⌊q⌋ and q − ⌊q⌋. The real part is that
    /// value, the imaginary part its Hilbert transform; adding is real to real, imaginary to
    /// imaginary.
    ///
    /// Cost per output sample and active element: 2·taps + N MACs (taps = 16·⌈fs/fout⌉, N the
    /// Hilbert taps a side), one division and one root; for the paper's 100 → 20 MHz 168 MACs.
    /// Per output sample three f64 divisions, and a root for [`TransmitLaw::Element`]. RAM: the
    /// stage, the scratch, and 1 KiB of stack near the ends of the record.
    ///
    /// # Errors
    /// Before anything is written: [`Error::Length`] for a slice of the wrong length;
    /// [`Error::Parameter`] for a law, t0, position or active range that is not possible, or RF
    /// beyond ±[`MAX_MAGNITUDE`]; [`Error::NonFinite`] with the flat index into `rf` (or into
    /// `out`, when adding).
    pub fn column(
        &self,
        column: &Column,
        rf: &[f32],
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let p = &self.parameters;
        let transmit = self.check(column, rf, scratch, out)?;
        let (depth, rest) = scratch.split_at_mut(self.line_len());
        let (whole, rest) = rest.split_at_mut(self.line_len());
        let (fraction, rest) = rest.split_at_mut(self.line_len());
        let (line, imaginary) = rest.split_at_mut(self.line_len());
        self.trace_axis(&transmit, column.t0, depth, whole, fraction);

        if column.store == Store::Replace {
            out.fill(Complex::new(0.0, 0.0));
        }
        let Active { first, count } = column.active;
        for element in first..first + count {
            let record = &rf[element * p.record_samples..(element + 1) * p.record_samples];
            let lag = ReceiveLag::new(
                column.element_x[element] - column.x,
                p.sound_speed,
                p.sampling_rate,
            );
            for (n, value) in line.iter_mut().enumerate() {
                *value = self.read(record, &lag, depth[n], whole[n], fraction[n]);
            }
            self.hilbert.quadrature(line, imaginary)?;
            let real = &line[self.hilbert.reach()..];
            let outputs = out.iter_mut().skip(element).step_by(p.elements);
            for ((y, &re), &im) in outputs.zip(real).zip(&*imaginary) {
                match column.store {
                    Store::Replace => *y = Complex::new(re, im),
                    Store::Add => *y = Complex::new(y.re + re, y.im + im),
                }
            }
        }
        Ok(())
    }

    /// Depth, whole sample and fraction at which an element on the axis is read; depth 0 where
    /// nothing can be read.
    fn trace_axis(
        &self,
        transmit: &TransmitDelay,
        t0: f64,
        depth: &mut [f32],
        whole: &mut [f32],
        fraction: &mut [f32],
    ) {
        let p = &self.parameters;
        let reach = self.hilbert.reach() as f64;
        for n in 0..depth.len() {
            let t = p.output_start + (n as f64 - reach) / p.output_rate;
            let z = p.sound_speed * t / 2.0;
            let position = ((transmit.time(z) + z / p.sound_speed) - t0) * p.sampling_rate;
            let near = position > -FAR && position < FAR;
            let floor = if near { libm::floor(position) } else { 0.0 };
            depth[n] = if near { z as f32 } else { 0.0 };
            whole[n] = floor as f32;
            fraction[n] = if near { (position - floor) as f32 } else { 0.0 };
        }
    }

    /// The element's value at one depth.
    #[inline(always)]
    fn read(&self, record: &[f32], lag: &ReceiveLag, z: f32, whole: f32, fraction: f32) -> f32 {
        if z <= 0.0 {
            return 0.0;
        }
        let position = fraction + lag.samples(z);
        // False for a NaN too, which an infinite over an infinite extent would give.
        let near = position < FAR as f32;
        if !near {
            return 0.0;
        }
        // 0 ≤ position: the conversion is the floor.
        let floor = position as i32;
        self.interpolator
            .at(record, whole as i32 + floor, position - floor as f32)
    }

    /// Everything that can be wrong with a call.
    fn check(
        &self,
        column: &Column,
        rf: &[f32],
        scratch: &[f32],
        out: &[Complex<f32>],
    ) -> Result<TransmitDelay, Error> {
        let p = &self.parameters;
        check_length("element_x", column.element_x.len(), p.elements)?;
        check_length("rf", rf.len(), p.elements * p.record_samples)?;
        check_length("scratch", scratch.len(), self.scratch_len())?;
        check_length("out", out.len(), p.elements * p.output_samples)?;
        finite("t0", column.t0)?;
        for &x in column.element_x {
            finite("element_x", x)?;
        }
        let end = column.active.first.saturating_add(column.active.count);
        if end > p.elements {
            let expected = "a range that ends within the elements";
            return Err(Error::Parameter {
                name: "active",
                value: end as f64,
                expected,
            });
        }
        for (index, &value) in rf.iter().enumerate() {
            if !value.is_finite() {
                return Err(Error::NonFinite { name: "rf", index });
            }
            if !(-MAX_MAGNITUDE..=MAX_MAGNITUDE).contains(&value) {
                let expected = "a magnitude of at most 1e30";
                return Err(Error::Parameter {
                    name: "rf",
                    value: f64::from(value),
                    expected,
                });
            }
        }
        if column.store == Store::Add {
            let index = out
                .iter()
                .position(|y| !(y.re.is_finite() && y.im.is_finite()));
            if let Some(index) = index {
                return Err(Error::NonFinite { name: "out", index });
            }
        }
        TransmitDelay::new(column.law, column.x, p.sound_speed)
    }
}
