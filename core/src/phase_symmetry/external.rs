//! External memory: what does not fit the fast one, reached a stretch at a time.

use crate::Error;

/// Numbers that can be read: SDRAM, a file, a slice.
pub trait Source {
    /// Copies the numbers from `first` on.
    ///
    /// # Errors
    /// [`Error::Memory`] where the memory fails or ends too early.
    fn read(&mut self, first: usize, into: &mut [f32]) -> Result<(), Error>;
}

/// Numbers that can be read and written.
pub trait Store: Source {
    /// Copies numbers to the places from `first` on.
    ///
    /// # Errors
    /// [`Error::Memory`] where the memory fails or ends too early.
    fn write(&mut self, first: usize, from: &[f32]) -> Result<(), Error>;
}

fn read(data: &[f32], first: usize, into: &mut [f32]) -> Result<(), Error> {
    let from = data.get(first..first.saturating_add(into.len()));
    into.copy_from_slice(from.ok_or(Error::Memory)?);
    Ok(())
}

impl Source for &[f32] {
    fn read(&mut self, first: usize, into: &mut [f32]) -> Result<(), Error> {
        read(self, first, into)
    }
}

impl Source for &mut [f32] {
    fn read(&mut self, first: usize, into: &mut [f32]) -> Result<(), Error> {
        read(self, first, into)
    }
}

impl Store for &mut [f32] {
    fn write(&mut self, first: usize, from: &[f32]) -> Result<(), Error> {
        let to = self.get_mut(first..first.saturating_add(from.len()));
        to.ok_or(Error::Memory)?.copy_from_slice(from);
        Ok(())
    }
}
