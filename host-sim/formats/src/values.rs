//! Arrays of a foreign file, as its format's reader hands them on.

use std::ops::Range;

use ndarray::{ArrayD, IxDyn};
use num_complex::Complex;

use crate::guard::ReadResult;
use bonebeam_files::{Error, Result};

/// Samples, row-major in the order of axes that the file's users see.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Real ones.
    Real(ArrayD<f32>),
    /// Complex ones.
    Complex(ArrayD<Complex<f32>>),
}

impl Values {
    /// Their shape.
    pub fn shape(&self) -> &[usize] {
        match self {
            Values::Real(values) => values.shape(),
            Values::Complex(values) => values.shape(),
        }
    }
}

/// A part of an array: an axis, and which indices along it. What lies beyond the array is left out.
pub type AxisRange = (usize, Range<usize>);

/// Named arrays: what the file's format is made of, whatever it calls them.
pub trait NamedArrays {
    /// An error about this file.
    fn error(&self, message: String) -> Error;

    /// The names of its arrays.
    fn names(&self) -> Vec<String>;

    /// Real numbers, exactly or rounded to f64.
    ///
    /// # Errors
    /// None of that name, of another type, or damaged.
    fn numbers(&self, name: &str) -> Result<ArrayD<f64>>;

    /// The shape of samples of which parts can be read; none where they are read whole.
    ///
    /// # Errors
    /// None of that name, or damaged.
    fn shape_for_parts(&self, name: &str) -> Result<Option<Vec<usize>>>;

    /// Samples, rounded to f32, or a part of them. Unsigned bytes have their zero at 128.
    ///
    /// # Errors
    /// None of that name, of another type, or damaged.
    fn samples(&self, name: &str, part: Option<AxisRange>) -> Result<Values>;

    /// Whether there is an array of that name.
    fn has(&self, name: &str) -> bool {
        self.names().iter().any(|known| known == name)
    }

    /// One number, of an array that holds just that.
    ///
    /// # Errors
    /// As [`NamedArrays::numbers`], and more than one number.
    fn scalar(&self, name: &str) -> Result<f64> {
        let numbers = self.numbers(name)?;
        match numbers.len() {
            1 => Ok(numbers.sum()),
            count => Err(self.error(format!("`{name}` has {count} numbers; expected one"))),
        }
    }

    /// The numbers of an array along one axis, whichever other axes of length 1 it has.
    ///
    /// # Errors
    /// As [`NamedArrays::numbers`], and more than one axis.
    fn vector(&self, name: &str) -> Result<Vec<f64>> {
        let numbers = self.numbers(name)?;
        if numbers.shape().iter().filter(|&&side| side > 1).count() > 1 {
            return Err(self.error(format!(
                "`{name}` has shape {:?}; expected one axis",
                numbers.shape()
            )));
        }
        Ok(numbers.iter().copied().collect())
    }
}

/// An array of these numbers in row-major order.
///
/// # Errors
/// Another number of them than the shape has.
pub fn array<T>(shape: &[usize], values: Vec<T>) -> ReadResult<ArrayD<T>> {
    let count = values.len();
    ArrayD::from_shape_vec(IxDyn(shape), values)
        .map_err(|_| format!("holds {count} numbers in a shape of {shape:?}"))
}
