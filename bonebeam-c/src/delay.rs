//! The delay stage: one scan line of one transmit, from RF to aligned analytic samples.

use crate::memory::{array, array_mut, one, one_mut, place};
use crate::status::{Status, status};
use crate::{Active, Complex};
use bonebeam::focus::{Compounding, Delay, DelayParameters as Core, Record, ScanLine as CoreLine};
use bonebeam::geometry::{self, Array, Ray, Transmit, TransmitLaw};
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

/// How the transmit wave travels.
#[repr(i32)]
#[derive(Clone, Copy)]
pub enum Law {
    /// A focused beam: the line lies on its axis.
    Focused = 0,
    /// A plane wave at the angle `angle`.
    Plane = 1,
    /// One element, at `element_x`.
    Element = 2,
}

/// One scan line of one transmit.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ScanLine {
    /// One of `bonebeam_law`, as a number: any other is refused.
    pub law: i32,
    /// Of a plane wave, rad; positive towards positive x.
    pub angle: f64,
    /// Of the transmitting element, m.
    pub transmit_x: f64,
    /// Time of record sample 0 from the moment the wave would pass the law's origin, s.
    pub t0: f64,
    /// Lateral position of the line, m.
    pub x: f64,
    /// Lateral positions of the elements, m, ascending and evenly spaced; as many as the stage has.
    pub element_x: *const f64,
    /// The elements to compute.
    pub active: Active,
    /// Not 0: add to what the output holds, as the next of several transmits.
    pub add: i32,
}

/// A delay stage.
pub struct DelayStage(Delay);

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
    status(|| {
        // SAFETY: by the caller's promise.
        let (parameters, out) = unsafe { (one(parameters)?, one_mut(delay)?) };
        let place: *mut DelayStage = place(storage, bytes)?;
        let stage = DelayStage(Delay::new(parameters.core())?);
        // SAFETY: the place is large enough and aligned.
        unsafe { place.write(stage) };
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
/// floats, `out` to output samples · elements, `line->element_x` to as many as there are elements.
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
        let (rf, element_x, scratch, out): (_, _, _, &mut [bonebeam::Complex<f32>]) = unsafe {
            (
                array(rf, recorded)?,
                array(line.element_x, p.elements)?,
                array_mut(scratch, scratch_length)?,
                array_mut(out.cast(), aligned)?,
            )
        };
        let law = match line.law {
            law if law == Law::Focused as i32 => TransmitLaw::Focused,
            law if law == Law::Plane as i32 => TransmitLaw::Plane { angle: line.angle },
            law if law == Law::Element as i32 => TransmitLaw::Element {
                x: line.transmit_x,
                z: 0.0,
            },
            _ => return Err(Status::Parameter),
        };
        let line = CoreLine {
            transmit: Transmit::new(law, line.t0),
            ray: Ray::down(line.x),
            array: Array::LinearAt(element_x),
            active: geometry::Active {
                first: line.active.first,
                count: line.active.count,
            },
            compounding: if line.add == 0 {
                Compounding::Replace
            } else {
                Compounding::Add
            },
        };
        let record = Record::new(rf, p.elements)?;
        // As long as asked for, whatever more there is.
        let scratch = scratch.get_mut(..p.scratch_len(1)).ok_or(Status::Length)?;
        Ok(delay.line(0.0f32, &line, &record, scratch, out)?)
    })
}
