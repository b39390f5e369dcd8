//! Drives the core's delay stage over a frame, on all threads.

use std::ops::Range;

use bonebeam::focus::{MAX_DECIMATION, MAX_SAMPLES, Record};
use bonebeam::geometry::{
    Active, Array, Axis as Positions, Depth, Lines, Scan, ScanParameters, Transmit, TransmitLaw,
};
use bonebeam::pipeline::LinePipeline;
use bonebeam::simd::{InstructionSet, Task, Vector};
use ndarray::{Array3, Axis, CowArray, Ix3};
use num_complex::Complex;
use rayon::prelude::*;

use crate::config::Beamform;
use crate::files::{ChannelData, Transmits};
use crate::{Error, Result};

/// The delay stage of one set of channel data: which beams, which depths, which elements.
///
/// Focused transmits make one beam each, on their axis; plane waves and single-element transmits
/// are compounded coherently (their mean) into two beams an element.
pub struct DelayStage<'a> {
    data: &'a ChannelData,
    rf: CowArray<'a, f32, Ix3>,
    pipeline: LinePipeline<'a>,
    transmits: Vec<Transmit<'a>>,
    beam_x: Vec<f64>,
}

impl<'a> DelayStage<'a> {
    /// Plans the delaying of `data`, from `depth_start` to `depth_end` of the parameters or over
    /// the whole record.
    ///
    /// # Errors
    /// [`Error::Usage`] for an output rate or a depth that does not fit the record.
    pub fn new(data: &'a ChannelData, parameters: &Beamform) -> Result<Self> {
        let c = parameters.sound_speed.unwrap_or(data.c);
        let rate = parameters.output_rate;
        let (lowest, highest) = (2.0 * data.f0, data.fs / MAX_DECIMATION as f64);
        if rate <= lowest || rate < highest {
            return Err(Error::Usage(format!(
                "--output-rate is {rate} Hz; expected more than twice the centre frequency of {} \
                 Hz and at least 1/{MAX_DECIMATION} of the sampling rate of {} Hz",
                data.f0, data.fs
            )));
        }
        let rf = straight_rf(data)?;
        let (_, transmits, elements, record_samples) = data.samples.dim();
        let (start, end) = record_times(data);
        let start = parameters
            .depth_start
            .map_or(Depth::Seconds(start), Depth::Metres);
        let end = parameters
            .depth_end
            .map_or(Depth::Seconds(end), Depth::Metres);
        check_depths(start, end, c)?;
        let lines = match &data.transmits {
            Transmits::Focused { x, .. } => Lines::At(x),
            // An adaptive beam is narrower than an element: one on each and one between.
            _ => Lines::Even(Positions {
                first: data.element_x[0],
                step: data.pitch() / 2.0,
                count: 2 * elements - 1,
            }),
        };
        let scan = Scan::new(ScanParameters {
            array: Array::LinearAt(&data.element_x),
            lines,
            sound_speed: c,
            centre_frequency: data.f0,
            sampling_rate: data.fs,
            record_samples,
            output_rate: rate,
            start,
            end,
            f_number: parameters.f_number,
            min_elements: parameters.min_elements,
        })?;
        if scan.samples() > MAX_SAMPLES {
            return Err(Error::Usage(format!(
                "the depths and --output-rate ask for {} samples a line; expected at most \
                 {MAX_SAMPLES}",
                scan.samples()
            )));
        }
        let transmits = (0..transmits).map(|t| Transmit {
            law: law(data, t),
            t0: data.t0[t],
        });
        Ok(Self {
            data,
            rf,
            pipeline: LinePipeline::new(scan, parameters.parameters())?,
            transmits: transmits.collect(),
            beam_x: (0..scan.lines()).map(|line| lines.x(line)).collect(),
        })
    }

    fn scan(&self) -> &Scan<'a> {
        self.pipeline.scan()
    }

    /// The lateral positions of the beams, m.
    pub fn beam_x(&self) -> &[f64] {
        &self.beam_x
    }

    /// Output samples a beam.
    pub fn samples(&self) -> usize {
        self.scan().samples()
    }

    /// The two-way time of output sample 0, s.
    pub fn start(&self) -> f64 {
        self.scan().start()
    }

    /// The speed of sound in use, m/s.
    pub fn sound_speed(&self) -> f64 {
        self.scan().parameters().sound_speed
    }

    /// The active elements of a beam at an output sample.
    pub fn active(&self, beam: usize, sample: usize) -> Active {
        self.scan().active(beam, sample)
    }

    /// The aligned analytic samples of some beams, [beam, sample, element].
    ///
    /// # Errors
    /// What the core refuses: samples beyond its range.
    pub fn delay(&self, beams: Range<usize>) -> Result<Array3<Complex<f32>>> {
        let shape = (beams.len(), self.samples(), self.scan().elements());
        let mut x = vec![Complex::new(0.0, 0.0); shape.0 * shape.1 * shape.2];
        self.delay_into(beams, &mut x)?;
        Ok(Array3::from_shape_vec(shape, x).expect("the length is that of the shape"))
    }

    /// The same, into memory of that size, which a new frame need not ask the system for again.
    ///
    /// # Errors
    /// What the core refuses.
    pub fn delay_into(&self, beams: Range<usize>, x: &mut [Complex<f32>]) -> Result<()> {
        // Each transmit is checked once, however many beams read it.
        let range = self.transmits(beams.start).start..self.transmits(beams.end.max(1) - 1).end;
        let records = range
            .clone()
            .into_par_iter()
            .map(|transmit| {
                let rf = self.rf.index_axis(Axis(0), transmit);
                let rf = rf
                    .to_slice()
                    .expect("one transmit of a standard layout is contiguous");
                Record::new(rf, self.scan().elements())
            })
            .collect::<std::result::Result<Vec<_>, _>>()?;
        let source = Source {
            transmits: &self.transmits[range.clone()],
            records: &records,
            of_line: &|beam| {
                let own = self.transmits(beam);
                own.start - range.start..own.end - range.start
            },
        };
        align(&self.pipeline, beams, source, x)
    }

    /// The transmits that make a beam.
    fn transmits(&self, beam: usize) -> Range<usize> {
        if matches!(self.data.transmits, Transmits::Focused { .. }) {
            beam..beam + 1
        } else {
            0..self.transmits.len()
        }
    }
}

/// What lines are delayed from.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    /// The transmits.
    pub transmits: &'a [Transmit<'a>],
    /// The record of each.
    pub records: &'a [Record<'a>],
    /// Which of them make a line.
    pub of_line: &'a (dyn Fn(usize) -> Range<usize> + Sync),
}

/// The aligned analytic samples of some lines of a pipeline, `x` as [line, sample, element], on all
/// threads.
///
/// # Errors
/// What the core refuses.
pub fn align(
    pipeline: &LinePipeline<'_>,
    lines: Range<usize>,
    source: Source<'_>,
    x: &mut [Complex<f32>],
) -> Result<()> {
    InstructionSet::detect().dispatch(Align {
        pipeline,
        lines,
        source,
        x,
    })
}

struct Align<'a> {
    pipeline: &'a LinePipeline<'a>,
    lines: Range<usize>,
    source: Source<'a>,
    x: &'a mut [Complex<f32>],
}

impl Task for Align<'_> {
    type Output = Result<()>;

    fn run<V: Vector>(self, zero: V) -> Self::Output {
        let Align {
            pipeline,
            lines,
            source,
            x,
        } = self;
        x.par_chunks_exact_mut(pipeline.aligned_len())
            .zip(lines)
            .try_for_each_init(
                || vec![0.0; pipeline.scratch_len(V::LANES)],
                |scratch, (x, line)| {
                    let own = (source.of_line)(line);
                    let transmits = source.transmits[own.clone()].iter().copied();
                    let transmits = transmits.zip(&source.records[own]);
                    Ok(pipeline.align(zero, line, transmits, scratch, x)?)
                },
            )
    }
}

/// The RF of the one frame of a straight array, which is what is delayed so far.
fn straight_rf(data: &ChannelData) -> Result<CowArray<'_, f32, Ix3>> {
    let not_yet = |what: &str| {
        Err(Error::Data(format!(
            "holds {what}; only one frame of RF of a straight array without a lens, with focused, \
             plane or single-element transmits, is beamformed so far"
        )))
    };
    if matches!(
        data.transmits,
        Transmits::VirtualSource { .. } | Transmits::Delays { .. }
    ) {
        return not_yet("virtual sources or delays of the elements");
    }
    if !data.is_straight() {
        return not_yet("an array that is not straight");
    }
    if data.lens_delay != 0.0 {
        return not_yet("a lens");
    }
    match data.samples.rf(0) {
        Some(rf) if data.samples.frames() == 1 && rf.is_standard_layout() => Ok(rf.into()),
        Some(rf) if data.samples.frames() == 1 => Ok(rf.as_standard_layout().into_owned().into()),
        Some(_) => not_yet("several frames"),
        None => not_yet("I/Q"),
    }
}

/// The delay law of one transmit.
fn law(data: &ChannelData, transmit: usize) -> TransmitLaw<'_> {
    match &data.transmits {
        Transmits::Focused { .. } => TransmitLaw::Focused,
        Transmits::Plane { angle } => TransmitLaw::Plane {
            angle: angle[transmit],
        },
        Transmits::Element { index } => TransmitLaw::Element {
            x: data.element_x[index[transmit]],
            z: 0.0,
        },
        Transmits::VirtualSource { .. } | Transmits::Delays { .. } => {
            unreachable!("refused by `straight_rf`")
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
            "the record leaves no depth: it ends {last} s after the transmit, and begins at {first} s"
        ))),
        _ => Err(Error::Usage(format!(
            "no depth is left between {} m and {} m (--depth-start, --depth-end, or the ends \
             of the record)",
            c * first / 2.0,
            c * last / 2.0
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
