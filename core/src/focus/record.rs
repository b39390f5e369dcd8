//! The RF of one transmit.

use crate::Error;
use crate::error::{check_length, none};
use core::num::NonZeroUsize;

/// The largest magnitude accepted in the RF, so that no sum can overflow: the filters multiply it by
/// less than 100, and adding that to the largest float is lost in its last place.
pub const MAX_MAGNITUDE: f32 = 1e30;

/// What the elements recorded of one transmit, row-major `[element][sample]`, checked once for all
/// the lines that read it.
#[derive(Clone, Copy, Debug)]
pub struct Record<'a> {
    rf: &'a [f32],
    elements: NonZeroUsize,
}

impl<'a> Record<'a> {
    /// Checks that `rf` holds as many samples of each of `elements` elements, all within
    /// ±[`MAX_MAGNITUDE`].
    ///
    /// ```
    /// use bonebeam::focus::Record;
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
        // A whole piece at a time, since that needs no branch a sample; true for a NaN, too.
        let beyond = |value: &f32| !(-MAX_MAGNITUDE..=MAX_MAGNITUDE).contains(value);
        let all_within = |piece: &[f32]| !piece.iter().fold(false, |any, x| any | beyond(x));
        if rf.chunks(256).all(all_within) {
            return Ok(Record { rf, elements });
        }
        let index = rf.iter().position(beyond).unwrap_or(0);
        match rf.get(index) {
            Some(value) if value.is_finite() => Err(Error::Parameter {
                name: "rf",
                value: f64::from(*value),
                expected: "a magnitude of at most 1e30",
            }),
            _ => Err(Error::NonFinite { name: "rf", index }),
        }
    }

    /// The number of elements.
    pub fn elements(&self) -> usize {
        self.elements.get()
    }

    /// The samples of each element.
    pub fn samples(&self) -> usize {
        self.rf.len() / self.elements
    }

    /// The samples of one element.
    pub(super) fn element(&self, element: usize) -> &'a [f32] {
        let samples = self.samples();
        let own = element * samples..(element + 1) * samples;
        self.rf.get(own).unwrap_or_default()
    }
}
