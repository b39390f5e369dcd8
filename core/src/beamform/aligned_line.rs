//! Aligned samples of one beam.

use crate::Error;
use crate::error::{none, not_negative};
use crate::magnitude::largest_part;
use core::num::NonZeroUsize;
use core::ops::Range;
use num_complex::Complex;

/// Largest distance of a line's exponent from that of 1 for sums without scaling.
const MODERATE: u32 = 64;

/// Aligned analytic samples of one beam, `[sample][element]`, checked once.
///
/// Row-major: a whole line ([`AlignedLine::new`]) or a block of a line ([`LinePipeline::align`]).
///
/// [`LinePipeline::align`]: crate::pipeline::LinePipeline::align
#[derive(Clone, Copy, Debug)]
pub struct AlignedLine<'a> {
    /// The samples, from sample `first` on.
    x: &'a [Complex<f32>],
    first: usize,
    /// Number of samples of the whole line.
    samples: usize,
    elements: NonZeroUsize,
    /// Exponent bits of the largest component, limited so that the reciprocal is normal.
    exponent: u32,
}

impl<'a> AlignedLine<'a> {
    /// Checks that `x` holds whole snapshots of `elements` finite samples.
    ///
    /// # Errors
    /// [`Error::Parameter`] for no elements, [`Error::Length`] for an empty or ragged `x`,
    /// [`Error::NonFinite`] with the index into `x` (`sample·elements + element`).
    pub fn new(x: &'a [Complex<f32>], elements: usize) -> Result<Self, Error> {
        let Some(elements) = NonZeroUsize::new(elements) else {
            return Err(none("elements"));
        };
        if x.is_empty() || x.len() % elements != 0 {
            let samples = (x.len() / elements).max(1);
            return Err(Error::length(
                "aligned samples",
                x.len(),
                samples * elements.get(),
            ));
        }
        let largest = largest_part(x);
        if largest >= f32::INFINITY.to_bits() {
            let index = x.iter().position(|value| !value.is_finite()).unwrap_or(0);
            return Err(Error::NonFinite {
                name: "aligned samples",
                index,
            });
        }
        Ok(AlignedLine {
            x,
            first: 0,
            samples: x.len() / elements,
            elements,
            exponent: exponent(largest),
        })
    }

    /// Marks the samples as a block of a line of `samples` samples, from `first` on.
    ///
    /// # Errors
    /// [`Error::Capacity`] for a block that ends after the line.
    pub fn of_line(self, first: usize, samples: usize) -> Result<Self, Error> {
        let end = first.saturating_add(self.x.len() / self.elements);
        if end > samples {
            return Err(Error::capacity("block", end, samples));
        }
        Ok(AlignedLine {
            first,
            samples,
            ..self
        })
    }

    /// The same samples at the working scale of a whole line.
    ///
    /// `largest` is the largest component of that line. A part of a line has its own scale otherwise, and so other bits
    /// in samples 300 dB below the rest. A `largest` below that of the samples has no effect.
    ///
    /// # Errors
    /// [`Error::Parameter`] unless `largest` is finite and at least 0.
    pub fn of_largest(self, largest: f32) -> Result<Self, Error> {
        not_negative("largest", largest)?;
        let exponent = exponent(largest.to_bits()).max(self.exponent);
        Ok(AlignedLine { exponent, ..self })
    }

    /// A block of a line of `samples` samples: whole snapshots from sample `first` on. `largest` bounds the magnitudes
    /// of the line and sets the working scale, which all blocks share.
    pub(crate) fn block(
        x: &'a [Complex<f32>],
        elements: NonZeroUsize,
        (first, samples): (usize, usize),
        largest: f32,
    ) -> Self {
        AlignedLine {
            x,
            first,
            samples,
            elements,
            exponent: exponent(largest.to_bits()),
        }
    }

    /// Number of elements.
    pub fn elements(&self) -> usize {
        self.elements.get()
    }

    /// Number of samples of the whole line.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Whether all of these samples are present; a block has only a part of its line.
    pub(super) fn holds(&self, samples: Range<usize>) -> bool {
        self.first <= samples.start && samples.end <= self.end()
    }

    /// The index after the last sample present; a block may end before its line.
    pub(super) fn end(&self) -> usize {
        self.first + self.x.len() / self.elements
    }

    /// The snapshot of one sample, and those after it.
    pub(super) fn samples_from(&self, sample: usize) -> &'a [Complex<f32>] {
        let first = sample
            .wrapping_sub(self.first)
            .wrapping_mul(self.elements.get());
        self.x.get(first..).unwrap_or_default()
    }

    /// The power of two that brings the line's largest component into `[1, 2)` (`[2, 4)` for the largest floats).
    /// Squares can then neither overflow nor, above −300 dB, underflow. A line scaled by a power of two gives the same
    /// numbers, scaled.
    pub(super) fn scale(&self) -> f32 {
        f32::from_bits((254 - self.exponent) << 23)
    }

    /// Whether sums of the line's samples need no scale.
    ///
    /// The largest component is then far from both ends of the floats' range.
    pub(super) fn is_moderate(&self) -> bool {
        self.exponent.abs_diff(127) <= MODERATE
    }

    /// `value` at the line's own scale, at most `f32::MAX` in magnitude.
    pub(super) fn unscale(&self, value: Complex<f32>) -> Complex<f32> {
        let factor = f32::from_bits(self.exponent << 23);
        Complex::new(saturate(value.re * factor), saturate(value.im * factor))
    }
}

/// Exponent bits of a magnitude, limited so that the reciprocal is normal.
fn exponent(magnitude: u32) -> u32 {
    (magnitude >> 23).clamp(1, 253)
}

fn saturate(x: f32) -> f32 {
    if x.abs() > f32::MAX {
        return largest_of_sign(x);
    }
    x
}

/// A separate function: seven instructions fewer a number on a Cortex-M7.
#[cold]
#[inline(never)]
fn largest_of_sign(x: f32) -> f32 {
    f32::MAX.copysign(x)
}

/// Prints the shape, not the samples.
#[cfg(feature = "defmt")]
impl defmt::Format for AlignedLine<'_> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(
            f,
            "aligned line of {} samples of {} elements",
            self.samples(),
            self.elements()
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At the top of the floats' range the working scale is 2⁻¹²⁶.
    #[test]
    fn what_leaves_f32_is_the_largest_number() {
        let x = [Complex::new(f32::MAX, 0.0)];
        let line = AlignedLine::new(&x, 1).expect("finite");
        let largest = Complex::new(f32::MAX, f32::MIN);
        assert_eq!(line.unscale(Complex::new(4.0, -4.0)), largest);
        let half = 0.5 * f32::MAX;
        let scaled = Complex::new(half, -half) * line.scale();
        assert_eq!(line.unscale(scaled), Complex::new(half, -half));
    }
}
