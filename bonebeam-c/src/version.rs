//! Version of header and library.

use core::ffi::{CStr, c_char};

/// Major version of the header.
pub const BONEBEAM_VERSION_MAJOR: u32 = 0;
/// Minor version of the header.
pub const BONEBEAM_VERSION_MINOR: u32 = 1;
/// Patch version of the header.
pub const BONEBEAM_VERSION_PATCH: u32 = 0;

// cbindgen takes literals only.
const _: () = {
    assert!(number(env!("CARGO_PKG_VERSION_MAJOR")) == BONEBEAM_VERSION_MAJOR);
    assert!(number(env!("CARGO_PKG_VERSION_MINOR")) == BONEBEAM_VERSION_MINOR);
    assert!(number(env!("CARGO_PKG_VERSION_PATCH")) == BONEBEAM_VERSION_PATCH);
};

const fn number(digits: &str) -> u32 {
    match u32::from_str_radix(digits, 10) {
        Ok(number) => number,
        Err(_) => panic!("a version has numbers"),
    }
}

/// Returns the version of the library, for instance "0.1.0".
///
/// It differs from the header's if the program was compiled with the header of another version.
#[unsafe(no_mangle)]
pub extern "C" fn bonebeam_version() -> *const c_char {
    const VERSION: &CStr =
        match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
            Ok(version) => version,
            Err(_) => panic!("a version has no zero"),
        };
    VERSION.as_ptr()
}
