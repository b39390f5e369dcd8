//! The delay stage for RF, from a record to aligned analytic samples.
//!
//! A call processes one scan line of one transmit.

use crate::bounds::{FREQUENCY, OUTPUT_RATE, RATE, SPEED, check_time};
use crate::image::product;
use crate::iq::{Interpolation, Layout};
use crate::memory::{Output, array, bytes_of, new, one, one_mut, possible, sum};
use crate::scan_line::ScanLine;
use crate::status::{Refused, Status, status};
use crate::vectors::{LANES, zero};
use crate::{Complex, Range};
use bonebeam::delay::{
    Delay, DelayParameters as Rf, IqLayout, IqParameters as Iq, Record, Stage, hilbert_taps,
};
use bonebeam::pipeline::IqInput;
use core::ffi::c_void;

/// Parameters of a delay stage for RF or for I/Q. SI units.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct DelayParameters {
    /// Speed of sound, m/s.
    pub sound_speed: f64,
    /// Sampling rate of the record, Hz; for I/Q complex samples per second.
    pub sampling_rate: f64,
    /// RF: centre frequency of the pulse, Hz. I/Q: demodulation frequency, Hz.
    pub frequency: f64,
    /// Output rate, Hz; for RF at least a sixteenth of the sampling rate.
    pub output_rate: f64,
    /// Two-way time of output sample 0, s.
    pub output_start: f64,
    /// Output samples of a line.
    pub output_samples: usize,
    /// Elements of the array.
    pub elements: usize,
    /// Samples of each element's record.
    pub record_samples: usize,
    /// RF: non-zero taps on one side of the Hilbert transformer.
    ///
    /// 0 chooses them by the rates; a frame takes only that choice.
    pub hilbert_taps: usize,
    /// RF: not 0 computes the filters in single precision.
    ///
    /// For processors with doubles in software: far fewer instructions. The bits of lines differ.
    pub single_precision: i32,
    /// I/Q: one of `bonebeam_interpolation`.
    pub interpolation: i32,
}

impl DelayParameters {
    /// Refuses values that no scanner and no medium has.
    pub(crate) fn check(&self) -> Result<(), Refused> {
        SPEED.check("sound_speed", self.sound_speed)?;
        RATE.check("sampling_rate", self.sampling_rate)?;
        OUTPUT_RATE.check("output_rate", self.output_rate)?;
        FREQUENCY.check("frequency", self.frequency)?;
        check_time("output_start", self.output_start, self.sound_speed)
    }

    pub(crate) fn rf(&self) -> Result<Rf, Refused> {
        self.check()?;
        RATE.check("frequency", self.frequency)?;
        Ok(Rf {
            sound_speed: self.sound_speed,
            sampling_rate: self.sampling_rate,
            centre_frequency: self.frequency,
            output_rate: self.output_rate,
            output_start: self.output_start,
            output_samples: self.output_samples,
            elements: self.elements,
            record_samples: self.record_samples,
            hilbert_taps: match self.hilbert_taps {
                0 => hilbert_taps(self.output_rate, self.frequency),
                taps => taps,
            },
        })
    }

    /// Sets a stage in place.
    pub(crate) fn set(&self, stage: &mut Delay) -> Result<(), Refused> {
        match self.single_precision {
            0 => stage.set(self.rf()?)?,
            _ => stage.set_in_f32(self.rf()?)?,
        }
        Ok(())
    }

    pub(crate) fn iq_input(&self) -> Result<IqInput, Refused> {
        Ok(IqInput {
            demodulation_frequency: self.frequency,
            interpolation: Some(Interpolation::core(self.interpolation)?),
        })
    }

    pub(crate) fn iq(&self) -> Result<Iq, Refused> {
        self.check()?;
        Ok(Iq {
            sound_speed: self.sound_speed,
            sampling_rate: self.sampling_rate,
            demodulation_frequency: self.frequency,
            output_rate: self.output_rate,
            output_start: self.output_start,
            output_samples: self.output_samples,
            elements: self.elements,
            record_samples: self.record_samples,
            interpolation: Interpolation::core(self.interpolation)?,
        })
    }
}

/// A delay stage for RF.
pub struct DelayStage {
    stage: &'static mut Delay,
    scratch: &'static mut [f32],
}

/// The stage that each new stage is copied from, and that is then set.
///
/// A stage made elsewhere would pass over the stack.
pub(crate) static ANY: Delay = match Delay::new(Rf {
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
};

impl DelayStage {
    fn set(&mut self, parameters: &DelayParameters) -> Result<(), Refused> {
        if parameters.rf()?.need(LANES).real > self.scratch.len() {
            return Err(Status::Storage.into());
        }
        parameters.set(self.stage)
    }

    /// # Safety
    /// The caller of `bonebeam_delay_block` keeps its promises.
    unsafe fn block(
        &mut self,
        line: *const ScanLine,
        rf: *const f32,
        block: Range,
        out: *mut Complex,
    ) -> Result<(), Refused> {
        let DelayStage { stage, scratch } = self;
        let p = stage.parameters();
        // SAFETY: by the caller's promise. The stage has checked that the product is possible.
        let (line, out, rf) = unsafe {
            let line = one(line)?.core(p.elements, p.sound_speed)?;
            let out = Output::complex(out, product(p.elements, block.count)?)?;
            let rf = out.apart(array(rf, p.elements * p.record_samples)?)?;
            (line, out.values(), rf)
        };
        let record = Record::new(rf, p.elements)?;
        let need = p.block_need(LANES, block.count).real;
        let scratch = scratch
            .get_mut(..need)
            .ok_or(Refused::Of(Status::Capacity))?;
        Ok(stage.block(zero(), &line, &record, block.first, scratch, out)?)
    }
}

/// Returns the bytes of a delay stage for RF.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_delay_bytes(parameters: *const DelayParameters) -> usize {
    // SAFETY: by the caller's promise.
    let bytes = || unsafe {
        let parameters = one(parameters)?.rf()?;
        parameters.check()?;
        possible(sum(&[
            bytes_of::<DelayStage>(1),
            bytes_of::<Delay>(1),
            bytes_of::<f32>(parameters.need(LANES).real),
        ]))
    };
    bytes().unwrap_or(0)
}

/// Places a delay stage for RF in `memory`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_delay_new(
    memory: *mut c_void,
    bytes: usize,
    parameters: *const DelayParameters,
    delay: *mut *mut DelayStage,
) -> Status {
    // SAFETY: by the caller's promise.
    unsafe {
        new(memory, bytes, delay, |bytes| {
            let mut delay = DelayStage {
                stage: bytes.copy(&ANY)?,
                scratch: bytes.rest()?,
            };
            delay.set(one(parameters)?)?;
            Ok(delay)
        })
    }
}

/// Changes the parameters of a stage.
///
/// The filters are kept if rates, frequency, taps and precision stay the same; a change of other parameters is
/// cheap. The stage's memory limits the new sizes: for the largest ones, give `bonebeam_delay_new` the bytes that
/// they need. If the parameters are refused, the stage stays unchanged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_delay_set(
    delay: *mut DelayStage,
    parameters: *const DelayParameters,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe { one_mut(delay)?.set(one(parameters)?) })
}

/// Aligns one scan line of one transmit.
///
/// `out[n·elements + m]` is the analytic sample of element `m` at output sample `n`. `rf` is `[element][record
/// sample]`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_delay_line(
    delay: *mut DelayStage,
    line: *const ScanLine,
    rf: *const f32,
    out: *mut Complex,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        let count = one(delay)?.stage.parameters().output_samples;
        one_mut(delay)?.block(line, rf, Range { first: 0, count }, out)
    })
}

/// Aligns the samples in `block` of a line, with the bits of the whole line.
///
/// `out` has `block.count·elements` numbers. The whole record is checked, but its samples from
/// `bonebeam_delay_record_end` on may have any finite value.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_delay_block(
    delay: *mut DelayStage,
    line: *const ScanLine,
    rf: *const f32,
    block: Range,
    out: *mut Complex,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe { one_mut(delay)?.block(line, rf, block, out) })
}

/// Computes the number of a record's first samples that a block of a line needs.
///
/// `block` is a range of the line's samples. It can be aligned once that number of samples is recorded. The cost is two
/// positions in doubles for each output sample: compute the number once for a scan.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_delay_record_end(
    delay: *const DelayStage,
    line: *const ScanLine,
    block: Range,
    samples: *mut usize,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        let (delay, samples) = (one(delay)?, one_mut(samples)?);
        let p = delay.stage.parameters();
        let line = one(line)?.core(p.elements, p.sound_speed)?;
        *samples = delay.stage.record_end(&line, block.samples())?;
        Ok(())
    })
}

/// Writes counts of 16 bits into a record of RF.
///
/// The samples in `block` of each element become `scale` times the counts. `layout` is one of `bonebeam_layout`, the
/// order of the block's `elements·block.count` counts. `rf` is `[element][record sample]`. The counts are those of a
/// whole record, or of a block of it as it arrives.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_rf_counts(
    counts: *const i16,
    layout: i32,
    scale: f32,
    block: Range,
    elements: usize,
    record_samples: usize,
    rf: *mut f32,
) -> Status {
    // SAFETY: by the caller's promise.
    status(|| unsafe {
        let samples = block.samples();
        if samples.end > record_samples {
            return Err(Status::Capacity.into());
        }
        // Steps of the counts from element to element, and from sample to sample.
        let (element, sample) = match Layout::core(layout)? {
            IqLayout::Planar => (block.count, 1),
            IqLayout::Interleaved => (1, elements),
        };
        let rf = Output::new(rf, product(elements, record_samples)?)?;
        let counts = rf.apart(array(counts, product(elements, block.count)?)?)?;
        let records = rf.values().chunks_exact_mut(record_samples.max(1));
        for (record, first) in records.zip((0..).step_by(element.max(1))) {
            let own = counts.get(first..).unwrap_or_default();
            let own = own.iter().step_by(sample.max(1));
            let record = record.get_mut(samples.clone()).unwrap_or_default();
            for (x, &count) in record.iter_mut().zip(own) {
                *x = scale * f32::from(count);
            }
        }
        Ok(())
    })
}
