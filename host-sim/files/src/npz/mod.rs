//! Keyed arrays of a `.npz` file; errors name file, key and expected value.

mod frames;

use std::fmt::Display;
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use ndarray::{Array, Array2, ArrayD, Dimension};
use num_complex::Complex;
use zip::ZipArchive;
use zip::result::ZipError;

pub use super::npz_writer::{Writer, Written};
pub use frames::SomeFrames;
pub(super) use frames::{complex, counts, floats};

use super::npy::{self, Half, NpyError, or_type};
use super::npy_header::{Header, MAX_LENGTH};
use crate::hash::SharedHash;
use crate::input;
use crate::{Error, Result, memory};

/// Largest ratio of a member's size to its compressed size.
///
/// Recordings shrink to a half or a tenth, those of a point without noise to a few hundredths. Equal bytes shrink 1,030
/// times by deflate. The ratio bounds time; the memory is checked too.
const MAX_INFLATION: u64 = 900;
/// A member of up to this size may have any compression, bytes.
const SMALL: u64 = 16 << 20;

/// Bytes of an archive: a file, or memory.
pub trait Source: Read + Seek {}

impl<S: Read + Seek> Source for S {}

/// An open `.npz` file.
pub struct Reader {
    path: PathBuf,
    archive: ZipArchive<Box<dyn Source>>,
    spare: Spare,
    hash: Option<SharedHash>,
}

/// Memory of samples that is no longer needed, for the next ones.
#[derive(Default)]
pub struct Spare {
    /// For real samples.
    pub real: Vec<f32>,
    /// For counts.
    pub counts: Vec<i16>,
    /// For complex ones.
    pub complex: Vec<Complex<f32>>,
}

/// Whether a file has the last record of an archive, a comment of at most 64 KiB before its end.
///
/// The library looks for it in the whole file.
fn ends_as_archive(file: &mut (impl Read + Seek)) -> std::io::Result<bool> {
    const RECORD: u64 = 22;
    let length = file.seek(SeekFrom::End(0))?;
    let tail = length.min(RECORD + u64::from(u16::MAX));
    let mut end = Vec::new();
    file.seek(SeekFrom::Start(length - tail))?;
    file.take(tail).read_to_end(&mut end)?;
    Ok(end.windows(4).any(|bytes| bytes == b"PK\x05\x06"))
}

impl Reader {
    /// Opens the archive and reads its table of contents.
    pub fn open(path: &Path) -> Result<Self> {
        let file =
            input::open(path).map_err(|e| super::file_error(path, super::cannot_be_opened(&e)))?;
        Self::of(Box::new(BufReader::new(file)), path)
    }

    /// Reads the table of contents of an archive; errors name it by `path`.
    pub fn of(mut file: Box<dyn Source>, path: &Path) -> Result<Self> {
        let wrong = |e: &dyn Display| {
            super::file_error(path, format!("is truncated or not an .npz archive ({e})"))
        };
        if !ends_as_archive(&mut file).map_err(|e| wrong(&e))? {
            return Err(wrong(&"no table of contents at its end"));
        }
        let archive = ZipArchive::new(file).map_err(|e| wrong(&e))?;
        Ok(Self {
            path: path.to_path_buf(),
            archive,
            spare: Spare::default(),
            hash: None,
        })
    }

    /// Uses spare memory for the samples of some frames.
    pub fn with_spare(self, spare: Spare) -> Self {
        Reader { spare, ..self }
    }

    /// Passes samples that are stored uncompressed to the hash of this file.
    ///
    /// A large frame may then stay in the file.
    pub fn with_hash(self, hash: Option<SharedHash>) -> Self {
        Reader { hash, ..self }
    }

    /// The file.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// An error about this file.
    pub fn error(&self, message: impl Into<String>) -> Error {
        super::file_error(&self.path, message)
    }

    /// The names of the arrays.
    pub fn keys(&self) -> Vec<String> {
        let names = self.archive.file_names();
        names
            .filter_map(|name| name.strip_suffix(".npy"))
            .map(str::to_owned)
            .collect()
    }

    /// The sides of an array, by its header.
    ///
    /// # Errors
    /// There is no such array, or it is damaged.
    pub fn shape(&mut self, key: &str) -> Result<Vec<usize>> {
        Ok(self.header(key)?.shape)
    }

    fn header(&mut self, key: &str) -> Result<Header> {
        let head = self.head(key)?;
        let header = Header::read(&head).map_err(|e| self.error(format!("`{key}` {e}")))?;
        Ok(header.0)
    }

    /// Whether an array has complex numbers, by its header.
    ///
    /// # Errors
    /// As [`Reader::shape`].
    pub fn is_complex(&mut self, key: &str) -> Result<bool> {
        Ok(self.header(key)?.descr.contains('c'))
    }

    /// Whether there is an array with this name.
    pub fn has(&self, key: &str) -> bool {
        self.archive.index_for_name(&format!("{key}.npy")).is_some()
    }

    /// A real number (0-d, or an array of one; f64, f32 or an integer).
    pub fn scalar(&mut self, key: &str) -> Result<f64> {
        let array = self.real_of_any_rank(key)?;
        match array.as_slice().unwrap_or_default() {
            [value] => Ok(*value),
            _ => Err(self.rank_error(key, array.shape(), "a scalar (0-d)")),
        }
    }

    /// As [`Reader::scalar`]; `None` if the key is missing.
    pub fn optional_scalar(&mut self, key: &str) -> Result<Option<f64>> {
        self.has(key).then(|| self.scalar(key)).transpose()
    }

    /// As [`Reader::vector`]; `None` if the key is missing.
    pub fn optional_vector(
        &mut self,
        key: &str,
        count: usize,
        of: &str,
    ) -> Result<Option<Vec<f64>>> {
        let there = self.has(key);
        there.then(|| self.vector(key, count, of)).transpose()
    }

    /// Real numbers of two axes.
    pub fn table(&mut self, key: &str, shape: [usize; 2], axes: &str) -> Result<Array2<f64>> {
        let array = self.real(key, axes)?;
        self.shaped(key, array, shape, axes)
    }

    /// Truth values of two axes: bool, or integers that are 0 or not.
    pub fn flags(&mut self, key: &str, shape: [usize; 2], axes: &str) -> Result<Array2<bool>> {
        let bytes = self.bytes(key)?;
        let array = or_type(npy::read::<bool>(&bytes), || {
            integers(&bytes).map(|a| a.mapv(|v| v != 0))
        });
        let array = self.typed(key, array, "bool or an integer type")?;
        let array = self.ranked(key, array, axes)?;
        self.shaped(key, array, shape, axes)
    }

    fn shaped<T>(
        &self,
        key: &str,
        array: Array2<T>,
        shape: [usize; 2],
        axes: &str,
    ) -> Result<Array2<T>> {
        if array.shape() == shape {
            return Ok(array);
        }
        let expected = format!("{axes}, which is {shape:?}");
        Err(self.rank_error(key, array.shape(), &expected))
    }

    /// Real numbers (f64, f32 or integers): `count` of them, one for each `of`.
    pub fn vector(&mut self, key: &str, count: usize, of: &str) -> Result<Vec<f64>> {
        let values = self.vector_of_any_length(key, of)?;
        self.check_length(key, values.len(), count, of)?;
        Ok(values)
    }

    /// Real numbers (f64, f32 or integers), one for each `of`.
    pub fn vector_of_any_length(&mut self, key: &str, of: &str) -> Result<Vec<f64>> {
        let array: Array<f64, ndarray::Ix1> = self.real(key, &format!("one axis, [{of}]"))?;
        Ok(array.to_vec())
    }

    /// As [`Reader::vector`]; a scalar stands for `count` equal numbers.
    pub fn vector_or_scalar(&mut self, key: &str, count: usize, of: &str) -> Result<Vec<f64>> {
        let array = self.real_of_any_rank(key)?;
        match array.ndim() {
            0 => Ok(vec![array.sum(); count]),
            1 if array.len() == 1 => Ok(vec![array.sum(); count]),
            1 => {
                self.check_length(key, array.len(), count, of)?;
                Ok(array.iter().copied().collect())
            }
            _ => Err(self.rank_error(key, array.shape(), &format!("a scalar or [{of}]"))),
        }
    }

    /// Indices (integers), `count` of them, each below `limit`.
    pub fn indices(
        &mut self,
        key: &str,
        count: usize,
        of: &str,
        limit: usize,
    ) -> Result<Vec<usize>> {
        let bytes = self.bytes(key)?;
        let array = self.typed(key, integers(&bytes), "an integer type such as int64")?;
        let array: Array<i64, ndarray::Ix1> =
            self.ranked(key, array, &format!("one axis, [{of}]"))?;
        self.check_length(key, array.len(), count, of)?;
        let mut indices = Vec::with_capacity(count);
        for (i, &value) in array.iter().enumerate() {
            match usize::try_from(value) {
                Ok(index) if index < limit => indices.push(index),
                _ => {
                    return Err(self.error(format!(
                        "`{key}` is {value} at {of} {i}; expected 0 to {}",
                        limit - 1
                    )));
                }
            }
        }
        Ok(indices)
    }

    /// Recorded samples as f32.
    ///
    /// Types: f32, f64 and integers (rounded), f16, or u8, whose zero is 128.
    pub fn samples_of_any_rank(&mut self, key: &str) -> Result<ArrayD<f32>> {
        let bytes = self.bytes(key)?;
        self.real_samples(key, &bytes)
    }

    fn real_samples(&self, key: &str, bytes: &[u8]) -> Result<ArrayD<f32>> {
        let array = or_type(npy::read::<f32>(bytes), || {
            npy::read::<i16>(bytes).map(|a| a.mapv(f32::from))
        });
        let array = or_type(array, || {
            npy::read::<f64>(bytes).map(|a| a.mapv(|v| v as f32))
        });
        let array = or_type(array, || {
            npy::read::<i32>(bytes).map(|a| a.mapv(|v| v as f32))
        });
        let array = or_type(array, || {
            npy::read::<u8>(bytes).map(|a| a.mapv(|v| f32::from(v) - 128.0))
        });
        let array = or_type(array, || npy::read::<i8>(bytes).map(|a| a.mapv(f32::from)));
        let array = or_type(array, || npy::read::<u16>(bytes).map(|a| a.mapv(f32::from)));
        let array = or_type(array, || {
            npy::read::<i64>(bytes).map(|a| a.mapv(|v| v as f32))
        });
        let array = or_type(array, || {
            npy::read::<Half>(bytes).map(|a| a.mapv(f32::from))
        });
        self.typed(
            key,
            array,
            "a float type, int8, int16, int32, int64, uint16 or uint8",
        )
    }

    /// Complex samples: complex64, or complex128 rounded to it.
    pub fn complex<D: Dimension>(
        &mut self,
        key: &str,
        axes: &str,
    ) -> Result<Array<Complex<f32>, D>> {
        let bytes = self.bytes(key)?;
        let array = self.complex_samples(key, &bytes)?;
        self.ranked(key, array, axes)
    }

    fn complex_samples(&self, key: &str, bytes: &[u8]) -> Result<ArrayD<Complex<f32>>> {
        let array = or_type(npy::read::<Complex<f32>>(bytes), || {
            let wide = npy::read::<Complex<f64>>(bytes)?;
            Ok(wide.mapv(|z| Complex::new(z.re as f32, z.im as f32)))
        });
        self.typed(key, array, "complex64 or complex128")
    }

    fn real<D: Dimension>(&mut self, key: &str, expected: &str) -> Result<Array<f64, D>> {
        let array = self.real_of_any_rank(key)?;
        self.ranked(key, array, expected)
    }

    /// Real numbers (f64, f32 or integers) of any shape.
    pub fn real_of_any_rank(&mut self, key: &str) -> Result<ArrayD<f64>> {
        let bytes = self.bytes(key)?;
        let floats = or_type(npy::read::<f64>(&bytes), || {
            npy::read::<f32>(&bytes).map(|a| a.mapv(f64::from))
        });
        // numpy makes integers of numbers written without a point, such as c=1540.
        let array = or_type(floats, || integers(&bytes).map(|a| a.mapv(|v| v as f64)));
        self.typed(key, array, "float64, float32 or an integer type")
    }

    /// Bytes of one member; reading to the end checks the archive's checksum.
    ///
    /// At most [`MAX_INFLATION`] times the compressed size is read.
    fn bytes(&mut self, key: &str) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let mut limit = u64::MAX;
        let outcome = match self.archive.by_name(&format!("{key}.npy")) {
            Ok(member) => {
                limit = member.compressed_size().saturating_mul(MAX_INFLATION);
                limit = limit.max(SMALL);
                // What is longer than the archive's table states is damaged.
                let needed =
                    (member.size().min(limit) as usize).saturating_mul(1 + npy::CONVERSIONS);
                if let Err(e) = memory::check(needed, "the array") {
                    let path = &self.path;
                    return Err(super::file_error(
                        path,
                        format!("`{key}` is too large: {e}"),
                    ));
                }
                let mut member = member.take(limit.saturating_add(1));
                member.read_to_end(&mut bytes).map_err(ZipError::from)
            }
            Err(e) => Err(e),
        };
        match outcome {
            Ok(read) if read as u64 > limit => Err(self.inflated(key)),
            Ok(_) => Ok(bytes),
            Err(e) => Err(self.damaged(key, &e)),
        }
    }

    fn inflated(&self, key: &str) -> Error {
        self.error(format!(
            "`{key}` inflates to more than {MAX_INFLATION} times its compressed size, \
             as if all samples were equal; recordings do not"
        ))
    }

    fn damaged(&self, key: &str, error: &ZipError) -> Error {
        match error {
            ZipError::FileNotFound => self.error(format!("has no key `{key}`")),
            ZipError::Io(e) if e.kind() == ErrorKind::OutOfMemory => {
                self.error(format!("`{key}` is too large: there is no memory for it"))
            }
            e => self.error(format!("`{key}` is truncated or damaged ({e})")),
        }
    }

    /// Beginning of a member, with the header of its array.
    fn head(&mut self, key: &str) -> Result<Vec<u8>> {
        let mut head = Vec::new();
        let outcome = self
            .archive
            .by_name(&format!("{key}.npy"))
            .and_then(|member| {
                let mut member = member.take(MAX_LENGTH as u64);
                member.read_to_end(&mut head).map_err(ZipError::from)
            });
        outcome.map_err(|e| self.damaged(key, &e))?;
        Ok(head)
    }

    fn typed<T>(
        &self,
        key: &str,
        array: std::result::Result<ArrayD<T>, NpyError>,
        expected: &str,
    ) -> Result<ArrayD<T>> {
        array.map_err(|e| match e {
            NpyError::Type(found) => {
                self.error(format!("`{key}` has dtype {found}; expected {expected}"))
            }
            NpyError::Damaged(message) => self.error(format!("`{key}` {message}")),
        })
    }

    fn ranked<T, D: Dimension>(
        &self,
        key: &str,
        array: ArrayD<T>,
        expected: &str,
    ) -> Result<Array<T, D>> {
        let shape = array.shape().to_vec();
        array
            .into_dimensionality()
            .map_err(|_| self.rank_error(key, &shape, expected))
    }

    fn rank_error(&self, key: &str, shape: &[usize], expected: &str) -> Error {
        self.error(format!("`{key}` has shape {shape:?}; expected {expected}"))
    }

    fn check_length(&self, key: &str, length: usize, expected: usize, of: &str) -> Result<()> {
        if length == expected {
            return Ok(());
        }
        Err(self.error(format!(
            "`{key}` has length {length}; expected {expected}, one for each {of}"
        )))
    }
}

/// Integers of any usual numpy type.
fn integers(bytes: &[u8]) -> std::result::Result<ArrayD<i64>, NpyError> {
    let signed = or_type(npy::read::<i64>(bytes), || {
        npy::read::<i32>(bytes).map(|a| a.mapv(i64::from))
    });
    let signed = or_type(signed, || {
        npy::read::<i16>(bytes).map(|a| a.mapv(i64::from))
    });
    let all = or_type(signed, || {
        npy::read::<u32>(bytes).map(|a| a.mapv(i64::from))
    });
    let all = or_type(all, || npy::read::<u16>(bytes).map(|a| a.mapv(i64::from)));
    let all = or_type(all, || npy::read::<u8>(bytes).map(|a| a.mapv(i64::from)));
    let all = or_type(all, || npy::read::<i8>(bytes).map(|a| a.mapv(i64::from)));
    // What is beyond i64 is beyond every range that is asked for.
    or_type(all, || {
        npy::read::<u64>(bytes).map(|a| a.mapv(|v| i64::try_from(v).unwrap_or(i64::MAX)))
    })
}
