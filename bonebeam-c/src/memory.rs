//! C's pointers as slices, with what can be checked of them checked.

use crate::status::Status;
use core::mem::align_of;
use core::slice;

/// The number that a pointer leads to.
///
/// # Safety
/// If it is not null, it leads to a `T` that nobody writes meanwhile.
pub unsafe fn one<'a, T>(pointer: *const T) -> Result<&'a T, Status> {
    if !pointer.is_aligned() {
        return Err(Status::Pointer);
    }
    // SAFETY: by the caller's promise; null gives none.
    unsafe { pointer.as_ref() }.ok_or(Status::Pointer)
}

/// [`one`], to be written.
///
/// # Safety
/// If it is not null, it leads to a `T` that nobody else uses meanwhile.
pub unsafe fn one_mut<'a, T>(pointer: *mut T) -> Result<&'a mut T, Status> {
    if !pointer.is_aligned() {
        return Err(Status::Pointer);
    }
    // SAFETY: by the caller's promise; null gives none.
    unsafe { pointer.as_mut() }.ok_or(Status::Pointer)
}

/// `length` numbers from a pointer on.
///
/// # Safety
/// If it is not null, so many numbers stand there, and nobody writes them meanwhile.
pub unsafe fn array<'a, T>(pointer: *const T, length: usize) -> Result<&'a [T], Status> {
    fits(pointer, length)?;
    // SAFETY: by the caller's promise; aligned, not null, and no longer than memory.
    Ok(unsafe { slice::from_raw_parts(pointer, length) })
}

/// [`array`], to be written.
///
/// # Safety
/// If it is not null, so many numbers stand there, and nobody else uses them meanwhile.
pub unsafe fn array_mut<'a, T>(pointer: *mut T, length: usize) -> Result<&'a mut [T], Status> {
    fits(pointer, length)?;
    // SAFETY: by the caller's promise; aligned, not null, and no longer than memory.
    Ok(unsafe { slice::from_raw_parts_mut(pointer, length) })
}

fn fits<T>(pointer: *const T, length: usize) -> Result<(), Status> {
    if pointer.is_null() || !pointer.is_aligned() {
        return Err(Status::Pointer);
    }
    match length.checked_mul(size_of::<T>()) {
        Some(bytes) if bytes <= isize::MAX as usize => Ok(()),
        _ => Err(Status::Length),
    }
}

/// Storage of the caller's as a place for a `T`.
pub fn place<T>(storage: *mut core::ffi::c_void, bytes: usize) -> Result<*mut T, Status> {
    if storage.is_null() || !storage.addr().is_multiple_of(align_of::<T>()) {
        return Err(Status::Pointer);
    }
    if bytes < size_of::<T>() {
        return Err(Status::Storage);
    }
    Ok(storage.cast())
}
