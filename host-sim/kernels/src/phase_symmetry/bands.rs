//! Parts of phase symmetry's matrices, each written by one thread.

use std::ops::Range;

use bonebeam::Error;
use bonebeam::phase_symmetry::{ReadAt, WriteAt};

/// A part of a matrix, from an index on.
pub struct MatrixPart<'a> {
    first: usize,
    data: &'a mut [f32],
}

impl<'a> MatrixPart<'a> {
    /// `data` as the values of the matrix from index `first` on.
    pub fn new(data: &'a mut [f32], first: usize) -> Self {
        MatrixPart { first, data }
    }

    fn holds(&self, first: usize, length: usize) -> bool {
        first >= self.first && first + length <= self.first + self.data.len()
    }
}

impl ReadAt for MatrixPart<'_> {
    fn read_at(&mut self, first: usize, into: &mut [f32]) -> Result<(), Error> {
        let first = first.checked_sub(self.first).ok_or(Error::Memory)?;
        (&*self.data).read_at(first, into)
    }

    fn view(&self, first: usize, length: usize) -> Option<&[f32]> {
        self.data
            .get(first.checked_sub(self.first)?..)?
            .get(..length)
    }
}

impl WriteAt for MatrixPart<'_> {
    fn write_at(&mut self, first: usize, from: &[f32]) -> Result<(), Error> {
        let first = first.checked_sub(self.first).ok_or(Error::Memory)?;
        (&mut *self.data).write_at(first, from)
    }

    fn view_mut(&mut self, first: usize, length: usize) -> Option<&mut [f32]> {
        self.data
            .get_mut(first.checked_sub(self.first)?..)?
            .get_mut(..length)
    }
}

/// A matrix that several threads read.
pub struct Whole<'a>(pub &'a [f32]);

impl ReadAt for Whole<'_> {
    fn read_at(&mut self, first: usize, into: &mut [f32]) -> Result<(), Error> {
        self.0.read_at(first, into)
    }

    fn view(&self, first: usize, length: usize) -> Option<&[f32]> {
        self.0.get(first..)?.get(..length)
    }
}

/// Indices in the filtered image of some strips of columns.
///
/// Each strip of rows has two parts: the columns and their mirror images.
pub struct Band<'a> {
    /// Length of a strip of rows.
    width: usize,
    parts: Vec<[MatrixPart<'a>; 2]>,
}

impl<'a> Band<'a> {
    /// Cuts the filtered image into bands of strips of columns.
    ///
    /// Its strips of rows have length `width`.
    pub fn cut<'b>(
        filtered: &'a mut [f32],
        width: usize,
        bands: impl ExactSizeIterator<Item = &'b [Range<usize>]> + Clone,
        columns: usize,
    ) -> Vec<Band<'a>> {
        let mut cut: Vec<Band> = Vec::new();
        cut.resize_with(bands.len(), || Band {
            width,
            parts: Vec::new(),
        });
        for (k, strip) in filtered.chunks_mut(width).enumerate() {
            let column = strip.len() / columns;
            let first = k * width;
            let (mut direct, mut mirrored) = strip.split_at_mut((columns / 2 + 1) * column);
            let nyquist = columns / 2;
            for (band, strips) in cut.iter_mut().zip(bands.clone()) {
                let (start, end) = (strips[0].start, strips[strips.len() - 1].end);
                let mirrored_columns = end.min(nyquist) - start.max(1).min(nyquist);
                let lengths = [(end - start) * column, mirrored_columns * column];
                let offset = (nyquist + start.max(1)) * column;
                let one = direct.split_off_mut(..lengths[0]).unwrap_or_default();
                let other = mirrored.split_off_mut(..lengths[1]).unwrap_or_default();
                band.parts.push([
                    MatrixPart::new(one, first + start * column),
                    MatrixPart::new(other, first + offset),
                ]);
            }
        }
        cut
    }
}

/// Columns are written; their rows are read from the whole matrix, later.
impl ReadAt for Band<'_> {
    fn read_at(&mut self, _: usize, _: &mut [f32]) -> Result<(), Error> {
        Err(Error::Memory)
    }
}

impl WriteAt for Band<'_> {
    fn write_at(&mut self, first: usize, from: &[f32]) -> Result<(), Error> {
        let parts = self.parts.get_mut(first / self.width).into_iter().flatten();
        let mut part = parts.filter(|part| part.holds(first, from.len()));
        part.next().ok_or(Error::Memory)?.write_at(first, from)
    }
}
