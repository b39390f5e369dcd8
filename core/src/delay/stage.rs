//! What the delay stages have in common, so that a pipeline takes either.

use super::delay_law::TransmitDelay;
use super::scan_line::{Compounding, ScanLine};
use crate::error::{check_length, finite};
use crate::memory::Need;
use crate::simd::Vector;
use crate::{Complex, Error};

/// A delay stage: [`Delay`] of RF or [`IqDelay`] of I/Q.
///
/// It makes any block of a line by itself, with memory for the block. A sample's bits do not depend on
/// how a line is cut.
///
/// [`Delay`]: super::Delay
/// [`IqDelay`]: super::IqDelay
pub trait Stage: Sealed {
    /// What the elements recorded of one transmit.
    type Record<'r>: Copy + Sync;

    /// The scratch for blocks of so many samples, for vectors of so many lanes (1 for `f32`): real numbers only,
    /// f32 for all vectors, and so a bare slice.
    fn need(&self, lanes: usize, samples: usize) -> Need;

    /// The aligned analytic samples of one scan line.
    ///
    /// `zero`: any vector of the instruction set to compute with. `scratch`: [`Stage::need`] values
    /// for the line's samples, contents irrelevant. `out`: row-major `[output sample][element]`, the scale of
    /// the record. Samples outside the record, and depths of 0 or less, read as 0. [`Delay`] and [`IqDelay`]
    /// tell the order of operations and the cost.
    ///
    /// # Errors
    /// Before anything is written: [`Error::Length`] for a slice of the wrong length or a record or array of
    /// another shape; [`Error::Parameter`] for a law, t0, position or active range that is not
    /// possible; [`Error::NonFinite`] with the flat index into `out`, when adding. Of I/Q read by
    /// [`IqInterpolation::LinearFixed`], [`Error::Parameter`] for samples that are not counts, and for elements 8191
    /// or more samples' way from the line.
    ///
    /// [`Delay`]: super::Delay
    /// [`IqDelay`]: super::IqDelay
    /// [`IqInterpolation::LinearFixed`]: super::IqInterpolation::LinearFixed
    fn line<V: Vector>(
        &self,
        zero: V,
        line: &ScanLine,
        record: &Self::Record<'_>,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let Shape {
            elements,
            output_samples,
            ..
        } = self.shape();
        check_length("out", out.len(), elements * output_samples)?;
        self.block(zero, line, record, 0, scratch, out)
    }

    /// The samples of a line from output sample `first` on, as many as `out` holds, to the bit as
    /// [`Stage::line`] has them. `scratch`: [`Stage::need`] values for so many.
    ///
    /// Cost: that of as many samples of a line; for RF also of the margins: up to a Hilbert reach beyond both
    /// ends is read, and up to full thirty-twos.
    ///
    /// # Errors
    /// As [`Stage::line`]; [`Error::Capacity`] for a block that ends behind the line.
    fn block<V: Vector>(
        &self,
        zero: V,
        line: &ScanLine,
        record: &Self::Record<'_>,
        first: usize,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        self.block_at_every(zero, line, record, (first, 1), scratch, out)
    }

    /// [`Stage::block`] of which only every `step`-th output sample is wanted, counted from the line's first. I/Q in fixed
    /// point puts 0, or adds nothing, elsewhere. The other readings ignore the step.
    ///
    /// # Errors
    /// As [`Stage::block`].
    fn block_at_every<V: Vector>(
        &self,
        zero: V,
        line: &ScanLine,
        record: &Self::Record<'_>,
        (first, step): (usize, usize),
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let shape = self.shape();
        let samples = out.len().checked_div(shape.elements).unwrap_or(0);
        check_length("out", out.len(), samples * shape.elements)?;
        let end = first.saturating_add(samples);
        if end > shape.output_samples {
            return Err(Error::Capacity {
                name: "block",
                actual: end,
                capacity: shape.output_samples,
            });
        }
        let Need { real, .. } = self.need(V::LANES, samples);
        check_length("scratch", scratch.len(), real)?;
        let [elements, record_samples] = Self::shape_of(record);
        check_length("element_x", line.array.elements(), shape.elements)?;
        check_length("record elements", elements, shape.elements)?;
        check_length("record samples", record_samples, shape.record_samples)?;
        let source = Source {
            transmit: check_line(line, shape.elements, shape.sound_speed, out)?,
            line,
            record,
            first,
            samples,
            step: step.max(1),
        };
        self.compute(zero, &source, scratch, out)
    }

    /// A magnitude that neither part of an aligned sample of this record exceeds.
    fn largest(record: &Self::Record<'_>) -> f32;

    /// What calls are checked against.
    #[doc(hidden)]
    fn shape(&self) -> Shape;

    /// The elements and samples of a record.
    #[doc(hidden)]
    fn shape_of(record: &Self::Record<'_>) -> [usize; 2];

    /// The samples, once everything that the stages have in common has been checked.
    #[doc(hidden)]
    fn compute<V: Vector>(
        &self,
        zero: V,
        source: &Source<'_, Self::Record<'_>>,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error>;
}

/// No others: that their samples are finite is known of these.
pub trait Sealed {}

impl<S: Sealed> Sealed for &S {}

/// The shapes of a stage, and its speed of sound.
pub struct Shape {
    pub(super) elements: usize,
    pub(super) output_samples: usize,
    pub(super) record_samples: usize,
    pub(super) sound_speed: f64,
}

/// What a line is focused from.
pub struct Source<'a, R> {
    pub(super) line: &'a ScanLine<'a>,
    pub(super) transmit: TransmitDelay<'a>,
    pub(super) record: &'a R,
    /// The first output sample that is asked for, and how many.
    pub(super) first: usize,
    pub(super) samples: usize,
    /// From one sample that is wanted to the next, at least 1; the line's first is one.
    pub(super) step: usize,
}

/// A stage that lies elsewhere: in a static, say.
impl<S: Stage> Stage for &S {
    type Record<'r> = S::Record<'r>;

    fn need(&self, lanes: usize, samples: usize) -> Need {
        S::need(self, lanes, samples)
    }

    fn largest(record: &Self::Record<'_>) -> f32 {
        S::largest(record)
    }

    fn shape(&self) -> Shape {
        S::shape(self)
    }

    fn shape_of(record: &Self::Record<'_>) -> [usize; 2] {
        S::shape_of(record)
    }

    fn compute<V: Vector>(
        &self,
        zero: V,
        source: &Source<'_, Self::Record<'_>>,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        S::compute(self, zero, source, scratch, out)
    }
}

/// What can be wrong with a line, whatever it is delayed from.
pub(super) fn check_line<'a>(
    line: &'a ScanLine<'_>,
    elements: usize,
    sound_speed: f64,
    out: &[Complex<f32>],
) -> Result<TransmitDelay<'a>, Error> {
    finite("t0", line.transmit.t0)?;
    line.array.check()?;
    let end = line.active.first.saturating_add(line.active.count);
    if end > elements {
        let expected = "a range that ends within the elements";
        return Err(Error::Parameter {
            name: "active",
            value: end as f64,
            expected,
        });
    }
    if line.compounding == Compounding::Add {
        // A whole chunk at a time, since that needs no branch a sample.
        let infinite = |y: &Complex<f32>| !y.re.is_finite() | !y.im.is_finite();
        let any = |chunk: &[Complex<f32>]| chunk.iter().fold(false, |any, y| any | infinite(y));
        if out.chunks(256).any(any) {
            let index = out.iter().position(infinite).unwrap_or(0);
            return Err(Error::NonFinite { name: "out", index });
        }
    }
    TransmitDelay::new(line.transmit.law, &line.ray, &line.array, sound_speed)
}
