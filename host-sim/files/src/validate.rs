//! Checks shared by several kinds of file.
//!
//! Messages name the key, the index and the expected value.

use std::f64::consts::FRAC_PI_2;

use ndarray::{ArrayBase, Data, Dimension};
use num_complex::Complex;

use crate::terminal::{digits, short};

/// Longest time, s: half a kilometre of depth.
///
/// A longer one has another unit, and would reduce the precision of a sample's position.
const MAX_TIME: f64 = 1.0;

/// Checks for a finite number above zero.
pub fn positive(key: &str, value: f64, unit: &str) -> Result<(), String> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(format!(
        "`{key}` is {}; expected a finite number above 0 ({unit})",
        short(value)
    ))
}

/// Checks for a finite number.
pub fn finite(key: &str, value: f64) -> Result<(), String> {
    if value.is_finite() {
        return Ok(());
    }
    Err(format!("`{key}` is {value}; expected a finite number"))
}

/// Checks for finite numbers, one for each `of`.
pub fn all_finite(key: &str, values: &[f64], of: &str) -> Result<(), String> {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(i) => Err(format!(
            "`{key}` is {} at {of} {i}; expected finite numbers",
            values[i]
        )),
    }
}

/// Checks record starts: seconds, at most [`MAX_TIME`], one for each `of`.
pub fn times(key: &str, values: &[f64], of: &str) -> Result<(), String> {
    all_finite(key, values, of)?;
    match values.iter().position(|v| v.abs() > MAX_TIME) {
        None => Ok(()),
        Some(i) => Err(format!(
            "`{key}` is {} at {of} {i}; expected seconds, at most {MAX_TIME} either way; it is probably \
             in µs or counted in samples",
            values[i]
        )),
    }
}

/// Checks directions in front of the array, rad, one for each `of`.
pub fn angles(key: &str, values: &[f64], of: &str) -> Result<(), String> {
    let before = |angle: &f64| angle.abs() < FRAC_PI_2;
    match values.iter().position(|angle| !before(angle)) {
        None => Ok(()),
        Some(i) => Err(format!(
            "`{key}` is {} at {of} {i}; expected radians between -pi/2 and pi/2; it is probably in \
             degrees",
            digits(values[i])
        )),
    }
}

/// Checks the number of values against the number of things that they describe.
pub fn count(key: &str, length: usize, expected: usize, of: &str) -> Result<(), String> {
    if length == expected {
        return Ok(());
    }
    Err(format!(
        "`{key}` has length {length}; expected {expected}, one for each {of}"
    ))
}

/// A sample that may be finite or not.
pub trait Sample: Copy + std::fmt::Display {
    /// Whether it is neither NaN nor infinite, in either part.
    fn is_finite(self) -> bool;
}

impl Sample for f32 {
    fn is_finite(self) -> bool {
        f32::is_finite(self)
    }
}

impl Sample for i16 {
    fn is_finite(self) -> bool {
        true
    }
}

impl Sample for Complex<f32> {
    fn is_finite(self) -> bool {
        self.re.is_finite() & self.im.is_finite()
    }
}

/// Checks that there is a sample, and that all are finite.
///
/// `axes` names the array's axes in order.
pub fn samples<S, D>(key: &str, array: &ArrayBase<S, D>, axes: &[&str]) -> Result<(), String>
where
    S: Data<Elem: Sample>,
    D: Dimension,
{
    if array.is_empty() {
        let shape = array.shape();
        return Err(format!(
            "`{key}` is empty (shape {shape:?}); expected [{}]",
            axes.join(", ")
        ));
    }
    // Over all lanes at once; a sample that is not finite is looked for only if there is one.
    let finite = |all: &[S::Elem]| all.iter().fold(true, |finite, v| finite & v.is_finite());
    if array.as_slice_memory_order().is_some_and(finite) {
        return Ok(());
    }
    let Some((flat, value)) = array.iter().enumerate().find(|(_, v)| !v.is_finite()) else {
        return Ok(());
    };
    // The index along each axis, from the last one, which runs fastest.
    let mut rest = flat;
    let mut index = Vec::new();
    for (axis, &length) in axes.iter().zip(array.shape()).rev() {
        index.push(format!("{axis} {}", rest % length));
        rest /= length;
    }
    index.reverse();
    Err(format!(
        "`{key}` is {value} at {}; expected finite samples",
        index.join(", ")
    ))
}
