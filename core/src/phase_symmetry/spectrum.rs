//! The half spectrum of the image, strip by strip.

use super::bank::PhaseSymmetry;
use super::external::{ReadAt, WriteAt};
use super::fft::Fft;
use super::gains::Gains;
use super::lines::{in_groups, load_partial, store_partial};
use super::memory::StripSlices;
use super::strip::Kernels;
use crate::Error;
use crate::simd::{Vector, get, vectorize};
use core::hint::cold_path;
use num_complex::Complex;

/// Largest accepted magnitude of a pixel.
///
/// It is far beyond an image's 255, and no step overflows below it.
pub const MAX_PIXEL: f32 = 1e12;

impl PhaseSymmetry {
    /// Checks the image and writes its half spectrum.
    ///
    /// This is the first step of [`PhaseSymmetry::run`]. [`StripSlices`] has an example.
    ///
    /// # Errors
    /// As [`PhaseSymmetry::run`].
    pub fn spectrum<V: Vector, F: Fft<V>, G: Gains<V>>(
        &self,
        kernels: &Kernels<'_, F, G>,
        image: &mut dyn ReadAt,
        spectrum: &mut dyn WriteAt,
        memory: &mut StripSlices<'_, V>,
    ) -> Result<(), Error> {
        let zero = self.check(kernels, memory)?;
        self.transform_rows(kernels.fft, image, spectrum, memory)?;
        self.transform_columns(zero, kernels.fft, spectrum, memory)
    }

    /// Reads and checks the image, and writes the left half of its rows' transforms.
    fn transform_rows<V: Vector, F: Fft<V>>(
        &self,
        fft: &F,
        image: &mut dyn ReadAt,
        spectrum: &mut dyn WriteAt,
        memory: &mut StripSlices<'_, V>,
    ) -> Result<(), Error> {
        let columns = self.columns;
        let half = self.sizes().half();
        for rows in self.row_strips() {
            let height = rows.len();
            let pixels = memory.sums.get_mut(..height * columns);
            let pixels = pixels.ok_or(Error::Memory)?;
            image.read_at(rows.start * columns, pixels)?;
            check_pixels(pixels, rows.start * columns)?;
            let pixels = &*pixels;
            let strip = memory.strip.get_mut(..2 * height * half);
            let strip = strip.ok_or(Error::Memory)?;
            let line = memory.line.get_mut(..columns).ok_or(Error::Memory)?;
            let zero = line.first().ok_or(Error::Memory)?.re.zero();
            vectorize!(zero, self.transform_strip_of_rows(fft, pixels, line, strip));
            for columns in self.column_strips() {
                let tile = strip.get(2 * height * columns.start..2 * height * columns.end);
                let offset = self.rows * columns.start + rows.start * columns.len();
                spectrum.write_at(2 * offset, tile.ok_or(Error::Memory)?)?;
            }
        }
        Ok(())
    }

    /// The left half of the transforms of a strip's rows, in tiles for the strips of columns.
    #[inline(always)]
    fn transform_strip_of_rows<V: Vector, F: Fft<V>>(
        &self,
        fft: &F,
        pixels: &[f32],
        line: &mut [Complex<V>],
        strip: &mut [f32],
    ) {
        let Some(bin) = line.first() else {
            return;
        };
        let zero = bin.re.zero();
        let length = line.len();
        let Some(height) = pixels.len().checked_div(length) else {
            return;
        };
        in_groups::<V>(
            height,
            #[inline(always)]
            |first, lanes| {
                fft.transform(
                    #[inline(always)]
                    |n| {
                        let mut re = zero;
                        for (k, lane) in re.lanes_mut().iter_mut().enumerate().take(lanes) {
                            match get::<V, _, _>(pixels, (first + k) * length + n) {
                                Some(&pixel) => *lane = pixel,
                                None => cold_path(),
                            }
                        }
                        Complex { re, im: zero }
                    },
                    line,
                );
                for columns in self.column_strips() {
                    let width = columns.len();
                    let tile = strip.get_mut(2 * height * columns.start..);
                    let (Some(tile), Some(bins)) = (tile, line.get(columns)) else {
                        return;
                    };
                    let rows = tile.chunks_exact_mut((2 * width).max(1)).skip(first);
                    for (k, row) in rows.enumerate().take(lanes) {
                        let Some((re, im)) = row.split_at_mut_checked(width) else {
                            return;
                        };
                        for ((re, im), bin) in re.iter_mut().zip(im).zip(bins) {
                            *re = bin.re.lanes()[k];
                            *im = bin.im.lanes()[k];
                        }
                    }
                }
            },
        );
    }

    /// Transforms the columns of the half spectrum, in place.
    fn transform_columns<V: Vector, F: Fft<V>>(
        &self,
        zero: V,
        fft: &F,
        spectrum: &mut dyn WriteAt,
        memory: &mut StripSlices<'_, V>,
    ) -> Result<(), Error> {
        for columns in self.column_strips() {
            let (offset, width) = (2 * self.rows * columns.start, columns.len());
            let strip = memory.strip.get_mut(..2 * self.rows * width);
            let strip = strip.ok_or(Error::Memory)?;
            spectrum.read_at(offset, strip)?;
            let line = memory.line.get_mut(..self.rows).ok_or(Error::Memory)?;
            vectorize!(
                zero,
                transform_strip_of_columns(zero, fft, strip, width, line)
            );
            spectrum.write_at(offset, strip)?;
        }
        Ok(())
    }
}

/// Transforms the `width` columns of a strip, in place.
#[inline(always)]
fn transform_strip_of_columns<V: Vector, F: Fft<V>>(
    zero: V,
    fft: &F,
    strip: &mut [f32],
    width: usize,
    line: &mut [Complex<V>],
) {
    in_groups::<V>(
        width,
        #[inline(always)]
        |first, lanes| {
            fft.transform(
                #[inline(always)]
                |row| {
                    Complex::new(
                        load_partial(zero, strip, 2 * row * width + first, lanes),
                        load_partial(zero, strip, (2 * row + 1) * width + first, lanes),
                    )
                },
                line,
            );
            for (rows, bin) in strip.chunks_exact_mut((2 * width).max(1)).zip(&*line) {
                store_partial(bin.re, rows, first, lanes);
                store_partial(bin.im, rows, width + first, lanes);
            }
        },
    );
}

pub(super) fn check_pixels(pixels: &[f32], offset: usize) -> Result<(), Error> {
    for (k, &pixel) in pixels.iter().enumerate() {
        if !pixel.is_finite() {
            return Err(Error::NonFinite {
                name: "image",
                index: offset + k,
            });
        }
        if pixel.abs() > MAX_PIXEL {
            let expected = "a magnitude of at most 1e12";
            return Err(Error::parameter("image pixel", pixel.into(), expected));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_good_up_to_the_largest() {
        for sign in [-1.0, 1.0] {
            assert_eq!(check_pixels(&[0.0, sign * MAX_PIXEL], 0), Ok(()));
            let beyond = sign * MAX_PIXEL.next_up();
            let refused = check_pixels(&[0.0, beyond], 0);
            assert!(
                matches!(refused, Err(Error::Parameter { value, .. }) if value == beyond.into())
            );
        }
        for (k, bad) in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY]
            .into_iter()
            .enumerate()
        {
            let refused = Err(Error::NonFinite {
                name: "image",
                index: 40 + k,
            });
            assert_eq!(check_pixels(&[0.0, 1.0, 2.0, bad][3 - k..], 40), refused);
        }
    }
}
