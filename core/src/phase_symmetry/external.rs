//! External memory for matrices that exceed fast memory, in blocks.

use crate::Error;
use crate::simd::copy;

/// Numbers that can be read from any offset: SDRAM, a file, a slice.
///
/// ```
/// use bonebeam::Error;
/// use bonebeam::phase_symmetry::{ReadAt, WriteAt};
///
/// let mut memory = [0.0; 4];
/// let mut slice = &mut memory[..];
/// slice.write_at(2, &[5.0, 6.0])?;
/// let mut two = [0.0; 2];
/// slice.read_at(1, &mut two)?;
/// assert_eq!(two, [0.0, 5.0]);
/// assert_eq!(slice.read_at(3, &mut two), Err(Error::Memory));
/// # Ok::<(), Error>(())
/// ```
pub trait ReadAt {
    /// Copies the numbers from `first` on.
    ///
    /// # Errors
    /// [`Error::Memory`] if the memory fails or ends too early.
    fn read_at(&mut self, first: usize, into: &mut [f32]) -> Result<(), Error>;

    /// Borrows `length` numbers from `first` on, if the memory allows it.
    ///
    /// The numbers are then not copied. Implement it for memory behind a cache, which is as fast as
    /// [`super::StripSlices`]. The result is `None` by default, and for slices, which may be slow.
    fn view(&self, first: usize, length: usize) -> Option<&[f32]> {
        let _ = (first, length);
        None
    }
}

/// Numbers that can be read and written at any offset.
pub trait WriteAt: ReadAt {
    /// Copies numbers to the offsets from `first` on.
    ///
    /// # Errors
    /// [`Error::Memory`] if the memory fails or ends too early.
    fn write_at(&mut self, first: usize, from: &[f32]) -> Result<(), Error>;

    /// Borrows the same numbers for writing.
    fn view_mut(&mut self, first: usize, length: usize) -> Option<&mut [f32]> {
        let _ = (first, length);
        None
    }
}

/// The numbers from `first` on, borrowed or copied to `buffer`, which sets their count.
pub(super) fn view_or_read<'a>(
    memory: &'a mut dyn ReadAt,
    first: usize,
    buffer: &'a mut [f32],
) -> Result<&'a [f32], Error> {
    if memory.view(first, buffer.len()).is_none() {
        memory.read_at(first, buffer)?;
        return Ok(buffer);
    }
    memory.view(first, buffer.len()).ok_or(Error::Memory)
}

fn read(data: &[f32], first: usize, into: &mut [f32]) -> Result<(), Error> {
    let from = data.get(first..).and_then(|from| from.get(..into.len()));
    copy(from.ok_or(Error::Memory)?, into);
    Ok(())
}

impl ReadAt for &[f32] {
    fn read_at(&mut self, first: usize, into: &mut [f32]) -> Result<(), Error> {
        read(self, first, into)
    }
}

impl ReadAt for &mut [f32] {
    fn read_at(&mut self, first: usize, into: &mut [f32]) -> Result<(), Error> {
        read(self, first, into)
    }
}

impl WriteAt for &mut [f32] {
    fn write_at(&mut self, first: usize, from: &[f32]) -> Result<(), Error> {
        let to = self.get_mut(first..);
        let to = to.and_then(|to| to.get_mut(..from.len()));
        copy(from, to.ok_or(Error::Memory)?);
        Ok(())
    }
}
