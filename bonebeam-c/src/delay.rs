//! The delay stage: one scan line of one transmit, from RF to aligned analytic samples.

use crate::Complex;
use crate::memory::{array, array_mut, one, one_mut, place};
use crate::scan_line::ScanLine;
use crate::status::{Status, status};
use bonebeam::Error;
use bonebeam::focus::{Delay, DelayParameters as Core, Record};
use core::ffi::c_void;

/// Shapes and rates of a delay stage. SI units.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct DelayParameters {
    /// Speed of sound, m/s.
    pub sound_speed: f64,
    /// Sampling rate of the record, Hz.
    pub sampling_rate: f64,
    /// Centre frequency of the pulse, Hz.
    pub centre_frequency: f64,
    /// Output rate, Hz, at least a sixteenth of the sampling rate.
    pub output_rate: f64,
    /// Two-way time of output sample 0, s.
    pub output_start: f64,
    /// Output samples.
    pub output_samples: usize,
    /// Elements of the array.
    pub elements: usize,
    /// Samples of each element's record.
    pub record_samples: usize,
    /// Non-zero taps on one side of the Hilbert transformer, 8 for instance.
    pub hilbert_taps: usize,
}

impl DelayParameters {
    fn core(&self) -> Core {
        Core {
            sound_speed: self.sound_speed,
            sampling_rate: self.sampling_rate,
            centre_frequency: self.centre_frequency,
            output_rate: self.output_rate,
            output_start: self.output_start,
            output_samples: self.output_samples,
            elements: self.elements,
            record_samples: self.record_samples,
            hilbert_taps: self.hilbert_taps,
        }
    }
}

/// A delay stage.
pub struct DelayStage(Delay);

/// Copied to where a stage is set up: one that is made elsewhere would go over the stack. Any valid one.
static ANY: DelayStage = DelayStage(
    match Delay::new(Core {
        sound_speed: 1540.0,
        sampling_rate: 20e6,
        centre_frequency: 5e6,
        output_rate: 20e6,
        output_start: 0.0,
        output_samples: 1,
        elements: 1,
        record_samples: 1,
        hilbert_taps: 8,
    }) {
        Ok(delay) => delay,
        Err(_) => panic!("the parameters are not valid"),
    },
);

/// Bytes of its storage.
pub const BONEBEAM_DELAY_SIZE: usize = 10240;
/// Alignment of its storage, bytes.
pub const BONEBEAM_DELAY_ALIGN: usize = 64;

const _: () = assert!(
    size_of::<DelayStage>() <= BONEBEAM_DELAY_SIZE
        && align_of::<DelayStage>() <= BONEBEAM_DELAY_ALIGN
);

/// Sets a delay stage up in storage of the caller's. `*delay` becomes the pointer to use.
///
/// # Safety
/// `storage` leads to so many `bytes`; `parameters` and `delay` lead to what they say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_delay_init(
    storage: *mut c_void,
    bytes: usize,
    parameters: *const DelayParameters,
    delay: *mut *mut DelayStage,
) -> Status {
    // SAFETY: by the caller's promise.
    unsafe { init(storage, bytes, parameters, delay, Delay::set) }
}

/// `bonebeam_delay_init` with the filter worked out in single precision: a fiftieth of the instructions where
/// doubles are computed in software. A line has other bits: `Delay::set_in_f32` in the core's documentation.
///
/// # Safety
/// As `bonebeam_delay_init`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_delay_init_in_f32(
    storage: *mut c_void,
    bytes: usize,
    parameters: *const DelayParameters,
    delay: *mut *mut DelayStage,
) -> Status {
    // SAFETY: by the caller's promise.
    unsafe { init(storage, bytes, parameters, delay, Delay::set_in_f32) }
}

/// The stage for other parameters. Filters are kept where rates, centre frequency and taps stay, so that another
/// sound speed, range of depths or number of elements costs next to nothing. What is refused leaves it as it was.
///
/// # Safety
/// `delay` is from its init; `parameters` leads to what it says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_delay_set(
    delay: *mut DelayStage,
    parameters: *const DelayParameters,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe { Ok(one_mut(delay)?.0.set(one(parameters)?.core())?) })
}

/// `bonebeam_delay_set` of a stage from `bonebeam_delay_init_in_f32`: its filter stays one in single precision.
///
/// # Safety
/// As `bonebeam_delay_set`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_delay_set_in_f32(
    delay: *mut DelayStage,
    parameters: *const DelayParameters,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe { Ok(one_mut(delay)?.0.set_in_f32(one(parameters)?.core())?) })
}

/// # Safety
/// As [`bonebeam_delay_init`].
unsafe fn init(
    storage: *mut c_void,
    bytes: usize,
    parameters: *const DelayParameters,
    delay: *mut *mut DelayStage,
    set: fn(&mut Delay, Core) -> Result<(), Error>,
) -> Status {
    status(|| {
        // SAFETY: by the caller's promise.
        let (parameters, out) = unsafe { (one(parameters)?, one_mut(delay)?) };
        let place: *mut DelayStage = place(storage, bytes)?;
        // SAFETY: the place is large enough and aligned, and is filled before it is referred to.
        let DelayStage(stage) = unsafe {
            place.copy_from_nonoverlapping(&raw const ANY, 1);
            &mut *place
        };
        set(stage, parameters.core())?;
        *out = place;
        Ok(())
    })
}

/// How many floats `bonebeam_delay_line` needs as scratch.
///
/// # Safety
/// `parameters` leads to what it says; null gives 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_delay_scratch(parameters: *const DelayParameters) -> usize {
    // SAFETY: by the caller's promise.
    match unsafe { one(parameters) } {
        Ok(parameters) => parameters.core().scratch_len(1),
        Err(_) => 0,
    }
}

/// One scan line: `out[n · elements + m]`, the analytic sample of element `m` at output sample `n`.
///
/// `rf` is `[element][record sample]`. Refuses samples that are not finite, and shapes that are not the
/// stage's.
///
/// # Safety
/// `delay` is from its init. `rf` leads to elements · record samples, `scratch` to `scratch_length`
/// floats, `out` to output samples · elements, the line's arrays to as many numbers as there are elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_delay_line(
    delay: *const DelayStage,
    line: *const ScanLine,
    rf: *const f32,
    scratch: *mut f32,
    scratch_length: usize,
    out: *mut Complex,
) -> Status {
    status(|| {
        // SAFETY: by the caller's promise.
        let (DelayStage(delay), line) = unsafe { (one(delay)?, one(line)?) };
        let p = delay.parameters();
        // The stage has checked that these products are possible.
        let (recorded, aligned) = (p.elements * p.record_samples, p.elements * p.output_samples);
        // SAFETY: by the caller's promise. The core's complex number is two floats as well.
        let (rf, line, scratch, out): (_, _, _, &mut [bonebeam::Complex<f32>]) = unsafe {
            (
                array(rf, recorded)?,
                line.core(p.elements)?,
                array_mut(scratch, scratch_length)?,
                array_mut(out.cast(), aligned)?,
            )
        };
        let record = Record::new(rf, p.elements)?;
        // As long as asked for, whatever more there is.
        let scratch = scratch.get_mut(..p.scratch_len(1)).ok_or(Status::Length)?;
        Ok(delay.line(0.0f32, &line, &record, scratch, out)?)
    })
}
