//! A picture and its phase symmetry, under one name.

use crate::experiments::outcome::Picture;
use bonebeam_drive::image::PixelGrid;
use ndarray::Array2;

use super::pictures::picture;

/// A B-mode image over `range` dB, and its phase symmetry.
///
/// The files are `stem.png` and `stem-ps.png`; `what` begins both captions.
pub fn pair(
    stem: &str,
    what: &str,
    range: f64,
    [b_mode, ridges]: [Array2<f32>; 2],
    grid: &PixelGrid,
) -> [Picture; 2] {
    let of = |end: &str, kind: &str, pixels| {
        let caption = format!("{what}{kind}");
        picture(format!("{stem}{end}.png"), caption, pixels, grid)
    };
    [
        of("", &format!("B-mode over {range} dB"), b_mode),
        of("-ps", "phase symmetry", ridges),
    ]
}
