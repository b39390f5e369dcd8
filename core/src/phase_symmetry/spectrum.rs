//! The half spectrum of the image, strip by strip.

use super::external::Area;
use super::strip::PhaseSymmetry;
use super::transform::forward;
use super::workspace::{External, StripBuffers, spectrum_columns};
use crate::Error;
use num_complex::Complex;

/// The largest magnitude of a pixel: far beyond an image's 255, and no step overflows below it.
pub const MAX_PIXEL: f32 = 1e12;

impl PhaseSymmetry {
    /// Reads and checks the image, and writes the left half of its rows' transforms.
    pub(super) fn transform_rows(
        &self,
        external: &mut External<'_>,
        buffers: &mut StripBuffers<'_>,
    ) -> Result<(), Error> {
        let half = spectrum_columns(self.columns);
        for row in (0..self.rows).step_by(self.strip) {
            let area = self.row_strip(row);
            let pixels = &mut buffers.symmetry[..area.rows * self.columns];
            external.image.read(area, pixels)?;
            check_pixels(pixels, row * self.columns)?;
            let spectrum = &mut buffers.strip[..area.rows * half];
            let line = &mut buffers.line[..self.columns];
            for (pixels, spectrum) in pixels
                .chunks_exact(self.columns)
                .zip(spectrum.chunks_exact_mut(half))
            {
                for (bin, &pixel) in line.iter_mut().zip(pixels) {
                    *bin = Complex::new(pixel, 0.0);
                }
                forward(line);
                spectrum.copy_from_slice(&line[..half]);
            }
            external.spectrum.write(
                Area {
                    columns: half,
                    ..area
                },
                spectrum,
            )?;
        }
        Ok(())
    }

    /// Transforms the columns of the half spectrum, in place.
    pub(super) fn transform_columns(
        &self,
        external: &mut External<'_>,
        buffers: &mut StripBuffers<'_>,
    ) -> Result<(), Error> {
        let half = spectrum_columns(self.columns);
        for column in (0..half).step_by(self.strip) {
            let area = self.column_strip(column, half);
            let width = area.columns;
            let strip = &mut buffers.strip[..self.rows * width];
            external.spectrum.read(area, strip)?;
            let line = &mut buffers.line[..self.rows];
            for k in 0..width {
                for (row, bin) in line.iter_mut().enumerate() {
                    *bin = strip[row * width + k];
                }
                forward(line);
                for (row, bin) in line.iter().enumerate() {
                    strip[row * width + k] = *bin;
                }
            }
            external.spectrum.write(area, strip)?;
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
