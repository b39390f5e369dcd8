//! Images: grey levels 0 to 255.
//!
//! They are `.npy` (float32 [row, column]), 8-bit PNG, and JPEG to read.

use std::io::{Cursor, Write};
use std::path::Path;

use ndarray::{Array2, ArrayD, Ix2};
use png::{
    BitDepth, ColorType, Compression, Decoder, DecodingError, Encoder, EncodingError, Filter,
    Limits, Transformations,
};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::atomic::Outputs;
use super::npy::{self, NpyError, or_type};
use super::{cannot_be_opened, file_error, input, validate};
use crate::terminal::digits;
use crate::{Error, Result};

/// Longest side of a PNG, pixels: the limit of written images.
const MAX_SIDE: u32 = 16_384;
/// Most memory to decode a PNG, bytes.
const MAX_BYTES: usize = 512 << 20;

/// Reads an image, [row, column], row 0 at the top.
///
/// A PNG or a JPEG becomes grey levels 0 to 255 (colours by their Rec. 709 luma, transparency ignored). The values of an
/// `.npy` array (float32, float64 or uint8) are not changed.
///
/// # Errors
/// The name ends in none of `.png`, `.jpg`, `.jpeg` and `.npy`, or the file is damaged, has another shape or type,
/// is empty, or holds a NaN or infinite pixel.
pub fn read(path: &Path) -> Result<Array2<f32>> {
    Ok(decoded(path)?.0)
}

/// The image, and whether it is a PNG of 16 bits.
fn decoded(path: &Path) -> Result<(Array2<f32>, bool)> {
    let format = match is_jpeg(path) {
        true => None,
        false => Some(Format::of(path)?),
    };
    let bytes = input::read(path, u64::MAX).map_err(|e| file_error(path, cannot_be_opened(&e)))?;
    let pixels = match format {
        Some(Format::Png) => decode_png(&bytes),
        Some(Format::Npy) => decode_npy(&bytes),
        None => decode_jpeg(&bytes),
    };
    let pixels = pixels.map_err(|message| file_error(path, message))?;
    validate::samples("image", &pixels, &["row", "column"])
        .map_err(|message| file_error(path, message))?;
    // The bit depth of a PNG is at a fixed place of its header.
    let wide = format == Some(Format::Png) && bytes.get(24) == Some(&16);
    Ok((pixels, wide))
}

/// Whether the name is that of an image that [`read`] takes.
pub fn is_image(path: &Path) -> bool {
    is_jpeg(path) || Format::of(path).is_ok()
}

fn is_jpeg(path: &Path) -> bool {
    let end = path.extension().and_then(|e| e.to_str());
    end.is_some_and(|e| {
        ["jpg", "jpeg"]
            .iter()
            .any(|own| e.eq_ignore_ascii_case(own))
    })
}

/// As [`read`], of grey levels.
///
/// # Errors
/// As [`read`], and values of another range, such as 0 to 1 or decibels.
pub fn read_levels(path: &Path) -> Result<Array2<f32>> {
    let (pixels, wide) = decoded(path)?;
    check_levels(&pixels, wide).map_err(|message| file_error(path, message))?;
    Ok(pixels)
}

/// As [`read_levels`], of the bytes of a PNG.
///
/// # Errors
/// As [`read_levels`]; `path` names the picture.
pub fn levels_of_png(bytes: &[u8], path: &Path) -> Result<Array2<f32>> {
    let pixels = decode_png(bytes).map_err(|message| file_error(path, message))?;
    check_levels(&pixels, bytes.get(24) == Some(&16))
        .map_err(|message| file_error(path, message))?;
    Ok(pixels)
}

/// Checks that the largest and the least value are those of grey levels, 0 to 255.
///
/// A picture of one value is accepted. 16-bit levels must use a quarter of their range.
///
/// # Errors
/// The values of another range, and how to change them.
pub fn check_levels(pixels: &Array2<f32>, wide: bool) -> std::result::Result<(), String> {
    let least = pixels.iter().copied().fold(f32::INFINITY, f32::min);
    let most = pixels.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let is = |range: std::ops::RangeInclusive<f32>| range.contains(&most);
    let remedy = match () {
        () if least == most || !(least.is_finite() && most.is_finite()) => return Ok(()),
        () if least < 0.0 && is(f32::NEG_INFINITY..=0.0) => {
            "of decibels take 255·(1 + dB/range), at least 0".to_owned()
        }
        () if least < -0.1 * most => {
            "of an oscillating signal take the envelope in decibels".to_owned()
        }
        () if most > 280.0 => format!(
            "multiply by 255/{}",
            (most + 1.0).log2().ceil().exp2() - 1.0
        ),
        () if wide && is(0.0..=64.0) => {
            "a picture of fewer bits in 16, whose levels are to be multiplied before it is stored"
                .to_owned()
        }
        () if is(0.0..=1.0) => "multiply by 255".to_owned(),
        () => return Ok(()),
    };
    let unit = if wide { 257.0 } else { 1.0 };
    let [least, most] = [least, most].map(|level| digits(f64::from(level * unit)));
    Err(format!(
        "has values from {least} to {most}; expected grey levels from 0 to {}: {remedy}",
        255.0 * unit
    ))
}

/// Stages an image as `.npy` or `.png`, by the ending of the name.
///
/// A PNG holds the values rounded to 0 to 255.
///
/// # Errors
/// The name ends in neither, or the file cannot be written.
pub fn add_to(pixels: &Array2<f32>, path: &Path, outputs: &mut Outputs) -> Result<()> {
    match Format::of(path)? {
        Format::Png => outputs.add(path, |sink| Ok(write_png(pixels, sink)?)),
        Format::Npy => outputs.add(path, |sink| Ok(npy::write(pixels, sink)?)),
    }
}

/// The bytes of a PNG with the values rounded to 0 to 255.
///
/// # Errors
/// An image that PNG cannot hold.
pub fn png(pixels: &Array2<f32>) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write_png(pixels, &mut bytes)
        .map_err(|e| Error::Data(format!("the image cannot be encoded: {e}")))?;
    Ok(bytes)
}

/// Writes an image as [`add_to`] does, whole or not at all.
///
/// # Errors
/// As [`add_to`].
pub fn write(pixels: &Array2<f32>, path: &Path) -> Result<()> {
    let mut outputs = Outputs::new();
    add_to(pixels, path, &mut outputs)?;
    outputs.commit()
}

/// File formats of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Format {
    /// 8-bit grey levels, for people.
    Png,
    /// float32 [row, column].
    Npy,
}

impl Format {
    /// The format by the ending of a file's name.
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

/// Grey levels of a JPEG, colours by their Rec. 709 luma.
///
/// # Errors
/// The problem, without the file's name.
pub fn decode_jpeg(bytes: &[u8]) -> std::result::Result<Array2<f32>, String> {
    let unreadable = |e| format!("is truncated or not a JPEG image ({e:?})");
    let side = MAX_SIDE as usize;
    let options = DecoderOptions::default()
        .set_max_width(side)
        .set_max_height(side)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(unreadable)?;
    let (columns, rows) = decoder.dimensions().unwrap_or_default();
    if columns * rows * 3 > MAX_BYTES {
        return Err(too_large());
    }
    let colours = decoder.decode().map_err(unreadable)?;
    let (pixels, _) = colours.as_chunks();
    let levels = pixels.iter().map(|rgb| luma(rgb.map(u32::from), 255.0));
    Array2::from_shape_vec((rows, columns), levels.collect()).map_err(|e| e.to_string())
}

fn too_large() -> String {
    format!("is too large an image; expected at most {MAX_SIDE} × {MAX_SIDE} pixels and 512 MiB")
}

fn decode_png(bytes: &[u8]) -> std::result::Result<Array2<f32>, String> {
    let unreadable = |error| match error {
        DecodingError::LimitsExceeded => too_large(),
        e => format!("is truncated or not a PNG image ({e})"),
    };
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: MAX_BYTES });
    // Palettes and grey levels of fewer bits become those of eight.
    decoder.set_transformations(Transformations::EXPAND);
    let header = decoder.read_header_info().map_err(unreadable)?;
    let (columns, rows) = header.size();
    if columns.max(rows) > MAX_SIDE {
        return Err(too_large());
    }
    let mut reader = decoder.read_info().map_err(unreadable)?;
    let length = reader.output_buffer_size();
    let length = length.filter(|&length| length <= MAX_BYTES);
    let mut samples = vec![0; length.ok_or_else(too_large)?];
    reader.next_frame(&mut samples).map_err(unreadable)?;
    let (colours, depth) = reader.output_color_type();
    let wide = depth == BitDepth::Sixteen;
    let pixels = samples.chunks_exact(colours.samples() * if wide { 2 } else { 1 });
    let levels = pixels.map(|pixel| {
        let sample = |k: usize| match wide {
            true => u32::from(u16::from_be_bytes([pixel[2 * k], pixel[2 * k + 1]])),
            false => u32::from(pixel[k]),
        };
        match colours {
            // The nearest of eight bits.
            ColorType::Grayscale | ColorType::GrayscaleAlpha if wide => {
                ((sample(0) + 128) / 257) as f32
            }
            ColorType::Grayscale | ColorType::GrayscaleAlpha => sample(0) as f32,
            _ => luma([0, 1, 2].map(sample), if wide { 65_535.0 } else { 255.0 }),
        }
    });
    Array2::from_shape_vec((rows as usize, columns as usize), levels.collect())
        .map_err(|e| e.to_string())
}

/// Grey level, 0 to 255, of red, green and blue of 0 to `white`.
///
/// It is the luma of Rec. 709, whose weights are those of its primaries in the white point D65.
pub fn luma(colour: [u32; 3], white: f32) -> f32 {
    const SHARES: [f32; 3] = [0.212_647_84, 0.715_179_2, 0.072_173_04];
    let shares = colour.iter().zip(SHARES);
    let luma = shares.fold(0.0, |sum, (&v, fraction)| {
        sum + v as f32 * (1.0 / white) * fraction
    });
    (255.0 * luma).round()
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

fn write_png(
    pixels: &Array2<f32>,
    sink: &mut impl Write,
) -> std::result::Result<(), EncodingError> {
    // The cast saturates: below 0 is 0, above 255 is 255.
    let levels: Vec<u8> = pixels.iter().map(|&level| (level + 0.5) as u8).collect();
    encode(pixels.dim(), ColorType::Grayscale, &levels, sink)
}

/// Stages an RGB picture as `.png`.
///
/// # Errors
/// The file cannot be written.
pub fn add_colours_to(pixels: &Array2<[u8; 3]>, path: &Path, outputs: &mut Outputs) -> Result<()> {
    let standard = pixels.as_standard_layout();
    let samples = standard.as_slice().unwrap_or_default().as_flattened();
    outputs.add(path, |sink| {
        Ok(encode(pixels.dim(), ColorType::Rgb, samples, sink)?)
    })
}

/// Writes a PNG of `(rows, columns)` pixels with eight bits per sample.
///
/// # Errors
/// A size that PNG cannot have, a wrong number of samples, or an error of the sink.
pub fn encode(
    (rows, columns): (usize, usize),
    colours: ColorType,
    samples: &[u8],
    sink: &mut impl Write,
) -> std::result::Result<(), EncodingError> {
    let mut encoder = Encoder::new(sink, columns as u32, rows as u32);
    encoder.set_color(colours);
    encoder.set_compression(Compression::Fast);
    encoder.set_filter(Filter::Adaptive);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(samples)?;
    writer.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(
        colours: ColorType,
        depth: BitDepth,
        samples: &[u8],
        palette: Option<&[u8]>,
    ) -> Vec<f32> {
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(colours);
        encoder.set_depth(depth);
        if let Some(palette) = palette {
            encoder.set_palette(palette);
        }
        let mut writer = encoder.write_header().unwrap();
        writer.write_image_data(samples).unwrap();
        writer.finish().unwrap();
        decode_png(&bytes).unwrap().into_raw_vec_and_offset().0
    }

    /// Values of another range would be a map of zeros, or of nothing but bone.
    #[test]
    fn values_that_are_no_grey_levels_are_refused_with_their_remedy() {
        let check = |values: [f32; 2], wide| {
            check_levels(
                &Array2::from_shape_vec((1, 2), values.into()).unwrap(),
                wide,
            )
        };
        for (values, wide, remedy) in [
            (
                [0.0, 1.0],
                false,
                "from 0 to 1; expected grey levels from 0 to 255: multiply by 255",
            ),
            ([0.0, 4095.0], false, "multiply by 255/4095"),
            ([-60.0, 0.0], false, "255·(1 + dB/range)"),
            ([-0.5, 0.5], false, "envelope"),
            (
                [0.0, 255.0 / 257.0],
                true,
                "from 0 to 255; expected grey levels from 0 to 65535: a picture of fewer bits in 16",
            ),
        ] {
            let message = check(values, wide).unwrap_err();
            assert!(message.contains(remedy), "{message}");
        }
        for values in [
            [0.0, 255.0],
            [3.0, 3.0],
            [-4.0, 262.0],
            [0.0, 16.0],
            [1.0, 80.0],
        ] {
            assert_eq!(check(values, false), Ok(()));
        }
    }

    /// The expected levels are those of the crate `image` 0.25.10.
    #[test]
    fn every_kind_of_png_becomes_grey_levels() {
        use BitDepth::{Eight, One, Sixteen};
        use ColorType::{Grayscale, GrayscaleAlpha, Indexed, Rgb, Rgba};
        let wide =
            |values: &[u16]| -> Vec<u8> { values.iter().flat_map(|v| v.to_be_bytes()).collect() };
        let colours = [255, 0, 0, 10, 200, 30];
        for (kind, depth, samples, palette, expected) in [
            (Grayscale, Eight, vec![7, 255], None, [7.0, 255.0]),
            (Grayscale, One, vec![0b0100_0000], None, [0.0, 255.0]),
            (Grayscale, Sixteen, wide(&[128, 65_535]), None, [0.0, 255.0]),
            (Grayscale, Sixteen, wide(&[129, 385]), None, [1.0, 1.0]),
            (GrayscaleAlpha, Eight, vec![7, 0, 9, 255], None, [7.0, 9.0]),
            (
                GrayscaleAlpha,
                Sixteen,
                wide(&[129, 0, 65_535, 9]),
                None,
                [1.0, 255.0],
            ),
            (Rgb, Eight, colours.to_vec(), None, [54.0, 147.0]),
            (
                Rgba,
                Eight,
                vec![0, 255, 0, 0, 0, 0, 255, 9],
                None,
                [182.0, 18.0],
            ),
            (
                Rgb,
                Sixteen,
                wide(&[65_535, 65_535, 65_535, 0, 257, 0]),
                None,
                [255.0, 1.0],
            ),
            (
                Indexed,
                Eight,
                vec![1, 0],
                Some(&colours[..]),
                [147.0, 54.0],
            ),
        ] {
            let levels = decoded(kind, depth, &samples, palette);
            assert_eq!(levels, expected, "{kind:?} {depth:?}");
        }
    }
}
