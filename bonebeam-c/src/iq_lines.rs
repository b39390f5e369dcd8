//! Lines of I/Q by the core's pipeline: focused and beamformed a stretch at a time.

use crate::beamformer::BeamformParameters;
use crate::iq::{Layout, Reading};
use crate::memory::{array, array_mut, one, one_mut, place};
use crate::scan_line::Wave;
use crate::status::{Status, status};
use crate::{Axis, Complex};
use bonebeam::beamform::WorkspaceView;
use bonebeam::covariance::Averaging;
use bonebeam::focus::{IqDelay, IqRecord, IqSamples};
use bonebeam::geometry::{Array, Depth, Lines, Scan, ScanParameters, Transmit};
use bonebeam::pipeline::{self, DepthGate, IqInput, LinePipeline};
use core::ffi::c_void;

/// The most transmits that one line is compounded of.
pub const BONEBEAM_IQ_WAVES: usize = 16;

/// A scan of I/Q by a linear array that is centred on 0. SI units.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct IqScan {
    /// Elements of the array.
    pub elements: usize,
    /// From one element to the next, m.
    pub pitch: f64,
    /// Where the lines leave, straight down.
    pub lines: Axis,
    /// Speed of sound, m/s.
    pub sound_speed: f64,
    /// Centre frequency of the pulse, Hz.
    pub centre_frequency: f64,
    /// Sampling rate of the record, complex samples a second.
    pub sampling_rate: f64,
    /// Samples of each element's record.
    pub record_samples: usize,
    /// The frequency that the record was demodulated with, Hz.
    pub demodulation_frequency: f64,
    /// One of `bonebeam_reading`, as a number: any other is refused.
    pub reading: i32,
    /// Output rate, Hz.
    pub output_rate: f64,
    /// Two-way time of a line's first sample, s.
    pub start: f64,
    /// Two-way time that a line's last sample does not exceed, s.
    pub end: f64,
    /// Depth over width of the aperture.
    pub f_number: f64,
    /// Active elements at the least.
    pub min_elements: usize,
    /// The least depth at which the beamformer works, m; 0 for both where it works everywhere.
    pub gate_from: f64,
    /// The greatest: elsewhere is DAS.
    pub gate_to: f64,
}

/// How long a line is, and the memory that it is worked out in.
#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct LineLengths {
    /// Samples of a line.
    pub samples: usize,
    /// Floats of scratch memory.
    pub scratch: usize,
    /// Complex numbers of aligned samples.
    pub aligned: usize,
}

/// The memory that a line is worked out in: of the lengths that `bonebeam_iq_lines_lengths` gives.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct LineMemory {
    /// How many samples are focused and beamformed at a time.
    pub stretch: usize,
    /// Scratch memory.
    pub scratch: *mut f32,
    /// Aligned samples.
    pub aligned: *mut Complex,
}

/// What the elements recorded of one transmit: counts of I and Q in turn, times `scale`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct IqWave {
    /// How the wave travels.
    pub wave: Wave,
    /// Elements · record samples pairs.
    pub counts: *const i16,
    /// What a count stands for.
    pub scale: f32,
    /// One of `bonebeam_layout`, as a number: any other is refused.
    pub layout: i32,
}

/// The lines of a scan: its delay stage, its apertures and its beamformer.
pub struct IqLines(LinePipeline<'static, IqDelay>);

/// Bytes of its storage.
pub const BONEBEAM_IQ_LINES_SIZE: usize = 512;
/// Alignment of its storage, bytes.
pub const BONEBEAM_IQ_LINES_ALIGN: usize = 8;

const _: () = assert!(
    size_of::<IqLines>() <= BONEBEAM_IQ_LINES_SIZE
        && align_of::<IqLines>() <= BONEBEAM_IQ_LINES_ALIGN
);

impl IqScan {
    fn core(&self) -> Result<(Scan<'static>, IqInput), Status> {
        let scan = Scan::of_iq(ScanParameters {
            array: Array::linear(self.elements, self.pitch),
            lines: Lines::Even(self.lines.core()),
            sound_speed: self.sound_speed,
            centre_frequency: self.centre_frequency,
            sampling_rate: self.sampling_rate,
            record_samples: self.record_samples,
            output_rate: self.output_rate,
            start: Depth::Seconds(self.start),
            end: Depth::Seconds(self.end),
            f_number: self.f_number,
            min_elements: self.min_elements,
        })?;
        let input = IqInput {
            demodulation_frequency: self.demodulation_frequency,
            reading: Some(Reading::core(self.reading)?),
        };
        Ok((scan, input))
    }
}

/// Sets the lines of a scan up in storage of the caller's. `*lines` becomes the pointer to use.
///
/// # Safety
/// `storage` leads to so many `bytes`; `scan`, `beamformer` and `lines` lead to what they say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_iq_lines_init(
    storage: *mut c_void,
    bytes: usize,
    scan: *const IqScan,
    beamformer: *const BeamformParameters,
    lines: *mut *mut IqLines,
) -> Status {
    status(|| {
        // SAFETY: by the caller's promise.
        let (scan, beamformer, out) = unsafe { (one(scan)?, one(beamformer)?, one_mut(lines)?) };
        let place: *mut IqLines = place(storage, bytes)?;
        let gate = DepthGate {
            from: scan.gate_from,
            to: scan.gate_to,
        };
        let (scan, input) = scan.core()?;
        let mut lines = LinePipeline::of_iq(scan, input, beamformer.core()?)?;
        if (gate.from, gate.to) != (0.0, 0.0) {
            lines = lines.with_gate(gate)?;
        }
        // SAFETY: the place is large enough and aligned.
        unsafe { place.write(IqLines(lines)) };
        *out = place;
        Ok(())
    })
}

/// The lengths for lines that are worked out `stretch` samples at a time: it changes memory and time, never a
/// line. All 0 where `lines` is null.
///
/// # Safety
/// `lines` is from its init.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bonebeam_iq_lines_lengths(
    lines: *const IqLines,
    stretch: usize,
) -> LineLengths {
    // SAFETY: by the caller's promise.
    match unsafe { one(lines) } {
        Ok(IqLines(lines)) => {
            let lengths = lines.lengths(stretch);
            LineLengths {
                samples: lines.scan().samples(),
                scratch: lengths.scratch,
                aligned: lengths.aligned,
            }
        }
        Err(_) => LineLengths::default(),
    }
}

/// What every size's line does.
///
/// # Safety
/// `lines` is from its init; `waves` leads to `count`, their counts to as many as the scan has; `memory` to its
/// lengths, `z` to the line's samples.
pub(crate) unsafe fn line<A: Averaging<f32>>(
    workspace: &mut WorkspaceView<'_, A>,
    lines: *const IqLines,
    line: usize,
    (waves, count): (*const IqWave, usize),
    memory: *const LineMemory,
    z: *mut Complex,
) -> Result<(), Status> {
    // SAFETY: by the caller's promise.
    let (IqLines(lines), waves, memory) =
        unsafe { (one(lines)?, array(waves, count)?, one(memory)?) };
    if count > BONEBEAM_IQ_WAVES {
        return Err(Status::Capacity);
    }
    let p = *lines.delay().parameters();
    let mut records: [Option<(Transmit<'_>, IqRecord<'_>)>; BONEBEAM_IQ_WAVES] =
        [const { None }; BONEBEAM_IQ_WAVES];
    for (place, wave) in records.iter_mut().zip(waves) {
        // SAFETY: by the caller's promise. The stage has checked that the product is possible.
        let (transmit, counts) = unsafe {
            (
                wave.wave.core(p.elements)?,
                array(wave.counts.cast(), p.elements * p.record_samples)?,
            )
        };
        let samples = IqSamples::Counts(counts, wave.scale);
        let record = IqRecord::new(samples, Layout::core(wave.layout)?, p.elements)?;
        *place = Some((transmit, record));
    }
    let transmits = records
        .iter()
        .flatten()
        .map(|(transmit, record)| (*transmit, record));
    let lengths = lines.lengths(memory.stretch);
    // SAFETY: by the caller's promise. The core's complex number is two floats as well.
    let (scratch, aligned, z): (_, &mut [bonebeam::Complex<f32>], &mut [_]) = unsafe {
        (
            array_mut(memory.scratch, lengths.scratch)?,
            array_mut(memory.aligned.cast(), lengths.aligned)?,
            array_mut(z.cast(), lines.scan().samples())?,
        )
    };
    let memory = pipeline::LineMemory { scratch, aligned };
    Ok(lines.line(line, transmits, memory, workspace, z)?)
}
