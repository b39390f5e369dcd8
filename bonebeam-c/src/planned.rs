//! A core's frame in the caller's bytes, over the processor's vectors.
//!
//! With one lane it is the core's own frame. The image has no vectors: they save no instruction there.

use crate::frame_parameters::FrameParameters;
use crate::image::product;
use crate::memory::{Bytes, Output, bytes_of, sum};
use crate::status::Status;
use crate::vectors::{LANES, V, zero};
use crate::workspace::{Workspace, scratch, workspace_bytes};
use crate::{Complex, scan};
use bonebeam::beamform::ShortLagCoherence;
#[cfg(feature = "forward")]
use bonebeam::covariance::Forward;
use bonebeam::covariance::{Averaging, Covariance};
use bonebeam::delay::Stage;
use bonebeam::image::Pooling;
use bonebeam::memory::Scratch;
use bonebeam::phase_symmetry::{GainTables, Kernels, LaneFft, LogGabor, Sizes, StripSlices};
use bonebeam::surface::{Detector, Point};
use bonebeam::{Error, Frame, Parameters, Pipeline, beamform};

/// A core's frame and its pipeline.
pub(crate) struct Planned<D: Stage + 'static> {
    pub(crate) pipeline: &'static Pipeline<'static, D>,
    frame: Averaged<D>,
    over: Option<&'static mut Over>,
}

enum Averaged<D: Stage + 'static> {
    #[cfg(feature = "forward")]
    Forward(Frame<'static, 'static, D, Forward>),
    ForwardBackward(Frame<'static, 'static, D>),
}

/// Memory of vectors, beside the frame's own.
pub(crate) struct Over {
    workspace: Workspace,
    fft: &'static LaneFft,
    strips: StripSlices<'static, V>,
    gains: Option<GainTables<&'static mut [f32]>>,
}

/// Evaluates an expression of the core's frame.
macro_rules! with_frame {
    ($averaged:expr, $frame:ident => $work:expr) => {
        match $averaged {
            #[cfg(feature = "forward")]
            Averaged::Forward($frame) => $work,
            Averaged::ForwardBackward($frame) => $work,
        }
    };
}

impl<D: Stage> Planned<D> {
    /// A frame of `pipeline` in `bytes`.
    pub(crate) fn new(
        pipeline: Pipeline<'static, D>,
        parameters: &FrameParameters,
        core: &Parameters<'_>,
        bytes: &mut Bytes,
    ) -> Result<Self, Status> {
        let covariance = parameters.beamformer.covariance()?;
        let pipeline = match parameters.scan.gate() {
            None => pipeline,
            Some(gate) => pipeline.with_gate(gate)?,
        };
        let pipeline: &'static _ = bytes.copy(&pipeline)?;
        let scratch = scratch(bytes, pipeline.need_over(LANES, covariance))?;
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
                let over = Over::new(bytes, sizes, covariance, bank.sizes(), gains)?;
                (Some(bytes.copy(&over)?), None)
            }
        };
        let coherence = match parameters.coherence(core)? {
            None => None,
            Some(of) => Some((of, bytes.fill(pipeline.coherence_len(of), 0.0)?)),
        };
        let options = Options {
            tables,
            coherence,
            pooling: match parameters.pool_by_rms {
                0 => Pooling::Largest,
                _ => Pooling::Rms,
            },
        };
        let frame = match covariance {
            #[cfg(feature = "forward")]
            Covariance::Forward => Averaged::Forward(frame(pipeline, scratch, options)?),
            #[cfg(not(feature = "forward"))]
            Covariance::Forward => return Err(Status::Parameter),
            Covariance::ForwardBackward => {
                Averaged::ForwardBackward(frame(pipeline, scratch, options)?)
            }
        };
        Ok(Planned {
            pipeline,
            frame,
            over,
        })
    }

    /// A line's numbers, or none for a null pointer.
    pub(crate) fn output(&self, z: *mut Complex) -> Result<Output<bonebeam::Complex<f32>>, Status> {
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
        records: &'r scan::Transmits<'r, D::Record<'r>>,
        z: &mut [bonebeam::Complex<f32>],
    ) -> Result<(), Status> {
        let waves = scan::each(records);
        let workspace = self.over.as_mut().map(|over| &mut over.workspace);
        let line = match (&mut self.frame, workspace) {
            #[cfg(feature = "forward")]
            (Averaged::Forward(frame), Some(Workspace::Forward(by))) if LANES > 1 => {
                frame.line_over(by, index, waves)?
            }
            (Averaged::ForwardBackward(frame), Some(Workspace::ForwardBackward(by)))
                if LANES > 1 =>
            {
                frame.line_over(by, index, waves)?
            }
            (frame, _) => with_frame!(frame, frame => frame.line(index, waves)?),
        };
        for (z, line) in z.iter_mut().zip(line) {
            *z = *line;
        }
        Ok(())
    }

    pub(crate) fn image(&mut self, progress: &mut dyn FnMut(usize)) -> Result<&[f32], Status> {
        Ok(with_frame!(&mut self.frame, frame => frame.image_in_steps(progress)?))
    }

    pub(crate) fn map(&mut self, progress: &mut dyn FnMut(usize)) -> Result<&[f32], Status> {
        let (frame, over) = match &mut self.over {
            Some(over) if LANES > 1 => (&mut self.frame, over),
            _ => {
                let map = with_frame!(&mut self.frame, frame => frame.bone_map_in_steps(progress)?);
                return Ok(map);
            }
        };
        let (fft, strips) = (over.fft, &mut over.strips);
        let map = match &over.gains {
            Some(gains) => {
                let kernels = &Kernels { fft, gains };
                with_frame!(frame, frame => frame.bone_map_over(kernels, strips, progress)?)
            }
            None => {
                let gains = &LogGabor::fixed();
                let kernels = &Kernels { fft, gains };
                with_frame!(frame, frame => frame.bone_map_over(kernels, strips, progress)?)
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
        with_frame!(&mut self.frame, frame => frame.surface(detector, memory, points))
    }
}

/// What a frame has besides.
struct Options {
    /// Memory of gains in tables.
    tables: Option<&'static mut [f32]>,
    /// The coherence and its memory.
    coherence: Option<(ShortLagCoherence, &'static mut [f32])>,
    pooling: Pooling,
}

/// The core's frame with its options.
fn frame<D: Stage, A: Averaging<f32>>(
    pipeline: &'static Pipeline<'static, D>,
    scratch: Scratch<'static>,
    options: Options,
) -> Result<Frame<'static, 'static, D, A>, Error> {
    let frame = Frame::with_averaging(pipeline, scratch)?.with_pooling(options.pooling);
    let frame = match options.coherence {
        None => frame,
        Some((coherence, memory)) => frame.with_coherence(coherence, memory)?,
    };
    match options.tables {
        None => Ok(frame),
        Some(tables) => frame.with_gain_tables(tables),
    }
}

impl Over {
    fn new(
        bytes: &mut Bytes,
        beamformer: beamform::Sizes,
        covariance: Covariance,
        image: Sizes,
        gains: Option<GainTables<&'static mut [f32]>>,
    ) -> Result<Self, Status> {
        let lanes = bonebeam::Complex::new(zero(), zero());
        Ok(Over {
            workspace: Workspace::new(bytes, beamformer, covariance)?,
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
    pub(crate) fn bytes(
        beamformer: beamform::Sizes,
        covariance: Covariance,
        image: Sizes,
    ) -> usize {
        if LANES == 1 {
            return 0;
        }
        sum(&[
            workspace_bytes(beamformer.need(covariance)),
            bytes_of::<LaneFft>(1),
            bytes_of::<Over>(1),
            bytes_of::<f32>(image.strip_len()),
            bytes_of::<f32>(image.sums_len()),
            bytes_of::<bonebeam::Complex<V>>(image.line_len()),
            bytes_of::<V>(image.gains_len()),
        ])
    }
}
