//! A scan of RF or I/Q, and the records of its transmits.

use crate::Axis;
use crate::beamformer::ApertureShape;
use crate::bounds::{LENGTH, SPACING};
use crate::delay::DelayParameters;
use crate::iq::IqRecord;
use crate::memory::{Output, array};
use crate::scan_line::Wave;
use crate::status::{Refused, Status};
use bonebeam::delay::{self, IqParameters, Record};
use bonebeam::geometry::{Array, Depth, Lines, ScanParameters, Transmit};
use bonebeam::pipeline::DepthGate;

/// Maximum number of transmits compounded in a line.
pub const BONEBEAM_WAVES: usize = 16;

/// A scan by a linear array that is centred on 0. SI units.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Scan {
    /// The delay stage.
    pub delay: DelayParameters,
    /// The receive aperture, with the same number of elements.
    pub aperture: ApertureShape,
    /// Lateral positions of the lines, which go straight down.
    pub lines: Axis,
    /// Least depth of the depth gate, m; 0 for both depths means no gate.
    pub gate_from: f64,
    /// Greatest depth of the depth gate, m. Samples outside the gate are DAS.
    pub gate_to: f64,
    /// Number of output samples in a block of alignment and beamforming.
    ///
    /// It changes memory and time, never a line.
    pub block: usize,
}

/// One transmit of a scan of RF.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct RfWave {
    /// The transmitted wave.
    pub wave: Wave,
    /// Its record, `[element][record sample]`.
    pub rf: *const f32,
}

/// One transmit of a scan of I/Q.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct IqWave {
    /// The transmitted wave.
    pub wave: Wave,
    /// Its record.
    pub record: IqRecord,
}

impl Scan {
    /// The core's scan, of a pulse with this centre frequency.
    pub(crate) fn core(&self, centre_frequency: f64) -> Result<ScanParameters<'static>, Refused> {
        let delay = &self.delay;
        delay.check()?;
        self.aperture.check()?;
        LENGTH.check("lines.first", self.lines.first)?;
        SPACING.check("lines.step", self.lines.step)?;
        LENGTH.check("gate_from", self.gate_from)?;
        LENGTH.check("gate_to", self.gate_to)?;
        if self.aperture.elements != delay.elements {
            let elements = self.aperture.elements as f64;
            return Err(Refused::field(
                "aperture.elements",
                elements,
                "those of delay",
            ));
        }
        // Half a sample behind the last one, so that rounding does not exclude it.
        let duration = (delay.output_samples as f64 - 0.5) / delay.output_rate;
        Ok(ScanParameters {
            array: Array::linear(delay.elements, self.aperture.pitch),
            lines: Lines::Even(self.lines.core()),
            sound_speed: delay.sound_speed,
            centre_frequency,
            sampling_rate: delay.sampling_rate,
            record_samples: delay.record_samples,
            output_rate: delay.output_rate,
            start: Depth::Seconds(delay.output_start),
            end: Depth::Seconds(delay.output_start + duration),
            f_number: self.aperture.f_number,
            min_elements: self.aperture.min_elements,
        })
    }

    /// [`Scan::core`] of I/Q: the demodulation frequency stands for the pulse's, which directions of sub-lines need.
    pub(crate) fn core_of_iq(&self) -> Result<ScanParameters<'static>, Refused> {
        let frequency = self.delay.frequency;
        // At baseband there is no carrier, and all directions are the line's.
        self.core(if frequency > 0.0 { frequency } else { 1.0 })
    }

    /// Refuses a number of samples of the core's scan that is not `output_samples`, which the caller's arrays have.
    pub(crate) fn check(&self, samples: usize) -> Result<(), Refused> {
        match samples == self.delay.output_samples {
            true => Ok(()),
            false => {
                let expected = "as many as there are from output_start at output_rate";
                Err(Refused::field(
                    "output_samples",
                    self.delay.output_samples as f64,
                    expected,
                ))
            }
        }
    }

    pub(crate) fn gate(&self) -> Option<DepthGate> {
        let gate = DepthGate {
            from: self.gate_from,
            to: self.gate_to,
        };
        ((gate.from, gate.to) != (0.0, 0.0)).then_some(gate)
    }
}

/// Transmits with their records.
pub(crate) type Transmits<'r> = [Option<(Transmit<'r>, Record<'r>)>; BONEBEAM_WAVES];

/// The core's transmits.
fn transmits<'r, W>(
    waves: &[W],
    core: impl Fn(&W) -> Result<(Transmit<'r>, Record<'r>), Refused>,
) -> Result<Transmits<'r>, Refused> {
    if waves.len() > BONEBEAM_WAVES {
        return Err(Status::Capacity.into());
    }
    let mut records = [const { None }; BONEBEAM_WAVES];
    for (slot, wave) in records.iter_mut().zip(waves) {
        *slot = Some(core(wave)?);
    }
    Ok(records)
}

/// The transmits in the form that the core takes.
pub(crate) fn each<'a>(
    records: &'a Transmits<'a>,
) -> impl Iterator<Item = (Transmit<'a>, &'a Record<'a>)> + Clone {
    let records = records.iter().flatten();
    records.map(|(transmit, record)| (*transmit, record))
}

impl RfWave {
    /// The core's transmits of `count` waves, whose records `out` does not overlap.
    ///
    /// # Safety
    /// As [`array`] and [`Wave::core`]; records have the length that a stage of these parameters reads.
    pub(crate) unsafe fn core<'r>(
        waves: *const RfWave,
        count: usize,
        p: &delay::DelayParameters,
        out: &Output<bonebeam::Complex<f32>>,
    ) -> Result<Transmits<'r>, Refused> {
        // SAFETY: by the caller's promise.
        let waves: &[RfWave] = unsafe { array(waves, count)? };
        transmits(waves, |wave| {
            // SAFETY: by the caller's promise. A stage has checked that the product is possible.
            let (transmit, rf) = unsafe {
                let rf = array(wave.rf, p.elements * p.record_samples)?;
                (wave.wave.core(p.elements, p.sound_speed)?, out.apart(rf)?)
            };
            Ok((transmit, Record::new(rf, p.elements)?))
        })
    }
}

impl IqWave {
    /// As [`RfWave::core`].
    ///
    /// # Safety
    /// As [`RfWave::core`].
    pub(crate) unsafe fn core<'r>(
        waves: *const IqWave,
        count: usize,
        p: &IqParameters,
        out: &Output<bonebeam::Complex<f32>>,
    ) -> Result<Transmits<'r>, Refused> {
        // SAFETY: by the caller's promise.
        let waves: &[IqWave] = unsafe { array(waves, count)? };
        transmits(waves, |wave| {
            // SAFETY: by the caller's promise.
            let (transmit, record) = unsafe {
                let transmit = wave.wave.core(p.elements, p.sound_speed)?;
                (transmit, wave.record.core(p, out)?)
            };
            Ok((transmit, record))
        })
    }
}
