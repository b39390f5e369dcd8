//! Drives the core's delay stage over a frame, on all threads.

use std::ops::Range;

use bonebeam::focus::{
    Compounding, Delay, DelayParameters, IqDelay, IqLayout, IqParameters, IqReading, IqRecord,
    IqSamples, MAX_DECIMATION, MAX_SAMPLES, Record, ScanLine, Stage as CoreStage, Upsampled,
};
use bonebeam::geometry::{
    Active, Aperture, Array, Axis, Depth, Element, Lines, Ray, Scan, ScanParameters, Transmit,
    TransmitLaw,
};
use bonebeam::pipeline::{Block, LinePipeline};
use bonebeam::simd::{InstructionSet, Task, Vector};
use ndarray::{Array3, ArrayView3};
use num_complex::Complex;
use rayon::prelude::*;

use super::beams::{self, Beams};
use super::compound::Compound;
use crate::config::{Beamform, RfReading};
use crate::{Error, Result};
use bonebeam_files::terminal::{digits, short};
use bonebeam_files::{ChannelData, Frame, Samples, Transmits};

/// The delay stage of one set of channel data: which beams, which depths, which elements.
///
/// Focused transmits make one beam each, on their axis, and so do virtual sources before the array that
/// come from left to right; other transmits are compounded coherently (their mean) into two beams an
/// element, or those that are asked for.
pub struct DelayStage<'a> {
    data: &'a ChannelData,
    /// None where the array is straight.
    elements: Vec<Element>,
    beams: Beams,
    beam_x: Vec<f64>,
    /// Where each beam leaves the array, in elements.
    feet: Vec<f64>,
    aperture: Aperture,
    start: f64,
    samples: usize,
    sound_speed: f64,
    output_rate: f64,
    stage: Stage,
    transmits: Vec<Transmit<'a>>,
    set: InstructionSet,
    /// Whether each record is upsampled once for all lines.
    upsampled: bool,
}

/// The core's stage for the kind of samples.
enum Stage {
    Rf(Box<Delay>),
    Iq(Box<IqDelay>),
}

/// The transmits of a frame, checked.
enum Records<'a> {
    Rf(Vec<Record<'a>>),
    Iq(Vec<IqRecord<'a>>),
}

impl<'a> DelayStage<'a> {
    /// Plans the delaying of `data`, from `depth_start` to `depth_end` of the parameters or over
    /// the whole record.
    ///
    /// # Errors
    /// [`Error::Usage`] for an output rate, a depth or lines that do not fit the record.
    pub fn new(data: &'a ChannelData, parameters: &Beamform) -> Result<Self> {
        let c = parameters.sound_speed.unwrap_or(data.c);
        let rate = parameters.rate_of(data);
        if let Samples::Rf(_) = data.samples {
            check_rate(rate, data)?;
        }
        let (_, transmits, _, record_samples) = data.samples.dim();
        let (start, end) = record_times(data);
        let start = parameters
            .depth_start
            .map_or(Depth::Seconds(start), Depth::Metres);
        let end = parameters
            .depth_end
            .map_or(Depth::Seconds(end), Depth::Metres);
        check_depths(start, end, c)?;
        let elements = match data.is_straight() {
            true => Vec::new(),
            false => beams::elements(data),
        };
        let array = array_of(data, &elements);
        let beams = Beams::new(data, &array, parameters)?;
        let scan = ScanParameters {
            array,
            lines: Lines::Rays(&beams.rays),
            sound_speed: c,
            centre_frequency: data.f0,
            sampling_rate: data.fs,
            record_samples,
            output_rate: rate,
            start,
            end,
            f_number: parameters.f_number,
            min_elements: parameters.min_elements,
        };
        let scan = match data.samples {
            Samples::Rf(_) => Scan::new(scan)?,
            Samples::Iq { .. } => Scan::of_iq(scan)?,
        };
        if scan.samples() > MAX_SAMPLES {
            return Err(Error::Usage(format!(
                "the depths and --output-rate ask for {} samples a line; expected at most \
                 {MAX_SAMPLES}",
                scan.samples()
            )));
        }
        let stage = match data.samples {
            Samples::Rf(_) => Stage::Rf(Box::new(Delay::new(DelayParameters::of(&scan))?)),
            Samples::Iq { f_demod, .. } => {
                let of_scan = IqParameters::of(&scan, f_demod);
                let reading = parameters
                    .iq_reading
                    .map_or(of_scan.reading, IqReading::from);
                Stage::Iq(Box::new(IqDelay::new(IqParameters { reading, ..of_scan })?))
            }
        };
        let upsampled = parameters.rf_reading == Some(RfReading::Upsampled);
        if upsampled {
            check_upsampling(&stage, &beams)?;
        }
        let transmits = (0..transmits).map(|t| Transmit {
            law: law(data, t),
            // A lens delays what is heard, there and back.
            t0: data.t0[t] - 2.0 * data.lens_delay,
        });
        Ok(Self {
            beam_x: beams.rays.iter().map(Ray::x).collect(),
            feet: (0..scan.lines()).map(|line| scan.foot(line)).collect(),
            aperture: *scan.aperture(),
            start: scan.start(),
            samples: scan.samples(),
            sound_speed: c,
            output_rate: rate,
            stage,
            transmits: transmits.collect(),
            data,
            elements,
            beams,
            set: InstructionSet::detect(),
            upsampled,
        })
    }

    /// The same with an instruction set of choice: the result does not depend on it.
    pub fn with_instruction_set(self, set: InstructionSet) -> Self {
        DelayStage { set, ..self }
    }

    /// The lateral positions of the beams, m: where they begin.
    pub fn beam_x(&self) -> &[f64] {
        &self.beam_x
    }

    /// The beams.
    pub fn rays(&self) -> &[Ray] {
        &self.beams.rays
    }

    /// Output samples a beam.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Elements of the array.
    pub fn elements(&self) -> usize {
        self.data.element_x.len()
    }

    /// The two-way time of output sample 0, s.
    pub fn start(&self) -> f64 {
        self.start
    }

    /// The depths of the output samples, m.
    pub fn depths(&self) -> Axis {
        Axis {
            first: self.sound_speed * self.start / 2.0,
            step: self.sound_speed / self.output_rate / 2.0,
            count: self.samples,
        }
    }

    /// The speed of sound in use, m/s.
    pub fn sound_speed(&self) -> f64 {
        self.sound_speed
    }

    /// The active elements of a beam at an output sample; none for a beam that there is not.
    pub fn active(&self, beam: usize, sample: usize) -> Active {
        let time = self.start + sample as f64 / self.output_rate;
        let foot = self.feet.get(beam).copied().unwrap_or(f64::NAN);
        self.aperture.active(foot, self.sound_speed * time / 2.0)
    }

    /// The aligned analytic samples of some beams of the first frame, [beam, sample, element].
    ///
    /// # Errors
    /// What the core refuses: samples beyond its range.
    pub fn delay(&self, beams: Range<usize>) -> Result<Array3<Complex<f32>>> {
        self.delay_frame(self.first_frame()?, beams)
    }

    /// The same of any frame of such data.
    ///
    /// # Errors
    /// What the core refuses: samples beyond its range, or of another shape.
    pub fn delay_frame(
        &self,
        frame: Frame<'_>,
        beams: Range<usize>,
    ) -> Result<Array3<Complex<f32>>> {
        let shape = (beams.len(), self.samples, self.elements());
        let mut x = vec![Complex::new(0.0, 0.0); shape.0 * shape.1 * shape.2];
        self.delay_frame_into(frame, beams, &mut x)?;
        Ok(Array3::from_shape_vec(shape, x).expect("the length is that of the shape"))
    }

    /// [`DelayStage::delay`] into memory of that size, which a new frame need not ask the system for
    /// again.
    ///
    /// # Errors
    /// What the core refuses.
    pub fn delay_into(&self, beams: Range<usize>, x: &mut [Complex<f32>]) -> Result<()> {
        self.delay_frame_into(self.first_frame()?, beams, x)
    }

    fn first_frame(&self) -> Result<Frame<'_>> {
        let first = self.data.samples.frame(0);
        first.ok_or_else(|| Error::Data("the recording has no frame".into()))
    }

    /// [`DelayStage::delay_frame`] into memory of that size.
    ///
    /// # Errors
    /// What the core refuses.
    pub fn delay_frame_into(
        &self,
        frame: Frame<'_>,
        beams: Range<usize>,
        x: &mut [Complex<f32>],
    ) -> Result<()> {
        // Each transmit is checked once, however many beams read it.
        let range = self.transmits(beams.start).start..self.transmits(beams.end.max(1) - 1).end;
        // What is not in row-major order is put into it, once a frame.
        let (rf, iq);
        let records = match &frame {
            Frame::Rf(samples) => {
                rf = samples.as_standard_layout();
                let checked = records(rf.view(), range.clone(), |rf, elements| {
                    Record::new(rf, elements)
                })?;
                if let (true, Stage::Rf(delay)) = (self.upsampled, &self.stage) {
                    let first = beams.start;
                    return self.set.dispatch(Compound {
                        delay,
                        transmits: &self.transmits,
                        rf: rf.as_slice().expect("a standard layout is contiguous"),
                        array: self.array(),
                        rays: &self.beams.rays[beams],
                        active: &|line, sample| self.active(first + line, sample),
                        x,
                    });
                }
                Records::Rf(checked)
            }
            Frame::Iq {
                iq: samples,
                f_demod,
            } => {
                iq = samples.as_standard_layout();
                // Demodulated from the moment of t0, which a lens puts off.
                let late = (2.0 * self.data.lens_delay * f_demod).rem_euclid(1.0);
                let phase = late * std::f64::consts::TAU;
                Records::Iq(records(iq.view(), range.clone(), |iq, elements| {
                    IqRecord::new(IqSamples::Float(iq), IqLayout::Planar, elements)?
                        .with_phase(phase)
                })?)
            }
        };
        self.set.dispatch(AlignBeams {
            stage: self,
            records: &records,
            first: range.start,
            beams,
            x,
        })
    }

    fn array(&self) -> Array<'_> {
        array_of(self.data, &self.elements)
    }

    /// The transmits that make a beam.
    fn transmits(&self, beam: usize) -> Range<usize> {
        if self.beams.own {
            beam..beam + 1
        } else {
            0..self.transmits.len()
        }
    }

    fn scratch_len(&self, lanes: usize) -> usize {
        match &self.stage {
            Stage::Rf(delay) => delay.parameters().scratch_len(lanes),
            Stage::Iq(delay) => delay.parameters().scratch_len(lanes),
        }
    }

    /// The aligned samples of a beam: the mean over its transmits, added up in their order.
    fn align<V: Vector>(
        &self,
        zero: V,
        beam: usize,
        (records, first): (&Records<'_>, usize),
        scratch: &mut [f32],
        x: &mut [Complex<f32>],
    ) -> Result<()> {
        let own = self.transmits(beam);
        let count = own.len();
        for (k, transmit) in own.enumerate() {
            let line = ScanLine {
                transmit: self.transmits[transmit],
                ray: self.beams.rays[beam],
                array: self.array(),
                // The last sample's active elements include those of all shallower ones.
                active: self.active(beam, self.samples - 1),
                compounding: match k {
                    0 => Compounding::Replace,
                    _ => Compounding::Add,
                },
            };
            match (&self.stage, records) {
                (Stage::Rf(delay), Records::Rf(records)) => {
                    delay.line(zero, &line, &records[transmit - first], scratch, x)?;
                }
                (Stage::Iq(delay), Records::Iq(records)) => {
                    delay.line(zero, &line, &records[transmit - first], scratch, x)?;
                }
                _ => {
                    return Err(Error::Data(
                        "the frame's samples are of another kind than the recording's".into(),
                    ));
                }
            }
        }
        if count > 1 {
            let scale = 1.0 / count as f32;
            for value in x {
                *value *= scale;
            }
        }
        Ok(())
    }
}

/// The records of some transmits, checked on all threads.
fn records<'r, T: Sync, R: Send>(
    samples: ArrayView3<'r, T>,
    transmits: Range<usize>,
    check: impl Fn(&'r [T], usize) -> std::result::Result<R, bonebeam::Error> + Sync,
) -> Result<Vec<R>> {
    let (_, elements, length) = samples.dim();
    let all = samples.to_slice().expect("a standard layout is contiguous");
    let checked = transmits.into_par_iter().map(|transmit| {
        let own = transmit * elements * length..(transmit + 1) * elements * length;
        check(&all[own], elements)
    });
    Ok(checked.collect::<std::result::Result<_, _>>()?)
}

struct AlignBeams<'a> {
    stage: &'a DelayStage<'a>,
    records: &'a Records<'a>,
    /// The transmit of the first record.
    first: usize,
    beams: Range<usize>,
    x: &'a mut [Complex<f32>],
}

impl Task for AlignBeams<'_> {
    type Output = Result<()>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let AlignBeams {
            stage,
            records,
            first,
            beams,
            x,
        } = self;
        x.par_chunks_exact_mut(stage.samples * stage.elements())
            .zip(beams)
            .try_for_each_init(
                || vec![0.0; stage.scratch_len(V::LANES)],
                |scratch, (x, beam)| stage.align(zero, beam, (records, first), scratch, x),
            )
    }
}

/// What lines are delayed from.
#[derive(Clone, Copy)]
pub struct Source<'a, R = Record<'a>> {
    /// The transmits.
    pub transmits: &'a [Transmit<'a>],
    /// The record of each.
    pub records: &'a [R],
    /// Which of them make a line.
    pub of_line: &'a (dyn Fn(usize) -> Range<usize> + Sync),
}

/// Samples of a line that are delayed together, of the elements that any of them needs: fewer take too much
/// of their margins.
const STRETCH: usize = 288;

/// The aligned analytic samples of some lines of a pipeline, `x` as [line, sample, element], on all
/// threads, with the vectors of `set`. Elements that no beamformed sample reads are 0.
///
/// # Errors
/// What the core refuses.
pub fn align<'r, D: CoreStage + Sync>(
    set: InstructionSet,
    pipeline: &LinePipeline<'_, D>,
    lines: Range<usize>,
    source: Source<'r, D::Record<'r>>,
    x: &mut [Complex<f32>],
) -> Result<()> {
    set.dispatch(Align {
        pipeline,
        lines,
        source,
        x,
    })
}

struct Align<'a, 'r, D: CoreStage> {
    pipeline: &'a LinePipeline<'a, D>,
    lines: Range<usize>,
    source: Source<'r, D::Record<'r>>,
    x: &'a mut [Complex<f32>],
}

impl<D: CoreStage + Sync> Task for Align<'_, '_, D> {
    type Output = Result<()>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let Align {
            pipeline,
            lines,
            source,
            x,
        } = self;
        let scan = pipeline.scan();
        let stretch = STRETCH * scan.elements();
        let reach = STRETCH + pipeline.beamformer().parameters().temporal_half_window;
        x.par_chunks_exact_mut(pipeline.aligned_len())
            .zip(lines)
            .try_for_each_init(
                || vec![0.0; pipeline.scratch_len(V::LANES)],
                |scratch, (x, line)| {
                    let own = (source.of_line)(line);
                    let transmits = source.transmits[own.clone()].iter().copied();
                    let transmits = transmits.zip(&source.records[own]);
                    for (k, x) in x.chunks_mut(stretch.max(1)).enumerate() {
                        let block = Block {
                            line,
                            first: k * STRETCH,
                            active: scan.active(line, (k * STRETCH + reach).min(scan.samples()) - 1),
                        };
                        pipeline.align(zero, block, transmits.clone(), scratch, x)?;
                    }
                    Ok(())
                },
            )
    }
}

/// An RF record holds the pulse at an output rate.
fn check_rate(rate: f64, data: &ChannelData) -> Result<()> {
    let (lowest, highest) = (2.0 * data.f0, data.fs / MAX_DECIMATION as f64);
    if rate > lowest && rate >= highest {
        return Ok(());
    }
    Err(Error::Usage(format!(
        "--output-rate is {} Hz; expected more than twice the centre frequency of {} \
         Hz and at least 1/{MAX_DECIMATION} of the sampling rate of {} Hz",
        short(rate),
        data.f0,
        data.fs
    )))
}

/// Records can be upsampled where lines are compounded of them.
fn check_upsampling(stage: &Stage, beams: &Beams) -> Result<()> {
    let Stage::Rf(delay) = stage else {
        return Err(Error::Usage(
            "--rf-reading upsampled has no effect on I/Q; give --iq-reading".into(),
        ));
    };
    if beams.own {
        return Err(Error::Usage(
            "--rf-reading upsampled is for transmits that are compounded; these make a line each"
                .into(),
        ));
    }
    Upsampled::new(delay).map(drop).map_err(|error| {
        Error::Usage(format!(
            "--rf-reading upsampled cannot read this record: {error}"
        ))
    })
}

/// The array of a recording, whose elements are told where it is not straight.
fn array_of<'e>(data: &'e ChannelData, elements: &'e [Element]) -> Array<'e> {
    if elements.is_empty() {
        return Array::LinearAt(&data.element_x);
    }
    Array::At {
        elements,
        pitch: data.pitch(),
    }
}

/// The delay law of one transmit.
fn law(data: &ChannelData, transmit: usize) -> TransmitLaw<'_> {
    match &data.transmits {
        Transmits::Focused { .. } => TransmitLaw::Focused,
        Transmits::Plane { angle } => TransmitLaw::Plane {
            angle: angle[transmit],
        },
        Transmits::Element { index } => {
            let [x, z] = data.element(index[transmit]);
            TransmitLaw::Element { x, z }
        }
        Transmits::VirtualSource { x, z } => TransmitLaw::VirtualSource {
            x: x[transmit],
            z: z[transmit],
        },
        Transmits::Delays { delay } => {
            let own = delay.row(transmit).to_slice();
            TransmitLaw::Delays(own.expect("checked to be in row-major order"))
        }
    }
}

/// The depths are in order.
fn check_depths(start: Depth, end: Depth, c: f64) -> Result<()> {
    let [first, last] = [start, end].map(|depth| depth.seconds(c));
    if last > first {
        return Ok(());
    }
    match (start, end) {
        (Depth::Seconds(_), Depth::Seconds(_)) => Err(Error::Data(format!(
            "the record leaves no depth: it ends {} s after the transmit, and begins at {} s",
            digits(last),
            digits(first)
        ))),
        _ => Err(Error::Usage(format!(
            "no depth is left between {} m and {} m (--depth-start, --depth-end, or the ends \
             of the record)",
            digits(c * first / 2.0),
            digits(c * last / 2.0)
        ))),
    }
}

/// The two-way times between which every transmit has recorded, from 0 at the earliest.
fn record_times(data: &ChannelData) -> (f64, f64) {
    let length = (data.samples.dim().3 - 1) as f64 / data.fs;
    let mut start = 0.0f64;
    let mut end = f64::INFINITY;
    for &t0 in &data.t0 {
        start = start.max(t0);
        end = end.min(t0 + length);
    }
    (start, end)
}
