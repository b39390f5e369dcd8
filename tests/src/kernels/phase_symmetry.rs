//! The bone map of an image, in strips and in one memory.

use std::vec;
use std::vec::Vec;

use bonebeam::phase_symmetry::{Kernels, MAX_PIXEL, Parameters, Sizes};
use bonebeam::prelude::stages::*;

use crate::draw::Draw;
use crate::kernel::Kernel;

/// A map.
#[derive(Clone, Debug)]
pub struct Map {
    /// Rows and columns.
    pub shape: [usize; 2],
    /// `r₀`, cycles per pixel.
    pub scales: Vec<f64>,
    /// `T_n`.
    pub threshold: f32,
    /// Height of a strip in the first way, and in the second.
    pub strips: [usize; 2],
    /// The image, `[row][column]`.
    pub image: Vec<f32>,
}

/// The ways in one memory, over one lane whatever the instruction set: gains on the fly, and from tables.
const IN_ONE_MEMORY: [usize; 2] = [usize::MAX, usize::MAX - 1];

impl Map {
    fn bank(&self, strip: usize) -> Result<PhaseSymmetry, Error> {
        let [rows, columns] = self.shape;
        let sizes = Sizes::new(rows, columns, strip);
        PhaseSymmetry::new(&Parameters {
            sizes,
            scales: &self.scales,
            threshold: self.threshold,
        })
    }

    fn sizes(&self, way: usize) -> Sizes {
        let [rows, columns] = self.shape;
        Sizes::new(rows, columns, if way == 0 { self.strips[0] } else { way })
    }
}

impl Kernel for Map {
    type Number = f32;

    fn draw(draw: &mut impl Draw) -> Result<Self, Error> {
        let shape = match draw.byte() {
            0..160 => [64, 64],
            160..240 => draw.one_of(&[[64, 128], [128, 64], [128, 128]]),
            _ => draw.one_of(&[[64, 512], [256, 64], [1024, 64]]),
        };
        let wild = draw.once_in(4);
        let scales = (0..1 + draw.below(3)).map(|_| draw.number(wild, [1.0 / 1024.0, 0.5]));
        let scales = scales.collect();
        let threshold = if draw.flag() {
            0.0
        } else {
            draw.number(wild, [0.0, 30.0]) as f32
        };
        let strips = [(); 2].map(|()| draw.below(66));
        let mut image = draw.samples(shape[0] * shape[1]);
        for pixel in &mut image {
            *pixel = if pixel.abs() > MAX_PIXEL { 0.0 } else { *pixel };
        }
        let map = Map {
            shape,
            scales,
            threshold,
            strips,
            image,
        };
        map.bank(strips[0])?;
        map.bank(strips[1])?;
        Ok(map)
    }

    fn need(&self, _: usize, way: usize) -> [Need; 2] {
        let sizes = self.sizes(way);
        if IN_ONE_MEMORY.contains(&way) {
            return [sizes.map_need(), Need::default()];
        }
        [
            Need::real(sizes.strip_len() + sizes.sums_len()),
            Need::new(sizes.gains_len(), sizes.line_len()),
        ]
    }

    fn numbers(&self) -> usize {
        self.image.len()
    }

    fn run<V: Vector>(
        &self,
        _: V,
        way: usize,
        (mut numbers, vectors): (Scratch<'_>, Scratch<'_, V>),
        out: &mut [f32],
    ) -> Result<(), Error> {
        let (sizes, filters) = (self.sizes(way), LogGabor::fixed());
        let mut done = 0;
        let step = &mut |steps| {
            done += 1;
            assert_eq!(steps, done);
        };
        let tables = |bank: &PhaseSymmetry| {
            GainTables::new(&filters, bank, vec![f32::NAN; bank.gain_tables_len()])
        };
        if IN_ONE_MEMORY.contains(&way) {
            let (bank, image) = (self.bank(1)?, &self.image);
            match way == IN_ONE_MEMORY[0] {
                true => bank.map(&filters, image, numbers, out, step)?,
                false => bank.map(&tables(&bank.by_columns())?, image, numbers, out, step)?,
            }
            assert_eq!(done, bank.map_steps());
        } else {
            let bank = self.bank(sizes.strip)?;
            let mut external = External {
                image: &mut &self.image[..],
                spectrum: &mut &mut vec![f32::NAN; sizes.spectrum_len()][..],
                filtered: &mut &mut vec![f32::NAN; sizes.filtered_len()][..],
                amplitude: &mut &mut vec![f32::NAN; sizes.amplitude_len()][..],
                symmetry: &mut &mut *out,
            };
            let fast = &mut StripSlices {
                strip: numbers.take(Need::real(sizes.strip_len()))?.real,
                sums: numbers.real,
                line: vectors.complex,
                gains: vectors.real,
            };
            let (fft, external) = (&LaneFft::new(), &mut external);
            // The second way has its gains in tables.
            match way {
                0 => bank.run(&Kernels::new(fft, &filters), external, fast, step)?,
                _ => bank.run(&Kernels::new(fft, &tables(&bank)?), external, fast, step)?,
            }
            assert_eq!(done, bank.filters());
        }
        assert!(
            out.iter().all(|value| (0.0..1.0).contains(value)),
            "beyond 0 to 1"
        );
        Ok(())
    }

    fn ways(&self) -> Vec<usize> {
        vec![self.strips[1], IN_ONE_MEMORY[0], IN_ONE_MEMORY[1]]
    }
}
