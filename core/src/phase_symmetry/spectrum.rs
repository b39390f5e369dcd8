//! The half spectrum of the image, strip by strip.

use super::external::{Source, Store};
use super::fft::Fft;
use super::gains::Gains;
use super::lines::{groups, load, store};
use super::strip::{Kernels, PhaseSymmetry};
use super::workspace::{StripBuffers, spectrum_columns};
use crate::Error;
use crate::simd::Vector;
use num_complex::Complex;

/// The largest magnitude of a pixel: far beyond an image's 255, and no step overflows below it.
pub const MAX_PIXEL: f32 = 1e12;

impl PhaseSymmetry {
    /// Checks the image and writes its half spectrum: the first step of [`PhaseSymmetry::run`].
    ///
    /// # Errors
    /// As [`PhaseSymmetry::run`].
    pub fn spectrum<V: Vector, F: Fft<V>, G: Gains<V>>(
        &self,
        kernels: &Kernels<'_, V, F, G>,
        image: &mut dyn Source,
        spectrum: &mut dyn Store,
        buffers: &mut StripBuffers<'_, V>,
    ) -> Result<(), Error> {
        self.check(kernels, buffers)?;
        self.transform_rows(kernels, image, spectrum, buffers)?;
        self.transform_columns(kernels, spectrum, buffers)
    }

    /// Reads and checks the image, and writes the left half of its rows' transforms.
    fn transform_rows<V: Vector, F: Fft<V>, G: Gains<V>>(
        &self,
        kernels: &Kernels<'_, V, F, G>,
        image: &mut dyn Source,
        spectrum: &mut dyn Store,
        buffers: &mut StripBuffers<'_, V>,
    ) -> Result<(), Error> {
        let (zero, fft, columns) = (kernels.zero, kernels.fft, self.columns);
        let half = spectrum_columns(columns);
        for rows in self.row_strips() {
            let height = rows.len();
            let pixels = &mut buffers.sums[..height * columns];
            image.read(rows.start * columns, pixels)?;
            check_pixels(pixels, rows.start * columns)?;
            let pixels = &*pixels;
            let strip = &mut buffers.strip[..2 * height * half];
            let line = &mut buffers.line[..columns];
            zero.vectorize(
                #[inline(always)]
                || {
                    for (first, lanes) in groups::<V>(height) {
                        let row = |n| {
                            let mut re = zero;
                            for (k, pixel) in re.lanes_mut().iter_mut().enumerate().take(lanes) {
                                *pixel = pixels[(first + k) * columns + n];
                            }
                            Complex { re, im: zero }
                        };
                        fft.transform(row, line);
                        for columns in self.column_strips() {
                            let width = columns.len();
                            let piece = &mut strip[2 * height * columns.start..];
                            let rows = piece.chunks_exact_mut(2 * width).skip(first);
                            for (k, row) in rows.enumerate().take(lanes) {
                                let (re, im) = row.split_at_mut(width);
                                let bins = &line[columns.clone()];
                                for ((re, im), bin) in re.iter_mut().zip(im).zip(bins) {
                                    *re = bin.re.lanes()[k];
                                    *im = bin.im.lanes()[k];
                                }
                            }
                        }
                    }
                },
            );
            for columns in self.column_strips() {
                let piece = &strip[2 * height * columns.start..2 * height * columns.end];
                let place = self.rows * columns.start + rows.start * columns.len();
                spectrum.write(2 * place, piece)?;
            }
        }
        Ok(())
    }

    /// Transforms the columns of the half spectrum, in place.
    fn transform_columns<V: Vector, F: Fft<V>, G: Gains<V>>(
        &self,
        kernels: &Kernels<'_, V, F, G>,
        spectrum: &mut dyn Store,
        buffers: &mut StripBuffers<'_, V>,
    ) -> Result<(), Error> {
        let (zero, fft) = (kernels.zero, kernels.fft);
        for columns in self.column_strips() {
            let (place, width) = (2 * self.rows * columns.start, columns.len());
            let strip = &mut buffers.strip[..2 * self.rows * width];
            spectrum.read(place, strip)?;
            let line = &mut buffers.line[..self.rows];
            zero.vectorize(
                #[inline(always)]
                || {
                    for (first, lanes) in groups::<V>(width) {
                        let column = |row: usize| Complex {
                            re: load(zero, strip, 2 * row * width + first, lanes),
                            im: load(zero, strip, (2 * row + 1) * width + first, lanes),
                        };
                        fft.transform(column, line);
                        for (rows, bin) in strip.chunks_exact_mut(2 * width).zip(&*line) {
                            store(bin.re, rows, first, lanes);
                            store(bin.im, rows, width + first, lanes);
                        }
                    }
                },
            );
            spectrum.write(place, strip)?;
        }
        Ok(())
    }
}

fn check_pixels(pixels: &[f32], offset: usize) -> Result<(), Error> {
    for (k, &pixel) in pixels.iter().enumerate() {
        if !pixel.is_finite() {
            return Err(Error::NonFinite {
                name: "image",
                index: offset + k,
            });
        }
        if pixel.abs() > MAX_PIXEL {
            return Err(Error::Parameter {
                name: "image pixel",
                value: pixel.into(),
                expected: "a magnitude of at most 1e12",
            });
        }
    }
    Ok(())
}
