//! Arrays of a file, as its format's reader returns them.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::ops::Range;

use ndarray::{ArrayD, Axis, IxDyn};
use num_complex::Complex;

use crate::guard::ReadResult;
use bonebeam_files::{Error, Result};

/// Samples, row-major in the order of axes that users see.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Real samples.
    Real(ArrayD<f32>),
    /// Complex samples.
    Complex(ArrayD<Complex<f32>>),
}

impl Values {
    /// Shape of the samples.
    pub fn shape(&self) -> &[usize] {
        match self {
            Values::Real(values) => values.shape(),
            Values::Complex(values) => values.shape(),
        }
    }
}

/// A part of an array: an axis, and a range of indices along it.
///
/// Indices beyond the array are left out.
pub type AxisRange = (usize, Range<usize>);

/// Names of the arrays that were read.
#[derive(Default)]
pub struct Reads(RefCell<BTreeSet<String>>);

impl Reads {
    /// Notes that an array was read.
    pub fn note(&self, name: &str) {
        self.0.borrow_mut().insert(plain(name));
    }

    /// The names of which no array was read.
    ///
    /// Entries of an array of structs or of a cell are one name.
    pub fn without(&self, mut names: Vec<String>) -> Vec<String> {
        let read = self.0.borrow();
        names.retain(|name| !read.contains(&plain(name)));
        for name in &mut names {
            if steps(name).iter().any(|(_, entry)| entry.is_some()) {
                *name = plain(name).replace('/', ".");
            }
        }
        let mut known = BTreeSet::new();
        names.retain(|name| known.insert(name.clone()));
        names
    }
}

/// The steps of a path without the entries that they select.
fn plain(path: &str) -> String {
    let steps: Vec<&str> = steps(path).iter().map(|(step, _)| *step).collect();
    steps.join("/")
}

/// Named arrays of a file, independent of its format.
pub trait NamedArrays {
    /// An error about this file.
    fn error(&self, message: String) -> Error;

    /// An error about the shape of an array.
    fn misshapen(&self, name: &str, shape: &[usize], expected: &str) -> Error {
        self.error(format!("`{name}` has shape {shape:?}; expected {expected}"))
    }

    /// The names of its arrays.
    fn names(&self) -> Vec<String>;

    /// Notes that the arrays are read for which a name stands.
    fn note(&self, _: &str) {}

    /// The names of the arrays that were not read until now.
    fn unread(&self) -> Vec<String> {
        Vec::new()
    }

    /// Real numbers, exactly or rounded to f64.
    ///
    /// # Errors
    /// There is no such array, it has another type, or it is damaged.
    fn numbers(&self, name: &str) -> Result<ArrayD<f64>>;

    /// Shape of samples that can be read in parts.
    ///
    /// `None` if they are read whole.
    ///
    /// # Errors
    /// There is no such array, or it is damaged.
    fn shape_for_parts(&self, name: &str) -> Result<Option<Vec<usize>>>;

    /// Samples, rounded to f32, or a part of them.
    ///
    /// The zero of unsigned bytes is 128.
    ///
    /// # Errors
    /// There is no such array, it has another type, or it is damaged.
    fn samples(&self, name: &str, part: Option<AxisRange>) -> Result<Values>;

    /// The sides of an array of numbers, in the order of axes that users see.
    fn sides(&self, name: &str) -> Option<Vec<usize>>;

    /// The arrays that a name stands for.
    ///
    /// One, all of a cell, or a field of all structs of an array. Steps of the name are separated by `.` or `/`;
    /// `{3}` or `(3)` after a step selects one.
    fn entries(&self, name: &str) -> Vec<String> {
        let known = self.names().into_iter();
        known.filter(|known| known == name).collect()
    }

    /// Whether there is an array with this name.
    fn has(&self, name: &str) -> bool {
        !self.entries(name).is_empty()
    }

    /// A text.
    ///
    /// # Errors
    /// As [`NamedArrays::numbers`]: text is read as the codes of its characters.
    fn text(&self, name: &str) -> Result<String> {
        let codes = self.numbers(name)?;
        let text = codes.iter().map(|&code| char::from_u32(code as u32));
        Ok(text.map(|c| c.unwrap_or('?')).collect())
    }

    /// The numbers of all arrays that a name stands for.
    ///
    /// Several arrays, which must have one shape, are concatenated along a new first axis.
    ///
    /// # Errors
    /// As [`NamedArrays::numbers`], and entries of several shapes.
    fn all_numbers(&self, name: &str) -> Result<ArrayD<f64>> {
        let entries = self.entries(name);
        self.note(name);
        if entries.len() < 2 {
            return self.numbers(entries.first().map_or(name, |entry| entry));
        }
        let parts = entries.iter().map(|entry| self.numbers(entry));
        let parts: Vec<ArrayD<f64>> = parts.collect::<Result<_>>()?;
        let views: Vec<_> = parts.iter().map(|part| part.view()).collect();
        ndarray::stack(Axis(0), &views).map_err(|_| {
            let shapes: Vec<_> = parts.iter().map(|part| part.shape()).take(4).collect();
            self.error(format!(
                "`{name}` has {} entries of several shapes, {shapes:?} and so on; choose one, as `{}`",
                parts.len(),
                entries[0]
            ))
        })
    }

    /// The number of an array with only one.
    ///
    /// # Errors
    /// As [`NamedArrays::numbers`], and more than one number.
    fn scalar(&self, name: &str) -> Result<f64> {
        let numbers = self.all_numbers(name)?;
        match numbers.len() {
            1 => Ok(numbers.sum()),
            count => Err(self.error(format!("`{name}` has {count} numbers; expected one"))),
        }
    }

    /// The numbers of an array with one axis; other axes of length 1 are ignored.
    ///
    /// # Errors
    /// As [`NamedArrays::numbers`], and more than one axis.
    fn vector(&self, name: &str) -> Result<Vec<f64>> {
        let numbers = self.all_numbers(name)?;
        if numbers.shape().iter().filter(|&&side| side > 1).count() > 1 {
            return Err(self.misshapen(name, numbers.shape(), "one axis"));
        }
        Ok(numbers.iter().copied().collect())
    }
}

/// Arrays in memory, for tests.
#[cfg(test)]
#[derive(Default)]
pub struct Arrays(pub Vec<(String, ArrayD<f64>)>);

#[cfg(test)]
impl Arrays {
    /// Replaces an array, or adds it.
    pub fn set(&mut self, name: &str, shape: &[usize], values: &[f64]) {
        let values = array(shape, values.to_vec()).unwrap();
        match self.0.iter_mut().find(|(known, _)| known == name) {
            Some((_, own)) => *own = values,
            None => self.0.push((name.to_owned(), values)),
        }
    }
}

#[cfg(test)]
impl NamedArrays for Arrays {
    fn error(&self, message: String) -> Error {
        Error::Data(message)
    }

    fn names(&self) -> Vec<String> {
        self.0.iter().map(|(name, _)| name.clone()).collect()
    }

    fn numbers(&self, name: &str) -> Result<ArrayD<f64>> {
        let entries = self.entries(name);
        let found = self.0.iter().find(|(known, _)| entries.contains(known));
        found
            .map(|(_, values)| values.clone())
            .ok_or_else(|| self.error(format!("has no `{name}`")))
    }

    fn shape_for_parts(&self, name: &str) -> Result<Option<Vec<usize>>> {
        Ok(self.sides(name))
    }

    fn samples(&self, name: &str, part: Option<AxisRange>) -> Result<Values> {
        let mut all = self.numbers(name)?.mapv(|value| value as f32);
        if let Some((axis, part)) = part {
            let end = part.end.min(all.shape()[axis]);
            all = all
                .slice_axis(Axis(axis), (part.start.min(end)..end).into())
                .to_owned();
        }
        Ok(Values::Real(all))
    }

    fn sides(&self, name: &str) -> Option<Vec<usize>> {
        self.numbers(name)
            .ok()
            .map(|values| values.shape().to_vec())
    }

    fn entries(&self, name: &str) -> Vec<String> {
        let wanted = steps(name);
        let fits = |known: &String| {
            let own = steps(known);
            let pairs = own.iter().zip(&wanted);
            own.len() == wanted.len()
                && pairs.into_iter().all(|(own, wanted)| {
                    own.0 == wanted.0 && wanted.1.is_none_or(|_| own.1 == wanted.1)
                })
        };
        self.names().into_iter().filter(fits).collect()
    }
}

/// An array of these numbers in row-major order.
///
/// # Errors
/// A count that does not match the shape.
pub fn array<T>(shape: &[usize], values: Vec<T>) -> ReadResult<ArrayD<T>> {
    let count = values.len();
    ArrayD::from_shape_vec(IxDyn(shape), values)
        .map_err(|_| format!("holds {count} numbers in a shape of {shape:?}"))
}

/// Steps of a path, each with the entry that it selects.
///
/// `Receive(3).mode` is `Receive` with 3, and `mode`.
pub fn steps(path: &str) -> Vec<(&str, Option<usize>)> {
    let step = |step: &'_ str| -> (usize, Option<usize>) {
        let inner = step.strip_suffix([')', '}']);
        inner
            .and_then(|inner| inner.rsplit_once(['(', '{']))
            .and_then(|(name, index)| Some((name.len(), Some(index.parse().ok()?))))
            .unwrap_or((step.len(), None))
    };
    let parts = path.split(['.', '/']).filter(|part| !part.is_empty());
    parts
        .map(|part| {
            let (end, index) = step(part);
            (&part[..end], index)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_have_steps_and_indices() {
        for path in ["Receive(3).mode", "/Receive{3}/mode"] {
            assert_eq!(steps(path), [("Receive", Some(3)), ("mode", None)]);
        }
        assert_eq!(steps("a(b)"), [("a(b)", None)]);
    }
}
