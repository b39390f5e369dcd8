//! C's pointers as references, and an object's parts in the caller's bytes.

use crate::Complex;
use crate::status::{Status, status};
use core::ffi::c_void;
use core::slice;

/// Alignment, bytes, of the memory of every object.
pub const BONEBEAM_ALIGN: usize = 64;

/// The value that a pointer leads to.
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

/// `length` values from a pointer on.
///
/// # Safety
/// If it is not null, so many values stand there, and nobody writes them meanwhile.
pub unsafe fn array<'a, T>(pointer: *const T, length: usize) -> Result<&'a [T], Status> {
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
) -> Result<&'a [bonebeam::Complex<f32>], Status> {
    // SAFETY: by the caller's promise.
    unsafe { array(pointer.cast(), length) }
}

/// Values to be written: no reference yet, so that an input that overlaps them is refused before there are two.
pub struct Output<T> {
    pointer: *mut T,
    length: usize,
}

impl<T> Output<T> {
    /// `length` values from a pointer on.
    pub fn new(pointer: *mut T, length: usize) -> Result<Self, Status> {
        fits(pointer, length)?;
        Ok(Output { pointer, length })
    }

    /// An input that shares no byte with the output.
    pub fn apart<'a, U>(&self, input: &'a [U]) -> Result<&'a [U], Status> {
        let first = self.pointer.addr();
        // No longer than memory, as `fits` has checked.
        let end = first.wrapping_add(self.length * size_of::<T>());
        let read = input.as_ptr_range();
        match first < read.end.addr() && read.start.addr() < end {
            true => Err(Status::Pointer),
            false => Ok(input),
        }
    }

    /// The values.
    ///
    /// # Safety
    /// So many values stand there, and nobody else uses them meanwhile.
    pub unsafe fn values<'a>(self) -> &'a mut [T] {
        // SAFETY: by the caller's promise; aligned, not null, and no longer than memory.
        unsafe { slice::from_raw_parts_mut(self.pointer, self.length) }
    }
}

impl Output<bonebeam::Complex<f32>> {
    /// [`Output::new`] of the core's complex numbers.
    pub fn complex(pointer: *mut Complex, length: usize) -> Result<Self, Status> {
        Output::new(pointer.cast(), length)
    }
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

/// Bytes of `count` values in an object's memory, up to full multiples of [`BONEBEAM_ALIGN`]; `usize::MAX`
/// if no memory holds them.
pub fn bytes_of<T>(count: usize) -> usize {
    let bytes = count.saturating_mul(size_of::<T>());
    bytes
        .checked_next_multiple_of(BONEBEAM_ALIGN)
        .unwrap_or(usize::MAX)
}

/// The sum, `usize::MAX` if it is larger.
pub fn sum(parts: &[usize]) -> usize {
    let add = |sum: usize, &part: &usize| sum.saturating_add(part);
    parts.iter().fold(0, add)
}

/// A type of which zeros are a value.
///
/// # Safety
/// It is made of floats alone.
pub unsafe trait Zeros {}
// SAFETY: a float.
unsafe impl Zeros for f32 {}
// SAFETY: two floats.
unsafe impl Zeros for bonebeam::Complex<f32> {}

/// Places an object in the caller's memory: it comes first, then what it takes of the bytes behind.
///
/// # Safety
/// As [`Bytes::new`] and [`one_mut`].
pub unsafe fn new<T>(
    memory: *mut c_void,
    bytes: usize,
    handle: *mut *mut T,
    object: impl FnOnce(&mut Bytes) -> Result<T, Status>,
) -> Status {
    status(|| {
        // SAFETY: by the caller's promise.
        let (handle, mut bytes) = unsafe { (one_mut(handle)?, Bytes::new(memory, bytes)?) };
        let place: *mut T = bytes.place(1)?;
        let object = object(&mut bytes)?;
        // SAFETY: a place for it.
        unsafe { place.write(object) };
        *handle = place;
        Ok(())
    })
}

/// The caller's bytes, of which an object takes its parts one after the other.
pub struct Bytes {
    first: *mut u8,
    left: usize,
}

impl Bytes {
    /// # Safety
    /// If `memory` is not null, so many `bytes` stand there, and only the object uses them from now on. What
    /// is taken of them lives as long as the object, whatever its lifetime says.
    pub unsafe fn new(memory: *mut c_void, bytes: usize) -> Result<Self, Status> {
        if memory.is_null() || !memory.addr().is_multiple_of(BONEBEAM_ALIGN) {
            return Err(Status::Pointer);
        }
        if bytes > isize::MAX as usize {
            return Err(Status::Length);
        }
        Ok(Bytes {
            first: memory.cast(),
            left: bytes,
        })
    }

    /// A place for so many values: aligned, and of nobody else.
    fn place<T>(&mut self, count: usize) -> Result<*mut T, Status> {
        const { assert!(align_of::<T>() <= BONEBEAM_ALIGN) };
        let bytes = bytes_of::<T>(count);
        let Some(left) = self.left.checked_sub(bytes) else {
            return Err(Status::Storage);
        };
        let place = self.first.cast();
        // SAFETY: no further than the end of the caller's bytes.
        self.first = unsafe { self.first.add(bytes) };
        self.left = left;
        Ok(place)
    }

    /// So many zeros.
    pub fn zeros<T: Zeros>(&mut self, count: usize) -> Result<&'static mut [T], Status> {
        let place: *mut T = self.place(count)?;
        // SAFETY: a place of its own; zeros are values.
        unsafe {
            place.write_bytes(0, count);
            Ok(slice::from_raw_parts_mut(place, count))
        }
    }

    /// A copy of a value, without its way over the stack.
    pub fn copy<T>(&mut self, value: &T) -> Result<&'static mut T, Status> {
        const { assert!(!core::mem::needs_drop::<T>()) };
        let place: *mut T = self.place(1)?;
        // SAFETY: a place of its own; two of what has nothing to drop are as good as one.
        unsafe {
            place.copy_from_nonoverlapping(value, 1);
            Ok(&mut *place)
        }
    }

    /// All bytes that are left, as floats.
    pub fn rest(&mut self) -> Result<&'static mut [f32], Status> {
        self.zeros(self.left / BONEBEAM_ALIGN * (BONEBEAM_ALIGN / size_of::<f32>()))
    }
}
