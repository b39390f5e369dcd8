//! The core's pipeline on threads and the widest vectors.
//!
//! RF or I/Q → lines → image → bone map.

use bonebeam::delay::Stage;
use bonebeam::geometry::Scan;
use bonebeam::image::{BMode, DepthInterpolation, Pooling};
use bonebeam::pipeline::Pipeline;
use bonebeam::simd::InstructionSet;
use bonebeam_kernels::source::LineSource;
use ndarray::{Array2, ArrayView2};
use num_complex::Complex;

use super::beamform::{Plan, Tile};
use super::{image, phase_symmetry};
use crate::Result;

/// Frames of a [`Pipeline`], with the bits of the core's `Frame`.
///
/// The core's `Frame` works line by line in fixed memory. This one uses all threads of the rayon pool in which it
/// is called.
pub struct Frames<'p> {
    set: InstructionSet,
    scan: Scan<'p>,
    interpolation: &'p DepthInterpolation,
    b_mode: &'p BMode,
    beamformer: Plan,
    tiles: Vec<Tile>,
    pooling: Pooling,
    bone_map: phase_symmetry::Plan,
}

impl<'p> Frames<'p> {
    /// Makes tables and memory once for all frames.
    ///
    /// # Errors
    /// [`Error::Usage`](crate::Error::Usage) if the sizes need more memory than is allowed.
    pub fn new<D: Stage>(pipeline: &'p Pipeline<'p, D>) -> Result<Self> {
        Self::with_instruction_set(InstructionSet::detect(), pipeline)
    }

    /// As [`Frames::new`], with a given instruction set; the result is the same.
    ///
    /// # Errors
    /// As [`Frames::new`].
    pub fn with_instruction_set<D: Stage>(
        set: InstructionSet,
        pipeline: &'p Pipeline<'p, D>,
    ) -> Result<Self> {
        let (lines, scan) = (pipeline.lines(), *pipeline.lines().scan());
        let parameters = *lines.beamformer().parameters();
        let beamformer = Plan::new(set, parameters, scan.elements())?;
        let beamformer = beamformer
            .within(lines.adaptive())
            .steered(&scan, 0..scan.lines())?;
        let centres: Vec<f64> = (0..scan.lines())
            .map(|line| scan.aperture_centre(line))
            .collect();
        let active = |line: usize, sample: usize| scan.active_at(centres[line], sample);
        let shape = (scan.samples(), scan.elements());
        let tiles = beamformer.tiles_of_lines(0..scan.lines(), shape, &active)?;
        Ok(Frames {
            set,
            scan,
            interpolation: pipeline.interpolation(),
            b_mode: pipeline.b_mode(),
            beamformer,
            tiles,
            pooling: Pooling::default(),
            bone_map: phase_symmetry::Plan::of(*pipeline.phase_symmetry())?,
        })
    }

    /// The same frames, with the envelope of the sub-lines by `pooling`.
    ///
    /// The default is the largest.
    pub fn with_pooling(self, pooling: Pooling) -> Self {
        Frames { pooling, ..self }
    }

    /// Lines of a frame, as [line, computed sample].
    ///
    /// With sub-lines, all of the first line come first, then those of the next.
    pub fn lines(&self, source: &LineSource<'_>) -> Result<Array2<Complex<f32>>> {
        let lines = self.scan.lines() * self.beamformer.sub_lines();
        let mut z = Array2::zeros((lines, self.interpolation.line_samples()));
        let tiles = &self.tiles;
        self.beamformer
            .run_source(tiles, source, &|_| {}, z.view_mut(), None)?;
        Ok(z)
    }

    /// Aligns the samples of a frame and does nothing else, to measure that part.
    ///
    /// Each tile overwrites the one before.
    pub fn align(&self, source: &LineSource<'_>) -> Result<()> {
        self.beamformer.align(&self.tiles, source)
    }

    /// The image of lines `z`, 0..255, [row, column].
    ///
    /// # Errors
    /// A sample that is NaN or infinite.
    pub fn image(&self, z: ArrayView2<'_, Complex<f32>>) -> Result<Array2<f32>> {
        match (self.beamformer.sub_lines(), self.interpolation.depth_step()) {
            (1, 1) => image::pixels(self.set, self.b_mode, z),
            (count, _) => {
                let pooling = (count, self.pooling);
                let lines = image::pooled_lines(z, pooling, self.interpolation)?;
                image::pixels(self.set, self.b_mode, lines.view())
            }
        }
    }

    /// The phase symmetry of an image, in `[0, 1)`, [row, column].
    ///
    /// # Errors
    /// A pixel that is NaN, infinite or beyond 1e12.
    pub fn bone_map(&mut self, image: ArrayView2<'_, f32>) -> Result<Array2<f32>> {
        self.bone_map.run(image, self.set, &mut |_, _| {})
    }

    /// All steps, from RF or I/Q to the bone map.
    ///
    /// # Errors
    /// As the steps.
    pub fn run(&mut self, source: &LineSource<'_>) -> Result<Array2<f32>> {
        let z = self.lines(source)?;
        let image = self.image(z.view())?;
        self.bone_map(image.view())
    }
}
