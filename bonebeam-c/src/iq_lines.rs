//! Lines of I/Q by the core's pipeline, aligned and beamformed in blocks.

use crate::beamformer::{ApertureShape, BeamformParameters};
use crate::delay::DelayParameters;
use crate::iq::IqRecord;
use crate::memory::{Output, array, bytes_of, new, one, one_mut, sum};
use crate::scan_line::Wave;
use crate::status::{Status, status};
use crate::workspace::{Workspace, need_bytes, scratch, with_view};
use crate::{Axis, Complex};
use bonebeam::beamform::Sizes;
use bonebeam::delay::IqDelay;
use bonebeam::geometry::{Array, Depth, Lines, Scan, ScanParameters};
use bonebeam::memory::{Need, Scratch};
use bonebeam::pipeline::{DepthGate, IqInput, LinePipeline};
use core::ffi::c_void;

/// Maximum number of transmits compounded in a line.
pub const BONEBEAM_IQ_WAVES: usize = 16;

/// A scan of I/Q by a linear array that is centred on 0. SI units.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct IqScan {
    /// The delay stage.
    pub delay: DelayParameters,
    /// The receive aperture, with the same number of elements.
    pub aperture: ApertureShape,
    /// Lateral positions of the lines, which go straight down.
    pub lines: Axis,
    /// Least depth of the depth gate, m; 0 for both depths means no gate.
    pub gate_from: f64,
    /// Greatest depth of the depth gate, m. Samples outside the gate are DAS.
    pub gate_to: f64,
    /// Number of output samples in a block of alignment and beamforming.
    ///
    /// It changes memory and time, never a line.
    pub block: usize,
}

/// One transmit of a scan of I/Q.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct IqWave {
    /// The transmitted wave.
    pub wave: Wave,
    /// Its record.
    pub record: IqRecord,
}

/// The lines of a scan of I/Q: delay stage, apertures and beamformer.
pub struct IqLines {
    pipeline: LinePipeline<'static, IqDelay>,
    scratch: Scratch<'static>,
    workspace: Workspace,
}

/// A pipeline and the sizes of its memory.
struct Plan {
    pipeline: LinePipeline<'static, IqDelay>,
    need: Need,
    sizes: Sizes,
}

impl IqScan {
    /// # Safety
    /// As [`BeamformParameters::core`].
    unsafe fn plan(&self, beamformer: &BeamformParameters) -> Result<Plan, Status> {
        let delay = self.delay.iq()?;
        if self.aperture.elements != delay.elements {
            return Err(Status::Parameter);
        }
        // Half a sample behind the last one, so that rounding does not exclude it.
        let duration = (delay.output_samples as f64 - 0.5) / delay.output_rate;
        let scan = Scan::of_iq(ScanParameters {
            array: Array::linear(delay.elements, self.aperture.pitch),
            lines: Lines::Even(self.lines.core()),
            sound_speed: delay.sound_speed,
            // The frequency only serves to choose an interpolation, which the caller gives.
            centre_frequency: 1.0,
            sampling_rate: delay.sampling_rate,
            record_samples: delay.record_samples,
            output_rate: delay.output_rate,
            start: Depth::Seconds(delay.output_start),
            end: Depth::Seconds(delay.output_start + duration),
            f_number: self.aperture.f_number,
            min_elements: self.aperture.min_elements,
        })?;
        // The caller's array for a line has `output_samples` numbers.
        if scan.samples() != delay.output_samples {
            return Err(Status::Parameter);
        }
        let input = IqInput {
            demodulation_frequency: delay.demodulation_frequency,
            interpolation: Some(delay.interpolation),
        };
        // SAFETY: by the caller's promise.
        let beamformer = unsafe { beamformer.core()? };
        let mut pipeline = LinePipeline::of_iq(scan, input, beamformer)?;
        let gate = (self.gate_from, self.gate_to);
        if gate != (0.0, 0.0) {
            let (from, to) = gate;
            pipeline = pipeline.with_gate(DepthGate { from, to })?;
        }
        // A deeper set contains the shallower ones.
        let deepest = pipeline.adaptive().end.saturating_sub(1);
        let count = |line| pipeline.scan().active(line, deepest).count;
        let elements = (0..scan.lines()).map(count).max().unwrap_or(0);
        Ok(Plan {
            need: pipeline.need(1, self.block),
            sizes: pipeline.beamformer().sizes(elements),
            pipeline,
        })
    }
}

/// Returns the bytes of the lines of a scan of I/Q.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_iq_lines_bytes(
    scan: *const IqScan,
    beamformer: *const BeamformParameters,
) -> usize {
    // SAFETY: by the caller's promise.
    let bytes = || unsafe {
        let (scan, beamformer) = (one(scan)?, one(beamformer)?);
        let plan = scan.plan(beamformer)?;
        Ok::<_, Status>(sum(&[
            bytes_of::<IqLines>(1),
            need_bytes(plan.need),
            need_bytes(plan.sizes.need(beamformer.covariance()?)),
        ]))
    };
    bytes().unwrap_or(0)
}

/// Places the lines of a scan of I/Q in `memory`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_iq_lines_new(
    memory: *mut c_void,
    bytes: usize,
    scan: *const IqScan,
    beamformer: *const BeamformParameters,
    lines: *mut *mut IqLines,
) -> Status {
    // SAFETY: by the caller's promise.
    unsafe {
        new(memory, bytes, lines, |bytes| {
            let (scan, beamformer) = (one(scan)?, one(beamformer)?);
            let plan = scan.plan(beamformer)?;
            Ok(IqLines {
                pipeline: plan.pipeline,
                scratch: scratch(bytes, plan.need)?,
                workspace: Workspace::new(bytes, plan.sizes, beamformer.covariance()?)?,
            })
        })
    }
}

/// Computes line `index`, the mean over `count` transmits.
///
/// `z` has `output_samples` numbers; with a `depth_step`, their number over the step, rounded up. An error may
/// leave them changed in part.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_iq_lines_line(
    lines: *mut IqLines,
    index: usize,
    waves: *const IqWave,
    count: usize,
    z: *mut Complex,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        let (own, waves) = (one_mut(lines)?, array(waves, count)?);
        if count > BONEBEAM_IQ_WAVES {
            return Err(Status::Capacity);
        }
        let p = own.pipeline.delay().parameters();
        let z = Output::complex(z, own.pipeline.line_samples())?;
        let mut records = [const { None }; BONEBEAM_IQ_WAVES];
        for (slot, wave) in records.iter_mut().zip(waves) {
            *slot = Some((wave.wave.core(p.elements)?, wave.record.core(p, &z)?));
        }
        let waves = records.iter().flatten();
        let waves = waves.map(|(transmit, record)| (*transmit, record));
        let scratch = own.scratch.reborrow();
        let (pipeline, z) = (&own.pipeline, z.values());
        with_view!(&mut own.workspace, view => pipeline.line(index, waves, scratch, view, z)?);
        Ok(())
    })
}
