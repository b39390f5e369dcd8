//! Images: grey levels 0 to 255 as `.npy` (float32 [row, column]) and as 8-bit PNG.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use image::{GrayImage, ImageError, ImageFormat, ImageReader, Limits};
use ndarray::{Array2, ArrayD, Ix2};
use ndarray_npy::WriteNpyExt;

use super::atomic::Outputs;
use super::npy::{self, NpyError, or_type};
use super::{cannot_be_opened, file_error, validate};
use crate::{Error, Result};

/// The longest side of a PNG, pixels, as of the images that are made.
const MAX_SIDE: u32 = 16_384;

/// Reads an image, [row, column], row 0 at the top. A PNG becomes grey levels 0 to 255 (colours by
/// their Rec. 709 luma, transparency ignored); an `.npy` array (float32, float64 or uint8) is taken
/// as it is.
///
/// # Errors
/// The name ends in neither `.png` nor `.npy`, or the file is damaged, has another shape or type,
/// is empty, or holds a NaN or infinite pixel.
pub fn read(path: &Path) -> Result<Array2<f32>> {
    let format = Format::of(path)?;
    let bytes = fs::read(path).map_err(|e| file_error(path, cannot_be_opened(&e)))?;
    let pixels = match format {
        Format::Png => decode_png(&bytes),
        Format::Npy => decode_npy(&bytes),
    };
    let pixels = pixels.map_err(|message| file_error(path, message))?;
    validate::samples("image", &pixels, &["row", "column"])
        .map_err(|message| file_error(path, message))?;
    Ok(pixels)
}

/// Stages an image as `.npy` or `.png`, as the name ends. A PNG holds the nearest of 0 to 255.
///
/// # Errors
/// The name ends in neither, or the file cannot be written.
pub fn stage(pixels: &Array2<f32>, path: &Path, outputs: &mut Outputs) -> Result<()> {
    match Format::of(path)? {
        Format::Png => outputs.stage(path, |sink| {
            Ok(encode_png(pixels).write_to(sink, ImageFormat::Png)?)
        }),
        Format::Npy => outputs.stage(path, |sink| Ok(pixels.write_npy(sink)?)),
    }
}

/// The bytes of a PNG of the nearest of 0 to 255.
///
/// # Errors
/// An image that PNG cannot hold.
pub fn png(pixels: &Array2<f32>) -> Result<Vec<u8>> {
    let mut bytes = Cursor::new(Vec::new());
    encode_png(pixels)
        .write_to(&mut bytes, ImageFormat::Png)
        .map_err(|e| Error::Data(format!("the image cannot be encoded: {e}")))?;
    Ok(bytes.into_inner())
}

/// Writes an image as [`stage`] does, whole or not at all.
///
/// # Errors
/// As [`stage`].
pub fn write(pixels: &Array2<f32>, path: &Path) -> Result<()> {
    let mut outputs = Outputs::new();
    stage(pixels, path, &mut outputs)?;
    outputs.commit()
}

/// The file formats of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Format {
    /// 8-bit grey levels, for people.
    Png,
    /// float32 [row, column].
    Npy,
}

impl Format {
    /// The format that a file's name asks for.
    ///
    /// # Errors
    /// The name ends in neither `.png` nor `.npy`.
    pub fn of(path: &Path) -> Result<Self> {
        let extension = path
            .extension()
            .and_then(|e| e.to_str())
            .map(str::to_ascii_lowercase);
        match extension.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("npy") => Ok(Self::Npy),
            _ => Err(Error::Usage(format!(
                "{}: an image's name must end in .png or .npy (of beamform also in .svg)",
                path.display()
            ))),
        }
    }
}

fn decode_png(bytes: &[u8]) -> std::result::Result<Array2<f32>, String> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    reader.limits(limits);
    let grey = reader
        .decode()
        .map_err(|e| match e {
            ImageError::Limits(_) => {
                format!("is too large an image; expected at most {MAX_SIDE} × {MAX_SIDE} pixels and 512 MiB")
            }
            e => format!("is truncated or not a PNG image ({e})"),
        })?
        .into_luma8();
    let shape = (grey.height() as usize, grey.width() as usize);
    let levels = grey.into_raw().into_iter().map(f32::from).collect();
    Array2::from_shape_vec(shape, levels).map_err(|e| e.to_string())
}

fn decode_npy(bytes: &[u8]) -> std::result::Result<Array2<f32>, String> {
    let array = or_type(npy::read::<f32>(bytes), || {
        npy::read::<f64>(bytes).map(|a| a.mapv(|v| v as f32))
    });
    let array: ArrayD<f32> = or_type(array, || npy::read::<u8>(bytes).map(|a| a.mapv(f32::from)))
        .map_err(|e| match e {
        NpyError::Type(found) => {
            format!("has dtype {found}; expected float32, float64 or uint8")
        }
        NpyError::Damaged(message) => message,
    })?;
    let shape = array.shape().to_vec();
    array
        .into_dimensionality::<Ix2>()
        .map_err(|_| format!("has shape {shape:?}; expected [row, column]"))
}

fn encode_png(pixels: &Array2<f32>) -> GrayImage {
    let (rows, columns) = pixels.dim();
    GrayImage::from_fn(columns as u32, rows as u32, |column, row| {
        let level = pixels[(row as usize, column as usize)];
        // The cast saturates: below 0 is 0, above 255 is 255.
        image::Luma([(level + 0.5) as u8])
    })
}
