//! Results of calls.

use bonebeam::Error;
use core::ffi::{CStr, c_char};

/// The result of a call.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// A parameter is outside its range.
    Parameter = 1,
    /// An array's length does not match the shapes.
    Length = 2,
    /// A size exceeds a capacity.
    Capacity = 3,
    /// An input sample is NaN or infinite.
    NonFinite = 4,
    /// External memory could not be read or written.
    Memory = 5,
    /// A pointer is null or not aligned, or an output overlaps an input.
    Pointer = 6,
    /// The object's memory is smaller than the result of its `_bytes` function.
    Storage = 7,
    /// An error without a number in this version.
    Other = 8,
}

impl From<Error> for Status {
    fn from(error: Error) -> Self {
        match error {
            Error::Parameter { .. } => Status::Parameter,
            Error::Length { .. } => Status::Length,
            Error::Capacity { .. } => Status::Capacity,
            Error::NonFinite { .. } => Status::NonFinite,
            Error::Memory => Status::Memory,
            _ => Status::Other,
        }
    }
}

/// The choice of a number, which a C enum has in the order of `all`.
pub(crate) fn chosen<T: Copy>(number: i32, all: &[T]) -> Result<T, Status> {
    let choice = usize::try_from(number).ok().and_then(|k| all.get(k));
    choice.copied().ok_or(Status::Parameter)
}

/// Converts the result of `work` to a status.
pub(crate) fn status(work: impl FnOnce() -> Result<(), Status>) -> Status {
    match work() {
        Ok(()) => Status::Ok,
        Err(status) => status,
    }
}

/// Returns the meaning of a status in English, for logs.
///
/// `status` may be any number.
#[unsafe(no_mangle)]
pub extern "C" fn bonebeam_status_text(status: i32) -> *const c_char {
    const TEXTS: [&CStr; 9] = [
        c"done",
        c"a parameter is outside its range",
        c"an array does not have the length that the shapes ask for",
        c"a size exceeds a capacity",
        c"an input sample is NaN or infinite",
        c"external memory could not be read or written",
        c"a pointer is null or not aligned, or an output overlaps an input",
        c"the object's memory is smaller than its _bytes function says",
        c"an error that this version has no number for",
    ];
    let text = usize::try_from(status).ok().and_then(|i| TEXTS.get(i));
    text.map_or(c"not a status of bonebeam", |text| *text)
        .as_ptr()
}
