//! The RF of one transmit.

use crate::Error;
use crate::error::{check_length, none};
use crate::magnitude::largest;
use core::num::NonZeroUsize;

/// Largest accepted magnitude of RF, so that no sum overflows.
///
/// The filters multiply it by less than 17 (`no_parameters_multiply_more`, below). Compounding adds the result to an
/// existing line. A value below 2¹⁰³ = 1.01·10³¹, half a unit in the last place of the largest float, is lost in that
/// addition: a gain of 100 would still be safe.
pub const MAX_MAGNITUDE: f32 = 1e29;

/// Largest gain of the filters in sequence.
///
/// The gain of a filter is at most the sum of its magnitudes: halvings 1.42 and twice 1.25, interpolation 2.2 (16
/// taps; no more between two rows of its table than in one), Hilbert transformer 3.4 with the most taps. The
/// largest gain seen for records is 3.8.
#[cfg(test)]
const LARGEST_GAIN: f64 = 1.42 * 1.25 * 1.25 * 2.2 * 3.4;

/// RF of one transmit, `[element][sample]`, checked once for all its lines.
#[derive(Clone, Copy, Debug)]
pub struct Record<'a> {
    rf: &'a [f32],
    elements: NonZeroUsize,
    /// The largest magnitude.
    largest: f32,
}

impl<'a> Record<'a> {
    /// Checks shape and magnitude of the RF of `elements` elements.
    ///
    /// Each element has the same number of samples, all within ±[`MAX_MAGNITUDE`].
    ///
    /// ```
    /// use bonebeam::delay::Record;
    ///
    /// let record = Record::new(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0], 2)?;
    /// assert_eq!((record.elements(), record.samples()), (2, 3));
    /// # Ok::<(), bonebeam::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Parameter`] for no elements or a sample beyond the magnitude, [`Error::Length`] for an
    /// empty or ragged `rf`, [`Error::NonFinite`] with the index into `rf`
    /// (`element·samples + sample`).
    pub fn new(rf: &'a [f32], elements: usize) -> Result<Self, Error> {
        let Some(elements) = NonZeroUsize::new(elements) else {
            return Err(none("elements"));
        };
        let samples = (rf.len() / elements).max(1);
        check_length("rf", rf.len(), elements.get().saturating_mul(samples))?;
        let largest = f32::from_bits(largest(rf));
        if largest <= MAX_MAGNITUDE {
            return Ok(Record {
                rf,
                elements,
                largest,
            });
        }
        // True for a NaN, too.
        let beyond = |value: &f32| !(-MAX_MAGNITUDE..=MAX_MAGNITUDE).contains(value);
        let index = rf.iter().position(beyond).unwrap_or(0);
        match rf.get(index) {
            Some(value) if value.is_finite() => Err(Error::Parameter {
                name: "rf",
                value: f64::from(*value),
                expected: "a magnitude of at most 1e29",
            }),
            _ => Err(Error::NonFinite { name: "rf", index }),
        }
    }

    /// Number of elements.
    pub fn elements(&self) -> usize {
        self.elements.get()
    }

    /// Number of samples of each element.
    pub fn samples(&self) -> usize {
        self.rf.len() / self.elements
    }

    /// Upper bound of the parts of an aligned sample.
    pub(super) fn largest_aligned(&self) -> f32 {
        // Above the filters' gains and their roundings.
        32.0 * self.largest
    }

    /// The samples of one element.
    pub(super) fn element(&self, element: usize) -> &'a [f32] {
        let samples = self.samples();
        let own = element * samples..(element + 1) * samples;
        self.rf.get(own).unwrap_or_default()
    }
}

/// Prints the shape, not the samples.
#[cfg(feature = "defmt")]
impl defmt::Format for Record<'_> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(
            f,
            "RF of {} samples of {} elements",
            self.samples(),
            self.elements()
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delay::MAX_HILBERT_TAPS;
    use crate::delay::analytic::HilbertTransformer;
    use crate::delay::interpolate::Interpolator;

    /// Gains of the filters over all rates and pulses that change them.
    ///
    /// These are the ratio of the rates, and the ratio of the pulse's frequency to them, from the widest to the
    /// narrowest window. The filters are smooth between the steps, and a tenth of [`LARGEST_GAIN`] is margin.
    #[test]
    fn no_parameters_multiply_more() {
        let mut largest = 0.0f64;
        for step in (1..=640).step_by(crate::step(213)) {
            let ratio = f64::from(step) / 40.0;
            for frequency in [1e-3, 0.25, 0.5, 1e3].into_iter().step_by(crate::step(3)) {
                let mut filter = Interpolator::NONE;
                filter.set(ratio, 1.0, frequency).unwrap();
                largest = largest.max(filter.gain() * filter.decimator().gain());
            }
        }
        let mut of_hilbert = 0.0f64;
        for taps in (1..=MAX_HILBERT_TAPS).step_by(crate::step(21)) {
            of_hilbert = of_hilbert.max(HilbertTransformer::new(taps).unwrap().gain());
        }
        let gain = largest * of_hilbert;
        assert!(
            gain > 10.0 && gain <= LARGEST_GAIN,
            "{largest} {of_hilbert}"
        );
        assert!(gain < 0.6 * 32.0);
        // The roundings of the sums, too, are lost in the rest.
        assert!(f64::from(MAX_MAGNITUDE) * LARGEST_GAIN * 5.0 < libm::exp2(103.0));
        assert_eq!(
            f32::MAX + 5.0 * (MAX_MAGNITUDE * LARGEST_GAIN as f32),
            f32::MAX
        );
    }
}
