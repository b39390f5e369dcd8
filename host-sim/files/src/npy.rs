//! One array in the `.npy` format, of an element type that the file decides.

use std::fs;
use std::path::Path;

use ndarray::{ArrayD, ArrayViewD};
use ndarray_npy::{ReadNpyExt, ReadableElement, ViewElement, ViewNpyError, ViewNpyExt};

use super::npy_header::claimed_length;
use super::{cannot_be_opened, file_error};
use crate::Result;
use crate::memory;

/// How many times its own size an array may take while it is read and converted.
pub const CONVERSIONS: usize = 4;

/// Why an array could not be read.
pub enum NpyError {
    /// It has another element type: the one named here.
    Type(String),
    /// It is damaged.
    Damaged(String),
}

/// Reads an array of element type `T` in row-major order, whatever the order in the file.
pub fn read<T>(bytes: &[u8]) -> std::result::Result<ArrayD<T>, NpyError>
where
    T: ReadableElement + ViewElement + Clone,
{
    // Before anything is allocated: a damaged header may ask for more memory than any machine has.
    let claimed = claimed_length(bytes).map_err(NpyError::Damaged)?;
    if let Some(missing) = claimed.checked_sub(bytes.len())
        && missing > 0
    {
        return Err(NpyError::Damaged(format!(
            "is truncated: {missing} bytes are missing"
        )));
    }
    // The array, its row-major copy, and what it is converted to.
    memory::check(bytes.len().saturating_mul(CONVERSIONS), "the array")
        .map_err(|e| NpyError::Damaged(format!("is too large: {e}")))?;
    match ArrayViewD::<T>::view_npy(bytes) {
        Ok(_) | Err(ViewNpyError::NonNativeEndian | ViewNpyError::MisalignedData) => {}
        Err(ViewNpyError::WrongDescriptor(found)) => {
            return Err(NpyError::Type(found.to_string()));
        }
        // The parser's own message draws a picture over several lines.
        Err(ViewNpyError::ParseHeader(_)) => {
            return Err(NpyError::Damaged("has a damaged header".into()));
        }
        Err(e) => return Err(NpyError::Damaged(format!("is damaged: {e}"))),
    }
    let array =
        ArrayD::<T>::read_npy(bytes).map_err(|e| NpyError::Damaged(format!("is damaged: {e}")))?;
    if array.is_standard_layout() {
        Ok(array)
    } else {
        Ok(array.as_standard_layout().into_owned())
    }
}

/// Reads a `.npy` file of element type `T`.
///
/// # Errors
/// [`crate::Error::File`]: it cannot be opened, is damaged, or has another element type.
pub fn read_array<T>(path: &Path) -> Result<ArrayD<T>>
where
    T: ReadableElement + ViewElement + Clone,
{
    let bytes = fs::read(path).map_err(|e| file_error(path, cannot_be_opened(&e)))?;
    read(&bytes).map_err(|error| match error {
        NpyError::Type(found) => file_error(path, format!("has the element type {found}")),
        NpyError::Damaged(how) => file_error(path, how),
    })
}

/// Tries another element type where the first did not fit.
pub fn or_type<T, F>(
    first: std::result::Result<ArrayD<T>, NpyError>,
    next: F,
) -> std::result::Result<ArrayD<T>, NpyError>
where
    F: FnOnce() -> std::result::Result<ArrayD<T>, NpyError>,
{
    match first {
        Err(NpyError::Type(_)) => next(),
        other => other,
    }
}
