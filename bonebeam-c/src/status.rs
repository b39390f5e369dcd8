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

/// Why a call is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refused {
    /// With its field.
    By(Error),
    /// Without more.
    Of(Status),
}

impl From<Error> for Refused {
    fn from(error: Error) -> Self {
        Refused::By(error)
    }
}

impl From<Status> for Refused {
    fn from(status: Status) -> Self {
        Refused::Of(status)
    }
}

impl Refused {
    /// A field outside its range.
    pub(crate) fn field(name: &'static str, value: f64, expected: &'static str) -> Self {
        Refused::By(Error::Parameter {
            name,
            value,
            expected,
        })
    }

    fn status(self) -> Status {
        match self {
            Refused::Of(status) => status,
            Refused::By(Error::Parameter { .. }) => Status::Parameter,
            Refused::By(Error::Length { .. }) => Status::Length,
            Refused::By(Error::Capacity { .. }) => Status::Capacity,
            Refused::By(Error::NonFinite { .. }) => Status::NonFinite,
            Refused::By(Error::Memory) => Status::Memory,
            Refused::By(_) => Status::Other,
        }
    }
}

/// The field for which a configuration is refused.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Refusal {
    /// The field's name, ended by 0; empty if no field is at fault.
    pub name: [c_char; 48],
    /// Its value, or 0.
    pub value: f64,
    /// The accepted values in words, ended by 0; empty of a length or a capacity.
    pub expected: [c_char; 112],
}

impl Refusal {
    /// The refusal of an outcome, and its status.
    pub(crate) fn of(outcome: Result<usize, Refused>) -> (Self, Status) {
        let mut refusal = Refusal {
            name: [0; 48],
            value: 0.0,
            expected: [0; 112],
        };
        let Err(refused) = outcome else {
            return (refusal, Status::Ok);
        };
        let (name, value, expected) = match refused {
            Refused::By(Error::Parameter {
                name,
                value,
                expected,
            }) => (name, value, expected),
            Refused::By(Error::Length { name, actual, .. }) => (name, actual as f64, ""),
            Refused::By(Error::Capacity { name, actual, .. }) => (name, actual as f64, ""),
            _ => ("", 0.0, ""),
        };
        put(&mut refusal.name, name);
        refusal.value = value;
        put(&mut refusal.expected, expected);
        (refusal, refused.status())
    }
}

/// Copies a text, cut if need be, before a last 0.
fn put(place: &mut [c_char], text: &str) {
    if let [place @ .., _] = place {
        for (to, from) in place.iter_mut().zip(text.bytes()) {
            *to = from as c_char;
        }
    }
}

/// The choice of a number, which a C enum has in the order of `all`.
pub(crate) fn chosen<T: Copy>(name: &'static str, number: i32, all: &[T]) -> Result<T, Refused> {
    let choice = usize::try_from(number).ok().and_then(|k| all.get(k));
    let expected = "a number of its enumeration";
    choice
        .copied()
        .ok_or(Refused::field(name, number.into(), expected))
}

/// Converts the result of `work` to a status.
pub(crate) fn status(work: impl FnOnce() -> Result<(), Refused>) -> Status {
    match work() {
        Ok(()) => Status::Ok,
        Err(refused) => refused.status(),
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
