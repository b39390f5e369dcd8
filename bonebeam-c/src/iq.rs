//! The delay stage from I/Q: one scan line of one transmit, from baseband samples to aligned analytic
//! samples.

use crate::Complex;
use crate::memory::{array, array_mut, one, one_mut, place};
use crate::scan_line::ScanLine;
use crate::status::{Status, status};
use bonebeam::focus::{IqDelay, IqLayout, IqParameters as Core, IqReading, IqRecord, IqSamples};
use core::ffi::c_void;

/// Shapes and rates of a delay stage for I/Q. SI units.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct IqParameters {
    /// Speed of sound, m/s.
    pub sound_speed: f64,
    /// Sampling rate of the record, complex samples a second.
    pub sampling_rate: f64,
    /// The frequency that the record was demodulated with, Hz.
    pub demodulation_frequency: f64,
    /// Output rate, Hz.
    pub output_rate: f64,
    /// Two-way time of output sample 0, s.
    pub output_start: f64,
    /// Output samples.
    pub output_samples: usize,
    /// Elements of the array.
    pub elements: usize,
    /// Samples of each element's record.
    pub record_samples: usize,
    /// One of `bonebeam_reading`, as a number: any other is refused.
    pub reading: i32,
}

/// How I/Q is read between two samples. `IqReading::for_band` in the core's documentation says which is
/// enough.
#[repr(i32)]
#[derive(Clone, Copy)]
pub enum Reading {
    /// Along the line between the two.
    Linear = 0,
    /// Along the cubic through the two and their neighbours.
    Cubic = 1,
    /// By a windowed sinc of 12 taps.
    Sinc = 2,
    /// Along the line, in fixed point: of counts only. `IqReading::LinearFixed` in the core's documentation has
    /// its limits.
    LinearFixed = 3,
}

/// In which order samples of I/Q lie.
#[repr(i32)]
#[derive(Clone, Copy)]
pub enum Layout {
    /// `[element][sample]`, as recordings are.
    Planar = 0,
    /// `[sample][element]`, as a front end sends them.
    Interleaved = 1,
}

impl IqParameters {
    fn core(&self) -> Result<Core, Status> {
        Ok(Core {
            sound_speed: self.sound_speed,
            sampling_rate: self.sampling_rate,
            demodulation_frequency: self.demodulation_frequency,
            output_rate: self.output_rate,
            output_start: self.output_start,
            output_samples: self.output_samples,
            elements: self.elements,
            record_samples: self.record_samples,
            reading: Reading::core(self.reading)?,
        })
    }
}

impl Reading {
    /// The core's reading.
    pub(crate) fn core(number: i32) -> Result<IqReading, Status> {
        match number {
            reading if reading == Reading::Linear as i32 => Ok(IqReading::Linear),
            reading if reading == Reading::Cubic as i32 => Ok(IqReading::Cubic),
            reading if reading == Reading::Sinc as i32 => Ok(IqReading::Sinc),
            reading if reading == Reading::LinearFixed as i32 => Ok(IqReading::LinearFixed),
            _ => Err(Status::Parameter),
        }
    }
}

impl Layout {
    /// The core's layout.
    pub(crate) fn core(number: i32) -> Result<IqLayout, Status> {
        match number {
            layout if layout == Layout::Planar as i32 => Ok(IqLayout::Planar),
            layout if layout == Layout::Interleaved as i32 => Ok(IqLayout::Interleaved),
            _ => Err(Status::Parameter),
        }
    }
}

/// A delay stage for I/Q.
pub struct IqStage(IqDelay);

/// Bytes of its storage.
pub const BONEBEAM_IQ_SIZE: usize = 128;
/// Alignment of its storage, bytes.
pub const BONEBEAM_IQ_ALIGN: usize = 8;

const _: () =
    assert!(size_of::<IqStage>() <= BONEBEAM_IQ_SIZE && align_of::<IqStage>() <= BONEBEAM_IQ_ALIGN);

/// Sets a delay stage for I/Q up in storage of the caller's. `*iq` becomes the pointer to use.
///
/// # Safety
/// `storage` leads to so many `bytes`; `parameters` and `iq` lead to what they say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_iq_init(
    storage: *mut c_void,
    bytes: usize,
    parameters: *const IqParameters,
    iq: *mut *mut IqStage,
) -> Status {
    status(|| {
        // SAFETY: by the caller's promise.
        let (parameters, out) = unsafe { (one(parameters)?, one_mut(iq)?) };
        let place: *mut IqStage = place(storage, bytes)?;
        let stage = IqStage(IqDelay::new(parameters.core()?)?);
        // SAFETY: the place is large enough and aligned.
        unsafe { place.write(stage) };
        *out = place;
        Ok(())
    })
}

/// How many floats `bonebeam_iq_line` and `bonebeam_iq_line_counts` need as scratch.
///
/// # Safety
/// `parameters` leads to what it says; null gives 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_iq_scratch(parameters: *const IqParameters) -> usize {
    // SAFETY: by the caller's promise.
    match unsafe { one(parameters) }.and_then(IqParameters::core) {
        Ok(parameters) => parameters.scratch_len(1),
        Err(_) => 0,
    }
}

/// One scan line: `out[n · elements + m]`, the analytic sample of element `m` at output sample `n`.
///
/// `iq` lies as `layout` says, one of `bonebeam_layout`. Refuses samples that are not finite, and shapes
/// that are not the stage's.
///
/// # Safety
/// `stage` is from its init. `iq` leads to elements · record samples, `scratch` to `scratch_length` floats,
/// `out` to output samples · elements, `line->element_x` to as many as there are elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_iq_line(
    stage: *const IqStage,
    line: *const ScanLine,
    iq: *const Complex,
    layout: i32,
    scratch: *mut f32,
    scratch_length: usize,
    out: *mut Complex,
) -> Status {
    status(|| {
        // SAFETY: by the caller's promise. The core's complex number is two floats as well.
        let (stage, samples) = unsafe {
            let IqStage(stage) = one(stage)?;
            (stage, array(iq.cast(), recorded(stage))?)
        };
        // SAFETY: by the caller's promise.
        unsafe {
            line_of(
                stage,
                line,
                IqSamples::Float(samples),
                layout,
                scratch,
                scratch_length,
                out,
            )
        }
    })
}

/// The same of counts of 16 bits as a front end sends them, I before Q; a count is `scale`.
///
/// # Safety
/// As [`bonebeam_iq_line`]; `counts` leads to twice as many numbers as there are samples.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_iq_line_counts(
    stage: *const IqStage,
    line: *const ScanLine,
    counts: *const i16,
    scale: f32,
    layout: i32,
    scratch: *mut f32,
    scratch_length: usize,
    out: *mut Complex,
) -> Status {
    status(|| {
        // SAFETY: by the caller's promise.
        let (stage, counts) = unsafe {
            let IqStage(stage) = one(stage)?;
            (stage, array(counts.cast(), recorded(stage))?)
        };
        let samples = IqSamples::Counts(counts, scale);
        // SAFETY: by the caller's promise.
        unsafe { line_of(stage, line, samples, layout, scratch, scratch_length, out) }
    })
}

/// The stage has checked that the product is possible.
fn recorded(stage: &IqDelay) -> usize {
    stage.parameters().elements * stage.parameters().record_samples
}

/// # Safety
/// As [`bonebeam_iq_line`].
unsafe fn line_of(
    stage: &IqDelay,
    line: *const ScanLine,
    samples: IqSamples<'_>,
    layout: i32,
    scratch: *mut f32,
    scratch_length: usize,
    out: *mut Complex,
) -> Result<(), Status> {
    let p = stage.parameters();
    // SAFETY: by the caller's promise. The core's complex number is two floats as well.
    let (line, scratch, out): (_, _, &mut [bonebeam::Complex<f32>]) = unsafe {
        (
            one(line)?.core(p.elements)?,
            array_mut(scratch, scratch_length)?,
            array_mut(out.cast(), p.elements * p.output_samples)?,
        )
    };
    let record = IqRecord::new(samples, Layout::core(layout)?, p.elements)?;
    // As long as asked for, whatever more there is.
    let scratch = scratch.get_mut(..p.scratch_len(1)).ok_or(Status::Length)?;
    Ok(stage.line(0.0f32, &line, &record, scratch, out)?)
}
