//! Images from parallel lines or from a fan of lines.

use std::vec;
use std::vec::Vec;

use bonebeam::image::{
    PixelGrid, envelope, largest, log_compression_with, median, resample, scan_convert,
};
use bonebeam::prelude::stages::*;

use crate::draw::Draw;
use crate::kernel::Kernel;

/// An image.
#[derive(Clone, Debug)]
pub struct Image {
    /// The stage.
    pub stage: BMode,
    /// The fan of its lines; `None` for parallel ones.
    pub fan: Option<Fan>,
    /// Beamformed samples, `[line][sample]`.
    pub z: Vec<Complex<f32>>,
}

/// The way by the functions of the stage.
const FUNCTIONS: usize = 1;

impl Image {
    fn by_functions<V: Vector>(
        &self,
        zero: V,
        envelopes: &[f32],
        mut work: Scratch<'_>,
        out: &mut [f32],
    ) -> Result<(), Error> {
        let p = self.stage.parameters();
        let levels = work.take(Need::real(envelopes.len()))?.real;
        let pixels = work.take(Need::real(out.len()))?.real;
        let reference = largest(envelopes);
        log_compression_with(p.logarithm, envelopes, reference, p.dynamic_range, levels)?;
        let (data, grid) = (
            [p.lines, p.samples],
            [p.grid.row_axis(), p.grid.column_axis()],
        );
        match self.fan {
            Some(fan) => scan_convert(levels, fan, data, grid, pixels)?,
            None => resample(levels, data, grid, pixels)?,
        }
        if p.median {
            return median(zero, pixels, p.grid.columns, out);
        }
        out.copy_from_slice(pixels);
        Ok(())
    }
}

impl Kernel for Image {
    type Number = f32;

    fn draw(draw: &mut impl Draw) -> Result<Self, Error> {
        let wild = draw.once_in(4);
        let in_fan = draw.flag();
        let counts = [(); 4].map(|()| {
            if draw.byte() < 192 {
                draw.below(12)
            } else {
                draw.below(40)
            }
        });
        let [lines, samples, rows, columns] = counts;
        let mut at = |usual| draw.number(wild, usual);
        let axis = |[first, step]: [f64; 2], count| Axis::new(first, step, count);
        let lines = match in_fan {
            true => axis([at([-0.8, 0.0]), at([1e-3, 0.2])], lines),
            false => axis([at([-5e-3, 0.0]), at([1e-4, 1e-3])], lines),
        };
        let samples = axis([at([0.0, 1e-2]), at([1e-4, 2e-3])], samples);
        let (x, z, radius) = (at([-0.01, 0.01]), at([-0.05, 0.0]), at([0.0, 0.05]));
        // Around the beginning of the lines, or a fan's middle one.
        let (left, above) = if in_fan {
            (x, z + radius)
        } else {
            (lines.first, 0.0)
        };
        let (x0, z0) = (
            left + at([-5e-3, 1e-3]),
            above + samples.first + at([-1e-3, 1e-3]),
        );
        let pixel = at([1e-4, 2e-3]);
        let grid = match draw.byte() < 192 && !in_fan && !wild {
            true => PixelGrid::of_lines(&lines, &samples, rows, columns),
            false => PixelGrid::new([x0, z0], pixel, [rows, columns]),
        };
        let parameters = BModeParameters {
            lines,
            samples,
            grid,
            dynamic_range: draw.number(wild, [1.0, 100.0]) as f32,
            logarithm: draw.one_of(&[Logarithm::Exact, Logarithm::Polynomial]),
            median: draw.flag(),
        };
        let fan = in_fan.then_some(Fan { x, z, radius });
        let stage = match fan {
            Some(fan) => BMode::of_fan(parameters, fan)?,
            None => BMode::new(parameters)?,
        };
        let parts = draw.samples(2 * stage.envelopes_len());
        let pairs = parts.as_chunks::<2>().0.iter();
        let z = pairs.map(|&[re, im]| Complex::new(re, im)).collect();
        Ok(Image { stage, fan, z })
    }

    fn need(&self, _: usize, way: usize) -> [Need; 2] {
        let own = match way {
            FUNCTIONS => Need::real(self.z.len() + self.numbers()),
            _ => self.stage.need(),
        };
        [Need::real(self.z.len()).and(own), Need::default()]
    }

    fn numbers(&self) -> usize {
        self.stage.parameters().grid.pixels()
    }

    fn run<V: Vector>(
        &self,
        zero: V,
        way: usize,
        (mut work, _): (Scratch<'_>, Scratch<'_, V>),
        out: &mut [f32],
    ) -> Result<(), Error> {
        let envelopes = work.take(Need::real(self.z.len()))?.real;
        envelope(&self.z, envelopes)?;
        match way {
            FUNCTIONS => self.by_functions(zero, envelopes, work, out)?,
            _ => self.stage.image(zero, envelopes, work.real, out)?,
        }
        assert!(
            out.iter().all(|pixel| (0.0..=255.0).contains(pixel)),
            "a grey level beyond 0 to 255"
        );
        Ok(())
    }

    fn ways(&self) -> Vec<usize> {
        vec![FUNCTIONS]
    }
}
