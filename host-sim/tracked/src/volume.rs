//! Volumes of CT: MetaImage, NRRD, and folders of DICOM slices.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use bonebeam_files::memory::{self, product};
use bonebeam_files::{Result, cannot_be_opened, file_error};

use crate::cloud::{dot, sub};
use crate::dicom::{element, opened, whole};
use crate::poses::PoseTable;
use crate::sequence::Sequence;

/// Deviation of the distances of slices from an even one, mm.
const UNEVEN: f64 = 0.05;

/// Steps from voxel to voxel that a CT may have, mm.
const STEPS: std::ops::RangeInclusive<f64> = 1e-3..=100.0;

type V3 = [f64; 3];
type Read<T> = std::result::Result<T, String>;

/// The voxels of a volume, and their places.
pub struct Voxels {
    /// Voxels along each axis.
    pub sides: [usize; 3],
    /// Numbers, as of Hounsfield units, the first axis fastest.
    pub hu: Vec<i16>,
    /// Rows of the matrix from (i, j, k, 1) to mm in LPS.
    pub to_lps: [[f64; 4]; 3],
}

impl Voxels {
    /// Whether a path is a volume by its ending, or a folder.
    pub fn recognizes(path: &Path) -> bool {
        let end = path.extension().and_then(|end| end.to_str());
        let ends = ["mha", "mhd", "nrrd", "nhdr"];
        path.is_dir() || end.is_some_and(|end| ends.iter().any(|own| end.eq_ignore_ascii_case(own)))
    }

    /// Reads a `.mha`, `.mhd`, `.nrrd` or `.nhdr` file, or a folder of DICOM slices.
    ///
    /// # Errors
    /// A file that is no volume, is damaged or lacks a place, or slices that are not one even series.
    pub fn read(path: &Path) -> Result<Self> {
        let voxels = match path.is_dir() {
            true => of_folder(path),
            false => of_file(path),
        }?;
        let step = |k: usize| voxels.to_lps.map(|row| row[k]);
        let steps = [0, 1, 2].map(|k| dot(step(k), step(k)).sqrt());
        match steps.iter().all(|step| STEPS.contains(step)) {
            true => Ok(voxels),
            false => Err(file_error(
                path,
                format!("has voxels of {steps:?} mm; expected 0.001 to 100 mm"),
            )),
        }
    }
}

fn reserved(path: &Path, sides: [usize; 3]) -> Result<Vec<i16>> {
    let bytes = product(&[sides[0], sides[1], sides[2], 4]);
    memory::check(bytes, "the CT volume").map_err(|e| file_error(path, e.to_string()))?;
    match sides.iter().all(|&side| side > 1) {
        true => Ok(Vec::new()),
        false => Err(file_error(
            path,
            format!("has {sides:?} voxels; expected a volume of three axes"),
        )),
    }
}

fn of_file(path: &Path) -> Result<Voxels> {
    let sequence = Sequence::open(path, &PoseTable::default())?;
    if !sequence.transform_names().is_empty() {
        let message = "is a tracked sequence of pictures; expected a CT volume";
        return Err(file_error(path, message));
    }
    let [columns, rows] = sequence.sides;
    let sides = [columns, rows, sequence.frames.len()];
    let (axes, origin) = place(&sequence).map_err(|message| file_error(path, message))?;
    let mut hu = reserved(path, sides)?;
    let mut reader = sequence.reader()?;
    for frame in 0..sides[2] {
        let slice = sequence.picture(reader.frame(frame)?)?;
        // The cast saturates.
        hu.extend(slice.iter().map(|value| value.round() as i16));
    }
    let to_lps = placed(axes, origin);
    Ok(Voxels { sides, hu, to_lps })
}

/// Rows of the matrix of three steps and an origin.
fn placed([a, b, c]: [V3; 3], origin: V3) -> [[f64; 4]; 3] {
    std::array::from_fn(|row| [a[row], b[row], c[row], origin[row]])
}

/// The steps along the axes, and the first voxel's centre, mm in LPS.
fn place(sequence: &Sequence) -> Read<([V3; 3], V3)> {
    let field = |names: &[&str]| {
        let text = names.iter().find_map(|name| sequence.fields.get(*name));
        let split = |c: char| c.is_whitespace() || ['(', ')', ','].contains(&c);
        let words = text.map_or("", String::as_str).split(split);
        let numbers = words.filter_map(|word| word.parse::<f64>().ok());
        numbers
            .filter(|number| number.is_finite())
            .collect::<Vec<_>>()
    };
    let three = |numbers: &[f64]| numbers.try_into().ok();
    let nine = |numbers: &[f64]| -> Option<[V3; 3]> {
        let rows = numbers.chunks(3).map(three).collect::<Option<Vec<V3>>>()?;
        rows.try_into().ok()
    };
    let along = |spacing: V3| {
        std::array::from_fn(|k| std::array::from_fn(|row| if row == k { spacing[k] } else { 0.0 }))
    };
    if sequence.format == "MetaImage" {
        let spacing: V3 = three(&field(&["ElementSpacing", "ElementSize"]))
            .ok_or("has no ElementSpacing of three axes")?;
        let names = ["TransformMatrix", "Rotation", "Orientation"];
        // One axis of the volume after the other.
        let turned = nine(&field(&names))
            .map(|axes| std::array::from_fn(|k| axes[k].map(|part| spacing[k] * part)));
        let origin = three(&field(&["Offset", "Position", "Origin"])).unwrap_or([0.0; 3]);
        return Ok((turned.unwrap_or(along(spacing)), origin));
    }
    let spaced = || three(&field(&["spacings"])).map(along);
    let axes = nine(&field(&["space directions"])).or_else(spaced);
    let axes = axes.ok_or("has no space directions of three axes")?;
    let origin = three(&field(&["space origin"])).unwrap_or([0.0; 3]);
    let space = sequence
        .fields
        .get("space")
        .map_or("left-posterior-superior", String::as_str);
    let flip = match space.to_ascii_lowercase().as_str() {
        "left-posterior-superior" | "lps" => [1.0; 3],
        "right-anterior-superior" | "ras" => [-1.0, -1.0, 1.0],
        "left-anterior-superior" | "las" => [1.0, -1.0, 1.0],
        other => return Err(format!("has the space {other}; expected LPS, RAS or LAS")),
    };
    let turn = |v: V3| std::array::from_fn(|k| flip[k] * v[k]);
    Ok((axes.map(turn), turn(origin)))
}

/// A slice of a series.
struct Slice {
    series: String,
    sides: [usize; 2],
    hu: Vec<i16>,
    /// The steps along columns and rows, mm, and the first pixel's centre.
    steps: [V3; 2],
    origin: V3,
}

fn slice(path: &Path) -> Read<Slice> {
    let object = opened(path)?;
    let numbers = |name: &str| -> Vec<f64> {
        let numbers = element(&object, name).and_then(|element| element.to_multi_float64().ok());
        numbers.unwrap_or_default()
    };
    let need = |name: &str| whole(&object, name).ok_or_else(|| format!("has no {name}"));
    let sides = [need("Columns")?, need("Rows")?];
    let bits = need("BitsAllocated")?;
    let (size, signed) = (bits / 8, need("PixelRepresentation")? == 1);
    let stored = whole(&object, "BitsStored").unwrap_or(bits);
    let high = whole(&object, "HighBit").unwrap_or(stored.saturating_sub(1));
    let pixels = element(&object, "PixelData").ok_or("has no PixelData")?;
    if pixels.fragments().is_some() || ![1, 2].contains(&size) || need("SamplesPerPixel")? != 1 {
        return Err("has pixels that are compressed or no numbers of 8 or 16 bits; dcmdjpeg, dcmdjpls or gdcmconv --raw unpacks them".into());
    }
    if stored == 0 || high >= bits || high + 1 < stored {
        return Err(format!("has {stored} bits up to bit {high} of {bits}"));
    }
    let bytes = pixels.to_bytes().map_err(|e| e.to_string())?;
    if bytes.len() < product(&[sides[0], sides[1], size]) {
        return Err(format!(
            "holds {} bytes of pixels of {sides:?}",
            bytes.len()
        ));
    }
    let (slope, shift) = (numbers("RescaleSlope"), numbers("RescaleIntercept"));
    let (slope, shift) = (slope.first().unwrap_or(&1.0), shift.first().unwrap_or(&0.0));
    let value = |number: &[u8]| {
        let word = match number {
            &[a, b] => u16::from_ne_bytes([a, b]),
            number => number[0].into(),
        };
        // The sign is the highest stored bit; those above it are no part of the number.
        let top = u32::from(word) << (31 - high);
        let whole = match signed {
            true => f64::from(top as i32 >> (32 - stored)),
            false => f64::from(top >> (32 - stored)),
        };
        // The cast saturates.
        (slope * whole + shift).round() as i16
    };
    let hu = bytes
        .chunks_exact(size)
        .take(sides[0] * sides[1])
        .map(value)
        .collect();
    let (origin, turn, spacing) = (
        numbers("ImagePositionPatient"),
        numbers("ImageOrientationPatient"),
        numbers("PixelSpacing"),
    );
    let (&[x, y, z], &[a, b, c, d, e, f], &[rows, columns]) =
        (&origin[..], &turn[..], &spacing[..])
    else {
        return Err("has no ImagePositionPatient, ImageOrientationPatient or PixelSpacing".into());
    };
    let uid = element(&object, "SeriesInstanceUID").and_then(|uid| uid.to_str().ok());
    Ok(Slice {
        series: uid.unwrap_or_default().into_owned(),
        sides,
        hu,
        steps: [
            [a, b, c].map(|part| columns * part),
            [d, e, f].map(|part| rows * part),
        ],
        origin: [x, y, z],
    })
}

fn of_folder(path: &Path) -> Result<Voxels> {
    let wrong = |message: String| file_error(path, message);
    let entries = fs::read_dir(path).map_err(|e| wrong(cannot_be_opened(&e)))?;
    let mut series: BTreeMap<String, Vec<Slice>> = BTreeMap::new();
    for entry in entries {
        let file = entry.map_err(|e| wrong(cannot_be_opened(&e)))?.path();
        if crate::open::is_dicom(&file) {
            let slice = slice(&file).map_err(|message| file_error(&file, message))?;
            series.entry(slice.series.clone()).or_default().push(slice);
        }
    }
    let many = series.len();
    let Some(mut slices) = series
        .into_values()
        .next()
        .filter(|slices| many == 1 && slices.len() > 1)
    else {
        return Err(wrong(format!(
            "has {many} series of DICOM slices; expected one, of two slices or more"
        )));
    };
    let ([across, down], sides) = (slices[0].steps, slices[0].sides);
    let normal: V3 = std::array::from_fn(|k| {
        let (next, last) = ((k + 1) % 3, (k + 2) % 3);
        across[next] * down[last] - across[last] * down[next]
    });
    let length = dot(normal, normal).sqrt();
    let depth = |slice: &Slice| dot(slice.origin, normal) / length;
    slices.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
    let (first, last) = (&slices[0], &slices[slices.len() - 1]);
    let count = slices.len();
    let step = sub(last.origin, first.origin).map(|part| part / (count - 1) as f64);
    let is_even = slices.iter().enumerate().all(|(k, slice)| {
        let off: V3 =
            std::array::from_fn(|row| first.origin[row] + k as f64 * step[row] - slice.origin[row]);
        let alike = slice
            .steps
            .iter()
            .flatten()
            .zip(first.steps.iter().flatten());
        slice.sides == sides
            && dot(off, off).sqrt() < UNEVEN
            && alike.clone().all(|(a, b)| (a - b).abs() < 1e-4)
    });
    if !is_even || dot(step, step) == 0.0 {
        return Err(wrong(format!(
            "has {count} slices of several sizes or directions, or at uneven distances; expected one series without gaps"
        )));
    }
    let to_lps = placed([across, down, step], first.origin);
    let mut hu = reserved(path, [sides[0], sides[1], count])?;
    slices.iter().for_each(|slice| hu.extend(&slice.hu));
    Ok(Voxels {
        sides: [sides[0], sides[1], count],
        hu,
        to_lps,
    })
}
