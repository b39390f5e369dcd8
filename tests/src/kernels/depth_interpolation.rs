//! Samples between those of a line with a depth step.

use std::vec::Vec;

use bonebeam::prelude::stages::*;

use crate::draw::Draw;
use crate::kernel::Kernel;

/// Envelopes at all samples of a line.
#[derive(Clone, Debug)]
pub struct Envelopes {
    /// All samples, the depth step, and cycles of the carrier from one of the samples to the next.
    pub grid: (usize, usize, f64),
    /// The sub-lines and their pooling.
    pub of_line: (usize, Pooling),
    /// The computed samples, `[sample][sub-line]`.
    pub z: Vec<Complex<f32>>,
}

impl Envelopes {
    fn stage(&self) -> Result<DepthInterpolation, Error> {
        let (samples, depth_step, cycles) = self.grid;
        DepthInterpolation::new(samples, depth_step, cycles)
    }
}

impl Kernel for Envelopes {
    type Number = f32;

    fn draw(draw: &mut impl Draw) -> Result<Self, Error> {
        let wild = draw.once_in(8);
        let (samples, depth_step) = (draw.size(60, 1000), draw.size(8, 10));
        let grid = (samples, depth_step, draw.number(wild, [-2.0, 2.0]));
        let pooling = draw.one_of(&[Pooling::Largest, Pooling::Rms]);
        let of_line = (draw.one_of(&[1, 2, 4, 16]), pooling);
        let parts = draw.record(2 * samples.div_ceil(depth_step) * of_line.0);
        let pairs = parts.as_chunks::<2>().0.iter();
        let z = pairs.map(|&[re, im]| Complex::new(re, im)).collect();
        let envelopes = Envelopes { grid, of_line, z };
        envelopes.stage()?;
        Ok(envelopes)
    }

    fn need(&self, _: usize, _: usize) -> [Need; 2] {
        let need = self.stage().map(|stage| stage.need(self.of_line.0));
        [need.unwrap_or_default(), Need::default()]
    }

    fn numbers(&self) -> usize {
        self.grid.0
    }

    fn is_one_call(&self, _: usize) -> bool {
        true
    }

    fn run<V: Vector>(
        &self,
        _: V,
        _: usize,
        (scratch, _): (Scratch<'_>, Scratch<'_, V>),
        out: &mut [f32],
    ) -> Result<(), Error> {
        self.stage()?
            .envelope(&self.z, self.of_line, scratch.complex, out)
    }
}
