//! The core's pipeline over threads and the widest vectors: RF or I/Q → lines → image → bone map.

use bonebeam::covariance::Covariance;
use bonebeam::focus::{Delay, Stage};
use bonebeam::pipeline::Pipeline;
use bonebeam::simd::InstructionSet;
use ndarray::{Array2, Array3, ArrayView2, ArrayView3};
use num_complex::Complex;

use super::delay::{Source, align};
use super::{beamform, image, phase_symmetry};
use crate::Result;

/// Frames of a [`Pipeline`]: what the core's `Frame` does line by line in fixed memory, on as many
/// threads as the rayon pool has in which it is made. The bits are the same.
pub struct Frames<'p, D = Delay> {
    pipeline: &'p Pipeline<'p, D>,
    set: InstructionSet,
    beamformer: beamform::Plan,
    bone_map: phase_symmetry::Plan,
    /// [line, sample, element].
    aligned: Array3<Complex<f32>>,
}

impl<'p, D: Stage + Sync> Frames<'p, D> {
    /// Makes threads and memory, once for all frames.
    ///
    /// # Errors
    /// [`Error::Usage`](crate::Error::Usage) where the sizes take more memory than is allowed.
    pub fn new(pipeline: &'p Pipeline<'p, D>, covariance: Covariance) -> Result<Self> {
        Self::with_instruction_set(InstructionSet::detect(), pipeline, covariance)
    }

    /// As [`Frames::new`], with an instruction set of choice: the result does not depend on it.
    ///
    /// # Errors
    /// As [`Frames::new`].
    pub fn with_instruction_set(
        set: InstructionSet,
        pipeline: &'p Pipeline<'p, D>,
        covariance: Covariance,
    ) -> Result<Self> {
        let lines = pipeline.lines();
        let scan = lines.scan();
        let shape = (scan.lines(), scan.samples(), scan.elements());
        let beamformer = *lines.beamformer().parameters();
        let plan = beamform::Plan::new(set, beamformer, covariance, scan.elements())?;
        Ok(Frames {
            pipeline,
            set,
            beamformer: match lines.adaptive() {
                all if all == (0..scan.samples()) => plan,
                adaptive => plan.within(adaptive)?,
            },
            bone_map: phase_symmetry::Plan::of(*pipeline.phase_symmetry())?,
            aligned: Array3::zeros(shape),
        })
    }

    /// The aligned samples of a frame, [line, sample, element].
    ///
    /// # Errors
    /// What the core refuses.
    pub fn align<'r>(
        &mut self,
        source: Source<'r, D::Record<'r>>,
    ) -> Result<ArrayView3<'_, Complex<f32>>> {
        let lines = 0..self.aligned.dim().0;
        let x = self.aligned.as_slice_mut().unwrap_or_default();
        align(self.set, self.pipeline.lines(), lines, source, x)?;
        Ok(self.aligned.view())
    }

    /// Lines of aligned samples `x`, as [line, sample].
    ///
    /// # Errors
    /// A sample that is NaN or infinite.
    pub fn lines(&self, x: ArrayView3<'_, Complex<f32>>) -> Result<Array2<Complex<f32>>> {
        let scan = self.pipeline.lines().scan();
        let active = |line: usize, sample: usize| scan.active(line, sample);
        self.beamformer.run(x, active, |_| {})
    }

    /// The image of lines `z`, 0..255, [row, column].
    ///
    /// # Errors
    /// A sample that is NaN or infinite.
    pub fn image(&self, z: ArrayView2<'_, Complex<f32>>) -> Result<Array2<f32>> {
        image::pixels(self.set, self.pipeline.b_mode(), z)
    }

    /// The phase symmetry of an image, in `[0, 1)`, [row, column].
    ///
    /// # Errors
    /// A pixel that is NaN, infinite or beyond 1e12.
    pub fn bone_map(&mut self, image: ArrayView2<'_, f32>) -> Result<Array2<f32>> {
        self.bone_map.run(image, self.set, |_, _| {})
    }

    /// All of it, from RF or I/Q to the bone map.
    ///
    /// # Errors
    /// As the steps.
    pub fn run<'r>(&mut self, source: Source<'r, D::Record<'r>>) -> Result<Array2<f32>> {
        self.align(source)?;
        let z = self.lines(self.aligned.view())?;
        let image = self.image(z.view())?;
        self.bone_map(image.view())
    }
}
