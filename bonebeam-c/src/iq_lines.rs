//! Lines of I/Q by the core's pipeline, aligned and beamformed in blocks.

use crate::Complex;
use crate::beamformer::BeamformParameters;
use crate::memory::{Output, bytes_of, new, one, one_mut, sum};
use crate::scan::{IqWave, Scan, each};
use crate::status::{Status, status};
use crate::workspace::{Workspace, need_bytes, scratch, with_view};
use bonebeam::beamform::Sizes;
use bonebeam::delay::IqDelay;
use bonebeam::geometry;
use bonebeam::memory::{Need, Scratch};
use bonebeam::pipeline::LinePipeline;
use core::ffi::c_void;

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

impl Plan {
    /// # Safety
    /// As [`BeamformParameters::core`].
    unsafe fn new(scan: &Scan, beamformer: &BeamformParameters) -> Result<Plan, Status> {
        // The frequency only serves to choose an interpolation, which the caller gives.
        let core = geometry::Scan::of_iq(scan.core(1.0)?)?;
        scan.check(core.samples())?;
        // SAFETY: by the caller's promise.
        let beamformer = unsafe { beamformer.core()? };
        let mut pipeline = LinePipeline::of_iq(core, scan.delay.iq_input()?, beamformer)?;
        if let Some(gate) = scan.gate() {
            pipeline = pipeline.with_gate(gate)?;
        }
        // A deeper set contains the shallower ones.
        let deepest = pipeline.adaptive().end.saturating_sub(1);
        let count = |line| pipeline.scan().active(line, deepest).count;
        let elements = (0..core.lines()).map(count).max().unwrap_or(0);
        Ok(Plan {
            need: pipeline.need(1, scan.block),
            sizes: pipeline.beamformer().sizes(elements),
            pipeline,
        })
    }
}

/// Returns the bytes of the lines of a scan of I/Q.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_iq_lines_bytes(
    scan: *const Scan,
    beamformer: *const BeamformParameters,
) -> usize {
    // SAFETY: by the caller's promise.
    let bytes = || unsafe {
        let (scan, beamformer) = (one(scan)?, one(beamformer)?);
        let plan = Plan::new(scan, beamformer)?;
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
    scan: *const Scan,
    beamformer: *const BeamformParameters,
    lines: *mut *mut IqLines,
) -> Status {
    // SAFETY: by the caller's promise.
    unsafe {
        new(memory, bytes, lines, |bytes| {
            let (scan, beamformer) = (one(scan)?, one(beamformer)?);
            let plan = Plan::new(scan, beamformer)?;
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
        let own = one_mut(lines)?;
        let z = Output::complex(z, own.pipeline.line_samples())?;
        let records = IqWave::core(waves, count, own.pipeline.delay().parameters(), &z)?;
        let waves = each(&records);
        let scratch = own.scratch.reborrow();
        let (pipeline, z) = (&own.pipeline, z.values());
        with_view!(&mut own.workspace, view => pipeline.line(index, waves, scratch, view, z)?);
        Ok(())
    })
}
