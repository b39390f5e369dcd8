//! `.npz` archives written array by array.

use std::io::{self, Seek, Write};

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
pub type Written = io::Result<()>;

/// The error of the sink, which the library's own message leaves out.
fn reason(error: ZipError) -> io::Error {
    match error {
        ZipError::Io(error) => error,
        other => other.into(),
    }
}

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
        self.start(key)?;
        npy::write(array, &mut self.zip)
    }

    /// Begins an array of this shape; [`Writer::append`] adds its numbers.
    pub fn begin<T: Element>(&mut self, key: &str, shape: &[usize]) -> Written {
        self.start(key)?;
        let header = Header {
            descr: T::NAME.into(),
            in_columns: false,
            shape: shape.to_vec(),
        };
        self.zip.write_all(&header.bytes())
    }

    fn start(&mut self, key: &str) -> Written {
        let started = self.zip.start_file(format!("{key}.npy"), self.options);
        started.map_err(reason)
    }

    /// Appends numbers to the array that was begun.
    pub fn append<T: Element, D: Dimension>(&mut self, array: &ArrayRef<T, D>) -> Written {
        let array = array.as_standard_layout();
        let numbers = array.as_slice().unwrap_or_default();
        T::encode(numbers, &mut self.zip)
    }

    /// Ends the archive.
    pub fn finish(self) -> Written {
        self.zip.finish().map_err(reason)?.flush()
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
