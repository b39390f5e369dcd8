//! Reads the arrays of a MATLAB file of version 5 to 7.2.
//!
//! Such files come from `save -v6`, `-v7` and scipy's `savemat`. The format is described in MathWorks' "MAT-File
//! Format", R2021b, chapter 1. Arrays of numbers and text are read, also in structs and cells; sparse arrays and
//! MATLAB's newer objects are not. One array is inflated at a time, within bounds; structs and cells are kept.

mod elements;

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Read;
use std::ops::{Range, RangeInclusive};
use std::path::{Path, PathBuf};

use flate2::read::ZlibDecoder;
use ndarray::{ArrayD, IxDyn, ShapeBuilder};
use num_complex::Complex;

use crate::guard::{CONVERSIONS, ReadResult, claim};
use crate::values::{AxisRange, NamedArrays, Reads, Values, steps};
use bonebeam_files::{Error, Result, cannot_be_opened, file_error, input, memory};
use elements::{Elements, TAG};

/// Length of the header of every file, bytes.
const HEADER: usize = 128;
/// Types of elements: an array, and a compressed one.
const ARRAY: u32 = 14;
const DEFLATED: u32 = 15;
/// Classes of arrays: cells, structs and objects, text, u8, and numbers.
const CELL: u8 = 1;
const OBJECT: u8 = 3;
const TEXT: u8 = 4;
const UINT8: u8 = 9;
const NUMBERS: RangeInclusive<u8> = 6..=15;
/// Deepest nesting of structs and cells, and largest number of arrays.
const DEEPEST: usize = 16;
const MOST_ARRAYS: usize = 1 << 20;
/// Bytes to inflate to find an array's name.
const NAME_WITHIN: u64 = 1024;

/// Advice if there is no memory for the whole file.
const READ_WHOLE: &str = "MATLAB 5 files are read whole: save('FILE.mat', '-v7.3') writes one that is read \
    frame by frame, and so does host-sim convert on a larger machine";

/// An open file.
pub struct Mat5 {
    path: PathBuf,
    bytes: Vec<u8>,
    big_endian: bool,
    arrays: Vec<Element>,
    /// Index of an array by name.
    by_name: HashMap<String, usize>,
    /// Inflated contents of structs and cells.
    inflated: Vec<Vec<u8>>,
    read: Reads,
}

/// Position of an array.
struct Element {
    /// Its path: `P.c`, `RcvData{1}`, `Receive(3).mode`.
    name: String,
    class: u8,
    sides: Vec<usize>,
    at: Range<usize>,
    deflated: bool,
    /// Index in [`Mat5::inflated`]; `None` for the file.
    within: Option<usize>,
}

impl Mat5 {
    /// Opens the file and finds its arrays.
    ///
    /// # Errors
    /// A file that cannot be opened, or is damaged.
    pub fn open(path: &Path) -> Result<Self> {
        let unreadable = |e: std::io::Error| file_error(path, cannot_be_opened(&e));
        let length = input::open(path)
            .and_then(|file| file.metadata())
            .map_err(unreadable)?
            .len();
        memory::check(length as usize, "the file")
            .map_err(|e| file_error(path, format!("is too large: {e}; {READ_WHOLE}")))?;
        let bytes = input::read(path, u64::MAX).map_err(unreadable)?;
        let big_endian = bytes.get(126..128) == Some(b"MI");
        let mut file = Self {
            path: path.to_path_buf(),
            bytes,
            big_endian,
            arrays: Vec::new(),
            by_name: HashMap::new(),
            inflated: Vec::new(),
            read: Reads::default(),
        };
        file.find().map_err(|message| file_error(path, message))?;
        Ok(file)
    }

    fn elements<'a>(&self, bytes: &'a [u8]) -> Elements<'a> {
        Elements {
            rest: bytes,
            big_endian: self.big_endian,
        }
    }

    fn number(&self, bytes: &[u8], at: usize) -> Option<u32> {
        self.elements(bytes.get(at..)?).number(0)
    }

    fn find(&mut self) -> ReadResult<()> {
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
                if let Some((name, class, sides)) = self.head(&start) {
                    self.take(Element {
                        name,
                        class,
                        sides,
                        at: if deflated { at + TAG..end } else { at..end },
                        deflated,
                        within: None,
                    })?;
                }
            }
            // An array's length counts its padding.
            at = end;
        }
        Ok(())
    }

    /// Name, class and sides of the array whose tag begins here.
    fn head(&self, bytes: &[u8]) -> Option<(String, u8, Vec<usize>)> {
        let array = self.elements(bytes.get(TAG..)?).array()?;
        let name = String::from_utf8_lossy(array.name).into_owned();
        Some((name, array.class, array.sides))
    }

    /// Keeps an array and those within it.
    fn take(&mut self, mut element: Element) -> ReadResult<()> {
        if !(CELL..=OBJECT).contains(&element.class) {
            return self.keep(element);
        }
        if element.deflated {
            let contents = self.contents(&element)?.into_owned();
            element.at = 0..contents.len();
            element.within = Some(self.inflated.len());
            self.inflated.push(contents);
        } else {
            element.at.start = element.at.end.min(element.at.start + TAG);
        }
        let mut open = vec![(element, 0)];
        while let Some((array, depth)) = open.pop() {
            if !(CELL..=OBJECT).contains(&array.class) {
                self.keep(array)?;
                continue;
            }
            if depth == DEEPEST {
                return Err(format!("nests structs or cells more than {DEEPEST} deep"));
            }
            let members = self.members(&array).ok_or_else(|| {
                format!(
                    "is damaged: `{}` does not hold what its header claims",
                    array.name
                )
            })?;
            open.extend(members.into_iter().rev().map(|member| (member, depth + 1)));
        }
        Ok(())
    }

    fn keep(&mut self, element: Element) -> ReadResult<()> {
        if self.arrays.len() == MOST_ARRAYS {
            return Err(format!("holds over {MOST_ARRAYS} arrays"));
        }
        let name = element.name.clone();
        self.by_name.entry(name).or_insert(self.arrays.len());
        self.arrays.push(element);
        Ok(())
    }

    fn held(&self, element: &Element) -> &[u8] {
        let bytes = element.within.map_or(&self.bytes, |k| &self.inflated[k]);
        &bytes[element.at.clone()]
    }

    /// Arrays in a struct or a cell, each with its tag after it.
    ///
    /// The tag of the struct or cell itself is not among its bytes.
    fn members(&self, parent: &Element) -> Option<Vec<Element>> {
        let held = self.held(parent);
        let array = self.elements(held).array()?;
        let count = array
            .sides
            .iter()
            .copied()
            .try_fold(1usize, usize::checked_mul)?;
        let mut rest = array.numbers;
        let mut fields = vec![String::new()];
        if parent.class != CELL {
            if parent.class == OBJECT {
                rest.next()?;
            }
            let (_, width) = rest.next()?;
            let width = rest.like(width).number(0)? as usize;
            let (_, names) = rest.next()?;
            let text = |name: &[u8]| {
                let name = name.split(|&byte| byte == 0).next().unwrap_or_default();
                String::from_utf8_lossy(name).into_owned()
            };
            fields = names.chunks_exact(width.max(1)).map(text).collect();
        }
        let total = count.checked_mul(fields.len())?;
        // Each takes a tag at the least.
        if total > rest.rest.len() / TAG {
            return None;
        }
        let mut members = Vec::with_capacity(total);
        for entry in 1..=count {
            let path = match (parent.class, count) {
                (CELL, _) => format!("{}{{{entry}}}", parent.name),
                (_, 1) => parent.name.clone(),
                _ => format!("{}({entry})", parent.name),
            };
            for field in &fields {
                let begin = held.len() - rest.rest.len();
                let (kind, body) = rest.next()?;
                let start = parent.at.start + begin;
                // What is empty may have no flags.
                let array = self.elements(body).array();
                let (class, sides) = array.map_or((0, vec![]), |array| (array.class, array.sides));
                let dot = if field.is_empty() { "" } else { "." };
                let holds = (CELL..=OBJECT).contains(&class);
                members.push(Element {
                    name: format!("{path}{dot}{field}"),
                    class: if kind == ARRAY { class } else { 0 },
                    sides,
                    at: start + if holds { TAG } else { 0 }..start + TAG + body.len(),
                    deflated: false,
                    within: parent.within,
                });
            }
        }
        Some(members)
    }

    /// Contents after the array's tag, inflated.
    fn contents(&self, element: &Element) -> ReadResult<Cow<'_, [u8]>> {
        let body = self.held(element);
        if !element.deflated {
            return Ok(body.get(TAG..).unwrap_or_default().into());
        }
        let mut tag = [0; TAG];
        let mut inflated = ZlibDecoder::new(body);
        let damaged = |e| format!("is truncated or damaged ({e})");
        inflated.read_exact(&mut tag).map_err(damaged)?;
        let length = self.number(&tag, 4).unwrap_or_default();
        let bytes = claim(&[length as usize], 1, self.bytes.len() as u64)?;
        memory::check(bytes.saturating_mul(CONVERSIONS), "the array")
            .map_err(|e| format!("is too large: {e}; {READ_WHOLE}"))?;
        let mut contents = Vec::with_capacity(bytes);
        let mut inflated = inflated.take(u64::from(length));
        inflated.read_to_end(&mut contents).map_err(damaged)?;
        if contents.len() != length as usize {
            return Err("is truncated".into());
        }
        Ok(contents.into())
    }

    /// An array: its sides in MATLAB's order, and its numbers converted from f64.
    ///
    /// f64 holds all but the largest 64-bit integers. `convert` receives the array's class.
    fn array<T>(
        &self,
        name: &str,
        class: RangeInclusive<u8>,
        convert: impl Fn(f64, u8) -> T,
    ) -> ReadResult<Parts<T>> {
        self.read.note(name);
        let element = match self.found(name).as_slice() {
            [] => return Err("is missing".into()),
            [element] => *element,
            several => {
                return Err(format!(
                    "stands for {} arrays; expected one of them, such as `{}`",
                    several.len(),
                    several[0].name
                ));
            }
        };
        if !class.contains(&element.class) {
            return Err(match element.class {
                TEXT => "is text; expected an array of numbers".into(),
                _ => format!(
                    "is of MATLAB's class {}; expected an array of numbers",
                    element.class
                ),
            });
        }
        memory::check(element.at.len().saturating_mul(8), "the array")
            .map_err(|e| format!("is too large: {e}; {READ_WHOLE}"))?;
        let contents = self.contents(element)?;
        let damaged = || "is damaged, or not of numbers".to_owned();
        let array = self.elements(&contents).array().ok_or_else(damaged)?;
        let sides = array.sides;
        let count = sides.iter().copied().try_fold(1usize, usize::checked_mul);
        let mut elements = array.numbers;
        let mut part = || {
            let numbers =
                elements.numbers(array.class == TEXT, |value| convert(value, array.class));
            let numbers = numbers.ok_or_else(damaged)?;
            match count == Some(numbers.len()) {
                true => Ok(numbers),
                false => Err(format!(
                    "claims a shape of {sides:?}, but holds another number of values"
                )),
            }
        };
        let real = part()?;
        let imaginary = array.complex.then(part).transpose()?;
        Ok(Parts {
            sides,
            real,
            imaginary,
        })
    }

    /// The arrays that a name stands for.
    fn found(&self, name: &str) -> Vec<&Element> {
        if let Some(&index) = self.by_name.get(name) {
            return vec![&self.arrays[index]];
        }
        let asked = steps(name);
        let is_asked = |element: &&Element| {
            let steps = steps(&element.name);
            let mut pairs = asked.iter().zip(&steps);
            asked.len() == steps.len()
                && pairs.all(|(asked, step)| {
                    asked.0 == step.0 && (asked.1.is_none() || asked.1 == step.1)
                })
        };
        self.arrays.iter().filter(is_asked).collect()
    }

    fn about<T>(&self, name: &str, outcome: ReadResult<T>) -> Result<T> {
        outcome.map_err(|message| self.error(format!("`{name}` {message}")))
    }
}

impl NamedArrays for Mat5 {
    fn error(&self, message: String) -> Error {
        file_error(&self.path, message)
    }

    fn names(&self) -> Vec<String> {
        self.arrays.iter().map(|array| array.name.clone()).collect()
    }

    fn unread(&self) -> Vec<String> {
        self.read.without(self.names())
    }

    fn sides(&self, name: &str) -> Option<Vec<usize>> {
        let found = self.found(name);
        let element = found
            .first()
            .filter(|element| NUMBERS.contains(&element.class))?;
        Some(element.sides.clone())
    }

    fn entries(&self, name: &str) -> Vec<String> {
        let found = self.found(name).into_iter();
        found.map(|element| element.name.clone()).collect()
    }

    fn numbers(&self, name: &str) -> Result<ArrayD<f64>> {
        let read = || {
            let array = self.array(name, NUMBERS, |v, _| v)?;
            match array.imaginary {
                Some(_) => Err("is complex; expected real numbers".into()),
                None => by_columns(&array.sides, array.real),
            }
        };
        self.about(name, read())
    }

    fn text(&self, name: &str) -> Result<String> {
        let read = self.array(name, TEXT..=TEXT, |code, _| code as u32);
        let codes = self.about(name, read)?.real.into_iter();
        Ok(codes
            .map(|code| char::from_u32(code).unwrap_or('?'))
            .collect())
    }

    /// `None`: arrays are compressed and stored by columns, so they are read whole.
    fn shape_for_parts(&self, _: &str) -> Result<Option<Vec<usize>>> {
        Ok(None)
    }

    fn samples(&self, name: &str, _: Option<AxisRange>) -> Result<Values> {
        let read = || {
            let zero = |class| if class == UINT8 { 128.0 } else { 0.0 };
            let array = self.array(name, NUMBERS, |v, class| (v - zero(class)) as f32)?;
            Ok(match array.imaginary {
                None => Values::Real(by_columns(&array.sides, array.real)?),
                Some(imaginary) => {
                    let both = array.real.into_iter().zip(imaginary);
                    let values = both.map(|(re, im)| Complex::new(re, im)).collect();
                    Values::Complex(by_columns(&array.sides, values)?)
                }
            })
        };
        self.about(name, read())
    }
}

/// The numbers of an array in MATLAB's order, and its sides.
struct Parts<T> {
    sides: Vec<usize>,
    real: Vec<T>,
    imaginary: Option<Vec<T>>,
}

/// Numbers in MATLAB's order, whose first side runs fastest.
fn by_columns<T: Clone>(sides: &[usize], values: Vec<T>) -> ReadResult<ArrayD<T>> {
    let array = ArrayD::from_shape_vec(IxDyn(sides).f(), values);
    let array = array.map_err(|e| format!("has a shape of {sides:?}: {e}"))?;
    Ok(array.as_standard_layout().into_owned())
}

#[cfg(test)]
mod tests;
