//! The interface that both delay stages share.

use super::delay_law::TransmitDelay;
use super::record::{Record, Samples};
use super::scan_line::{Compounding, ScanLine};
use crate::error::{check_length, finite};
use crate::geometry::DepthStep;
use crate::memory::Need;
use crate::simd::Vector;
use crate::{Complex, Error};

/// A delay stage: [`Delay`] for RF or [`IqDelay`] for I/Q.
///
/// Any block of a line can be computed alone, in memory for the block. A sample's bits do not depend on the
/// division of a line into blocks.
///
/// [`Delay`]: super::Delay
/// [`IqDelay`]: super::IqDelay
pub trait Stage: Sealed {
    /// Scratch for blocks of `samples` samples with vectors of `lanes` lanes.
    ///
    /// `lanes` is 1 for `f32`. The scratch holds only f32, for all vectors: a plain slice is enough.
    fn need(&self, lanes: usize, samples: usize) -> Need;

    /// Computes the aligned analytic samples of one scan line.
    ///
    /// `zero`: any vector of the instruction set to compute with. `scratch`: [`Stage::need`] values for the line's
    /// samples, contents irrelevant. `out`: row-major `[output sample][element]`, in the record's scale. Samples
    /// outside the record, and depths of 0 or less, are read as 0. [`Delay`] and [`IqDelay`] document the order of
    /// operations and the cost.
    ///
    /// # Errors
    /// Before anything is written:
    ///
    /// - [`Error::Length`] for a slice of the wrong length or a record or array of another shape;
    /// - [`Error::Parameter`] for an impossible law, t0, position or active range;
    /// - [`Error::Parameter`] for active elements that a [part of an array](Record::part_of) did not receive;
    /// - [`Error::NonFinite`] with the flat index into `out`, when adding;
    /// - [`Error::Parameter`] for I/Q with [`IqInterpolation::LinearFixed`] if samples are not counts, or if the path
    ///   from an element to the line is 8191 samples or more.
    ///
    /// [`Delay`]: super::Delay
    /// [`IqDelay`]: super::IqDelay
    /// [`IqInterpolation::LinearFixed`]: super::IqInterpolation::LinearFixed
    fn line<V: Vector>(
        &self,
        zero: V,
        line: &ScanLine,
        record: &Record<'_>,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let StageShape {
            elements,
            output_samples,
            ..
        } = self.shape();
        check_length("out", out.len(), elements * output_samples)?;
        self.block(zero, line, record, 0, scratch, out)
    }

    /// Computes the samples of a line from output sample `first` on.
    ///
    /// `out` has the block's length, and the bits of [`Stage::line`]. `scratch`: [`Stage::need`] values for the block.
    ///
    /// Cost: that of as many samples of a line. RF adds margins: up to a Hilbert reach beyond both ends, and up to
    /// a multiple of 32 samples.
    ///
    /// # Errors
    /// As [`Stage::line`]; [`Error::Capacity`] for a block that ends after the line.
    fn block<V: Vector>(
        &self,
        zero: V,
        line: &ScanLine,
        record: &Record<'_>,
        first: usize,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        if line.compounding == Compounding::Add {
            check_sums(out)?;
        }
        self.block_of(zero, line, record, Outputs::every(first, 1), scratch, out)
    }

    /// [`Stage::block`] with only every `step`-th output sample in use.
    ///
    /// They count from the line's first on. When adding, `out` is what earlier calls made, and not checked.
    ///
    /// RF is still interpolated at all samples, since an imaginary part needs the real parts around it.
    #[doc(hidden)]
    fn block_of<V: Vector>(
        &self,
        zero: V,
        line: &ScanLine,
        record: &Record<'_>,
        wanted: Outputs,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        let Outputs { first, step, rest } = wanted;
        let shape = self.shape();
        let samples = out.len().checked_div(shape.elements).unwrap_or(0);
        check_length("out", out.len(), samples * shape.elements)?;
        let end = first.saturating_add(samples);
        if end > shape.output_samples {
            return Err(Error::capacity("block", end, shape.output_samples));
        }
        let Need { real, .. } = self.need(V::LANES, samples);
        check_length("scratch", scratch.len(), real)?;
        // A record of the other kind has no samples.
        let is_own = matches!(record.samples, Samples::Rf(_)) == Self::RF;
        let record_samples = if is_own { record.samples() } else { 0 };
        check_length("element_x", line.array.elements(), shape.elements)?;
        check_length("record elements", record.elements(), shape.elements)?;
        check_length("record samples", record_samples, shape.record_samples)?;
        if record.is_part() && line.active.within(record.received()) != line.active {
            let expected = "elements that the record has";
            return Err(Error::parameter(
                "active",
                line.active.first as f64,
                expected,
            ));
        }
        let source = Source {
            transmit: check_line(line, shape.elements, shape.sound_speed)?,
            line,
            record,
            first,
            samples,
            step,
            rest,
        };
        if record.is_part() && line.active.count == 0 {
            if line.compounding == Compounding::Replace {
                out.fill(Complex::new(0.0, 0.0));
            }
            return Ok(());
        }
        self.compute(zero, &source, scratch, out)
    }

    /// The shape that calls are checked against.
    #[doc(hidden)]
    fn shape(&self) -> StageShape;

    /// Whether records are RF.
    #[doc(hidden)]
    const RF: bool;

    /// Computes the samples after all common checks.
    #[doc(hidden)]
    fn compute<V: Vector>(
        &self,
        zero: V,
        source: &Source<'_>,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error>;
}

/// Private supertrait: no other stages exist, so their samples are finite.
pub trait Sealed {}

impl<S: Sealed> Sealed for &S {}

/// The shapes of a stage, and its speed of sound.
pub struct StageShape {
    pub(super) elements: usize,
    pub(super) output_samples: usize,
    pub(super) record_samples: usize,
    pub(super) sound_speed: f64,
}

/// The samples of a block that are wanted.
#[derive(Clone, Copy)]
pub struct Outputs {
    /// The line's sample with which the block begins.
    pub(crate) first: usize,
    /// Distance between wanted samples.
    pub(crate) step: DepthStep,
    pub(crate) rest: Rest,
}

impl Outputs {
    /// Every `step`-th sample of a line from `first` on; the others are 0, or add nothing.
    pub(crate) fn every(first: usize, step: usize) -> Self {
        Outputs {
            first,
            step: DepthStep::new(step),
            rest: Rest::Zero,
        }
    }
}

/// The other samples, and inactive elements.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Rest {
    /// They are 0.
    Zero,
    /// Nothing reads them, so that a stage may leave them as they are.
    Undefined,
}

/// The source data of a line.
pub struct Source<'a> {
    pub(super) line: &'a ScanLine<'a>,
    pub(super) transmit: TransmitDelay<'a>,
    pub(super) record: &'a Record<'a>,
    /// The first requested output sample, and the number of them.
    pub(super) first: usize,
    pub(super) samples: usize,
    /// Distance between wanted samples; the line's first sample is wanted.
    pub(super) step: DepthStep,
    pub(super) rest: Rest,
}

/// A stage by reference, for instance in a static.
impl<S: Stage> Stage for &S {
    const RF: bool = S::RF;

    fn need(&self, lanes: usize, samples: usize) -> Need {
        S::need(self, lanes, samples)
    }

    fn shape(&self) -> StageShape {
        S::shape(self)
    }

    fn compute<V: Vector>(
        &self,
        zero: V,
        source: &Source<'_>,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        S::compute(self, zero, source, scratch, out)
    }
}

/// Refuses numbers that are not finite.
fn check_sums(out: &[Complex<f32>]) -> Result<(), Error> {
    // A whole chunk at a time, since that needs no branch a sample.
    let infinite = |y: &Complex<f32>| !y.re.is_finite() | !y.im.is_finite();
    let any = |chunk: &[Complex<f32>]| chunk.iter().fold(false, |any, y| any | infinite(y));
    if out.chunks(256).any(any) {
        let index = out.iter().position(infinite).unwrap_or(0);
        return Err(Error::NonFinite { name: "out", index });
    }
    Ok(())
}

/// Checks of a line that all stages share.
pub(super) fn check_line<'a>(
    line: &'a ScanLine<'_>,
    elements: usize,
    sound_speed: f64,
) -> Result<TransmitDelay<'a>, Error> {
    finite("t0", line.transmit.t0)?;
    line.array.check()?;
    let end = line.active.first.saturating_add(line.active.count);
    if end > elements {
        let expected = "a range that ends within the elements";
        return Err(Error::parameter("active", end as f64, expected));
    }
    TransmitDelay::new(line.transmit.law, &line.ray, &line.array, sound_speed)
}

#[cfg(test)]
mod tests {
    use crate::delay::{
        Compounding, Delay, DelayParameters, IqDelay, IqLayout, IqParameters, IqSamples, Record,
        ScanLine, Stage,
    };
    use crate::geometry::{Scan, ScanParameters, Transmit, TransmitLaw};
    use crate::{Complex, Error};
    use std::vec;

    /// It has no samples of the stage's kind.
    #[test]
    fn a_record_of_the_other_kind_is_refused() {
        let scan = Scan::new(ScanParameters::EXAMPLE).unwrap();
        let (elements, samples) = (scan.elements(), scan.parameters().record_samples);
        let (rf, iq) = (
            vec![0.0; elements * samples],
            vec![Complex::ZERO; elements * samples],
        );
        let rf = Record::new(&rf, elements).unwrap();
        let iq = Record::iq(IqSamples::Float(&iq), IqLayout::Planar, elements).unwrap();
        let of_rf = Delay::new(DelayParameters::of(&scan)).unwrap();
        let of_iq = IqDelay::new(IqParameters::of(&scan, 5e6)).unwrap();
        let line = ScanLine::of(
            &scan,
            0,
            Transmit::new(TransmitLaw::Focused, 0.0),
            Compounding::Replace,
        );
        fn refused(stage: &impl Stage, line: &ScanLine, record: &Record<'_>) -> Result<(), Error> {
            let mut scratch = vec![0.0; stage.need(1, 9).real];
            let mut x = vec![Complex::ZERO; 9 * line.array.elements()];
            stage.block(0.0f32, line, record, 0, &mut scratch, &mut x)
        }
        let expected = Err(Error::length("record samples", 0, samples));
        assert_eq!(refused(&of_rf, &line, &iq), expected);
        assert_eq!(refused(&of_iq, &line, &rf), expected);
    }
}
