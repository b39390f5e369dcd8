//! NRRD: `.nrrd`, and `.nhdr` with its pixels beside it.

use std::io::{BufRead, Seek};
use std::path::Path;

use super::header::Header;
use super::pixels::{Axis, Element, Packing, Pixels};

/// First letters of the format.
pub const MAGIC: &[u8] = b"NRRD";

/// Reads the header; PLUS also writes free fields as `name: value`.
///
/// # Errors
/// The problem, without the file's name.
pub fn read(path: &Path, reader: &mut (impl BufRead + Seek)) -> Result<(Header, Pixels), String> {
    let mut header = Header::default();
    header.line(reader)?;
    while let Some(line) = header.line(reader)?.filter(|line| !line.is_empty()) {
        if line.starts_with('#') {
            continue;
        }
        let (name, value) = line
            .split_once(':')
            .ok_or_else(|| format!("has the line {line}"))?;
        header.take(name, value.strip_prefix('=').unwrap_or(value))?;
    }
    let element = match header.get("type").ok_or("has no type")? {
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Element::U8,
        "signed char" | "int8" | "int8_t" => Element::I8,
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Element::U16,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => {
            Element::I16
        }
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Element::U32,
        "int" | "signed int" | "int32" | "int32_t" => Element::I32,
        "float" => Element::F32,
        "double" => Element::F64,
        other => return Err(format!("has type: {other}; expected one of numbers")),
    };
    let packing = match header.get("encoding").ok_or("has no encoding")? {
        "raw" => Packing::Raw,
        "gz" | "gzip" => Packing::Gzip,
        other => return Err(format!("has encoding: {other}; expected raw or gzip")),
    };
    for skip in ["line skip", "byte skip", "lineskip", "byteskip"] {
        if header.get(skip).is_some_and(|count| count != "0") {
            return Err(format!("has a {skip}, which is not read"));
        }
    }
    let sides = header.sizes("sizes")?;
    let kinds = header.words("kinds");
    let is_volume = kinds.len() == 3 && kinds.iter().all(|kind| ["domain", "space"].contains(kind));
    let mut axes = Vec::new();
    for (k, side) in sides.iter().enumerate() {
        let axis = match kinds.get(k).copied() {
            Some("list" | "time") => Axis::Frame,
            Some("vector" | "RGB-color" | "RGBA-color" | "3-color" | "4-color") => Axis::Component,
            // The slices of a volume are its frames.
            Some("domain" | "space") if is_volume && k == 2 => Axis::Frame,
            Some("domain" | "space") => Axis::Picture,
            _ if k >= 2 && k + 1 == sides.len() => Axis::Frame,
            _ => Axis::Picture,
        };
        axes.push((axis, *side));
    }
    let big_endian = header.get("endian") == Some("big");
    let file = header.get("data file").or(header.get("datafile"));
    let pixels = Pixels::of(path, &header, packing, element, big_endian, &axes, file)?;
    Ok((header, pixels))
}
