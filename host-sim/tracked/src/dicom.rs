//! DICOM ultrasound: pictures of one or several frames, with the size of their pixels.
//!
//! Pixels are uncompressed, JPEG with 8 bits, or RLE; grey, a palette, RGB or YBR. The size of a pixel and the part of the
//! picture are those of the largest two-dimensional region of SequenceOfUltrasoundRegions (DICOM PS3.3, C.8.5.5), in cm.

use std::io::Cursor;
use std::path::Path;

use bonebeam_files::image::{decode_jpeg, luma};
use bonebeam_files::memory::{self, product};
use bonebeam_files::{cannot_be_opened, input};
use dicom_object::mem::InMemElement;
use dicom_object::{DefaultDicomObject, InMemDicomObject, OpenFileOptions};
use ndarray::Array2;

use crate::header::MOST_FRAMES;

/// Place and value of the format's mark.
pub const MAGIC: (usize, &[u8]) = (128, b"DICM");
/// Longest side of a picture, pixels.
const LONGEST_SIDE: usize = 16_384;

type Read<T> = std::result::Result<T, String>;

/// The pictures of a file.
pub struct Pictures {
    /// Uncompressed pixels of all frames.
    data: Vec<u8>,
    /// Compressed pixels; a frame may be in several.
    fragments: Vec<Vec<u8>>,
    packing: Packing,
    colours: Colours,
    /// Columns, rows.
    pub sides: [usize; 2],
    pub frames: usize,
    /// Bytes of a number.
    size: usize,
    /// Level of a number of grey: its factor, and that of 0.
    grey: [f32; 2],
    /// Whether colours follow one another as planes.
    planes: bool,
    /// Grey levels of the palette, and its first index.
    palette: (Vec<f32>, usize),
}

#[derive(Clone, Copy, PartialEq)]
enum Packing {
    Raw,
    Jpeg,
    Rle,
}

#[derive(Clone, Copy, PartialEq)]
enum Colours {
    Grey,
    Palette,
    Rgb,
    Ybr,
    /// Two brightnesses and the two colours that they share.
    Ybr422,
}

/// What a file holds.
pub struct File {
    pub pictures: Pictures,
    /// The part that shows tissue: column, row, width, height.
    pub part: Option<[usize; 4]>,
    /// Sides of a pixel, mm.
    pub pixel: Option<[f64; 2]>,
    /// Time from frame to frame, s.
    pub interval: Option<f64>,
}

/// Reads a file.
///
/// # Errors
/// The problem, without the file's name.
pub fn read(path: &Path) -> Read<File> {
    let object = opened(path)?;
    let region = region(&object)?;
    let spacing = numbers(&object, "PixelSpacing");
    let pixel = match (&region, &spacing[..]) {
        (Some(region), _) => Some(region.pixel),
        (None, [rows, columns]) => Some([*columns, *rows]),
        _ => None,
    };
    let interval = numbers(&object, "FrameTime").first().map(|ms| 1e-3 * ms);
    let pictures = Pictures::of(&object)?;
    let [columns, rows] = pictures.sides;
    let within = |[x, y, width, height]: [usize; 4]| x + width <= columns && y + height <= rows;
    let part = region.map(|region| region.part);
    if part.is_some_and(|part| !within(part)) {
        return Err(format!("has a region beyond its {columns} x {rows} pixels"));
    }
    Ok(File {
        pictures,
        part,
        pixel,
        interval,
    })
}

impl Pictures {
    pub fn is_grey(&self) -> bool {
        self.colours == Colours::Grey
    }

    /// Whether levels have more than 8 bits, which a picture may leave unused.
    pub fn is_wide(&self) -> bool {
        self.size > 1
    }

    fn of(object: &DefaultDicomObject) -> Read<Self> {
        let count = |name: &str| whole(object, name);
        let need = |name: &str| count(name).ok_or_else(|| format!("has no {name}"));
        let syntax = object.meta().transfer_syntax().trim_end_matches('\0');
        let pixels = element(object, "PixelData").ok_or("has no PixelData")?;
        let fragments = pixels.fragments();
        let packing = match syntax {
            "1.2.840.10008.1.2.4.50" | "1.2.840.10008.1.2.4.51" => Packing::Jpeg,
            "1.2.840.10008.1.2.5" => Packing::Rle,
            _ if fragments.is_none() => Packing::Raw,
            other => {
                return Err(format!(
                    "has pixels of the transfer syntax {other}; expected uncompressed, JPEG baseline or RLE: dcmdjpeg, \
                     dcmdjpls or gdcmconv --raw unpacks it"
                ));
            }
        };
        let colours = element(object, "PhotometricInterpretation");
        let colours = colours.and_then(|colours| colours.to_str().ok());
        let samples = need("SamplesPerPixel")?;
        let colours = match (colours.as_deref().map(str::trim), samples) {
            (Some("MONOCHROME1" | "MONOCHROME2"), 1) => Colours::Grey,
            (Some("PALETTE COLOR"), 1) => Colours::Palette,
            (Some("RGB"), 3) => Colours::Rgb,
            (Some("YBR_FULL_422"), 3) if packing == Packing::Raw => Colours::Ybr422,
            (Some("YBR_FULL" | "YBR_FULL_422"), 3) => Colours::Ybr,
            (other, _) => {
                return Err(format!(
                    "has PhotometricInterpretation {} of {samples} samples; expected MONOCHROME1 or 2, PALETTE COLOR, RGB, \
                     YBR_FULL or YBR_FULL_422",
                    other.unwrap_or("none")
                ));
            }
        };
        let [columns, rows] = [need("Columns")?, need("Rows")?];
        let frames = count("NumberOfFrames").unwrap_or(1);
        let sides = 1..=LONGEST_SIDE;
        if !sides.contains(&columns)
            || !sides.contains(&rows)
            || frames == 0
            || frames > MOST_FRAMES
        {
            return Err(format!("has {frames} frames of {columns} x {rows} pixels"));
        }
        let (allocated, stored) = (need("BitsAllocated")?, need("BitsStored")?);
        let plain = matches!(colours, Colours::Grey | Colours::Palette);
        let valid = allocated == 8 || (allocated == 16 && plain && packing == Packing::Raw);
        if !valid || stored == 0 || stored > allocated || count("PixelRepresentation") == Some(1) {
            return Err(format!(
                "has {stored} of {allocated} bits; expected unsigned numbers of 8 bits, or of 16 for uncompressed grey"
            ));
        }
        let palette = match colours {
            Colours::Palette => palette(object)?,
            _ => (Vec::new(), 0),
        };
        let pictures = Pictures {
            data: match fragments {
                Some(_) => Vec::new(),
                None => pixels.to_bytes().map_err(|e| e.to_string())?.into_owned(),
            },
            fragments: fragments.unwrap_or_default().to_vec(),
            packing,
            colours,
            sides: [columns, rows],
            frames,
            size: allocated / 8,
            grey: grey(object, ((1u32 << stored) - 1) as f32),
            planes: count("PlanarConfiguration") == Some(1) && samples == 3,
            palette,
        };
        let (held, bytes) = (pictures.data.len(), product(&[pictures.length(), frames]));
        if packing == Packing::Raw && held < bytes {
            return Err(format!(
                "holds {held} bytes of pixels; its header says {bytes}"
            ));
        }
        Ok(pictures)
    }

    /// Bytes of an uncompressed frame.
    fn length(&self) -> usize {
        let samples = match self.colours {
            Colours::Grey | Colours::Palette => 1,
            Colours::Ybr422 => 2,
            Colours::Rgb | Colours::Ybr => 3,
        };
        samples * self.size * self.sides[0] * self.sides[1]
    }

    /// Grey levels of a frame, `[row, column]`.
    pub fn picture(&self, frame: usize) -> Read<Array2<f32>> {
        let [columns, rows] = self.sides;
        memory::check(product(&[8, columns, rows]), "a DICOM picture")
            .map_err(|e| e.to_string())?;
        let none = || format!("has no pixels of frame {frame}");
        let length = self.length();
        let unpacked;
        let (bytes, planes) = match self.packing {
            Packing::Raw => {
                let data = self
                    .data
                    .get(frame * length..)
                    .and_then(|data| data.get(..length));
                (data.ok_or_else(none)?, self.planes)
            }
            Packing::Jpeg => {
                let levels = decode_jpeg(&self.encapsulated(frame).ok_or_else(none)?)?;
                if levels.dim() != (rows, columns) {
                    let (own_rows, own_columns) = levels.dim();
                    return Err(format!(
                        "has a JPEG of {own_columns} x {own_rows} pixels; its header says {columns} x {rows}"
                    ));
                }
                match self.colours {
                    Colours::Grey | Colours::Palette => {
                        unpacked = levels
                            .into_iter()
                            .map(|level| level as u8)
                            .collect::<Vec<_>>();
                        (&unpacked[..], false)
                    }
                    _ => return Ok(levels),
                }
            }
            Packing::Rle => {
                unpacked = unpacked_rle(&self.encapsulated(frame).ok_or_else(none)?, length)?;
                (&unpacked[..], true)
            }
        };
        let area = columns * rows;
        let number = |at: usize| match self.size {
            1 => f32::from(bytes[at]),
            _ => f32::from(u16::from_ne_bytes([bytes[2 * at], bytes[2 * at + 1]])),
        };
        let of_three = |at: usize, k: usize| bytes[if planes { k * area + at } else { 3 * at + k }];
        let level = |at: usize| match self.colours {
            Colours::Grey => (self.grey[0] * number(at) + self.grey[1]).clamp(0.0, 255.0),
            Colours::Palette => {
                let (levels, first) = &self.palette;
                let index = (number(at) as usize).saturating_sub(*first);
                levels[index.min(levels.len() - 1)]
            }
            Colours::Rgb => luma([0, 1, 2].map(|k| u32::from(of_three(at, k))), 255.0),
            Colours::Ybr => f32::from(of_three(at, 0)),
            Colours::Ybr422 => f32::from(bytes[4 * (at / 2) + at % 2]),
        };
        Ok(Array2::from_shape_fn((rows, columns), |(row, column)| {
            level(row * columns + column)
        }))
    }

    /// The compressed bytes of a frame, which may be in several fragments.
    fn encapsulated(&self, frame: usize) -> Option<Vec<u8>> {
        let fragments = &self.fragments;
        if fragments.len() == self.frames {
            return fragments.get(frame).cloned();
        }
        let begins = |fragment: &Vec<u8>| fragment.starts_with(&[0xff, 0xd8]);
        let starts = fragments
            .iter()
            .enumerate()
            .filter(|(_, fragment)| begins(fragment));
        let start = starts.map(|(k, _)| k).nth(frame)?;
        let rest = fragments
            .get(start + 1..)?
            .iter()
            .take_while(|fragment| !begins(fragment));
        Some(
            fragments[start..=start]
                .iter()
                .chain(rest)
                .flatten()
                .copied()
                .collect(),
        )
    }
}

pub(crate) fn element<'o>(object: &'o InMemDicomObject, name: &str) -> Option<&'o InMemElement> {
    object.element_by_name(name).ok()
}

pub(crate) fn whole(object: &InMemDicomObject, name: &str) -> Option<usize> {
    element(object, name)?.to_int().ok()
}

fn numbers(object: &InMemDicomObject, name: &str) -> Vec<f64> {
    let numbers = element(object, name).and_then(|element| element.to_multi_float64().ok());
    let mut numbers = numbers.unwrap_or_default();
    numbers.retain(|number| number.is_finite() && *number > 0.0);
    numbers
}

/// Factor of a number of grey, and level of 0: modality, window and presentation (PS3.3, C.11 and C.7.6.3.1.2).
fn grey(object: &InMemDicomObject, white: f32) -> [f32; 2] {
    let first = |name: &str| {
        let values = element(object, name)?.to_multi_float32().ok()?;
        values.first().copied().filter(|value| value.is_finite())
    };
    let text = |name: &str| {
        let value = element(object, name)?.to_str().ok()?;
        Some(value.trim().to_owned())
    };
    let slope = first("RescaleSlope").unwrap_or(1.0);
    let shift = first("RescaleIntercept").unwrap_or(0.0);
    // The window's darkest and brightest value.
    let window = first("WindowCenter").zip(first("WindowWidth"));
    let [dark, bright] = match window.filter(|(_, width)| *width > 1.0) {
        Some((centre, width)) => [-0.5, 0.5].map(|side| centre - 0.5 + side * (width - 1.0)),
        None => [0.0, white],
    };
    let factor = 255.0 / (bright - dark);
    let (factor, zero) = (factor * slope, factor * (shift - dark));
    let shape = text("PresentationLUTShape");
    let inverted = text("PhotometricInterpretation").as_deref() == Some("MONOCHROME1");
    match inverted || shape.as_deref() == Some("INVERSE") {
        true => [-factor, 255.0 - zero],
        false => [factor, zero],
    }
}

/// The elements of a file.
pub(crate) fn opened(path: &Path) -> Read<DefaultDicomObject> {
    let bytes = input::read(path, u64::MAX).map_err(|e| cannot_be_opened(&e))?;
    let object = OpenFileOptions::new().from_reader(Cursor::new(with_group_length(bytes)));
    object.map_err(|e| format!("is damaged or no DICOM file ({e})"))
}

/// The file with the length of its first group, which pydicom leaves out by default.
fn with_group_length(mut bytes: Vec<u8>) -> Vec<u8> {
    let start = MAGIC.0 + MAGIC.1.len();
    let mut end = start;
    while let Some(&[2, 0, low, high, a, b, ..]) = bytes.get(end..) {
        if end == start && (low, high) == (0, 0) {
            return bytes;
        }
        let long = matches!(&[a, b], b"OB" | b"OW" | b"UN" | b"UT" | b"SQ");
        let length = match (bytes.get(end + 6..end + 8), bytes.get(end + 8..end + 12)) {
            (_, Some(&[a, b, c, d])) if long => 12 + u32::from_le_bytes([a, b, c, d]) as usize,
            (Some(&[a, b]), _) if !long => 8 + usize::from(u16::from_le_bytes([a, b])),
            _ => return bytes,
        };
        end = end.saturating_add(length);
    }
    if (start + 1..=bytes.len()).contains(&end) {
        let length = ((end - start) as u32).to_le_bytes();
        let element = [2, 0, 0, 0, b'U', b'L', 4, 0].into_iter().chain(length);
        bytes.splice(start..start, element);
    }
    bytes
}

/// Grey levels of the palette, and the index of the first.
fn palette(object: &InMemDicomObject) -> Read<(Vec<f32>, usize)> {
    let colour = |name: &str| {
        let find = |what| element(object, &format!("{name}PaletteColorLookupTable{what}"));
        let [count, first, bits] = find("Descriptor")?.to_multi_int().ok()?[..] else {
            return None;
        };
        let count = if count == 0 { 1 << 16 } else { count as usize };
        let data = find("Data")?.to_bytes().ok()?;
        let values: Vec<u32> = match bits {
            8 => data.iter().copied().map(u32::from).collect(),
            _ => data
                .chunks_exact(2)
                .map(|pair| u32::from(pair[1]))
                .collect(),
        };
        (values.len() >= count).then_some((values, count, first as usize))
    };
    let all = ["Red", "Green", "Blue"].map(colour);
    let [
        Some((red, count, first)),
        Some((green, ..)),
        Some((blue, ..)),
    ] = all
    else {
        return Err("has PALETTE COLOR without the tables of its colours".into());
    };
    let count = count.min(green.len()).min(blue.len());
    let levels = (0..count).map(|k| luma([red[k], green[k], blue[k]], 255.0));
    Ok((levels.collect(), first))
}

struct Region {
    /// Column, row, width, height.
    part: [usize; 4],
    /// Sides of a pixel, mm.
    pixel: [f64; 2],
}

/// The largest two-dimensional region of tissue with sizes in cm.
fn region(object: &InMemDicomObject) -> Read<Option<Region>> {
    let regions = element(object, "SequenceOfUltrasoundRegions");
    let regions = regions.and_then(InMemElement::items).unwrap_or_default();
    let (is_flat, cm) = (
        |region: &&InMemDicomObject| whole(region, "RegionSpatialFormat") == Some(1),
        Some(3),
    );
    let mut best: Option<Region> = None;
    for region in regions.iter().filter(is_flat) {
        let units = ["PhysicalUnitsXDirection", "PhysicalUnitsYDirection"];
        if units.map(|name| whole(region, name)) != [cm, cm] {
            continue;
        }
        let names = ["MinX0", "MinY0", "MaxX1", "MaxY1"];
        let ends = names.map(|name| whole(region, &format!("RegionLocation{name}")));
        let pixel = ["PhysicalDeltaX", "PhysicalDeltaY"]
            .map(|name| element(region, name)?.to_float64().ok());
        let ([Some(x), Some(y), Some(right), Some(bottom)], [Some(dx), Some(dy)]) = (ends, pixel)
        else {
            return Err("has an ultrasound region without its place or its sizes".into());
        };
        let pixel = [dx, dy].map(|cm| 10.0 * cm.abs());
        let valid = pixel.iter().all(|side| (1e-3..=10.0).contains(side));
        if !valid || right <= x || bottom <= y {
            return Err(format!(
                "has an ultrasound region from {x},{y} to {right},{bottom} with pixels of {dx} x {dy} cm"
            ));
        }
        let part = [x, y, right - x + 1, bottom - y + 1];
        let area = |part: [usize; 4]| part[2].saturating_mul(part[3]);
        if best
            .as_ref()
            .is_none_or(|best| area(best.part) < area(part))
        {
            best = Some(Region { part, pixel });
        }
    }
    Ok(best)
}

/// The bytes of a frame in RLE, one plane for each sample of a pixel (DICOM PS3.5, annex G).
fn unpacked_rle(bytes: &[u8], length: usize) -> Read<Vec<u8>> {
    let wrong = || "has damaged RLE pixels".to_owned();
    let word = |k: usize| {
        let word = bytes.get(4 * k..)?.first_chunk()?;
        Some(u32::from_le_bytes(*word) as usize)
    };
    let count = word(0)
        .filter(|count| (1..=3).contains(count))
        .ok_or_else(wrong)?;
    let mut out = Vec::with_capacity(length);
    for segment in 1..=count {
        let end = match segment == count {
            true => Some(bytes.len()),
            false => word(segment + 1),
        };
        let (Some(start), Some(end)) = (word(segment), end) else {
            return Err(wrong());
        };
        let mut rest = bytes.get(start..end).ok_or_else(wrong)?;
        let plane = segment * (length / count);
        while let [head, tail @ ..] = rest {
            if out.len() >= plane {
                break;
            }
            let used = match *head as i8 {
                head @ 0.. => {
                    let run = tail.get(..head as usize + 1).ok_or_else(wrong)?;
                    out.extend(run);
                    run.len()
                }
                -128 => 0,
                head => {
                    let byte = *tail.first().ok_or_else(wrong)?;
                    out.resize(out.len() + 1 + usize::from(head.unsigned_abs()), byte);
                    1
                }
            };
            rest = &tail[used..];
        }
        if out.len() != plane {
            return Err(wrong());
        }
    }
    Ok(out)
}
