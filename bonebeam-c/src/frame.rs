//! A frame: channel data to lines, image, bone map and surface, in one object.

use crate::beamformer::BeamformParameters;
use crate::delay::ANY;
use crate::image::product;
use crate::memory::{Bytes, Output, bytes_of, new, one, one_mut, sum};
use crate::phase_symmetry::PhaseSymmetryParameters;
use crate::scan::{IqWave, RfWave, Scan, Transmits, each};
use crate::status::{Status, status};
use crate::vectors::LANES;
use crate::workspace::{Workspace, need_bytes, scratch, workspace_bytes};
use crate::{Axis, Complex};
#[cfg(feature = "forward")]
use bonebeam::covariance::Forward;
use bonebeam::covariance::{Averaging, Covariance};
use bonebeam::delay::{Delay, IqDelay, Stage};
use bonebeam::image::Pooling;
use bonebeam::memory::{Need, Scratch};
use bonebeam::phase_symmetry::{self, PhaseSymmetry, Sizes};
use bonebeam::surface::{self, Detector, Settings};
use bonebeam::{Error, Frame, Parameters, Pipeline, geometry};
use core::ffi::c_void;

/// The parameters of a frame.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct FrameParameters {
    /// Records, lines, aperture and depth gate.
    pub scan: Scan,
    /// The beamformer.
    pub beamformer: BeamformParameters,
    /// The image's size, and the filters of the bone map; `strip` is not used.
    pub image: PhaseSymmetryParameters,
    /// Level of black below the largest envelope, dB.
    pub dynamic_range: f32,
    /// Not 0: the image is filtered by a median of 3 × 3 pixels.
    pub median: i32,
    /// Not 0: the image shows the RMS of sub-lines; else the largest.
    pub pool_by_rms: i32,
    /// Not 0: the filters' gains are in tables, for faster maps of the same bits.
    pub gain_tables: i32,
    /// Least depth of the surface, m.
    ///
    /// 0 for both depths means no surface, and no memory for it.
    pub surface_from: f64,
    /// Greatest depth of the surface, m; may be infinite.
    pub surface_to: f64,
}

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
/// A step is less than a million instructions on a Cortex-M7, so that a watchdog can be reset in it. May be null.
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

/// A core's frame and its pipeline.
struct Planned<D: Stage + 'static> {
    pipeline: &'static Pipeline<'static, D>,
    frame: Averaged<D>,
    /// For lines by vectors.
    workspace: Option<Workspace>,
}

enum Averaged<D: Stage + 'static> {
    #[cfg(feature = "forward")]
    Forward(Frame<'static, 'static, D, Forward>),
    ForwardBackward(Frame<'static, 'static, D>),
}

struct Surface {
    detector: Detector,
    memory: Scratch<'static>,
    points: &'static mut [Option<surface::Point>],
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

/// [`with_frame`] for any records.
macro_rules! with_any {
    ($object:expr, $frame:ident => $work:expr) => {
        match &mut $object.source {
            Source::Rf(planned) => with_frame!(&mut planned.frame, $frame => $work),
            Source::Iq(planned) => with_frame!(&mut planned.frame, $frame => $work),
        }
    };
}

impl<D: Stage> Planned<D> {
    /// A frame of `pipeline` in `bytes`.
    fn new(
        pipeline: Pipeline<'static, D>,
        parameters: &FrameParameters,
        bytes: &mut Bytes,
    ) -> Result<Self, Status> {
        let covariance = parameters.beamformer.covariance()?;
        let pipeline = match parameters.scan.gate() {
            None => pipeline,
            Some(gate) => pipeline.with_gate(gate)?,
        };
        let pipeline: &'static _ = bytes.copy(&pipeline)?;
        let (need, workspace) = match LANES {
            1 => (pipeline.need(covariance), None),
            _ => {
                let lines = pipeline.lines();
                let sizes = lines.beamformer().sizes(lines.scan().elements());
                let workspace = Workspace::new(bytes, sizes, covariance)?;
                (pipeline.need_over(LANES, covariance), Some(workspace))
            }
        };
        let scratch = scratch(bytes, need)?;
        let tables = match parameters.gain_tables {
            0 => None,
            _ => Some(bytes.fill(pipeline.phase_symmetry().gain_tables_len(), 0.0)?),
        };
        let pooling = match parameters.pool_by_rms {
            0 => Pooling::Largest,
            _ => Pooling::Rms,
        };
        let frame = match covariance {
            #[cfg(feature = "forward")]
            Covariance::Forward => Averaged::Forward(frame(pipeline, scratch, tables, pooling)?),
            #[cfg(not(feature = "forward"))]
            Covariance::Forward => return Err(Status::Parameter),
            Covariance::ForwardBackward => {
                Averaged::ForwardBackward(frame(pipeline, scratch, tables, pooling)?)
            }
        };
        Ok(Planned {
            pipeline,
            frame,
            workspace,
        })
    }

    /// A line's numbers, or none for a null pointer.
    fn output(&self, z: *mut Complex) -> Result<Output<bonebeam::Complex<f32>>, Status> {
        let lines = self.pipeline.lines();
        match z.is_null() {
            true => Ok(Output::none()),
            false => {
                let sub_lines = lines.beamformer().parameters().sub_lines;
                Output::complex(z, product(lines.line_samples(), sub_lines)?)
            }
        }
    }

    fn line<'r>(
        &mut self,
        index: usize,
        records: &'r Transmits<'r, D::Record<'r>>,
        z: &mut [bonebeam::Complex<f32>],
    ) -> Result<(), Status> {
        let waves = each(records);
        let line = match (&mut self.frame, &mut self.workspace) {
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
}

/// The core's frame, with gains in tables or not, and a pooling of sub-lines.
fn frame<D: Stage, A: Averaging<f32>>(
    pipeline: &'static Pipeline<'static, D>,
    scratch: Scratch<'static>,
    tables: Option<&'static mut [f32]>,
    pooling: Pooling,
) -> Result<Frame<'static, 'static, D, A>, Error> {
    let frame = Frame::with_averaging(pipeline, scratch)?.with_pooling(pooling);
    match tables {
        None => Ok(frame),
        Some(tables) => frame.with_gain_tables(tables),
    }
}

/// The records of a frame.
#[derive(Clone, Copy)]
enum Input {
    Rf,
    Iq,
}

impl FrameParameters {
    /// The core's parameters.
    ///
    /// # Safety
    /// As [`BeamformParameters::core`] and [`PhaseSymmetryParameters::core`].
    unsafe fn core(&self, input: Input) -> Result<Parameters<'static>, Status> {
        // SAFETY: by the caller's promise.
        let (beamformer, image) = unsafe { (self.beamformer.core()?, self.image.core()?) };
        let scan = match input {
            Input::Rf => self.scan.core(self.scan.delay.frequency)?,
            Input::Iq => self.scan.core_of_iq()?,
        };
        self.scan.check(geometry::Scan::of_iq(scan)?.samples())?;
        Ok(Parameters {
            scan,
            beamformer,
            rows: self.image.rows,
            columns: self.image.columns,
            dynamic_range: self.dynamic_range,
            median: self.median != 0,
            scales: image.scales,
            threshold: image.threshold,
            strip: self.image.strip.max(1),
            block: self.scan.block,
        })
    }

    /// The detector, if there is a surface.
    fn detector(&self, core: &Parameters<'_>) -> Result<Option<Detector>, Status> {
        let depths = [self.surface_from, self.surface_to];
        if depths == [0.0; 2] {
            return Ok(None);
        }
        let settings = Settings {
            depths,
            ..Settings::DEFAULT
        };
        Ok(Some(Detector::new(core.surface(settings)?)?))
    }

    /// # Safety
    /// As [`FrameParameters::core`].
    unsafe fn bytes(&self, input: Input) -> Result<usize, Status> {
        // SAFETY: by the caller's promise.
        let core = unsafe { self.core(input)? };
        let covariance = self.beamformer.covariance()?;
        let (plan, need) = match input {
            Input::Rf => {
                let plan = bytes_of::<Pipeline<'_, &Delay>>(1);
                let need = match LANES {
                    1 => core.need(covariance)?,
                    lanes => core.need_over(lanes, covariance)?,
                };
                (sum(&[bytes_of::<Delay>(1), plan]), need)
            }
            Input::Iq => {
                let need = match LANES {
                    1 => core.need_of_iq(covariance)?,
                    lanes => core.need_over_of_iq(lanes, covariance)?,
                };
                (bytes_of::<Pipeline<'_, IqDelay>>(1), need)
            }
        };
        let workspace = match LANES {
            1 => 0,
            _ => {
                let sizes = core.beamformer.sizes(core.scan.array.elements());
                workspace_bytes(sizes.need(covariance))
            }
        };
        let bank = PhaseSymmetry::new(&phase_symmetry::Parameters {
            sizes: Sizes {
                rows: core.rows,
                columns: core.columns,
                strip: core.strip,
            },
            scales: core.scales,
            threshold: core.threshold,
        })?;
        let tables = match self.gain_tables {
            0 => 0,
            _ => bank.gain_tables_len(),
        };
        let (detector, points) = match self.detector(&core)? {
            None => (Need::default(), 0),
            Some(detector) => (detector.need(), self.scan.lines.count),
        };
        Ok(sum(&[
            bytes_of::<FrameObject>(1),
            plan,
            workspace,
            need_bytes(need),
            bytes_of::<f32>(tables),
            need_bytes(detector),
            bytes_of::<Option<surface::Point>>(points),
        ]))
    }
}

impl FrameObject {
    fn new(
        source: Source,
        parameters: &FrameParameters,
        core: &Parameters<'_>,
        bytes: &mut Bytes,
    ) -> Result<Self, Status> {
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
            let planned = Planned::new(Pipeline::by(stage, core)?, parameters, bytes)?;
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
            let planned = Planned::new(pipeline, parameters, bytes)?;
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
            return Err(Status::Parameter);
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
            return Err(Status::Parameter);
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
        *image = with_any!(own, frame => frame.image_in_steps(steps)?).as_ptr();
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
        *map = with_any!(own, frame => frame.bone_map_in_steps(steps)?).as_ptr();
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
        let surface = own.surface.as_mut().ok_or(Status::Parameter)?;
        let out = Output::new(points, surface.points.len())?;
        let memory = surface.memory.reborrow();
        let (detector, found) = (&surface.detector, &mut *surface.points);
        with_any!(own, frame => frame.surface(detector, memory, found)?);
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
