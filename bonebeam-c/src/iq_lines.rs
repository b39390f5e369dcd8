//! Lines of I/Q by the core's pipeline, aligned and beamformed in blocks.

use crate::beamformer::BeamformParameters;
use crate::image::product;
use crate::memory::{Output, bytes_of, new, one, one_mut, possible, sum};
use crate::scan::{IqWave, Scan, each};
use crate::status::{Refused, Status, status};
use crate::vectors::{LANES, V};
use crate::workspace::{need_bytes, scratch, workspace, workspace_bytes};
use crate::{Complex, SUB_LINES};
use bonebeam::beamform::{Sizes, Workspace};
use bonebeam::delay::IqDelay;
use bonebeam::geometry::{self, SteeringTable};
use bonebeam::memory::{Need, Scratch};
use bonebeam::pipeline::LinePipeline;
use core::ffi::c_void;

/// The lines of a scan of I/Q: delay stage, apertures and beamformer.
pub struct IqLines {
    pipeline: LinePipeline<'static, IqDelay>,
    scratch: Scratch<'static>,
    workspace: Workspace<'static, V>,
    /// Directions of sub-lines, if there are any.
    steering: Option<SteeringTable<'static>>,
}

/// A pipeline and the sizes of its memory.
struct Plan {
    pipeline: LinePipeline<'static, IqDelay>,
    need: Need,
    sizes: Sizes,
    /// Complex numbers of the directions of all sub-lines, if there are any.
    directions: usize,
}

impl Plan {
    fn directions_bytes(&self) -> usize {
        bytes_of::<bonebeam::Complex<f32>>(self.directions)
    }

    /// # Safety
    /// As [`BeamformParameters::core`].
    unsafe fn new(scan: &Scan, beamformer: &BeamformParameters) -> Result<Plan, Refused> {
        let core = geometry::Scan::of_iq(scan.core_of_iq()?)?;
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
            directions: pipeline.directions_len(),
            need: pipeline.need(LANES, scan.block),
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
        possible(sum(&[
            bytes_of::<IqLines>(1),
            need_bytes(plan.need),
            workspace_bytes(plan.sizes.need()),
            plan.directions_bytes(),
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
            let steering = match plan.directions {
                length if length == 0 || !SUB_LINES => None,
                length => {
                    let memory = bytes.fill(length, bonebeam::Complex::ZERO)?;
                    Some(plan.pipeline.directions(memory)?)
                }
            };
            Ok(IqLines {
                steering,
                pipeline: plan.pipeline,
                scratch: scratch(bytes, plan.need)?,
                workspace: workspace(bytes, plan.sizes)?,
            })
        })
    }
}

/// Computes line `index`, the mean over `count` transmits.
///
/// `z` has `output_samples` numbers; with a `depth_step`, that number divided by the step, rounded up. With sub-lines
/// it has as many for each sub-line, `[sample][sub-line]`. An error may leave `z` partly changed.
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
        let sub_lines = own.pipeline.beamformer().parameters().sub_lines;
        let z = Output::complex(z, product(own.pipeline.line_samples(), sub_lines)?)?;
        let records = IqWave::core(waves, count, own.pipeline.delay().parameters(), &z)?;
        let waves = each(&records);
        let scratch = own.scratch.reborrow();
        let (pipeline, workspace, z) = (&own.pipeline, &mut own.workspace, z.values());
        match own.steering.as_ref().filter(|_| SUB_LINES) {
            None => pipeline.line(index, waves, scratch, workspace, z)?,
            Some(table) => {
                let output = (table.line(index).ok_or(Refused::Of(Status::Capacity))?, z);
                pipeline.sub_lines(index, waves, scratch, workspace, output)?;
            }
        }
        Ok(())
    })
}
