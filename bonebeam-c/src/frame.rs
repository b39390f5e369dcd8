//! A frame: channel data to lines, image, bone map and surface, in one object.

use crate::delay::ANY;
use crate::frame_parameters::FrameParameters;
use crate::memory::{Bytes, Output, bytes_of, new, one, one_mut, possible, sum};
use crate::planned::{Over, Planned};
use crate::scan::{IqWave, RfWave};
use crate::status::{Refusal, Refused, Status, status};
use crate::vectors::LANES;
use crate::workspace::{need_bytes, scratch};
use crate::{Axis, Complex};
use bonebeam::delay::{Delay, IqDelay};
use bonebeam::memory::{Need, Scratch};
use bonebeam::phase_symmetry::Sizes;
use bonebeam::pipeline::Input;
use bonebeam::surface::{self, Detector};
use bonebeam::{Parameters, Pipeline, geometry};
use core::ffi::c_void;

/// The surface in a line.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Point {
    /// Not 0: there is a surface. The other values are otherwise 0.
    pub found: i32,
    /// Not 0: a piece of surface begins here.
    pub begins: i32,
    /// Depth along the line, m.
    pub depth: f32,
    /// Confidence, 0 to 1.
    pub confidence: f32,
}

/// Called after each step of an image or a map, with the number of steps so far.
///
/// A step is less than a million instructions on a Cortex-M7, so that a watchdog can be reset in it. By vectors, a step
/// of a map is a filter. May be null.
pub type Progress = Option<unsafe extern "C" fn(context: *mut c_void, done: usize)>;

/// A frame: channel data line by line, then image, bone map and surface.
///
/// Image and map are in the frame's memory, and valid until the frame is used again.
pub struct FrameObject {
    source: Source,
    surface: Option<Surface>,
}

enum Source {
    Rf(Planned<&'static Delay>),
    Iq(Planned<IqDelay>),
}

struct Surface {
    detector: Detector,
    memory: Scratch<'static>,
    points: &'static mut [Option<surface::Point>],
}

/// Evaluates an expression of the planned frame, whatever its records.
macro_rules! with_planned {
    ($object:expr, $planned:ident => $work:expr) => {
        match &mut $object.source {
            Source::Rf($planned) => $work,
            Source::Iq($planned) => $work,
        }
    };
}

impl FrameObject {
    fn new(
        source: Source,
        parameters: &FrameParameters,
        core: &Parameters<'_>,
        bytes: &mut Bytes,
    ) -> Result<Self, Refused> {
        let surface = match parameters.detector(core)? {
            None => None,
            Some(detector) => Some(Surface {
                memory: scratch(bytes, detector.need())?,
                points: bytes.fill(core.scan.lines.count(), None)?,
                detector,
            }),
        };
        Ok(FrameObject { source, surface })
    }
}

impl FrameParameters {
    /// # Safety
    /// As [`FrameParameters::core`].
    unsafe fn bytes(&self, input: Input) -> Result<usize, Refused> {
        // SAFETY: by the caller's promise.
        let core = unsafe { self.core(input)? };
        let need = core.need(input, LANES)?;
        if let Some(gate) = self.scan.gate() {
            gate.samples(&geometry::Scan::of_iq(core.scan)?.depths())?;
        }
        if input == Input::Iq {
            self.scan.delay.iq_input()?;
        }
        let plan = match input {
            Input::Rf => {
                let plan = bytes_of::<Pipeline<'_, &Delay>>(1);
                sum(&[bytes_of::<Delay>(1), plan])
            }
            Input::Iq => bytes_of::<Pipeline<'_, IqDelay>>(1),
        };
        let sizes = Sizes::new(core.rows, core.columns, core.strip);
        let beamformer = core.beamformer.sizes(core.scan.array.elements());
        let tables = match self.gain_tables {
            0 => 0,
            _ => sizes.gain_tables_len(core.scales.len()),
        };
        let coherence = match self.coherence(&core)? {
            None => 0,
            Some(coherence) => core.coherence_len(coherence)?,
        };
        let (detector, points) = match self.detector(&core)? {
            None => (Need::default(), 0),
            Some(detector) => (detector.need(), self.scan.lines.count),
        };
        possible(sum(&[
            bytes_of::<FrameObject>(1),
            plan,
            Over::bytes(beamformer, sizes),
            need_bytes(need),
            bytes_of::<bonebeam::Complex<f32>>(core.directions_len()?),
            bytes_of::<f32>(tables),
            bytes_of::<f32>(coherence),
            need_bytes(detector),
            bytes_of::<Option<surface::Point>>(points),
        ]))
    }
}

/// Returns the bytes of a frame of RF.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_frame_bytes(parameters: *const FrameParameters) -> usize {
    // SAFETY: by the caller's promise.
    unsafe { one(parameters).and_then(|p| p.bytes(Input::Rf)) }.unwrap_or(0)
}

/// Returns the bytes of a frame of I/Q.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_frame_iq_bytes(parameters: *const FrameParameters) -> usize {
    // SAFETY: by the caller's promise.
    unsafe { one(parameters).and_then(|p| p.bytes(Input::Iq)) }.unwrap_or(0)
}

/// Checks the configuration of a frame of RF: why `bonebeam_frame_new` refuses it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_frame_check(
    parameters: *const FrameParameters,
    refusal: *mut Refusal,
) -> Status {
    // SAFETY: by the caller's promise.
    unsafe { check(parameters, Input::Rf, refusal) }
}

/// Checks the configuration of a frame of I/Q, as `bonebeam_frame_check`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_frame_iq_check(
    parameters: *const FrameParameters,
    refusal: *mut Refusal,
) -> Status {
    // SAFETY: by the caller's promise.
    unsafe { check(parameters, Input::Iq, refusal) }
}

/// # Safety
/// As [`FrameParameters::bytes`].
unsafe fn check(parameters: *const FrameParameters, input: Input, refusal: *mut Refusal) -> Status {
    // SAFETY: by the caller's promise.
    let (found, status) = Refusal::of(unsafe { one(parameters).and_then(|p| p.bytes(input)) });
    // SAFETY: by the caller's promise.
    match unsafe { one_mut(refusal) } {
        Ok(refusal) => *refusal = found,
        Err(_) => return Status::Pointer,
    }
    status
}

/// Places a frame of RF in `memory`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_frame_new(
    memory: *mut c_void,
    bytes: usize,
    parameters: *const FrameParameters,
    frame: *mut *mut FrameObject,
) -> Status {
    // SAFETY: by the caller's promise.
    unsafe {
        new(memory, bytes, frame, |bytes| {
            let parameters = one(parameters)?;
            let core = parameters.core(Input::Rf)?;
            let stage = bytes.copy(&ANY)?;
            parameters.scan.delay.set(stage)?;
            let planned = Planned::new(Pipeline::by(stage, core)?, parameters, &core, bytes)?;
            FrameObject::new(Source::Rf(planned), parameters, &core, bytes)
        })
    }
}

/// Places a frame of I/Q in `memory`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_frame_iq_new(
    memory: *mut c_void,
    bytes: usize,
    parameters: *const FrameParameters,
    frame: *mut *mut FrameObject,
) -> Status {
    // SAFETY: by the caller's promise.
    unsafe {
        new(memory, bytes, frame, |bytes| {
            let parameters = one(parameters)?;
            let core = parameters.core(Input::Iq)?;
            let pipeline = Pipeline::of_iq(core, parameters.scan.delay.iq_input()?)?;
            let planned = Planned::new(pipeline, parameters, &core, bytes)?;
            FrameObject::new(Source::Iq(planned), parameters, &core, bytes)
        })
    }
}

/// Computes line `index` of a frame of RF, and keeps its envelope.
///
/// The line is the mean over `count` transmits. Lines may come in any order. A line that does not come keeps its
/// values of the last frame. `z`, unless null, receives the line: `output_samples` numbers; with a `depth_step`, their
/// number over the step, rounded up. With sub-lines it receives as many for each, `[sample][sub-line]`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_frame_line(
    frame: *mut FrameObject,
    index: usize,
    waves: *const RfWave,
    count: usize,
    z: *mut Complex,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        let Source::Rf(own) = &mut one_mut(frame)?.source else {
            return Err(Status::Parameter.into());
        };
        let z = own.output(z)?;
        let records = RfWave::core(waves, count, own.pipeline.lines().delay().parameters(), &z)?;
        own.line(index, &records, z.values())
    })
}

/// Computes line `index` of a frame of I/Q, as `bonebeam_frame_line`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_frame_iq_line(
    frame: *mut FrameObject,
    index: usize,
    waves: *const IqWave,
    count: usize,
    z: *mut Complex,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        let Source::Iq(own) = &mut one_mut(frame)?.source else {
            return Err(Status::Parameter.into());
        };
        let z = own.output(z)?;
        let records = IqWave::core(waves, count, own.pipeline.lines().delay().parameters(), &z)?;
        own.line(index, &records, z.values())
    })
}

/// The core's progress.
///
/// # Safety
/// `progress` may be called with this context.
unsafe fn steps(progress: Progress, context: *mut c_void) -> impl FnMut(usize) {
    move |done| {
        if let Some(progress) = progress {
            // SAFETY: by the caller's promise.
            unsafe { progress(context, done) };
        }
    }
}

/// Computes the image of the lines so far: `[row][column]`, grey levels 0 to 255.
///
/// Lines that never came are black. `context` is passed to `progress`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_frame_image(
    frame: *mut FrameObject,
    progress: Progress,
    context: *mut c_void,
    image: *mut *const f32,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        let (own, image) = (one_mut(frame)?, one_mut(image)?);
        let steps = &mut steps(progress, context);
        *image = with_planned!(own, planned => planned.image(steps)?).as_ptr();
        Ok(())
    })
}

/// Computes the bone map of the last image.
///
/// It is `[row][column]`, at least 0 and below 1. `context` is passed to `progress`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_frame_map(
    frame: *mut FrameObject,
    progress: Progress,
    context: *mut c_void,
    map: *mut *const f32,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        let (own, map) = (one_mut(frame)?, one_mut(map)?);
        let steps = &mut steps(progress, context);
        *map = with_planned!(own, planned => planned.map(steps)?).as_ptr();
        Ok(())
    })
}

/// Finds the bone surface in the lines so far: a point for each line.
///
/// The detector is made for a `dynamic_range` of 60 dB. A frame without a surface gives BONEBEAM_STATUS_PARAMETER.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_frame_surface(
    frame: *mut FrameObject,
    points: *mut Point,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        let own = one_mut(frame)?;
        let surface = own.surface.as_mut().ok_or(Refused::Of(Status::Parameter))?;
        let out = Output::new(points, surface.points.len())?;
        let memory = surface.memory.reborrow();
        let (detector, found) = (&surface.detector, &mut *surface.points);
        with_planned!(own, planned => planned.surface(detector, memory, found)?);
        for (out, found) in out.values().iter_mut().zip(found) {
            *out = Point {
                found: found.is_some().into(),
                begins: found.is_some_and(|point| point.begins).into(),
                depth: found.map_or(0.0, |point| point.depth),
                confidence: found.map_or(0.0, |point| point.confidence),
            };
        }
        Ok(())
    })
}

/// Returns the positions of an image's rows and columns, m.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_frame_axes(
    frame: *mut FrameObject,
    rows: *mut Axis,
    columns: *mut Axis,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        let (own, rows, columns) = (one_mut(frame)?, one_mut(rows)?, one_mut(columns)?);
        let b_mode = match &own.source {
            Source::Rf(planned) => planned.pipeline.b_mode(),
            Source::Iq(planned) => planned.pipeline.b_mode(),
        };
        let grid = b_mode.parameters().grid;
        *rows = Axis::of(grid.row_axis());
        *columns = Axis::of(grid.column_axis());
        Ok(())
    })
}
