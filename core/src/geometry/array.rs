//! The elements of the transducer.

use crate::Error;
use crate::error::{at_least_one, finite, positive};

/// Where the elements of a transducer are. They lie at depth 0 and look down.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Array<'a> {
    /// A linear array, centred on 0.
    Linear {
        /// The number of elements, M.
        elements: usize,
        /// From one element to the next, m.
        pitch: f64,
    },
    /// A linear array by the lateral position of each element, m: ascending and evenly spaced, up to
    /// rounding.
    LinearAt(&'a [f64]),
}

impl Array<'_> {
    /// A linear array of `elements`, `pitch` m apart.
    pub const fn linear(elements: usize, pitch: f64) -> Self {
        Array::Linear { elements, pitch }
    }

    /// The number of elements, M.
    pub const fn elements(&self) -> usize {
        match *self {
            Array::Linear { elements, .. } => elements,
            Array::LinearAt(x) => x.len(),
        }
    }

    /// The lateral position of an element, m; NaN beyond the last.
    ///
    /// ```
    /// use bonebeam::geometry::Array;
    ///
    /// let array = Array::Linear { elements: 4, pitch: 0.3e-3 };
    /// assert_eq!(array.x(0), -1.5 * 0.3e-3);
    /// assert_eq!(Array::LinearAt(&[-1e-3, 0.0, 1e-3]).x(2), 1e-3);
    /// ```
    #[inline]
    pub const fn x(&self, element: usize) -> f64 {
        match *self {
            Array::Linear { elements, pitch } if element < elements => {
                (element as f64 - (elements - 1) as f64 / 2.0) * pitch
            }
            Array::LinearAt(x) if element < x.len() => x[element],
            _ => f64::NAN,
        }
    }

    /// The spacing of the elements, m; NaN where their positions are given and there is only one.
    pub const fn pitch(&self) -> f64 {
        match *self {
            Array::Linear { pitch, .. } => pitch,
            Array::LinearAt(x) => match x {
                [first, .., last] => (*last - *first) / (x.len() - 1) as f64,
                _ => f64::NAN,
            },
        }
    }

    /// Refuses an array without elements, and positions that are not finite.
    pub(crate) const fn check(&self) -> Result<(), Error> {
        if let Err(error) = at_least_one("elements", self.elements()) {
            return Err(error);
        }
        match *self {
            Array::Linear { pitch, .. } => match positive("pitch", pitch) {
                Ok(()) => finite("element_x", self.x(0)),
                Err(error) => Err(error),
            },
            Array::LinearAt(x) => {
                let mut m = 0;
                while m < x.len() {
                    if let Err(error) = finite("element_x", x[m]) {
                        return Err(error);
                    }
                    m += 1;
                }
                Ok(())
            }
        }
    }
}
