//! A picture by itself for print: axes in mm and whole pixels at 300 dots an inch, as PNG.

use plotters::prelude::*;

use crate::experiments::outcome::Picture;
use crate::{Error, Result};

use super::plot::{Around, axes, register_font};

/// The least width of the picture within its axes, dots: 85 mm, a column of a journal.
const WIDTH: usize = 1000;
/// Dots a metre: 300 an inch.
const DOTS: u32 = 11_811;
/// Letters of 7 points.
const AROUND: Around = Around {
    left: 120,
    edge: 16,
    bottom: 100,
    margin: 24,
    text: [32, 29],
    line: 3,
};

/// The bytes of the PNG. A pixel is a square of dots, so that its grey level is not changed.
///
/// # Errors
/// The picture cannot be drawn or encoded.
pub fn print(picture: &Picture) -> Result<Vec<u8>> {
    register_font()?;
    let (rows, columns) = picture.pixels.dim();
    let dots = WIDTH.div_ceil(columns.max(1));
    let (width, height) = (columns * dots, rows * dots);
    let [left, bottom, margin] = [AROUND.left, AROUND.bottom, AROUND.margin].map(|v| v as usize);
    let (all_across, all_down) = (left + width + margin, margin + height + bottom);
    let failed = |e: &dyn std::fmt::Display| {
        Error::Data(format!("{} cannot be drawn for print: {e}", picture.file))
    };
    let mut colours = vec![255; 3 * all_across * all_down];
    {
        let size = (all_across as u32, all_down as u32);
        let root = BitMapBackend::with_buffer(&mut colours, size).into_drawing_area();
        axes(&root, picture, &[], &AROUND).map_err(|e| failed(&e))?;
        root.present().map_err(|e| failed(&e))?;
    }
    // Axes and letters are black on white.
    let mut grey: Vec<u8> = colours.chunks_exact(3).map(|c| c[0]).collect();
    for row in 0..height {
        let line = &mut grey[(margin + row) * all_across + left..][..width];
        for (column, dot) in line.iter_mut().enumerate() {
            let level = picture.pixels[[row / dots, column / dots]];
            *dot = level.round().clamp(0.0, 255.0) as u8;
        }
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, all_across as u32, all_down as u32);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_pixel_dims(Some(png::PixelDimensions {
        xppu: DOTS,
        yppu: DOTS,
        unit: png::Unit::Meter,
    }));
    let mut writer = encoder.write_header().map_err(|e| failed(&e))?;
    writer.write_image_data(&grey).map_err(|e| failed(&e))?;
    writer.finish().map_err(|e| failed(&e))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::image::PixelGrid;
    use crate::experiments::common::pictures::picture;
    use ndarray::Array2;

    #[test]
    fn a_print_has_every_pixel_within_axes_and_300_dots_an_inch() {
        let grid = PixelGrid {
            x0: -10e-3,
            z0: 5e-3,
            pixel: 0.1e-3,
            rows: 150,
            columns: 200,
        };
        let pixels =
            Array2::from_shape_fn((150, 200), |(row, column)| ((row + column) % 256) as f32);
        let shown = picture("a.png".into(), "a".into(), pixels.clone(), &grid);
        let bytes = print(&shown).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes))
            .read_info()
            .unwrap();
        let dimensions = reader.info().pixel_dims.unwrap();
        assert_eq!((dimensions.xppu, dimensions.yppu), (11_811, 11_811));
        let (width, height) = reader.info().size();
        assert_eq!((width, height), (120 + 1000 + 24, 24 + 750 + 100));
        let mut dots = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut dots).unwrap();
        let dot = |x: usize, y: usize| f32::from(dots[y * width as usize + x]);
        for (row, column) in [(0, 0), (149, 199), (70, 33)] {
            let (x, y) = (120 + 5 * column, 24 + 5 * row);
            assert_eq!([dot(x, y), dot(x + 4, y + 4)], [pixels[[row, column]]; 2]);
        }
        // Letters stand to the left of the picture and below it, none above.
        let dark = |x: std::ops::Range<usize>, y: std::ops::Range<usize>| {
            let all = y.flat_map(|y| x.clone().map(move |x| (x, y)));
            all.filter(|&(x, y)| dot(x, y) < 128.0).count()
        };
        // None is cut off at the edge.
        assert_eq!(dark(0..4, 24..774), 0);
        assert!(dark(0..100, 24..774) > 500);
        assert!(dark(120..1120, 790..874) > 500);
        assert_eq!(dark(0..1144, 0..10), 0);
    }
}
