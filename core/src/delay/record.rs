//! The samples of one transmit.

use crate::error::{check_length, finite, none};
use crate::geometry::Active;
use crate::magnitude::{largest, largest_part};
use crate::{Complex, Error};
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

/// Samples of one transmit, checked once for all lines that read them.
///
/// They stay in the caller's memory.
#[derive(Clone, Copy, Debug)]
pub struct Record<'a> {
    pub(super) samples: Samples<'a>,
    /// Elements of the array.
    elements: NonZeroUsize,
    /// The elements that were received.
    received: Active,
    length: usize,
    /// Phase of the demodulator of I/Q, in cycles.
    pub(super) cycles: f64,
    /// The largest magnitude.
    largest: f32,
}

/// Baseband samples, as a front end delivers them.
#[derive(Clone, Copy, Debug)]
pub enum IqSamples<'a> {
    /// Complex numbers.
    Float(&'a [Complex<f32>]),
    /// Counts `[I, Q]`, and the value of one count.
    Counts(&'a [[i16; 2]], f32),
}

/// Order of samples in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum IqLayout {
    /// `[element][sample]`, as in recordings.
    Planar,
    /// `[sample][element]`, as a front end sends them.
    Interleaved,
}

/// Samples of a record.
#[derive(Clone, Copy, Debug)]
pub(super) enum Samples<'a> {
    /// `[element][sample]`.
    Rf(&'a [f32]),
    Iq(IqSamples<'a>, IqLayout),
}

impl<'a> Record<'a> {
    /// Checks shape and magnitude of RF, `[element][sample]` of `elements` elements.
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
        let expected = "a magnitude of at most 1e29";
        let largest = || within("rf", expected, largest(rf), rf, |&x| [x]);
        Record::of(Samples::Rf(rf), elements, ("rf", rf.len()), largest)
    }

    /// Checks shape and magnitude of the I/Q of `elements` elements.
    ///
    /// Each element has the same number of samples, and both parts are within ±[`MAX_MAGNITUDE`]. The samples are
    /// demodulated with e^(−j2π·f_demod·t), where t has the same origin as t0.
    ///
    /// ```
    /// use bonebeam::delay::{IqLayout, IqSamples, Record};
    ///
    /// // Two samples of each of three elements, as an ADC of 16 bits delivers them.
    /// let counts = [[0, 0], [1, -1], [300, 20], [-4, 0], [5, 5], [0, 7]];
    /// let samples = IqSamples::Counts(&counts, 1.0 / 32768.0);
    /// let record = Record::iq(samples, IqLayout::Interleaved, 3)?;
    /// assert_eq!((record.elements(), record.samples()), (3, 2));
    /// # Ok::<(), bonebeam::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Parameter`] for no elements, a scale of 0, or a sample or scale beyond the magnitude; [`Error::Length`] for an
    /// empty or ragged slice; [`Error::NonFinite`] with the index of a sample.
    pub fn iq(samples: IqSamples<'a>, layout: IqLayout, elements: usize) -> Result<Self, Error> {
        let count = match samples {
            IqSamples::Float(samples) => samples.len(),
            IqSamples::Counts(samples, _) => samples.len(),
        };
        let largest = || match samples {
            IqSamples::Float(samples) => {
                let expected = "magnitudes of at most 1e29";
                let parts = |y: &Complex<f32>| [y.re, y.im];
                within("iq", expected, largest_part(samples), samples, parts)
            }
            IqSamples::Counts(_, scale) => {
                finite("iq scale", f64::from(scale))?;
                const LARGEST: f32 = MAX_MAGNITUDE / 32768.0;
                let expected = "not 0, with a magnitude of at most 1e29 over 32768";
                match (-LARGEST..=LARGEST).contains(&scale) && scale != 0.0 {
                    true => Ok(32768.0 * if scale < 0.0 { -scale } else { scale }),
                    false => Err(Error::parameter("iq scale", f64::from(scale), expected)),
                }
            }
        };
        Record::of(
            Samples::Iq(samples, layout),
            elements,
            ("iq", count),
            largest,
        )
    }

    /// Adds a phase of the demodulator: e^(−j(2π·f_demod·t + phase)), rad.
    ///
    /// For a demodulator whose time origin differs from that of t0, or for a lens that delays all echoes.
    ///
    /// # Errors
    /// [`Error::Parameter`] unless `phase` is finite.
    pub fn with_phase(self, phase: f64) -> Result<Self, Error> {
        finite("iq phase", phase)?;
        Ok(Record {
            cycles: phase / (2.0 * core::f64::consts::PI),
            ..self
        })
    }

    /// The record of a part of an array, as of a multiplexed probe.
    ///
    /// It begins with element `first` of `elements`. The others are silent. Silence takes no memory, and is neither
    /// delayed nor added: a line of transmits with such records is that of records with zeros, to the bit, except for
    /// the sign of a zero.
    ///
    /// ```
    /// use bonebeam::delay::Record;
    /// use bonebeam::geometry::Active;
    ///
    /// // Two of 16 elements were received.
    /// let record = Record::new(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0], 2)?.part_of(16, 6)?;
    /// assert_eq!((record.elements(), record.samples()), (16, 3));
    /// assert_eq!(record.received(), Active::new(6, 2));
    /// # Ok::<(), bonebeam::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Parameter`] for I/Q; [`Error::Capacity`] for elements that end behind the array.
    pub fn part_of(self, elements: usize, first: usize) -> Result<Self, Error> {
        if let Samples::Iq(..) = self.samples {
            let expected = "RF, for a part of an array";
            return Err(Error::parameter("iq", 0.0, expected));
        }
        let end = first.saturating_add(self.received.count);
        match NonZeroUsize::new(elements).filter(|elements| end <= elements.get()) {
            None => Err(Error::capacity("received elements", end, elements)),
            Some(elements) => Ok(Record {
                elements,
                received: Active::new(first, self.received.count),
                ..self
            }),
        }
    }

    /// A record of `count` samples of all elements.
    fn of(
        samples: Samples<'a>,
        elements: usize,
        (name, count): (&'static str, usize),
        largest: impl FnOnce() -> Result<f32, Error>,
    ) -> Result<Self, Error> {
        let Some(elements) = NonZeroUsize::new(elements) else {
            return Err(none("elements"));
        };
        let length = (count / elements).max(1);
        check_length(name, count, elements.get().saturating_mul(length))?;
        Ok(Record {
            samples,
            elements,
            received: Active::new(0, elements.get()),
            length,
            cycles: 0.0,
            largest: largest()?,
        })
    }

    /// Number of elements of the array.
    pub fn elements(&self) -> usize {
        self.elements.get()
    }

    /// The elements that were received: all, or those of [`Record::part_of`].
    pub fn received(&self) -> Active {
        self.received
    }

    /// Whether elements are silent.
    pub(crate) fn is_part(&self) -> bool {
        self.received.count < self.elements.get()
    }

    /// Number of samples of each element.
    pub fn samples(&self) -> usize {
        self.length
    }

    /// Upper bound of the parts of an aligned sample.
    pub fn largest_aligned(&self) -> f32 {
        match self.samples {
            // Above the filters' gains and their roundings.
            Samples::Rf(_) => 32.0 * self.largest,
            // Interpolation has a gain of at most 2.3, and rotation √2.
            Samples::Iq(..) => 4.0 * self.largest,
        }
    }

    /// The RF of a received element; nothing for I/Q.
    pub(super) fn element(&self, element: usize) -> &'a [f32] {
        let start = element.wrapping_sub(self.received.first) * self.length;
        match self.samples {
            Samples::Rf(rf) => rf.get(start..start + self.length).unwrap_or_default(),
            Samples::Iq(..) => &[],
        }
    }
}

/// The largest magnitude, of which `bits` are given; a refusal of the first sample beyond the limit.
fn within<T, const PARTS: usize>(
    name: &'static str,
    expected: &'static str,
    bits: u32,
    samples: &[T],
    parts: impl Fn(&T) -> [f32; PARTS],
) -> Result<f32, Error> {
    let largest = f32::from_bits(bits);
    if largest <= MAX_MAGNITUDE {
        return Ok(largest);
    }
    // True for a NaN, too.
    let beyond = |part: &f32| !(-MAX_MAGNITUDE..=MAX_MAGNITUDE).contains(part);
    let beyond = |sample: &T| parts(sample).into_iter().find(beyond);
    let index = samples.iter().position(|sample| beyond(sample).is_some());
    let index = index.unwrap_or(0);
    match samples.get(index) {
        Some(sample) if parts(sample).iter().all(|part| part.is_finite()) => {
            let value = f64::from(beyond(sample).unwrap_or(0.0));
            Err(Error::parameter(name, value, expected))
        }
        _ => Err(Error::NonFinite { name, index }),
    }
}

/// Prints the shape, not the samples.
#[cfg(feature = "defmt")]
impl defmt::Format for Record<'_> {
    fn format(&self, f: defmt::Formatter<'_>) {
        let kind = match self.samples {
            Samples::Rf(_) => "RF",
            Samples::Iq(..) => "I/Q",
        };
        let (samples, elements) = (self.samples(), self.elements());
        defmt::write!(
            f,
            "{} of {} samples of {} elements",
            kind,
            samples,
            elements
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

    /// 2.3 of interpolation times √2 of rotation, of samples of any size, as numbers and as counts.
    #[test]
    fn the_bound_of_aligned_samples_grows_with_the_samples() {
        let nothing = Record::iq(IqSamples::Float(&[Complex::ZERO]), IqLayout::Planar, 1);
        assert_eq!(nothing.unwrap().largest_aligned(), 0.0);
        // Counts times 0 would be a black line without a word.
        let black = IqSamples::Counts(&[[0, i16::MIN]], -0.0);
        let refused = Record::iq(black, IqLayout::Planar, 1).unwrap_err();
        assert!(matches!(
            refused,
            Error::Parameter {
                name: "iq scale",
                ..
            }
        ));
        for largest in [1e-20f32, 1e-3, 1.0, 1000.0, MAX_MAGNITUDE] {
            let iq = [Complex::new(0.5 * largest, -largest)];
            let scale = -largest / 32768.0;
            for samples in [
                IqSamples::Float(&iq),
                IqSamples::Counts(&[[0, i16::MIN]], scale),
            ] {
                let record = Record::iq(samples, IqLayout::Planar, 1).unwrap();
                let bound = record.largest_aligned();
                assert!(
                    bound >= 3.26 * largest && bound <= 4.01 * largest,
                    "{largest}"
                );
            }
        }
    }
}
