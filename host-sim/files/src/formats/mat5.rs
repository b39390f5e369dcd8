//! The arrays of a MATLAB file of version 5 to 7.2 (`save -v6`, `-v7`, scipy's `savemat`).
//!
//! `matfile` reads them. It holds every array of a file, inflates without a bound, and gives the file up
//! for one array that it cannot read. So each array is cut out of the file and inflated here, within
//! bounds, and `matfile` is given that one. Arrays of numbers are read, structs and cells are not.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use flate2::read::ZlibDecoder;
use matfile::{MatFile, NumericData};
use ndarray::{ArrayD, IxDyn, ShapeBuilder};
use num_complex::Complex;

use super::super::{cannot_be_opened, file_error};
use super::guard::{CONVERSIONS, Told, claim, guarded};
use super::values::{Part, Source, Values};
use crate::memory;
use crate::{Error, Result};

/// The header that every file begins with, bytes.
const HEADER: usize = 128;
/// The tag before an element: its type and its length.
const TAG: usize = 8;
/// Types of elements: an array, and one that is deflated.
const ARRAY: u32 = 14;
const DEFLATED: u32 = 15;
/// Where an array tells its class, from its tag on.
const CLASS_AT: usize = 16;
/// Classes of arrays: f64, i8, u32, and those of numbers.
const DOUBLE: u8 = 6;
const INT8: u8 = 8;
const UINT32: u8 = 13;
const NUMBERS: std::ops::RangeInclusive<u8> = 6..=15;
/// What is inflated to find an array's name.
const NAME_WITHIN: u64 = 1024;

/// What to do where there is no memory for all of it.
const READ_WHOLE: &str = "MATLAB 5 files are read whole: save('FILE.mat', '-v7.3') writes one that is read \
    frame by frame, and so does host-sim convert on a larger machine";

/// An open file.
pub struct Mat5 {
    path: PathBuf,
    bytes: Vec<u8>,
    big_endian: bool,
    arrays: Vec<Element>,
}

/// Where an array lies.
struct Element {
    name: String,
    /// None for what holds no numbers.
    numbers: bool,
    at: std::ops::Range<usize>,
    deflated: bool,
}

impl Mat5 {
    /// Opens the file and finds its arrays.
    ///
    /// # Errors
    /// A file that cannot be opened, or is damaged.
    pub fn open(path: &Path) -> Result<Self> {
        let unreadable = |e: std::io::Error| file_error(path, cannot_be_opened(&e));
        let length = fs::metadata(path).map_err(unreadable)?.len();
        memory::check(length as usize, "the file")
            .map_err(|e| file_error(path, format!("is too large: {e}; {READ_WHOLE}")))?;
        let bytes = fs::read(path).map_err(unreadable)?;
        let big_endian = bytes.get(126..128) == Some(b"MI");
        let mut file = Self {
            path: path.to_path_buf(),
            bytes,
            big_endian,
            arrays: Vec::new(),
        };
        file.find().map_err(|message| file_error(path, message))?;
        Ok(file)
    }

    fn number(&self, bytes: &[u8], at: usize) -> Option<u32> {
        let four = bytes.get(at..at.checked_add(4)?)?.try_into().ok()?;
        Some(match self.big_endian {
            true => u32::from_be_bytes(four),
            false => u32::from_le_bytes(four),
        })
    }

    fn find(&mut self) -> Told<()> {
        let truncated = || "is truncated or damaged".to_owned();
        let mut at = HEADER;
        while at + TAG <= self.bytes.len() {
            let (kind, length) = self
                .number(&self.bytes, at)
                .zip(self.number(&self.bytes, at + 4))
                .ok_or_else(truncated)?;
            let end = at
                .checked_add(TAG + length as usize)
                .filter(|&end| end <= self.bytes.len())
                .ok_or_else(truncated)?;
            let deflated = kind == DEFLATED;
            if deflated || kind == ARRAY {
                let body = &self.bytes[at + TAG..end];
                let mut start = Vec::new();
                if deflated {
                    let mut inflated = ZlibDecoder::new(body).take(NAME_WITHIN);
                    let read = inflated.read_to_end(&mut start);
                    read.map_err(|e| format!("is truncated or damaged ({e})"))?;
                } else {
                    let within = (end - at).min(NAME_WITHIN as usize);
                    start.extend(&self.bytes[at..at + within]);
                }
                // What has no such head is no array of numbers: MATLAB's objects, say.
                if let Some((name, numbers)) = self.head(&start) {
                    self.arrays.push(Element {
                        name,
                        numbers,
                        at: if deflated { at + TAG..end } else { at..end },
                        deflated,
                    });
                }
            }
            // Only arrays that are not deflated are padded.
            at = if deflated {
                end
            } else {
                end.next_multiple_of(8)
            };
        }
        Ok(())
    }

    /// The name of the array whose tag this begins with, and whether it holds numbers.
    fn head(&self, bytes: &[u8]) -> Option<(String, bool)> {
        let flags = self.number(bytes, CLASS_AT)?;
        let sides = self.number(bytes, CLASS_AT + 12)? as usize;
        let name = (CLASS_AT + 16)
            .checked_add(sides)?
            .checked_next_multiple_of(8)?;
        let tag = self.number(bytes, name)?;
        // Up to four letters share the tag's eight bytes.
        let (from, length) = match tag >> 16 {
            0 => (name.checked_add(8)?, self.number(bytes, name + 4)? as usize),
            length => (name.checked_add(4)?, length as usize),
        };
        let name = bytes.get(from..from.checked_add(length)?)?;
        let numbers = NUMBERS.contains(&((flags & 0xff) as u8));
        Some((String::from_utf8_lossy(name).into_owned(), numbers))
    }

    /// The array as a file of its own, inflated.
    fn alone(&self, element: &Element) -> Told<Vec<u8>> {
        let body = &self.bytes[element.at.clone()];
        let mut file = self.bytes[..HEADER].to_vec();
        if !element.deflated {
            file.extend(body);
            return Ok(file);
        }
        let mut tag = [0; TAG];
        let mut inflated = ZlibDecoder::new(body);
        let damaged = |e| format!("is truncated or damaged ({e})");
        inflated.read_exact(&mut tag).map_err(damaged)?;
        let length = self.number(&tag, 4).unwrap_or_default();
        let bytes = claim(&[length as usize], 1, self.bytes.len() as u64)?;
        memory::check(bytes.saturating_mul(CONVERSIONS), "the array")
            .map_err(|e| format!("is too large: {e}; {READ_WHOLE}"))?;
        file.extend(tag);
        let mut inflated = inflated.take(u64::from(length));
        inflated.read_to_end(&mut file).map_err(damaged)?;
        if file.len() != HEADER + TAG + length as usize {
            return Err("is truncated".into());
        }
        Ok(file)
    }

    /// An array, with its sides in MATLAB's order.
    fn array(&self, name: &str) -> Told<(Vec<usize>, NumericData)> {
        let mut named = self.arrays.iter().filter(|element| element.name == name);
        let element = named.next().ok_or("is missing")?;
        if !element.numbers {
            return Err(
                "is a struct, a cell or text; expected an array of numbers (save its fields by \
                 save('FILE.mat', '-struct', 'NAME'))"
                    .into(),
            );
        }
        memory::check(element.at.len().saturating_mul(8), "the array")
            .map_err(|e| format!("is too large: {e}; {READ_WHOLE}"))?;
        let mut file = self.alone(element)?;
        let class_at = HEADER + CLASS_AT + if self.big_endian { 3 } else { 0 };
        let own = *file.get(class_at).ok_or("is truncated")?;
        // MATLAB stores small integers of any class as bytes, and `matfile` 0.5 takes int32 for uint32.
        for class in [own, DOUBLE, INT8, UINT32] {
            file[class_at] = class;
            let Ok(read) = MatFile::parse(file.as_slice()) else {
                continue;
            };
            let Some(array) = read.arrays().first() else {
                continue;
            };
            let sides = array.size().clone();
            let count = sides.iter().copied().try_fold(1usize, usize::checked_mul);
            let data = array.data().clone();
            if count != Some(length(&data)) {
                return Err(format!(
                    "claims a shape of {sides:?}, and holds other numbers"
                ));
            }
            return Ok((sides, data));
        }
        Err("is damaged, or not of numbers".into())
    }

    fn about<T>(&self, name: &str, outcome: Told<T>) -> Result<T> {
        outcome.map_err(|message| self.error(format!("`{name}` {message}")))
    }
}

impl Source for Mat5 {
    fn error(&self, message: String) -> Error {
        file_error(&self.path, message)
    }

    fn names(&self) -> Vec<String> {
        self.arrays.iter().map(|array| array.name.clone()).collect()
    }

    fn numbers(&self, name: &str) -> Result<ArrayD<f64>> {
        let read = || {
            let (sides, data) = self.array(name)?;
            let (real, imaginary) = parts(&data, |v| v);
            match imaginary {
                Some(_) => Err("is complex; expected real numbers".into()),
                None => by_columns(&sides, real),
            }
        };
        self.about(name, guarded(read))
    }

    /// Its arrays are deflated and in columns: whole.
    fn shape_for_parts(&self, _: &str) -> Result<Option<Vec<usize>>> {
        Ok(None)
    }

    fn samples(&self, name: &str, _: Option<Part>) -> Result<Values> {
        let read = || {
            let (sides, data) = self.array(name)?;
            let offset = match data {
                NumericData::UInt8 { .. } => 128.0,
                _ => 0.0,
            };
            let (real, imaginary) = parts(&data, |v| (v - offset) as f32);
            Ok(match imaginary {
                None => Values::Real(by_columns(&sides, real)?),
                Some(imaginary) => {
                    let both = real.into_iter().zip(imaginary);
                    let values = both.map(|(re, im)| Complex::new(re, im)).collect();
                    Values::Complex(by_columns(&sides, values)?)
                }
            })
        };
        self.about(name, guarded(read))
    }
}

/// Numbers in MATLAB's order, whose first side runs fastest.
fn by_columns<T: Clone>(sides: &[usize], values: Vec<T>) -> Told<ArrayD<T>> {
    let array = ArrayD::from_shape_vec(IxDyn(sides).f(), values);
    let array = array.map_err(|e| format!("has a shape of {sides:?}: {e}"))?;
    Ok(array.as_standard_layout().into_owned())
}

/// Real and imaginary parts, converted from f64, which holds all but the largest 64-bit integers.
fn parts<T>(data: &NumericData, convert: impl Fn(f64) -> T) -> (Vec<T>, Option<Vec<T>>) {
    macro_rules! parts {
        ($($class:ident),*) => {
            match data {
                $(NumericData::$class { real, imag } => {
                    let all = |values: &Vec<_>| values.iter().map(|&v| convert(v as f64)).collect();
                    (all(real), imag.as_ref().map(all))
                })*
            }
        };
    }
    parts!(
        Int8, UInt8, Int16, UInt16, Int32, UInt32, Int64, UInt64, Single, Double
    )
}

fn length(data: &NumericData) -> usize {
    parts(data, |_| ()).0.len()
}
