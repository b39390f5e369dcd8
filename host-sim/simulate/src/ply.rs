//! Reads a mesh from a PLY file, as text or as bytes of either order.
//!
//! Unused properties and elements are skipped.
//!
//! Source: G. Turk, The PLY Polygon File Format, 1994.

use std::collections::BTreeMap;
use std::io::{BufRead, Read};

type Result<T> = std::result::Result<T, String>;

/// Longest line of a header and longest number, bytes.
const MAX_LINE: u64 = 4096;
const MAX_NUMBER: usize = 128;

/// Corners and triangles from a file.
#[derive(Default)]
pub(super) struct Raw {
    /// In mm, not checked.
    pub(super) vertices: Vec<[f64; 3]>,
    /// Indices, checked.
    pub(super) triangles: Vec<[usize; 3]>,
}

/// Values of the vertices by their names.
pub type Columns = BTreeMap<String, Vec<f64>>;

#[derive(Clone, Copy, PartialEq)]
enum Format {
    Text,
    LittleEndian,
    BigEndian,
}

#[derive(Clone, Copy, PartialEq)]
enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

struct Property {
    name: String,
    /// The type of a list's count.
    list: Option<Scalar>,
    scalar: Scalar,
}

struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

/// The mesh of a file of `length` bytes.
///
/// # Errors
/// A message on one line.
pub(super) fn read(reader: impl BufRead, length: u64) -> Result<Raw> {
    Ok(read_parts(reader, length, true)?.0)
}

/// The vertices' values of a file of `length` bytes, which needs no faces.
///
/// # Errors
/// A message on one line.
pub(super) fn read_columns(reader: impl BufRead, length: u64) -> Result<Columns> {
    Ok(read_parts(reader, length, false)?.1)
}

/// The mesh, or the values of its vertices.
fn read_parts(mut reader: impl BufRead, length: u64, mesh: bool) -> Result<(Raw, Columns)> {
    let unreadable = |reason: String| format!("not a readable PLY file: {reason}");
    let (format, elements) = header(&mut reader).map_err(unreadable)?;
    check_counts(&elements, length)?;
    let count = |name: &str| {
        let found = elements.iter().find(|e| e.name == name && e.count > 0);
        found
            .map(|element| element.count)
            .ok_or_else(|| format!("the PLY file has no element \"{name}\""))
    };
    let known = count("vertex")?;
    if mesh {
        count("face")?;
    }
    let mut values = Values { reader, format };
    let (mut raw, mut columns) = (Raw::default(), Columns::new());
    for element in &elements {
        check_properties(element)?;
        for index in 0..element.count {
            let mut vertex = [0.0; 3];
            for property in &element.properties {
                let values = &mut values;
                let mut next = |scalar| values.next(scalar).map_err(unreadable);
                let Some(list) = property.list else {
                    let value = next(property.scalar)?;
                    if !mesh && element.name == "vertex" {
                        let column = columns.entry(property.name.clone());
                        column.or_default().push(value);
                    }
                    if let Some(axis) = ["x", "y", "z"].iter().position(|k| *k == property.name) {
                        vertex[axis] = value;
                    }
                    continue;
                };
                let entries = next(list)?;
                let entries = whole(entries)
                    .ok_or_else(|| unreadable(format!("a list of {entries} entries")))?;
                let is_face = mesh && element.name == "face" && names_corners(property);
                let mut corners = [0; 2];
                for k in 0..entries {
                    let value = next(property.scalar)?;
                    if !is_face {
                        continue;
                    }
                    let corner = whole(value).filter(|&corner| corner < known);
                    let corner = corner
                        .ok_or_else(|| format!("face {index} names vertex {value} of {known}"))?;
                    // A polygon is a fan of triangles.
                    if k >= 2 {
                        raw.triangles.push([corners[0], corners[1], corner]);
                    }
                    corners[k.min(1)] = corner;
                }
            }
            if mesh && element.name == "vertex" {
                raw.vertices.push(vertex);
            }
        }
    }
    Ok((raw, columns))
}

fn names_corners(property: &Property) -> bool {
    ["vertex_indices", "vertex_index"].contains(&&property.name[..])
}

/// A count or an index.
fn whole(value: f64) -> Option<usize> {
    (value >= 0.0 && value.fract() == 0.0).then_some(value as usize)
}

/// Type, name and count of the elements, up to the line `end_header`.
fn header(reader: &mut impl BufRead) -> Result<(Format, Vec<Element>)> {
    let mut format = None;
    let mut elements: Vec<Element> = Vec::new();
    if line(reader)? != "ply" {
        return Err("it does not begin with \"ply\"".into());
    }
    loop {
        let text = line(reader)?;
        let wrong = || format!("header line {text:?}");
        let scalar = |name: &str| scalar(name).ok_or_else(wrong);
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        let property = match words[..] {
            [] | ["comment" | "obj_info", ..] => continue,
            ["end_header"] => break,
            ["format", name, "1.0"] => {
                format = Some(match name {
                    "ascii" => Format::Text,
                    "binary_little_endian" => Format::LittleEndian,
                    "binary_big_endian" => Format::BigEndian,
                    _ => return Err(wrong()),
                });
                continue;
            }
            ["element", name, count] => {
                elements.push(Element {
                    name: name.into(),
                    count: count.parse().map_err(|_| wrong())?,
                    properties: Vec::new(),
                });
                continue;
            }
            ["property", "list", count, of, name] => Property {
                name: name.into(),
                list: Some(scalar(count)?),
                scalar: scalar(of)?,
            },
            ["property", of, name] => Property {
                name: name.into(),
                list: None,
                scalar: scalar(of)?,
            },
            _ => return Err(wrong()),
        };
        let element = elements.last_mut().ok_or_else(wrong)?;
        element.properties.push(property);
    }
    let format = format.ok_or("the header has no line \"format\"")?;
    Ok((format, elements))
}

fn line(reader: &mut impl BufRead) -> Result<String> {
    let mut bytes = Vec::new();
    let taken = reader.take(MAX_LINE).read_until(b'\n', &mut bytes);
    taken.map_err(|error| error.to_string())?;
    if bytes.pop() != Some(b'\n') {
        let message = format!("the header ends early, or a line has more than {MAX_LINE} bytes");
        return Err(message);
    }
    Ok(String::from_utf8_lossy(&bytes).trim_end().into())
}

fn scalar(name: &str) -> Option<Scalar> {
    Some(match name {
        "char" | "int8" => Scalar::I8,
        "uchar" | "uint8" => Scalar::U8,
        "short" | "int16" => Scalar::I16,
        "ushort" | "uint16" => Scalar::U16,
        "int" | "int32" => Scalar::I32,
        "uint" | "uint32" => Scalar::U32,
        "float" | "float32" => Scalar::F32,
        "double" | "float64" => Scalar::F64,
        _ => return None,
    })
}

/// Checks that the header claims no more than the file can hold.
///
/// The reader loops over these counts. Each property of each entry takes at least a byte.
fn check_counts(elements: &[Element], length: u64) -> Result<()> {
    for Element {
        name,
        count,
        properties,
    } in elements
    {
        let least = properties.len().max(1);
        if (*count as u64).saturating_mul(least as u64) > length {
            return Err(format!(
                "the PLY header claims {count} entries of {name:?}, more than the file's {length} bytes can hold"
            ));
        }
    }
    Ok(())
}

/// Checks that corners and faces have the properties of a mesh.
fn check_properties(element: &Element) -> Result<()> {
    let mut properties = element.properties.iter();
    match &element.name[..] {
        "vertex" => {
            for key in ["x", "y", "z"] {
                let is_float = |p: &Property| matches!(p.scalar, Scalar::F32 | Scalar::F64);
                let found = |p: &Property| p.name == key && p.list.is_none() && is_float(p);
                if !element.properties.iter().any(found) {
                    return Err(format!("a vertex needs {key} as float or double"));
                }
            }
            Ok(())
        }
        "face" if !properties.any(|p| p.list.is_some() && names_corners(p)) => {
            Err("a face needs a list vertex_indices".into())
        }
        _ => Ok(()),
    }
}

/// The contents after the header, number by number.
struct Values<R> {
    reader: R,
    format: Format,
}

impl<R: BufRead> Values<R> {
    /// The next number; every type is exact.
    fn next(&mut self, scalar: Scalar) -> Result<f64> {
        if self.format == Format::Text {
            return self.number(scalar);
        }
        Ok(match scalar {
            Scalar::I8 => i8::from_le_bytes(self.bytes()?).into(),
            Scalar::U8 => u8::from_le_bytes(self.bytes()?).into(),
            Scalar::I16 => i16::from_le_bytes(self.bytes()?).into(),
            Scalar::U16 => u16::from_le_bytes(self.bytes()?).into(),
            Scalar::I32 => i32::from_le_bytes(self.bytes()?).into(),
            Scalar::U32 => u32::from_le_bytes(self.bytes()?).into(),
            Scalar::F32 => f32::from_le_bytes(self.bytes()?).into(),
            Scalar::F64 => f64::from_le_bytes(self.bytes()?),
        })
    }

    /// The next bytes, the least significant first.
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N]> {
        let mut bytes = [0; N];
        let read = self.reader.read_exact(&mut bytes);
        read.map_err(|error| error.to_string())?;
        if self.format == Format::BigEndian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn number(&mut self, scalar: Scalar) -> Result<f64> {
        let mut word = String::new();
        for byte in self.reader.by_ref().bytes() {
            let byte = byte.map_err(|error| error.to_string())?;
            match byte.is_ascii_whitespace() {
                true if word.is_empty() => {}
                true => break,
                false => word.push(byte.into()),
            }
            if word.len() > MAX_NUMBER {
                return Err(format!("a number of more than {MAX_NUMBER} bytes"));
            }
        }
        let value = match scalar {
            Scalar::F32 => word.parse::<f32>().map(f64::from),
            _ => word.parse(),
        };
        let value = value.ok().filter(|value: &f64| value.is_finite());
        value.ok_or_else(|| format!("expected a number, found {word:?}"))
    }
}
