//! MetaImage: `.mha`, and `.mhd` with its pixels beside it.

use std::io::{BufRead, Seek};
use std::path::Path;

use super::header::Header;
use super::pixels::{Axis, Element, Packing, Pixels};

/// First words of the format.
pub const MAGIC: [&[u8]; 2] = [b"ObjectType", b"NDims"];

/// Reads the header.
///
/// # Errors
/// The problem, without the file's name.
pub fn read(path: &Path, reader: &mut (impl BufRead + Seek)) -> Result<(Header, Pixels), String> {
    let mut header = Header::default();
    let file = loop {
        let line = header.line(reader)?.ok_or("has no ElementDataFile")?;
        if line.is_empty() {
            continue;
        }
        let (name, value) = line
            .split_once('=')
            .ok_or_else(|| format!("has the line {line}"))?;
        if name.trim() == "ElementDataFile" {
            break value.trim().to_owned();
        }
        header.take(name, value)?;
    };
    let says = |name: &str| {
        header
            .get(name)
            .is_some_and(|value| value.eq_ignore_ascii_case("true"))
    };
    let element = match header.get("ElementType").ok_or("has no ElementType")? {
        "MET_UCHAR" => Element::U8,
        "MET_CHAR" => Element::I8,
        "MET_USHORT" => Element::U16,
        "MET_SHORT" => Element::I16,
        "MET_UINT" => Element::U32,
        "MET_INT" => Element::I32,
        "MET_FLOAT" => Element::F32,
        "MET_DOUBLE" => Element::F64,
        other => {
            return Err(format!(
                "has ElementType = {other}; expected one of numbers"
            ));
        }
    };
    let sides = header.sizes("DimSize")?;
    // The format counts the axes of frames among the others; PLUS names them in `Kinds`.
    let kinds = header.words("Kinds");
    let mut axes: Vec<(Axis, usize)> = (sides.iter().enumerate())
        .map(|(k, side)| {
            let frames = match kinds.get(k) {
                Some(kind) => ["list", "time"].contains(kind),
                None => k >= 2 && k + 1 == sides.len(),
            };
            (if frames { Axis::Frame } else { Axis::Picture }, *side)
        })
        .collect();
    if let Some(components) = header.get("ElementNumberOfChannels") {
        let count = components.parse().ok();
        let count = count.ok_or_else(|| format!("has ElementNumberOfChannels = {components}"))?;
        axes.insert(0, (Axis::Component, count));
    }
    let packing = match says("CompressedData") {
        true => Packing::Zlib,
        false => Packing::Raw,
    };
    let big_endian = says("BinaryDataByteOrderMSB") || says("ElementByteOrderMSB");
    let file = (file != "LOCAL").then_some(&file[..]);
    let pixels = Pixels {
        length: (header.get("CompressedDataSize")).and_then(|size| size.parse().ok()),
        ..Pixels::of(path, &header, packing, element, big_endian, &axes, file)?
    };
    Ok((header, pixels))
}
