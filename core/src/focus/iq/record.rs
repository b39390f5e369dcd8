//! The I/Q of one transmit.

use core::num::NonZeroUsize;

use crate::error::{check_length, finite, none};
use crate::focus::MAX_MAGNITUDE;
use crate::{Complex, Error};

/// Samples in the base band, as a front end delivers them.
#[derive(Clone, Copy, Debug)]
pub enum IqSamples<'a> {
    /// Complex numbers.
    Float(&'a [Complex<f32>]),
    /// Counts `[I, Q]`, and what one count is.
    Counts(&'a [[i16; 2]], f32),
}

/// In which order samples lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum IqLayout {
    /// `[element][sample]`, as recordings are.
    Planar,
    /// `[sample][element]`, as a front end sends them.
    Interleaved,
}

/// What the elements recorded of one transmit in the base band, checked once for all the lines that
/// read it, where it lies.
#[derive(Clone, Copy, Debug)]
pub struct IqRecord<'a> {
    samples: IqSamples<'a>,
    layout: IqLayout,
    elements: NonZeroUsize,
    length: usize,
    phase: f64,
}

impl<'a> IqRecord<'a> {
    /// Checks that there are as many samples of each of `elements` elements, both parts within
    /// ±[`MAX_MAGNITUDE`]. Demodulated with e^(−j2π·f_demod·t), with t from the same moment as t0.
    ///
    /// ```
    /// use bonebeam::focus::{IqLayout, IqRecord, IqSamples};
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
    /// [`Error::Parameter`] for no elements, or a sample or scale beyond the magnitude, [`Error::Length`]
    /// for samples that are none or ragged, [`Error::NonFinite`] with the index of a sample.
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
        match samples {
            IqSamples::Float(samples) => check_magnitudes(samples)?,
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
            }
        }
        Ok(IqRecord {
            samples,
            layout,
            elements,
            length,
            phase: 0.0,
        })
    }

    /// The same samples, demodulated with e^(−j(2π·f_demod·t + phase)), rad: where the demodulator began
    /// at another moment than that from which t0 counts, or where a lens delays all of it.
    ///
    /// # Errors
    /// [`Error::Parameter`] unless `phase` is finite.
    pub fn with_phase(self, phase: f64) -> Result<Self, Error> {
        finite("iq phase", phase)?;
        Ok(IqRecord { phase, ..self })
    }

    /// The number of elements.
    pub fn elements(&self) -> usize {
        self.elements.get()
    }

    /// The samples of each element.
    pub fn samples(&self) -> usize {
        self.length
    }

    pub(super) fn phase(&self) -> f64 {
        self.phase
    }

    /// What the samples are to be multiplied by.
    pub(super) fn scale(&self) -> f32 {
        match self.samples {
            IqSamples::Float(_) => 1.0,
            IqSamples::Counts(_, scale) => scale,
        }
    }

    /// `TAPS` samples of an element from `first` on; those outside the record are 0.
    #[inline(always)]
    pub(super) fn window<const TAPS: usize>(
        &self,
        element: usize,
        first: i32,
    ) -> [Complex<f32>; TAPS] {
        match self.samples {
            IqSamples::Float(samples) => self.taps(samples, element, first, |&sample| sample),
            IqSamples::Counts(samples, _) => self.taps(samples, element, first, |&[i, q]| {
                Complex::new(f32::from(i), f32::from(q))
            }),
        }
    }

    #[inline(always)]
    fn taps<T, const TAPS: usize>(
        &self,
        samples: &[T],
        element: usize,
        first: i32,
        value: impl Fn(&T) -> Complex<f32>,
    ) -> [Complex<f32>; TAPS] {
        let mut taps = [Complex::new(0.0, 0.0); TAPS];
        let elements = self.elements.get();
        // What is negative becomes large.
        let first = first as u32 as usize;
        let inside = first
            .checked_add(TAPS)
            .is_some_and(|end| end <= self.length);
        match (self.layout, inside) {
            (IqLayout::Planar, true) => {
                let start = element * self.length + first;
                if let Some(under) = samples.get(start..start + TAPS) {
                    for (tap, sample) in taps.iter_mut().zip(under) {
                        *tap = value(sample);
                    }
                }
            }
            (IqLayout::Interleaved, true) => {
                let start = first * elements + element;
                for (k, tap) in taps.iter_mut().enumerate() {
                    if let Some(sample) = samples.get(start + k * elements) {
                        *tap = value(sample);
                    }
                }
            }
            (_, false) => {
                for (k, tap) in taps.iter_mut().enumerate() {
                    // In front of the record, indices wrap around, to its first samples.
                    let index = (first as u32).wrapping_add(k as u32) as usize;
                    let place = match self.layout {
                        IqLayout::Planar => element * self.length + index,
                        IqLayout::Interleaved => index.saturating_mul(elements) + element,
                    };
                    if index < self.length
                        && let Some(sample) = samples.get(place)
                    {
                        *tap = value(sample);
                    }
                }
            }
        }
        taps
    }
}

fn check_magnitudes(samples: &[Complex<f32>]) -> Result<(), Error> {
    // A whole piece at a time, since that needs no branch a sample; true for a NaN, too.
    let beyond = |value: f32| !(-MAX_MAGNITUDE..=MAX_MAGNITUDE).contains(&value);
    let either = |y: &Complex<f32>| beyond(y.re) | beyond(y.im);
    let all_within = |piece: &[Complex<f32>]| !piece.iter().fold(false, |any, y| any | either(y));
    if samples.chunks(256).all(all_within) {
        return Ok(());
    }
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

/// Its shape; not its samples.
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
