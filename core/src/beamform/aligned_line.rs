//! The aligned samples of one beam.

use crate::Error;
use crate::error::none;
use core::num::NonZeroUsize;
use num_complex::Complex;

/// The largest exponent of a line whose samples are summed as they are, and the least, negative.
const MODERATE: u32 = 64;

/// Aligned analytic samples of one beam, row-major `[sample][element]`, checked once.
#[derive(Clone, Copy, Debug)]
pub struct AlignedLine<'a> {
    x: &'a [Complex<f32>],
    elements: NonZeroUsize,
    /// The exponent bits of the largest component, within what a normal reciprocal allows.
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
            return Err(Error::Length {
                name: "aligned samples",
                actual: x.len(),
                expected: samples * elements.get(),
            });
        }
        let largest = largest_magnitude(x);
        if largest >= f32::INFINITY.to_bits() as i32 {
            let index = x.iter().position(|value| !value.is_finite()).unwrap_or(0);
            return Err(Error::NonFinite {
                name: "aligned samples",
                index,
            });
        }
        let exponent = (largest >> 23).clamp(1, 253) as u32;
        Ok(AlignedLine {
            x,
            elements,
            exponent,
        })
    }

    /// The number of elements.
    pub fn elements(&self) -> usize {
        self.elements.get()
    }

    /// The number of samples.
    pub fn samples(&self) -> usize {
        self.x.len() / self.elements
    }

    /// The snapshot of one sample, and those after it.
    pub(super) fn samples_from(&self, sample: usize) -> &'a [Complex<f32>] {
        let first = sample * self.elements.get();
        self.x.get(first..).unwrap_or_default()
    }

    /// The power of two that brings the line's largest component into `[1, 2)` (`[2, 4)` for the
    /// largest floats): squares can then neither overflow nor, above −300 dB, underflow, and a line
    /// scaled by a power of two gives the same numbers scaled.
    pub(super) fn scale(&self) -> f32 {
        f32::from_bits((254 - self.exponent) << 23)
    }

    /// Whether the largest component is so far from both ends of the floats' range that sums of the
    /// line's samples need no scale.
    pub(super) fn is_moderate(&self) -> bool {
        self.exponent.abs_diff(127) <= MODERATE
    }

    /// `value` back at the line's own scale, at most `f32::MAX` in magnitude.
    pub(super) fn unscale(&self, value: Complex<f32>) -> Complex<f32> {
        let factor = f32::from_bits(self.exponent << 23);
        Complex::new(saturate(value.re * factor), saturate(value.im * factor))
    }
}

fn saturate(x: f32) -> f32 {
    if x > f32::MAX {
        f32::MAX
    } else if x < f32::MIN {
        f32::MIN
    } else {
        x
    }
}

/// The bits of the largest magnitude of all parts: they order as the magnitudes do, and what is not
/// finite comes last.
fn largest_magnitude(x: &[Complex<f32>]) -> i32 {
    if cfg!(target_pointer_width = "32") {
        // Without vectors one chain is best, and a shift is part of Arm's comparison.
        let mut largest = 0;
        for value in x {
            for part in [value.re, value.im] {
                let doubled = part.to_bits() << 1;
                largest = if largest < doubled { doubled } else { largest };
            }
        }
        return (largest >> 1) as i32;
    }
    // Side by side for registers of any size, and signed, since SSE2 compares no others.
    const SIDE_BY_SIDE: usize = 8;
    let mut largest = [0; 2 * SIDE_BY_SIDE];
    let (blocks, rest) = x.as_chunks::<SIDE_BY_SIDE>();
    for block in blocks {
        let mut parts = [0; 2 * SIDE_BY_SIDE];
        for (parts, value) in parts.as_chunks_mut::<2>().0.iter_mut().zip(block) {
            *parts = [magnitude(value.re), magnitude(value.im)];
        }
        for (largest, part) in largest.iter_mut().zip(parts) {
            *largest = if *largest < part { part } else { *largest };
        }
    }
    let mut all = 0;
    let rest = rest
        .iter()
        .flat_map(|value| [magnitude(value.re), magnitude(value.im)]);
    for part in largest.into_iter().chain(rest) {
        all = if all < part { part } else { all };
    }
    all
}

fn magnitude(part: f32) -> i32 {
    (part.to_bits() & 0x7fff_ffff) as i32
}

/// Its shape; not its samples.
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
