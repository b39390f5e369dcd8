//! What a call came to.

use bonebeam::Error;
use core::ffi::{CStr, c_char};

/// What a call came to. Only 0 leaves something in the outputs.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// A parameter is outside its range.
    Parameter = 1,
    /// An array has another length than the shapes ask for.
    Length = 2,
    /// A size exceeds what there is room for.
    Capacity = 3,
    /// An input sample is NaN or infinite.
    NonFinite = 4,
    /// External memory could not be read or written.
    Memory = 5,
    /// A pointer is null or not aligned.
    Pointer = 6,
    /// The storage is smaller than its constant.
    Storage = 7,
    /// An error that this version has no number for.
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

/// Work that may be refused, as C sees it.
pub(crate) fn status(work: impl FnOnce() -> Result<(), Status>) -> Status {
    match work() {
        Ok(()) => Status::Ok,
        Err(status) => status,
    }
}

/// What a status means, in English; for logs. Any number may be asked for.
#[unsafe(no_mangle)]
pub extern "C" fn bonebeam_status_text(status: i32) -> *const c_char {
    const TEXTS: [&CStr; 9] = [
        c"done",
        c"a parameter is outside its range",
        c"an array has another length than the shapes ask for",
        c"a size exceeds what there is room for",
        c"an input sample is NaN or infinite",
        c"external memory could not be read or written",
        c"a pointer is null or not aligned",
        c"the storage is smaller than its constant",
        c"an error that this version has no number for",
    ];
    let text = usize::try_from(status).ok().and_then(|i| TEXTS.get(i));
    text.map_or(c"not a status of bonebeam", |text| *text)
        .as_ptr()
}
