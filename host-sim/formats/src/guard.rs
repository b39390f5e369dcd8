//! Keeps libraries of other formats within bounds when files are crafted.
//!
//! A panic becomes an error, and memory is checked before it is used.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

use bonebeam_files::memory;

/// Largest ratio of an array's size to the file's length.
///
/// Recordings shrink to a half or a tenth, those of a point without noise to a few hundredths. Equal bytes shrink 1,030
/// times by deflate. The ratio bounds time; the memory is checked too.
const MAX_INFLATION: u64 = 900;
/// An array of up to this size may have any compression, bytes.
const SMALL: u64 = 16 << 20;
/// Memory to read and convert an array, as a multiple of its size.
pub const CONVERSIONS: usize = 4;

/// Result of reading a part of a file; the error is a sentence without its subject.
pub type ReadResult<T> = Result<T, String>;

thread_local! {
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// Runs a library on a file.
///
/// A panic is reported as a damaged file, and prints nothing.
///
/// # Errors
/// Errors of `read`, and a panic.
pub fn guarded<T>(read: impl FnOnce() -> ReadResult<T>) -> ReadResult<T> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let others = take_hook();
        set_hook(Box::new(move |panic| {
            if !QUIET.get() {
                others(panic);
            }
        }));
    });
    let before = QUIET.replace(true);
    let outcome = catch_unwind(AssertUnwindSafe(read));
    QUIET.set(before);
    outcome.unwrap_or_else(|_| Err("is damaged: its reader failed".into()))
}

/// Size of an array in bytes, if a file of `length` bytes can hold it.
///
/// # Errors
/// A shape that no file of this length can have.
pub fn claim(shape: &[usize], element: usize, length: u64) -> ReadResult<usize> {
    let too_large = || {
        format!(
            "claims a shape of {shape:?}, more than its file can hold: over {MAX_INFLATION} times the file, as if all \
             samples were equal"
        )
    };
    let sides = shape.iter().copied().chain([element]);
    let bytes = sides
        .into_iter()
        .try_fold(1usize, usize::checked_mul)
        .ok_or_else(too_large)?;
    if bytes as u64 > length.saturating_mul(MAX_INFLATION).max(SMALL) {
        return Err(too_large());
    }
    Ok(bytes)
}

/// Size of an array in bytes, if the file and the memory can hold it.
///
/// # Errors
/// As [`claim`], or a shape that is too large for the memory.
pub fn claim_in_memory(shape: &[usize], element: usize, length: u64) -> ReadResult<usize> {
    let bytes = claim(shape, element, length)?;
    memory::check(bytes.saturating_mul(CONVERSIONS), "the array")
        .map_err(|e| format!("is too large: {e}"))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error() {
        let outcome: Result<(), String> = guarded(|| panic!("no"));
        assert!(outcome.unwrap_err().contains("damaged"));
        assert_eq!(guarded(|| Ok(3)), Ok(3));
    }

    #[test]
    fn a_shape_beyond_the_file_is_refused() {
        assert_eq!(claim_in_memory(&[3, 4], 8, 10), Ok(96));
        for shape in [&[1 << 40][..], &[usize::MAX, 2], &[1 << 20, 1 << 20]] {
            claim_in_memory(shape, 4, 1000).unwrap_err();
        }
        assert_eq!(claim_in_memory(&[1 << 40, 0], 4, 1000), Ok(0));
    }
}
