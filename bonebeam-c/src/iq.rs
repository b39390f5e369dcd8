//! The delay stage for I/Q, from a record to aligned analytic samples.
//!
//! A call processes one scan line of one transmit.

use crate::Complex;
use crate::delay::DelayParameters;
use crate::memory::{Output, array, bytes_of, complex, new, one, one_mut, possible, sum};
use crate::scan_line::ScanLine;
use crate::status::{Refused, Status, chosen, status};
use crate::vectors::{LANES, zero};
use bonebeam::delay::{IqDelay, IqInterpolation, IqLayout, IqParameters, IqSamples, Record, Stage};
use core::ffi::c_void;

/// Interpolation of I/Q.
///
/// `IqInterpolation::for_band` in the core's documentation gives the cheapest one for a bandwidth.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum Interpolation {
    /// Linear interpolation.
    Linear = 0,
    /// Cubic interpolation through four samples.
    Cubic = 1,
    /// A windowed sinc of 12 taps.
    Sinc = 2,
    /// Linear interpolation in fixed point, for counts only.
    ///
    /// `IqInterpolation::LinearFixed` in the core's documentation gives the limits.
    LinearFixed = 3,
}

/// The order of samples in memory.
#[repr(C)]
#[derive(Clone, Copy)]
pub enum Layout {
    /// `[element][sample]`, as in recordings.
    Planar = 0,
    /// `[sample][element]`, as from a front end.
    Interleaved = 1,
}

/// The I/Q of one transmit: complex numbers, or counts of 16 bits.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct IqRecord {
    /// Complex numbers; null for counts.
    pub samples: *const Complex,
    /// I and Q in turn, if `samples` is null.
    pub counts: *const i16,
    /// The value of one count.
    pub scale: f32,
    /// One of `bonebeam_layout`.
    pub layout: i32,
}

impl Interpolation {
    /// The core's interpolation.
    pub(crate) fn core(number: i32) -> Result<IqInterpolation, Refused> {
        use IqInterpolation::{Cubic, Linear, LinearFixed, Sinc};
        chosen("interpolation", number, &[Linear, Cubic, Sinc, LinearFixed])
    }
}

impl Layout {
    /// The core's layout.
    pub(crate) fn core(number: i32) -> Result<IqLayout, Refused> {
        chosen("layout", number, &[IqLayout::Planar, IqLayout::Interleaved])
    }
}

impl IqRecord {
    /// The core's record, which `out` does not overlap.
    ///
    /// # Safety
    /// `samples` or `counts` points to as many as a stage of these parameters reads, and nobody writes them
    /// meanwhile.
    pub(crate) unsafe fn core<'a>(
        &self,
        p: &IqParameters,
        out: &Output<bonebeam::Complex<f32>>,
    ) -> Result<Record<'a>, Refused> {
        let layout = Layout::core(self.layout)?;
        // A stage has checked that the product is possible.
        let count = p.elements * p.record_samples;
        // SAFETY: by the caller's promise.
        let samples = unsafe {
            match self.samples.is_null() {
                false => IqSamples::Float(out.apart(complex(self.samples, count)?)?),
                true => {
                    let counts = out.apart(array(self.counts.cast(), count)?)?;
                    IqSamples::Counts(counts, self.scale)
                }
            }
        };
        Ok(Record::iq(samples, layout, p.elements)?)
    }
}

/// A delay stage for I/Q.
pub struct IqStage {
    stage: IqDelay,
    scratch: &'static mut [f32],
}

/// Returns the bytes of a delay stage for I/Q.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_iq_bytes(parameters: *const DelayParameters) -> usize {
    // SAFETY: by the caller's promise.
    let bytes = || unsafe {
        let parameters = one(parameters)?.iq()?;
        IqDelay::new(parameters)?;
        let scratch = bytes_of::<f32>(parameters.need(LANES).real);
        possible(sum(&[bytes_of::<IqStage>(1), scratch]))
    };
    bytes().unwrap_or(0)
}

/// Places a delay stage for I/Q in `memory`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_iq_new(
    memory: *mut c_void,
    bytes: usize,
    parameters: *const DelayParameters,
    iq: *mut *mut IqStage,
) -> Status {
    // SAFETY: by the caller's promise.
    unsafe {
        new(memory, bytes, iq, |bytes| {
            let stage = IqDelay::new(one(parameters)?.iq()?)?;
            let scratch = bytes.fill(stage.parameters().need(LANES).real, 0.0)?;
            Ok(IqStage { stage, scratch })
        })
    }
}

/// Aligns one scan line of I/Q; `out` is as in `bonebeam_delay_line`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_iq_line(
    iq: *mut IqStage,
    line: *const ScanLine,
    record: *const IqRecord,
    out: *mut Complex,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        let IqStage { stage, scratch } = one_mut(iq)?;
        let p = stage.parameters();
        let out = Output::complex(out, p.elements * p.output_samples)?;
        let line = one(line)?.core(p.elements, p.sound_speed)?;
        let record = one(record)?.core(p, &out)?;
        Ok(stage.line(zero(), &line, &record, scratch, out.values())?)
    })
}
