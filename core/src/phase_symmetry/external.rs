//! External memory: what does not fit the fast one, reached a rectangle at a time.

use crate::Error;

/// A rectangle of a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Area {
    /// The first row.
    pub row: usize,
    /// The first column.
    pub column: usize,
    /// The number of rows.
    pub rows: usize,
    /// The number of columns.
    pub columns: usize,
}

/// A matrix that can be read: SDRAM, a file, a slice.
pub trait Source<T> {
    /// Copies a rectangle, row-major, into `into`, which has its size.
    ///
    /// # Errors
    /// [`Error::Memory`] where the memory fails or the rectangle does not lie in it.
    fn read(&mut self, area: Area, into: &mut [T]) -> Result<(), Error>;
}

/// A matrix that can be read and written.
pub trait Store<T>: Source<T> {
    /// Copies `from`, row-major and of the rectangle's size, to a rectangle.
    ///
    /// # Errors
    /// [`Error::Memory`] where the memory fails or the rectangle does not lie in it.
    fn write(&mut self, area: Area, from: &[T]) -> Result<(), Error>;
}

/// A row-major slice as a [`Source`].
#[derive(Clone, Copy, Debug)]
pub struct SliceSource<'a, T> {
    data: &'a [T],
    columns: usize,
}

/// A row-major slice as a [`Store`].
#[derive(Debug)]
pub struct SliceStore<'a, T> {
    data: &'a mut [T],
    columns: usize,
}

impl<'a, T> SliceSource<'a, T> {
    /// A matrix of `data.len() / columns` rows.
    ///
    /// # Errors
    /// As [`SliceStore::new`].
    pub fn new(data: &'a [T], columns: usize) -> Result<Self, Error> {
        check_whole_rows(data.len(), columns)?;
        Ok(SliceSource { data, columns })
    }
}

impl<'a, T> SliceStore<'a, T> {
    /// A matrix of `data.len() / columns` rows.
    ///
    /// # Errors
    /// [`Error::Parameter`] for no columns, [`Error::Length`] where the slice does not end with
    /// a row.
    pub fn new(data: &'a mut [T], columns: usize) -> Result<Self, Error> {
        check_whole_rows(data.len(), columns)?;
        Ok(SliceStore { data, columns })
    }
}

fn check_whole_rows(length: usize, columns: usize) -> Result<(), Error> {
    if columns == 0 {
        return Err(Error::Parameter {
            name: "columns of a slice",
            value: 0.0,
            expected: "at least 1",
        });
    }
    if !length.is_multiple_of(columns) {
        return Err(Error::Length {
            name: "slice of whole rows",
            actual: length,
            expected: length / columns * columns,
        });
    }
    Ok(())
}

impl Area {
    /// The number of values.
    fn len(&self) -> usize {
        self.rows.saturating_mul(self.columns)
    }

    /// Where row `k` of the rectangle lies in a flat matrix of a given width.
    fn span(&self, k: usize, width: usize) -> Result<core::ops::Range<usize>, Error> {
        // Saturated sums lie outside every slice, so a nonsensical rectangle is refused as well.
        let row = self.row.saturating_add(k).saturating_mul(width);
        let start = row.saturating_add(self.column);
        if self.column.saturating_add(self.columns) > width {
            return Err(Error::Memory);
        }
        Ok(start..start.saturating_add(self.columns))
    }
}

fn read<T: Copy>(data: &[T], width: usize, area: Area, into: &mut [T]) -> Result<(), Error> {
    if into.len() != area.len() {
        return Err(Error::Memory);
    }
    for (k, row) in into.chunks_exact_mut(area.columns.max(1)).enumerate() {
        let span = area.span(k, width)?;
        row.copy_from_slice(data.get(span).ok_or(Error::Memory)?);
    }
    Ok(())
}

impl<T: Copy> Source<T> for SliceSource<'_, T> {
    fn read(&mut self, area: Area, into: &mut [T]) -> Result<(), Error> {
        read(self.data, self.columns, area, into)
    }
}

impl<T: Copy> Source<T> for SliceStore<'_, T> {
    fn read(&mut self, area: Area, into: &mut [T]) -> Result<(), Error> {
        read(self.data, self.columns, area, into)
    }
}

impl<T: Copy> Store<T> for SliceStore<'_, T> {
    fn write(&mut self, area: Area, from: &[T]) -> Result<(), Error> {
        if from.len() != area.len() {
            return Err(Error::Memory);
        }
        for (k, row) in from.chunks_exact(area.columns.max(1)).enumerate() {
            let span = area.span(k, self.columns)?;
            self.data
                .get_mut(span)
                .ok_or(Error::Memory)?
                .copy_from_slice(row);
        }
        Ok(())
    }
}
