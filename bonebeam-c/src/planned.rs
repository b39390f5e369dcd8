//! A core's frame in the caller's bytes, over the processor's vectors.
//!
//! With one lane it is the core's own frame. The image has no vectors: they save no instruction there.

use crate::frame_parameters::FrameParameters;
use crate::image::product;
use crate::memory::{Bytes, Output, bytes_of, sum};
use crate::status::Refused;
use crate::vectors::{LANES, V, zero};
use crate::workspace::{scratch, workspace, workspace_bytes};
use crate::{Complex, scan};
use bonebeam::beamform::Workspace;
use bonebeam::delay::Stage;
use bonebeam::image::Pooling;
use bonebeam::memory::Scratch;
use bonebeam::phase_symmetry::{GainTables, Kernels, LaneFft, LogGabor, Sizes, StripSlices};
use bonebeam::surface::{Detector, Point};
use bonebeam::{Error, Frame, Parameters, Pipeline, beamform};

/// A core's frame and its pipeline.
pub(crate) struct Planned<D: Stage + 'static> {
    pub(crate) pipeline: &'static Pipeline<'static, D>,
    frame: Frame<'static, 'static, D>,
    over: Option<&'static mut Over>,
}

/// Memory of vectors, beside the frame's own.
pub(crate) struct Over {
    workspace: Workspace<'static, V>,
    fft: &'static LaneFft,
    strips: StripSlices<'static, V>,
    gains: Option<GainTables<&'static mut [f32]>>,
}

impl<D: Stage> Planned<D> {
    /// A frame of `pipeline` in `bytes`.
    pub(crate) fn new(
        pipeline: Pipeline<'static, D>,
        parameters: &FrameParameters,
        core: &Parameters<'_>,
        bytes: &mut Bytes,
    ) -> Result<Self, Refused> {
        let pipeline = match parameters.scan.gate() {
            None => pipeline,
            Some(gate) => pipeline.with_gate(gate)?,
        };
        let pipeline = match pipeline.lines().directions_len() {
            0 => pipeline,
            length => {
                let memory = bytes.fill(length, bonebeam::Complex::ZERO)?;
                pipeline.lines().directions(memory)?;
                pipeline.with_directions(memory)?
            }
        };
        let pipeline: &'static _ = bytes.copy(&pipeline)?;
        let scratch = scratch(bytes, pipeline.need(LANES))?;
        let bank = pipeline.phase_symmetry();
        let tables = match parameters.gain_tables {
            0 => None,
            _ => Some(bytes.fill(bank.gain_tables_len(), 0.0)?),
        };
        let (over, tables) = match LANES {
            1 => (None, tables),
            _ => {
                let lines = pipeline.lines();
                let sizes = lines.beamformer().sizes(lines.scan().elements());
                let gains = match tables {
                    None => None,
                    Some(tables) => Some(GainTables::new(&LogGabor::fixed(), bank, tables)?),
                };
                let over = Over::new(bytes, sizes, bank.sizes(), gains)?;
                (Some(bytes.copy(&over)?), None)
            }
        };
        let coherence = match parameters.coherence(core)? {
            None => None,
            Some(of) => Some((of, bytes.fill(pipeline.coherence_len(of), 0.0)?)),
        };
        let frame = Frame::new(pipeline, scratch)?.with_pooling(match parameters.pool_by_rms {
            0 => Pooling::Largest,
            _ => Pooling::Rms,
        });
        let frame = match coherence {
            None => frame,
            Some((coherence, memory)) => frame.with_coherence(coherence, memory)?,
        };
        let frame = match tables {
            None => frame,
            Some(tables) => frame.with_gain_tables(tables)?,
        };
        Ok(Planned {
            pipeline,
            frame,
            over,
        })
    }

    /// A line's numbers, or none for a null pointer.
    pub(crate) fn output(
        &self,
        z: *mut Complex,
    ) -> Result<Output<bonebeam::Complex<f32>>, Refused> {
        let lines = self.pipeline.lines();
        match z.is_null() {
            true => Ok(Output::none()),
            false => {
                let sub_lines = lines.beamformer().parameters().sub_lines;
                Output::complex(z, product(lines.line_samples(), sub_lines)?)
            }
        }
    }

    pub(crate) fn line<'r>(
        &mut self,
        index: usize,
        records: &'r scan::Transmits<'r>,
        z: &mut [bonebeam::Complex<f32>],
    ) -> Result<(), Refused> {
        let waves = scan::each(records);
        let line = match &mut self.over {
            Some(over) if LANES > 1 => self.frame.line_over(&mut over.workspace, index, waves)?,
            _ => self.frame.line(index, waves)?,
        };
        for (z, line) in z.iter_mut().zip(line) {
            *z = *line;
        }
        Ok(())
    }

    pub(crate) fn image(&mut self, progress: &mut dyn FnMut(usize)) -> Result<&[f32], Refused> {
        Ok(self.frame.image_in_steps(progress)?)
    }

    pub(crate) fn map(&mut self, progress: &mut dyn FnMut(usize)) -> Result<&[f32], Refused> {
        let over = match &mut self.over {
            Some(over) if LANES > 1 => over,
            _ => return Ok(self.frame.bone_map_in_steps(progress)?),
        };
        let (fft, strips) = (over.fft, &mut over.strips);
        let map = match &over.gains {
            Some(gains) => {
                let kernels = &Kernels::new(fft, gains);
                self.frame.bone_map_over(kernels, strips, progress)?
            }
            None => {
                let gains = &LogGabor::fixed();
                let kernels = &Kernels::new(fft, gains);
                self.frame.bone_map_over(kernels, strips, progress)?
            }
        };
        Ok(map)
    }

    pub(crate) fn surface(
        &mut self,
        detector: &Detector,
        memory: Scratch<'_>,
        points: &mut [Option<Point>],
    ) -> Result<(), Error> {
        self.frame.surface(detector, memory, points)
    }
}

impl Over {
    fn new(
        bytes: &mut Bytes,
        beamformer: beamform::Sizes,
        image: Sizes,
        gains: Option<GainTables<&'static mut [f32]>>,
    ) -> Result<Self, Refused> {
        let lanes = bonebeam::Complex::new(zero(), zero());
        Ok(Over {
            workspace: workspace(bytes, beamformer)?,
            fft: bytes.copy(&LaneFft::new())?,
            strips: StripSlices {
                strip: bytes.fill(image.strip_len(), 0.0)?,
                sums: bytes.fill(image.sums_len(), 0.0)?,
                line: bytes.fill(image.line_len(), lanes)?,
                gains: bytes.fill(image.gains_len(), zero())?,
            },
            gains,
        })
    }

    /// Bytes of vectors' memory, without the gains in tables.
    pub(crate) fn bytes(beamformer: beamform::Sizes, image: Sizes) -> usize {
        if LANES == 1 {
            return 0;
        }
        sum(&[
            workspace_bytes(beamformer.need()),
            bytes_of::<LaneFft>(1),
            bytes_of::<Over>(1),
            bytes_of::<f32>(image.strip_len()),
            bytes_of::<f32>(image.sums_len()),
            bytes_of::<bonebeam::Complex<V>>(image.line_len()),
            bytes_of::<V>(image.gains_len()),
        ])
    }
}
