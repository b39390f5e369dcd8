//! The I/Q of one transmit.

use core::num::NonZeroUsize;

use crate::delay::MAX_MAGNITUDE;
use crate::delay::stage::Source;
use crate::error::{check_length, finite, none};
use crate::magnitude::largest_part;
use crate::{Complex, Error};

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

/// I/Q of one transmit, checked once for all lines that read it.
///
/// The samples stay in the caller's memory.
#[derive(Clone, Copy, Debug)]
pub struct IqRecord<'a> {
    samples: IqSamples<'a>,
    layout: IqLayout,
    elements: NonZeroUsize,
    length: usize,
    /// Phase of the demodulator, in cycles.
    cycles: f64,
    /// The largest magnitude.
    largest: f32,
}

/// Source of a line.
pub(super) type IqSource<'a> = Source<'a, IqRecord<'a>>;

impl<'a> IqRecord<'a> {
    /// Checks shape and magnitude of the samples of `elements` elements.
    ///
    /// Each element has the same number of samples, and both parts are within ±[`MAX_MAGNITUDE`]. The samples are
    /// demodulated with e^(−j2π·f_demod·t), where t has the same origin as t0.
    ///
    /// ```
    /// use bonebeam::delay::{IqLayout, IqRecord, IqSamples};
    ///
    /// // Two samples of each of three elements, as an ADC of 16 bits delivers them.
    /// let counts = [[0, 0], [1, -1], [300, 20], [-4, 0], [5, 5], [0, 7]];
    /// let samples = IqSamples::Counts(&counts, 1.0 / 32768.0);
    /// let record = IqRecord::new(samples, IqLayout::Interleaved, 3)?;
    /// assert_eq!((record.elements(), record.samples()), (3, 2));
    /// # Ok::<(), bonebeam::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Parameter`] for no elements, or a sample or scale beyond the magnitude; [`Error::Length`] for an
    /// empty or ragged slice; [`Error::NonFinite`] with the index of a sample.
    pub fn new(samples: IqSamples<'a>, layout: IqLayout, elements: usize) -> Result<Self, Error> {
        let Some(elements) = NonZeroUsize::new(elements) else {
            return Err(none("elements"));
        };
        let count = match samples {
            IqSamples::Float(samples) => samples.len(),
            IqSamples::Counts(samples, _) => samples.len(),
        };
        let length = (count / elements).max(1);
        check_length("iq", count, elements.get().saturating_mul(length))?;
        let largest = match samples {
            IqSamples::Float(samples) => checked_magnitude(samples)?,
            IqSamples::Counts(_, scale) => {
                finite("iq scale", f64::from(scale))?;
                const LARGEST: f32 = MAX_MAGNITUDE / 32768.0;
                if !(-LARGEST..=LARGEST).contains(&scale) {
                    return Err(Error::Parameter {
                        name: "iq scale",
                        value: f64::from(scale),
                        expected: "a magnitude of at most 1e29 over 32768",
                    });
                }
                32768.0 * if scale < 0.0 { -scale } else { scale }
            }
        };
        Ok(IqRecord {
            samples,
            layout,
            elements,
            length,
            cycles: 0.0,
            largest,
        })
    }

    /// Adds a phase of the demodulator: e^(−j(2π·f_demod·t + phase)), rad.
    ///
    /// For a demodulator whose time origin differs from that of t0, or for a lens that delays all echoes.
    ///
    /// # Errors
    /// [`Error::Parameter`] unless `phase` is finite.
    pub fn with_phase(self, phase: f64) -> Result<Self, Error> {
        finite("iq phase", phase)?;
        Ok(IqRecord {
            cycles: phase / (2.0 * core::f64::consts::PI),
            ..self
        })
    }

    /// Number of elements.
    pub fn elements(&self) -> usize {
        self.elements.get()
    }

    /// Number of samples of each element.
    pub fn samples(&self) -> usize {
        self.length
    }

    /// Upper bound of the parts of an aligned sample.
    ///
    /// Interpolation has a gain of at most 2.3, and rotation √2.
    pub(in crate::delay) fn largest_aligned(&self) -> f32 {
        4.0 * self.largest
    }

    pub(super) fn cycles(&self) -> f64 {
        self.cycles
    }

    /// Factor of the samples.
    pub(super) fn scale(&self) -> f32 {
        match self.samples {
            IqSamples::Float(_) => 1.0,
            IqSamples::Counts(_, scale) => scale,
        }
    }

    pub(super) fn kind(&self) -> IqSamples<'a> {
        self.samples
    }

    /// Position of samples of the type `T` in memory.
    pub(super) fn window<T>(&self, samples: &'a [T]) -> Window<'a, T> {
        let elements = self.elements.get();
        let (element, sample) = match self.layout {
            IqLayout::Planar => (self.length, 1),
            IqLayout::Interleaved => (1, elements),
        };
        Window {
            samples,
            element,
            sample,
            length: self.length,
        }
    }
}

/// Samples of either order, with the strides of elements and of samples.
#[derive(Clone, Copy)]
pub(super) struct Window<'a, T> {
    pub(super) samples: &'a [T],
    pub(super) element: usize,
    pub(super) sample: usize,
    pub(super) length: usize,
}

/// A sample of a record in memory.
pub(super) trait Sample: Copy {
    fn value(self) -> Complex<f32>;
}

impl Sample for Complex<f32> {
    #[inline(always)]
    fn value(self) -> Complex<f32> {
        self
    }
}

impl Sample for [i16; 2] {
    #[inline(always)]
    fn value(self) -> Complex<f32> {
        Complex::new(f32::from(self[0]), f32::from(self[1]))
    }
}

impl<T: Sample> Window<'_, T> {
    /// `TAPS` samples of an element from `first` on; those outside the record are 0.
    #[inline(always)]
    pub(super) fn taps<const TAPS: usize>(
        &self,
        element: usize,
        first: i32,
    ) -> [Complex<f32>; TAPS] {
        let mut taps = [Complex::new(0.0, 0.0); TAPS];
        // A negative index becomes large.
        let first = first as u32 as usize;
        if first < self.length.saturating_sub(TAPS - 1) {
            let start = element * self.element + first * self.sample;
            // A separate path with one comparison for all taps, for vectors. A microcontroller takes 5 % longer with
            // it.
            if cfg!(target_pointer_width = "64")
                && self.sample == 1
                && let Some(samples) = self
                    .samples
                    .get(start..)
                    .and_then(<[T]>::first_chunk::<TAPS>)
            {
                return samples.map(Sample::value);
            }
            for (k, tap) in taps.iter_mut().enumerate() {
                if let Some(sample) = self.samples.get(start + k * self.sample) {
                    *tap = sample.value();
                }
            }
        } else {
            self.at_the_edge(element, first, &mut taps);
        }
        taps
    }

    /// The samples `index` and after it of the element that begins at `first`; 0 outside the record. In front
    /// of it, indices wrap around.
    #[cold]
    #[inline(never)]
    pub(super) fn edge(&self, first: usize, index: u32) -> [T; 2]
    where
        T: Default,
    {
        [0, 1].map(|k| {
            let index = index.wrapping_add(k) as usize;
            let sample = (index < self.length).then(|| first + index * self.sample);
            let sample = sample.and_then(|sample| self.samples.get(sample));
            sample.copied().unwrap_or_default()
        })
    }

    #[cold]
    #[inline(never)]
    fn at_the_edge(&self, element: usize, first: usize, taps: &mut [Complex<f32>]) {
        for (k, tap) in taps.iter_mut().enumerate() {
            // In front of the record, indices wrap around, to its first samples.
            let index = (first as u32).wrapping_add(k as u32) as usize;
            if index < self.length
                && let Some(sample) = self
                    .samples
                    .get(element * self.element + index * self.sample)
            {
                *tap = sample.value();
            }
        }
    }
}

/// The largest magnitude of a part, within the limit.
fn checked_magnitude(samples: &[Complex<f32>]) -> Result<f32, Error> {
    let largest = f32::from_bits(largest_part(samples));
    if largest <= MAX_MAGNITUDE {
        return Ok(largest);
    }
    // True for a NaN, too.
    let beyond = |value: f32| !(-MAX_MAGNITUDE..=MAX_MAGNITUDE).contains(&value);
    let either = |y: &Complex<f32>| beyond(y.re) | beyond(y.im);
    let index = samples.iter().position(either).unwrap_or(0);
    match samples.get(index) {
        Some(y) if y.re.is_finite() && y.im.is_finite() => Err(Error::Parameter {
            name: "iq",
            value: f64::from(if beyond(y.re) { y.re } else { y.im }),
            expected: "magnitudes of at most 1e29",
        }),
        _ => Err(Error::NonFinite { name: "iq", index }),
    }
}

/// Prints the shape, not the samples.
#[cfg(feature = "defmt")]
impl defmt::Format for IqRecord<'_> {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(
            f,
            "I/Q of {} samples of {} elements",
            self.samples(),
            self.elements()
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2.3 of interpolation times √2 of rotation, of samples of any size, as numbers and as counts.
    #[test]
    fn the_bound_of_aligned_samples_grows_with_the_samples() {
        for largest in [0.0, 1e-20f32, 1e-3, 1.0, 1000.0, MAX_MAGNITUDE] {
            let iq = [Complex::new(0.5 * largest, -largest)];
            let scale = -largest / 32768.0;
            for samples in [
                IqSamples::Float(&iq),
                IqSamples::Counts(&[[0, i16::MIN]], scale),
            ] {
                let record = IqRecord::new(samples, IqLayout::Planar, 1).unwrap();
                let bound = record.largest_aligned();
                assert!(
                    bound >= 3.26 * largest && bound <= 4.01 * largest,
                    "{largest}"
                );
            }
        }
    }
}
