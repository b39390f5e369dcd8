//! One image column of one transmit: RF → aligned analytic samples (dynamic receive focusing).
//!
//! Output sample n lies at depth z = c·t/2, t = start + n/fout. Each active element is read there at
//! (τ_tx + τ_rx − t0)·fs ([`delay_law`](super::delay_law)) through the filter that interpolates and
//! decimates ([`interpolate`](super::interpolate)), from a record whose rate is halved first where
//! it is much higher than the output's (`decimator`); then the analytic signal
//! is formed along depth at the output rate ([`analytic`](super::analytic)). The column is computed
//! a Hilbert reach beyond both ends, so that its first and last samples are as good as the others.
//!
//! As many elements as there are lanes are worked on together (`groups`). Lanes are samples of one element
//! where its record is halved and read, and elements where the analytic signal is formed; numbers change
//! places in squares of as many registers as there are lanes.

mod focus;
mod groups;

use super::analytic::HilbertTransformer;
use super::delay_law::{TransmitDelay, TransmitLaw};
use super::interpolate::Interpolator;
use super::record::Record;
use super::{at_least_one, finite, positive};
use crate::error::check_length;
use crate::geometry::Active;
use crate::simd::{PARTIAL_SUMS, Vector};
use crate::{Complex, Error};

/// The most samples in a record or a column: every index must be exact in f32.
pub const MAX_SAMPLES: usize = 1 << 22;
/// Sixteens of positions that are worked out before they are read, so that neither waits for the
/// other.
const STEP: usize = 8;
/// Output samples that are transposed and transformed together.
const CHUNK: usize = 32;
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

/// A delay stage: validated parameters and their filters.
#[derive(Clone, Debug)]
pub struct Delay {
    parameters: DelayParameters,
    interpolator: Interpolator,
    hilbert: HilbertTransformer,
}

impl Delay {
    /// RAM of the stage, bytes (about 10 KiB, nearly all of it the interpolation table).
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

    /// Length of the scratch slice of [`Delay::column`], f32. A line has output_samples, up to full
    /// thirty-twos, + 2·reach values, with the reach of the Hilbert transformer, up to full sixteens.
    /// There are three lines and one a lane; a lane also takes 32 + 2·reach values. If records are halved,
    /// there is room for the halved record and its margins (for two of them with several lanes), and for
    /// up to 448 values that pass through the filters (992 where it is halved three times). 15 values are
    /// room for the rows to begin on a cache line.
    pub fn scratch_len<V: Vector>(&self) -> usize {
        let lanes = self.line_len() + self.rows();
        let halved =
            V::LANES.min(2) * self.halved_len() + self.interpolator.decimator().streams_len();
        PARTIAL_SUMS - 1 + V::LANES * lanes + halved + 3 * self.line_len()
    }

    /// Output samples with the margins, up to full sixteens.
    fn line_len(&self) -> usize {
        let outputs = self.parameters.output_samples.next_multiple_of(CHUNK);
        (outputs + 2 * self.hilbert.reach()).next_multiple_of(PARTIAL_SUMS)
    }

    /// Rows of a lane each that the filters take.
    fn rows(&self) -> usize {
        2 * self.hilbert.reach() + CHUNK
    }

    /// Room for an element's record after the halvings.
    fn halved_len(&self) -> usize {
        let samples = self.parameters.record_samples;
        self.interpolator.decimator().halved_len(samples)
    }

    /// The rate at which the interpolator reads, Hz.
    fn rate(&self) -> f64 {
        self.parameters.sampling_rate / (1 << self.interpolator.halvings()) as f64
    }

    /// The aligned analytic samples of one column.
    ///
    /// `zero`: any vector of the instruction set to compute with. `scratch`: [`Delay::scratch_len`]
    /// values, contents irrelevant. `out`: row-major `[output sample][element]`, the scale of the RF.
    /// Samples outside the record, and depths z ≤ 0, read as 0.
    ///
    /// Order of operations. The record is halved h times to the rate f = fs/2ʰ. Per depth, f64, with
    /// n from −reach: t = start + n/fout; z = c·t/2; p = ((τ_tx(z) + z/c) − t0)·f; then z, ⌊p⌋ and
    /// p − ⌊p⌋ as f32. Per element, f32: q = (p − ⌊p⌋) + lag(z); the record is read at ⌊p⌋ + ⌊q⌋
    /// and q − ⌊q⌋. The real part is that value, the imaginary part its Hilbert transform; adding
    /// is real to real, imaginary to imaginary.
    ///
    /// Cost per output sample and active element: 2·taps + N products and 3·taps + 2N additions (taps = 16,
    /// or 32 where f is more than 1.25·fout; N the Hilbert taps a side), a division and a root; for the
    /// last halving 7·f/fout products and 12·f/fout additions, for the one before 10·f/fout and
    /// 16·f/fout, and twice as many for the one before that. For the paper's 100 → 20 MHz 61 products
    /// and 99 additions. With several lanes,
    /// two elements at the same distance on either side of the column share the position and the
    /// coefficients (taps products, 2·taps additions, the division and the root); a record is halved
    /// only where it is read. Per output sample
    /// three f64 divisions, and a root for [`TransmitLaw::Element`]. RAM: the stage, the scratch, and
    /// 5 KiB of stack.
    ///
    /// # Errors
    /// Before anything is written: [`Error::Length`] for a slice of the wrong length or a record of
    /// another shape; [`Error::Parameter`] for a law, t0, position or active range that is not
    /// possible; [`Error::NonFinite`] with the flat index into `out`, when adding.
    pub fn column<V: Vector>(
        &self,
        zero: V,
        column: &Column,
        record: &Record,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        check_length("scratch", scratch.len(), self.scratch_len::<V>())?;
        let transmit = self.check(column, record, out)?;
        zero.vectorize(
            #[inline(always)]
            || self.compute(zero, &transmit, column, record, scratch, out),
        );
        Ok(())
    }

    /// Everything that can be wrong with a call.
    fn check(
        &self,
        column: &Column,
        record: &Record,
        out: &[Complex<f32>],
    ) -> Result<TransmitDelay, Error> {
        let p = &self.parameters;
        check_length("element_x", column.element_x.len(), p.elements)?;
        check_length("record elements", record.elements(), p.elements)?;
        check_length("record samples", record.samples(), p.record_samples)?;
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
        if column.store == Store::Add {
            // A whole piece at a time, since that needs no branch a sample.
            let infinite = |y: &Complex<f32>| !y.re.is_finite() | !y.im.is_finite();
            let any = |piece: &[Complex<f32>]| piece.iter().fold(false, |any, y| any | infinite(y));
            if out.chunks(256).any(any) {
                let index = out.iter().position(infinite).unwrap_or(0);
                return Err(Error::NonFinite { name: "out", index });
            }
        }
        TransmitDelay::new(column.law, column.x, p.sound_speed)
    }
}
