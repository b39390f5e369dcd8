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
    /// One element, at `transmit_x`, `transmit_z`.
    Element = 2,
    /// A wave that goes to the point at `transmit_x`, `transmit_z`, or comes from it where that lies behind
    /// the array, `transmit_z` ≤ 0.
    Source = 3,
}

/// One scan line of one transmit.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct ScanLine {
    /// One of `bonebeam_law`, as a number: any other is refused.
    pub law: i32,
    /// Of a plane wave, rad; positive towards positive x.
    pub angle: f64,
    /// Of the transmitting element, or of the source, m.
    pub transmit_x: f64,
    /// The same, depth, m.
    pub transmit_z: f64,
    /// Time of record sample 0 from the moment the wave would pass the law's origin, s.
    pub t0: f64,
    /// Where the line leaves, m.
    pub x: f64,
    /// The same, depth, m.
    pub z: f64,
    /// Its angle from straight down, rad; positive towards positive x.
    pub steering: f64,
    /// Lateral positions of the elements, m, ascending and evenly spaced; as many as the stage has.
    pub element_x: *const f64,
    /// The elements to compute.
    pub active: Active,
    /// Not 0: add to what the output holds, as the next of several transmits.
    pub add: i32,
}

impl ScanLine {
    /// The core's line.
    ///
    /// # Safety
    /// `element_x` leads to so many numbers, which nobody writes meanwhile.
    pub(crate) unsafe fn core<'a>(&self, elements: usize) -> Result<CoreLine<'a>, Status> {
        // SAFETY: by the caller's promise.
        let element_x = unsafe { array(self.element_x, elements)? };
        let (x, z) = (self.transmit_x, self.transmit_z);
        let law = match self.law {
            law if law == Law::Focused as i32 => TransmitLaw::Focused,
            law if law == Law::Plane as i32 => TransmitLaw::Plane { angle: self.angle },
            law if law == Law::Element as i32 => TransmitLaw::Element { x, z },
            law if law == Law::Source as i32 => TransmitLaw::VirtualSource { x, z },
            _ => return Err(Status::Parameter),
        };
        Ok(CoreLine {
            transmit: Transmit::new(law, self.t0),
            ray: Ray::new(self.x, self.z, self.steering),
            array: Array::LinearAt(element_x),
            active: geometry::Active {
                first: self.active.first,
                count: self.active.count,
            },
            compounding: if self.add == 0 {
                Compounding::Replace
            } else {
                Compounding::Add
            },
        })
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
    status(|| {
        // SAFETY: by the caller's promise.
        let (parameters, out) = unsafe { (one(parameters)?, one_mut(delay)?) };
        let place: *mut DelayStage = place(storage, bytes)?;
        // SAFETY: the place is large enough and aligned, and is filled before it is referred to.
        let DelayStage(stage) = unsafe {
            place.copy_from_nonoverlapping(&raw const ANY, 1);
            &mut *place
        };
        stage.set(parameters.core())?;
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
