//! Pictures coloured by another quantity.
//!
//! Blue is below zero, white at zero, red above; brightness is the grey level.

use crate::experiments::outcome::Coloured;
use crate::{Error, Result};
use bonebeam_files::image::encode;

/// Colour at full brightness of a share of the quantity's range, −1 to 1.
pub fn colour(fraction: f64) -> [f64; 3] {
    // The square root keeps small ones apart.
    let pale = 1.0 - fraction.clamp(-1.0, 1.0).abs().sqrt();
    match fraction > 0.0 {
        true => [1.0, pale, pale],
        false => [pale, pale, 1.0],
    }
}

impl Coloured {
    /// The colour of a pixel.
    pub fn at(&self, row: usize, column: usize) -> [u8; 3] {
        let grey = f64::from(self.picture.pixels[[row, column]]);
        let fraction = self.values[[row, column]] / self.reach;
        colour(fraction).map(|v| (v * grey).round().clamp(0.0, 255.0) as u8)
    }

    /// The bytes of a PNG of its pixels alone.
    ///
    /// # Errors
    /// A picture that PNG cannot hold.
    pub fn png(&self) -> Result<Vec<u8>> {
        let (rows, columns) = self.picture.pixels.dim();
        let pixels = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
        let samples: Vec<u8> = pixels
            .flat_map(|(row, column)| self.at(row, column))
            .collect();
        let mut bytes = Vec::new();
        encode((rows, columns), png::ColorType::Rgb, &samples, &mut bytes)
            .map_err(|e| Error::Data(format!("the colour map cannot be encoded: {e}")))?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_is_white_and_the_ends_are_blue_and_red() {
        assert_eq!(colour(0.0), [1.0, 1.0, 1.0]);
        assert_eq!(colour(-1.0), [0.0, 0.0, 1.0]);
        assert_eq!(colour(1.0), [1.0, 0.0, 0.0]);
        assert_eq!(colour(0.25), [1.0, 0.5, 0.5]);
        assert_eq!(colour(-7.0), colour(-1.0));
    }
}
