//! Brightness of the bone over the tissue around it.

use crate::Result;
use bonebeam_drive::image::b_mode;
use bonebeam_files::BeamformedLines;
use ndarray::Array2;
use serde::{Deserialize, Serialize};

use super::bone::View;
use super::truth::TOLERANCE;
use crate::experiments::outcome::ranged;

/// Dynamic range of the image that levels are read from, dB.
const RANGE: f64 = 160.0;

/// The bone's echo over the tissue's RMS, dB, over columns with a surface.
///
/// The echo is the largest envelope within 0.5 mm of the surface. Speckle alone gives 3 to 5 dB.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Brightness {
    /// The median.
    pub median_db: f64,
    /// The 10th and the 90th percentile.
    pub tenths_db: [f64; 2],
}

impl Brightness {
    /// The brightness in the lines of a scene; `None` without tissue or bone.
    ///
    /// The tissue lies within a lateral range and a depth range, m.
    ///
    /// # Errors
    /// Lines that do not make an image.
    pub fn of(
        lines: &BeamformedLines,
        view: &View,
        lateral: [f64; 2],
        depths: [f64; 2],
    ) -> Result<Option<Self>> {
        let image = b_mode(lines, RANGE as f32, &view.grid, false)?.pixels;
        Ok(Self::of_image(&image, view, lateral, depths))
    }

    fn of_image(
        image: &Array2<f32>,
        view: &View,
        lateral: [f64; 2],
        depths: [f64; 2],
    ) -> Option<Self> {
        let level = |grey: f64| RANGE * (grey / 255.0 - 1.0);
        let [tissue, _] = view.tissue_and_shadow(image, lateral, depths);
        let power = tissue.iter().map(|&g| 10f64.powf(0.1 * level(g)));
        let mean = power.sum::<f64>() / tissue.len().max(1) as f64;
        let echo = |(column, hit): (usize, &Option<f64>)| {
            let row = hit.as_ref()?;
            let near = view.near(*row, TOLERANCE);
            let levels = near.map(|k| f64::from(image[[k, column]]));
            Some(level(levels.max_by(f64::total_cmp)?) - 10.0 * mean.log10())
        };
        let mut echoes: Vec<f64> = view.hits.iter().enumerate().filter_map(echo).collect();
        echoes.sort_by(f64::total_cmp);
        let at = |fraction: f64| {
            let position = (fraction * (echoes.len().checked_sub(1)?) as f64).round();
            echoes.get(position as usize).copied()
        };
        let found = Brightness {
            median_db: at(0.5)?,
            tenths_db: [at(0.1)?, at(0.9)?],
        };
        (mean > 0.0).then_some(found)
    }

    /// The text in tables.
    pub fn text(found: Option<&Self>) -> String {
        found.map_or("–".into(), |found| {
            ranged(found.median_db, found.tenths_db)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::common::bone::tests::slab;

    #[test]
    fn a_line_above_even_tissue_has_its_level() {
        let view = slab();
        let grey = |level: f64| (255.0 * (1.0 + level / RANGE)) as f32;
        // Tissue of −50 dB; the surface has −20 dB in most columns, −40 dB in a fifth of them.
        let mut image = Array2::from_elem((201, 101), grey(-50.0));
        for column in 0..101 {
            image[[101, column]] = grey(if column < 20 { -40.0 } else { -20.0 });
        }
        let found = Brightness::of_image(&image, &view, [-4e-3, 4e-3], [12e-3, 40e-3]).unwrap();
        assert!((found.median_db - 30.0).abs() < 1e-3);
        assert!((found.tenths_db[0] - 10.0).abs() < 1e-3);
        assert!((found.tenths_db[1] - 30.0).abs() < 1e-3);
        let empty = Brightness::of_image(&image, &view, [-4e-3, 4e-3], [60e-3, 70e-3]);
        assert_eq!(empty, None);
    }
}
