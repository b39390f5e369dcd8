//! What the delay stages have in common, so that a pipeline takes either.

use super::{Delay, IqDelay, IqRecord, Record, ScanLine};
use crate::simd::Vector;
use crate::{Complex, Error};

/// A delay stage: [`Delay`] of RF or [`IqDelay`] of I/Q.
///
/// It makes any stretch of a line by itself, with memory for the stretch. A sample's bits do not depend on
/// how a line is cut.
pub trait Stage: Sealed {
    /// What the elements recorded of one transmit.
    type Record<'r>: Copy + Sync;

    /// Length of the scratch slice for stretches of so many samples, f32, for vectors of so many lanes (1
    /// for `f32`).
    fn scratch_len(&self, lanes: usize, samples: usize) -> usize;

    /// The aligned analytic samples of a scan line from output sample `first` on, as many as `out` holds:
    /// as [`Delay::line`] and [`IqDelay::line`].
    ///
    /// # Errors
    /// As those; [`Error::Capacity`] for a stretch that ends behind the line.
    fn stretch<V: Vector>(
        &self,
        zero: V,
        line: &ScanLine,
        record: &Self::Record<'_>,
        first: usize,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error>;

    /// A magnitude that neither part of an aligned sample of this record exceeds.
    fn largest(record: &Self::Record<'_>) -> f32;
}

/// No others: that their samples are finite is known of these.
pub trait Sealed {}

impl Sealed for Delay {}
impl Sealed for IqDelay {}
impl<S: Sealed> Sealed for &S {}

/// A stage that lies elsewhere: in a static, say.
impl<S: Stage> Stage for &S {
    type Record<'r> = S::Record<'r>;

    fn scratch_len(&self, lanes: usize, samples: usize) -> usize {
        S::scratch_len(self, lanes, samples)
    }

    fn stretch<V: Vector>(
        &self,
        zero: V,
        line: &ScanLine,
        record: &Self::Record<'_>,
        first: usize,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        S::stretch(self, zero, line, record, first, scratch, out)
    }

    fn largest(record: &Self::Record<'_>) -> f32 {
        S::largest(record)
    }
}

impl Stage for Delay {
    type Record<'r> = Record<'r>;

    fn scratch_len(&self, lanes: usize, samples: usize) -> usize {
        self.parameters().stretch_scratch_len(lanes, samples)
    }

    fn stretch<V: Vector>(
        &self,
        zero: V,
        line: &ScanLine,
        record: &Record<'_>,
        first: usize,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        Delay::stretch(self, zero, line, record, first, scratch, out)
    }

    fn largest(record: &Record<'_>) -> f32 {
        record.largest_aligned()
    }
}

impl Stage for IqDelay {
    type Record<'r> = IqRecord<'r>;

    fn scratch_len(&self, lanes: usize, _: usize) -> usize {
        self.parameters().scratch_len(lanes)
    }

    fn stretch<V: Vector>(
        &self,
        zero: V,
        line: &ScanLine,
        record: &IqRecord<'_>,
        first: usize,
        scratch: &mut [f32],
        out: &mut [Complex<f32>],
    ) -> Result<(), Error> {
        IqDelay::stretch(self, zero, line, record, first, scratch, out)
    }

    fn largest(record: &IqRecord<'_>) -> f32 {
        record.largest_aligned()
    }
}
