//! `.npz` archives written array by array.

use std::io::{Seek, Write};

use ndarray::{ArrayRef, Dimension};
use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::npy::{self, Element};
use super::npy_header::Header;

/// An archive that is written array by array.
pub struct Writer<W: Write + Seek> {
    zip: ZipWriter<W>,
    options: SimpleFileOptions,
}

/// Result of writing.
pub type Written<T = ()> = std::result::Result<T, ZipError>;

impl<W: Write + Seek> Writer<W> {
    /// An archive whose largest array has `bytes` bytes.
    pub fn new(sink: W, bytes: usize) -> Self {
        Self {
            zip: ZipWriter::new(sink),
            options: options(bytes),
        }
    }

    /// Adds an array.
    pub fn add<T: Element, D: Dimension>(&mut self, key: &str, array: &ArrayRef<T, D>) -> Written {
        self.zip.start_file(format!("{key}.npy"), self.options)?;
        Ok(npy::write(array, &mut self.zip)?)
    }

    /// Begins an array of this shape; [`Writer::append`] adds its numbers.
    pub fn begin<T: Element>(&mut self, key: &str, shape: &[usize]) -> Written {
        self.zip.start_file(format!("{key}.npy"), self.options)?;
        let header = Header {
            descr: T::NAME.into(),
            in_columns: false,
            shape: shape.to_vec(),
        };
        Ok(self.zip.write_all(&header.bytes())?)
    }

    /// Appends numbers to the array that was begun.
    pub fn append<T: Element, D: Dimension>(&mut self, array: &ArrayRef<T, D>) -> Written {
        let array = array.as_standard_layout();
        let numbers = array.as_slice().unwrap_or_default();
        Ok(T::encode(numbers, &mut self.zip)?)
    }

    /// Ends the archive.
    pub fn finish(self) -> Written {
        self.zip.finish()?.flush().map_err(ZipError::from)?;
        Ok(())
    }
}

/// How arrays are stored: uncompressed.
///
/// Sizes have 64 bits if `bytes` of data need them.
fn options(bytes: usize) -> SimpleFileOptions {
    // The header of the array adds less than this.
    const HEADER: usize = 4096;
    let large = bytes.saturating_add(HEADER) > u32::MAX as usize;
    SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .large_file(large)
}
