//! External memory: what does not fit the fast one, reached a stretch at a time.

use crate::Error;

/// Numbers that can be read from any place on: SDRAM, a file, a slice.
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
    /// [`Error::Memory`] where the memory fails or ends too early.
    fn read_at(&mut self, first: usize, into: &mut [f32]) -> Result<(), Error>;
}

/// Numbers that can be read and written at any place.
pub trait WriteAt: ReadAt {
    /// Copies numbers to the places from `first` on.
    ///
    /// # Errors
    /// [`Error::Memory`] where the memory fails or ends too early.
    fn write_at(&mut self, first: usize, from: &[f32]) -> Result<(), Error>;
}

fn read(data: &[f32], first: usize, into: &mut [f32]) -> Result<(), Error> {
    let from = data.get(first..first.saturating_add(into.len()));
    into.copy_from_slice(from.ok_or(Error::Memory)?);
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
        let to = self.get_mut(first..first.saturating_add(from.len()));
        to.ok_or(Error::Memory)?.copy_from_slice(from);
        Ok(())
    }
}
