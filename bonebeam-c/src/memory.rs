//! References from C's pointers, and an object's parts in the caller's bytes.

use crate::Complex;
use crate::status::{Refused, Status, status};
use core::ffi::c_void;
use core::slice;

/// Alignment of the memory of every object, bytes.
pub const BONEBEAM_ALIGN: usize = 64;

/// References the value that a pointer leads to.
///
/// # Safety
/// If it is not null, it leads to a `T` that no one writes meanwhile.
pub unsafe fn one<'a, T>(pointer: *const T) -> Result<&'a T, Refused> {
    if !pointer.is_aligned() {
        return Err(Status::Pointer.into());
    }
    // SAFETY: by the caller's promise; null gives none.
    unsafe { pointer.as_ref() }.ok_or(Refused::Of(Status::Pointer))
}

/// References the value that a pointer leads to, for writing.
///
/// # Safety
/// If it is not null, it leads to a `T` that no one else uses meanwhile.
pub unsafe fn one_mut<'a, T>(pointer: *mut T) -> Result<&'a mut T, Refused> {
    if !pointer.is_aligned() {
        return Err(Status::Pointer.into());
    }
    // SAFETY: by the caller's promise; null gives none.
    unsafe { pointer.as_mut() }.ok_or(Refused::Of(Status::Pointer))
}

/// References `length` values from a pointer on.
///
/// # Safety
/// If it is not null, `length` values follow it, and no one writes them meanwhile.
pub unsafe fn array<'a, T>(pointer: *const T, length: usize) -> Result<&'a [T], Refused> {
    fits(pointer, length)?;
    // SAFETY: by the caller's promise; aligned, not null, and no longer than memory.
    Ok(unsafe { slice::from_raw_parts(pointer, length) })
}

/// [`array`] of the core's complex numbers, which are two floats as well.
///
/// # Safety
/// As [`array`].
pub unsafe fn complex<'a>(
    pointer: *const Complex,
    length: usize,
) -> Result<&'a [bonebeam::Complex<f32>], Refused> {
    // SAFETY: by the caller's promise.
    unsafe { array(pointer.cast(), length) }
}

/// Values to be written, before a reference to them exists.
///
/// An input that overlaps them is therefore refused before there are two references.
pub struct Output<T> {
    pointer: *mut T,
    length: usize,
}

impl<T> Output<T> {
    /// Takes `length` values from a pointer on.
    pub fn new(pointer: *mut T, length: usize) -> Result<Self, Refused> {
        fits(pointer, length)?;
        Ok(Output { pointer, length })
    }

    /// No values, which no input overlaps.
    pub fn none() -> Self {
        Output {
            pointer: core::ptr::dangling_mut(),
            length: 0,
        }
    }

    /// Returns an input that shares no byte with the output.
    pub fn apart<'a, U>(&self, input: &'a [U]) -> Result<&'a [U], Refused> {
        let first = self.pointer.addr();
        // No longer than memory, as `fits` has checked.
        let end = first.wrapping_add(self.length * size_of::<T>());
        let read = input.as_ptr_range();
        match first < read.end.addr() && read.start.addr() < end {
            true => Err(Status::Pointer.into()),
            false => Ok(input),
        }
    }

    /// References the values.
    ///
    /// # Safety
    /// All values exist, and no one else uses them meanwhile.
    pub unsafe fn values<'a>(self) -> &'a mut [T] {
        // SAFETY: by the caller's promise; aligned, not null, and no longer than memory.
        unsafe { slice::from_raw_parts_mut(self.pointer, self.length) }
    }
}

impl Output<bonebeam::Complex<f32>> {
    /// [`Output::new`] of the core's complex numbers.
    pub fn complex(pointer: *mut Complex, length: usize) -> Result<Self, Refused> {
        Output::new(pointer.cast(), length)
    }
}

fn fits<T>(pointer: *const T, length: usize) -> Result<(), Refused> {
    if pointer.is_null() || !pointer.is_aligned() {
        return Err(Status::Pointer.into());
    }
    match length.checked_mul(size_of::<T>()) {
        Some(bytes) if bytes <= isize::MAX as usize => Ok(()),
        _ => Err(Status::Length.into()),
    }
}

/// Bytes of `count` values in an object's memory, in units of [`BONEBEAM_ALIGN`].
///
/// `usize::MAX` if no memory holds them.
pub fn bytes_of<T>(count: usize) -> usize {
    let bytes = count.saturating_mul(size_of::<T>());
    bytes
        .checked_next_multiple_of(BONEBEAM_ALIGN)
        .unwrap_or(usize::MAX)
}

/// Returns the sum, or `usize::MAX` on overflow.
pub fn sum(parts: &[usize]) -> usize {
    let add = |sum: usize, &part: &usize| sum.saturating_add(part);
    parts.iter().fold(0, add)
}

/// Refuses bytes that no memory has.
pub fn possible(bytes: usize) -> Result<usize, Refused> {
    match isize::try_from(bytes) {
        Ok(_) => Ok(bytes),
        Err(_) => Err(Status::Length.into()),
    }
}

/// Places an object in the caller's memory, and then its parts.
///
/// # Safety
/// As [`Bytes::new`] and [`one_mut`].
pub unsafe fn new<T>(
    memory: *mut c_void,
    bytes: usize,
    handle: *mut *mut T,
    object: impl FnOnce(&mut Bytes) -> Result<T, Refused>,
) -> Status {
    status(|| {
        // SAFETY: by the caller's promise.
        let (handle, mut bytes) = unsafe { (one_mut(handle)?, Bytes::new(memory, bytes)?) };
        let place: *mut T = bytes.place(1)?;
        let object = object(&mut bytes)?;
        // SAFETY: memory reserved for it.
        unsafe { place.write(object) };
        *handle = place;
        Ok(())
    })
}

/// The caller's bytes, from which an object takes its parts in turn.
pub struct Bytes {
    first: *mut u8,
    left: usize,
}

impl Bytes {
    /// Takes the caller's bytes.
    ///
    /// # Safety
    /// If `memory` is not null, it has `bytes` bytes, and only the object uses them from now on. Parts live as long
    /// as the object, whatever their lifetime says.
    pub unsafe fn new(memory: *mut c_void, bytes: usize) -> Result<Self, Refused> {
        if memory.is_null() || !memory.addr().is_multiple_of(BONEBEAM_ALIGN) {
            return Err(Status::Pointer.into());
        }
        if bytes > isize::MAX as usize {
            return Err(Status::Length.into());
        }
        Ok(Bytes {
            first: memory.cast(),
            left: bytes,
        })
    }

    /// Reserves memory for `count` values: aligned, and not shared.
    fn place<T>(&mut self, count: usize) -> Result<*mut T, Refused> {
        const { assert!(align_of::<T>() <= BONEBEAM_ALIGN) };
        let bytes = bytes_of::<T>(count);
        let Some(left) = self.left.checked_sub(bytes) else {
            return Err(Status::Storage.into());
        };
        let place = self.first.cast();
        // SAFETY: no further than the end of the caller's bytes.
        self.first = unsafe { self.first.add(bytes) };
        self.left = left;
        Ok(place)
    }

    /// Takes `count` copies of a value.
    pub fn fill<T: Copy>(&mut self, count: usize, value: T) -> Result<&'static mut [T], Refused> {
        let place: *mut T = self.place(count)?;
        for index in 0..count {
            // SAFETY: memory of its own for `count` values.
            unsafe { place.add(index).write(value) };
        }
        // SAFETY: memory of its own, with a value in each place.
        Ok(unsafe { slice::from_raw_parts_mut(place, count) })
    }

    /// Copies a value, without a copy on the stack.
    pub fn copy<T>(&mut self, value: &T) -> Result<&'static mut T, Refused> {
        const { assert!(!core::mem::needs_drop::<T>()) };
        let place: *mut T = self.place(1)?;
        // SAFETY: memory of its own; without a destructor a second copy is valid.
        unsafe {
            place.copy_from_nonoverlapping(value, 1);
            Ok(&mut *place)
        }
    }

    /// Takes all remaining bytes, as floats.
    pub fn rest(&mut self) -> Result<&'static mut [f32], Refused> {
        let floats = self.left / BONEBEAM_ALIGN * (BONEBEAM_ALIGN / size_of::<f32>());
        self.fill(floats, 0.0)
    }
}
