//! A picture for print: axes in mm and whole pixels at 300 dots per inch, as PNG.

use plotters::prelude::*;

use crate::experiments::outcome::{Coloured, Picture};
use crate::{Error, Result};

use bonebeam_report::page::axes::{Extent, Margins, axes};
use bonebeam_report::page::bar::Bar;
use bonebeam_report::page::colours::colour;

/// Least width of the picture within its axes, dots: 85 mm, a journal column.
const WIDTH: usize = 1000;
/// Dots per metre: 300 per inch.
const DOTS: u32 = 11_811;
/// Letters of 7 points.
const MARGINS: Margins = Margins {
    left: 120,
    edge: 16,
    bottom: 100,
    margin: [24; 2],
    text: [32, 29],
    labels: [6, 6],
    line: 3,
};

/// Width of a colour bar with its labels beside the picture, dots.
const BAR: u32 = 230;

/// The bytes of the PNG.
///
/// Each pixel is a square of dots, so its grey level is not changed.
///
/// # Errors
/// The picture cannot be drawn or encoded.
pub fn print(picture: &Picture) -> Result<Vec<u8>> {
    let mut sheet = Sheet::new(picture, None)?;
    sheet.fill(picture, |row, column| {
        [picture.pixels[[row, column]].round().clamp(0.0, 255.0) as u8; 3]
    });
    // Axes and letters are black on white.
    let (colours, _) = sheet.colours.as_chunks::<3>();
    let grey: Vec<u8> = colours.iter().map(|c| c[0]).collect();
    sheet.encode(&grey, png::ColorType::Grayscale)
}

/// The bytes of the PNG of a coloured picture, with its colour bar.
///
/// # Errors
/// As [`print()`].
pub fn print_coloured(shown: &Coloured) -> Result<Vec<u8>> {
    let bar = Bar {
        range: [-shown.reach, shown.reach],
        name: shown.quantity,
        margins: [
            MARGINS.margin[0],
            2 * MARGINS.margin[1],
            MARGINS.bottom,
            MARGINS.edge,
        ],
        labels: 120,
        text: MARGINS.text,
        line: MARGINS.line,
    };
    let mut sheet = Sheet::new(&shown.picture, Some(&bar))?;
    sheet.fill(&shown.picture, |row, column| shown.at(row, column));
    sheet.encode(&sheet.colours, png::ColorType::Rgb)
}

/// Axes of a picture, and the place of its pixels.
struct Sheet {
    /// Dots of a pixel's side.
    dots: usize,
    across: usize,
    down: usize,
    /// Red, green and blue of every dot.
    colours: Vec<u8>,
}

impl Sheet {
    /// The axes of a picture, and a colour bar if there is one.
    fn new(picture: &Picture, bar: Option<&Bar<'_>>) -> Result<Self> {
        register_font()?;
        let (rows, columns) = picture.pixels.dim();
        let dots = WIDTH.div_ceil(columns.max(1));
        let beside = MARGINS.left + (columns * dots) as u32 + MARGINS.margin[1];
        let across = beside + bar.map_or(0, |_| BAR);
        let down = MARGINS.margin[0] + (rows * dots) as u32 + MARGINS.bottom;
        let mut colours = vec![255; 3 * (across * down) as usize];
        {
            let root = BitMapBackend::with_buffer(&mut colours, (across, down));
            let root = root.into_drawing_area();
            let draw = || match bar {
                None => axes(&root, &Extent::of(picture), &[], &MARGINS),
                Some(bar) => {
                    let (left, right) = root.split_horizontally(beside);
                    axes(&left, &Extent::of(picture), &[], &MARGINS)?;
                    bar.draw(&right, |fraction| {
                        let [r, g, b] = colour(2.0 * fraction - 1.0).map(|v| (255.0 * v) as u8);
                        RGBColor(r, g, b)
                    })
                }
            };
            draw().map_err(|e| failed(&e))?;
            root.present().map_err(|e| failed(&e))?;
        }
        Ok(Sheet {
            dots,
            across: across as usize,
            down: down as usize,
            colours,
        })
    }

    /// Puts the pixels within the axes.
    fn fill(&mut self, picture: &Picture, colour: impl Fn(usize, usize) -> [u8; 3]) {
        let (rows, columns) = picture.pixels.dim();
        let [left, top] = [MARGINS.left, MARGINS.margin[0]].map(|v| v as usize);
        for row in 0..rows * self.dots {
            let start = (top + row) * self.across + left;
            let line = &mut self.colours[3 * start..][..3 * columns * self.dots];
            for (column, dot) in line.as_chunks_mut::<3>().0.iter_mut().enumerate() {
                *dot = colour(row / self.dots, column / self.dots);
            }
        }
    }

    fn encode(&self, dots: &[u8], colours: png::ColorType) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.across as u32, self.down as u32);
        encoder.set_color(colours);
        encoder.set_pixel_dims(Some(png::PixelDimensions {
            xppu: DOTS,
            yppu: DOTS,
            unit: png::Unit::Meter,
        }));
        let mut writer = encoder.write_header().map_err(|e| failed(&e))?;
        writer.write_image_data(dots).map_err(|e| failed(&e))?;
        writer.finish().map_err(|e| failed(&e))?;
        Ok(bytes)
    }
}

fn failed(error: &dyn std::fmt::Display) -> Error {
    Error::Data(format!("a picture cannot be drawn for print: {error}"))
}

/// Registers the font that measures and draws text.
///
/// The reader's own fonts show the page.
pub fn register_font() -> Result<()> {
    let bytes = dejavu::sans::regular();
    plotters::style::register_font("sans-serif", plotters::style::FontStyle::Normal, bytes)
        .map_err(|_| Error::Data("the font of the axes cannot be read".into()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::common::pictures::picture;
    use bonebeam_drive::image::PixelGrid;
    use ndarray::Array2;

    #[test]
    fn a_print_has_every_pixel_within_axes_and_300_dots_an_inch() {
        let grid = PixelGrid::new([-10e-3, 5e-3], 0.1e-3, [150, 200]);
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

    #[test]
    fn a_print_in_colours_has_their_bar_beside_it() {
        let grid = PixelGrid::new([-5e-3, 5e-3], 0.1e-3, [80, 100]);
        let white = Array2::from_elem((80, 100), 255.0);
        let shown = Coloured {
            picture: picture("a.png".into(), "a".into(), white, &grid),
            // From the blue end at the left to the red one at the right.
            values: Array2::from_shape_fn((80, 100), |(_, column)| column as f64 / 49.5 - 1.0),
            reach: 1.0,
            quantity: "distance, mm",
        };
        let bytes = print_coloured(&shown).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes))
            .read_info()
            .unwrap();
        assert_eq!(
            reader.info().size(),
            (120 + 1000 + 24 + 230, 24 + 800 + 100)
        );
        let mut dots = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut dots).unwrap();
        let across = 120 + 1000 + 24 + 230;
        let at = |x: usize, y: usize| -> [u8; 3] {
            dots[3 * (y * across + x)..][..3].try_into().unwrap()
        };
        assert_eq!(at(120, 24), [0, 0, 255]);
        assert_eq!(at(1119, 823), [255, 0, 0]);
        // The bar's ends: red above, blue below.
        let bar = 120 + 1000 + 24 + 60;
        assert_eq!(at(bar, 30), [255, 0, 0]);
        assert_eq!(at(bar, 818), [0, 0, 255]);
        // Its labels and its name, of which none is cut off at the edge.
        let dark = |x: std::ops::Range<usize>| {
            let all = x.flat_map(|x| (0..924).map(move |y| (x, y)));
            all.filter(|&(x, y)| at(x, y).iter().all(|v| *v < 128))
                .count()
        };
        assert!(dark(1260..1370) > 500);
        assert_eq!(dark(1370..1374), 0);
    }
}
