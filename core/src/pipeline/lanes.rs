//! The bone map of a frame by vectors; `frame.rs` has the lines.

use super::Frame;
use crate::Error;
use crate::delay::Stage;
use crate::phase_symmetry::{External, Fft, Gains, Kernels, ReadAt, StripSlices, WriteAt};
use crate::simd::{Vector, split_front};

impl<D: Stage> Frame<'_, '_, D> {
    /// [`Frame::bone_map`] by vectors, with the same pixels.
    ///
    /// `kernels` has the transform of vectors ([`LaneFft`]) and gains for [`Pipeline::phase_symmetry`], `memory` the
    /// strips of [`PhaseSymmetry::sizes`]; both are separate from the frame's memory. A strip as high as the image
    /// takes the fewest instructions. `progress` is that of [`PhaseSymmetry::run`].
    ///
    /// # Errors
    /// [`Error::Capacity`] for strips of another size, and [`Error::Parameter`] for gains of another bank.
    ///
    /// [`LaneFft`]: crate::phase_symmetry::LaneFft
    /// [`Pipeline::phase_symmetry`]: super::Pipeline::phase_symmetry
    /// [`PhaseSymmetry::sizes`]: crate::phase_symmetry::PhaseSymmetry::sizes
    /// [`PhaseSymmetry::run`]: crate::phase_symmetry::PhaseSymmetry::run
    pub fn bone_map_over<V: Vector, F: Fft<V>, G: Gains<V>>(
        &mut self,
        kernels: &Kernels<'_, F, G>,
        memory: &mut StripSlices<'_, V>,
        progress: &mut dyn FnMut(usize),
    ) -> Result<&mut [f32], Error> {
        let bank = self.pipeline.phase_symmetry();
        let sizes = bank.sizes();
        let mut real = &mut *self.scratch.real;
        let lengths = [
            sizes.spectrum_len(),
            sizes.filtered_len(),
            sizes.amplitude_len(),
        ];
        let [spectrum, filtered, amplitude] = lengths.map(|length| split_front(&mut real, length));
        let mut external = External {
            image: &mut Fast(self.image),
            spectrum: &mut Fast(spectrum),
            filtered: &mut Fast(filtered),
            amplitude: &mut Fast(amplitude),
            symmetry: &mut Fast(self.map),
        };
        bank.run(kernels, &mut external, memory, progress)?;
        Ok(self.map)
    }
}

/// The frame's memory, from which nothing need be copied.
struct Fast<'a>(&'a mut [f32]);

impl ReadAt for Fast<'_> {
    fn read_at(&mut self, first: usize, into: &mut [f32]) -> Result<(), Error> {
        self.0.read_at(first, into)
    }

    fn view(&self, first: usize, length: usize) -> Option<&[f32]> {
        self.0.get(first..)?.get(..length)
    }
}

impl WriteAt for Fast<'_> {
    fn write_at(&mut self, first: usize, from: &[f32]) -> Result<(), Error> {
        self.0.write_at(first, from)
    }

    fn view_mut(&mut self, first: usize, length: usize) -> Option<&mut [f32]> {
        self.0.get_mut(first..)?.get_mut(..length)
    }
}
