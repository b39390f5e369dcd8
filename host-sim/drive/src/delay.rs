//! The delay stage of a recording: its lines, its depths and their input.

use std::f64::consts::FRAC_PI_2;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use bonebeam::beamform::Parameters;
use bonebeam::delay::{Delay, DelayParameters, IqLayout, IqSamples, MAX_SAMPLES, Record};
use bonebeam::geometry::{
    Active, Aperture, Array, Axis, Depth, Element, Lines, Ray, Scan, ScanParameters, Transmit,
    TransmitLaw,
};
use bonebeam::image::DepthInterpolation;
use bonebeam::pipeline::{IqInput, LinePipeline};
use bonebeam::simd::InstructionSet;
use bonebeam_kernels::Compounded;
use bonebeam_kernels::source::{LineSource, Recorded};
use ndarray::{Array3, ArrayView2, ArrayView3, ArrayViewMut2, CowArray, Ix3};
use num_complex::Complex;

use super::beams::{self, Beams};
use super::lens::Lens;
use super::limits::{check_depths, check_rate, check_upsampling, record_times};
use super::records::{in_float, picked, records};
use super::sub_lines::SubLines;
use crate::config::{Beamform, RfInterpolation};
use crate::{Error, Result};
use bonebeam_files::npz::Spare;
use bonebeam_files::terminal::digits;
use bonebeam_files::{BeamRays, BeamformedLines, ChannelData, FrameSamples, Samples};
use bonebeam_files::{StoredFrame, Transmits};

/// Number of compounded transmits from which on upsampled records are the default: they cost less than the filter.
pub(crate) const UPSAMPLED_FROM: usize = 2;
/// Number of lines whose records are upsampled at a time; limited by memory.
pub(crate) const LINES_UPSAMPLED: usize = 128;
/// Parts of a frame that are converted from counts to f32 in turn, if each line has its own transmit.
const COUNTED_PASSES: usize = 8;

/// The delay stage of one set of channel data: beams, depths, elements.
///
/// Focused transmits make one beam each, on their axis; those at one position are averaged. So do virtual sources in
/// front of the array if none is behind another. Beams go from left to right, in any order of transmits. Other
/// transmits are compounded coherently (their mean) into two beams per element (one if the recording decides the number
/// of sub-lines), or into the requested beams.
pub struct DelayStage<'a> {
    data: &'a ChannelData,
    /// None if the array is straight.
    elements: Vec<Element>,
    lens: Lens,
    beams: Beams,
    sub_lines: SubLines,
    interpolation: DepthInterpolation,
    beam_x: Vec<f64>,
    /// Position at which each beam leaves the array, in elements.
    centres: Vec<f64>,
    /// Parameters without array and lines.
    parameters: ScanParameters<'static>,
    aperture: Aperture,
    start: f64,
    samples: usize,
    stage: Stage,
    transmits: Vec<Transmit<'a>>,
    set: InstructionSet,
    /// Whether each record is upsampled once for all lines.
    upsampled: bool,
    /// Factor of each transmit's record, if they differ.
    factors: Option<Vec<f32>>,
    /// For counts as f32 and samples from a file; memory that is used again costs less than fresh memory.
    spare: Mutex<Spare>,
}

/// The core's stage for this kind of samples.
enum Stage {
    Rf(Box<Delay>),
    Iq(IqInput),
}

impl<'a> DelayStage<'a> {
    /// Plans the delays of `data`.
    ///
    /// The depths are `depth_start` to `depth_end` of the parameters, or the whole record.
    ///
    /// # Errors
    /// [`Error::Usage`] for an output rate, a depth or lines that do not fit the record.
    pub fn new(data: &'a ChannelData, parameters: &Beamform) -> Result<Self> {
        let c = parameters.sound_speed.unwrap_or(data.c);
        let rate = parameters.rate_of(data);
        if data.samples.f_demod().is_none() {
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
        let lens = Lens::new(parameters, c);
        let [start, end] = [start, end].map(|depth| match depth {
            Depth::Metres(depth) => Depth::Metres(depth + lens.behind()),
            Depth::Seconds(time) => Depth::Seconds(time + 2.0 * lens.behind() / c),
        });
        let elements = lens.moved(beams::elements_of(data));
        let array = beams::array_of(data, &elements);
        let beams = Beams::new(data, &array, parameters)?;
        let own = ScanParameters {
            array: Array::LinearAt(&[]),
            lines: Lines::Rays(&[]),
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
        let scan = scan(data, array, &beams, own)?;
        if scan.samples() > MAX_SAMPLES {
            return Err(Error::Usage(format!(
                "the depths and --output-rate make {} samples per line; expected at most \
                 {MAX_SAMPLES}",
                scan.samples()
            )));
        }
        let stage = match data.samples.f_demod() {
            None => Stage::Rf(Box::new(Delay::new(DelayParameters::of(&scan))?)),
            Some(f_demod) => {
                let iq = IqInput {
                    demodulation_frequency: f_demod,
                    interpolation: parameters.iq_interpolation.map(Into::into),
                };
                LinePipeline::of_iq(scan, iq, Parameters::DEFAULT)?;
                Stage::Iq(iq)
            }
        };
        let delay = match &stage {
            Stage::Rf(delay) => Some(&**delay),
            Stage::Iq(_) => None,
        };
        let upsampled = match parameters.rf_interpolation {
            Some(RfInterpolation::Filtered) => false,
            Some(RfInterpolation::Upsampled) => {
                check_upsampling(delay, beams.own).map(|()| true)?
            }
            None => transmits >= UPSAMPLED_FROM && check_upsampling(delay, beams.own).is_ok(),
        };
        let factors = match &parameters.transmit_weights {
            Some(_) if beams.own => {
                let message =
                    "--transmit-weights is for compounded transmits; these make one line each";
                return Err(Error::Usage(message.into()));
            }
            Some(weights) => Some(weights.factors(transmits, parameters.tukey_taper as f32)?),
            None => None,
        };
        let late = late(data, lens, c);
        let transmit = |t| Transmit {
            law: law(data, &elements, t),
            t0: data.t0[t] - late,
        };
        let transmits: Vec<Transmit> = match &beams.order {
            Some(order) => order.iter().copied().map(transmit).collect(),
            None => (0..transmits).map(transmit).collect(),
        };
        let mut sub_lines = SubLines::new(data, &beams, parameters);
        for ray in &mut sub_lines.rays {
            *ray = lens.at_face(*ray);
        }
        let angles = || sub_lines.rays.iter().map(Ray::angle);
        if let Some(beyond) = angles().find(|angle| angle.abs() >= FRAC_PI_2) {
            return Err(Error::Usage(format!(
                "the lines and --sub-lines have a direction of {} rad; expected less than pi/2 to either side",
                digits(beyond)
            )));
        }
        Ok(Self {
            beam_x: sub_lines.rays.iter().map(Ray::x).collect(),
            sub_lines,
            interpolation: DepthInterpolation::of(&scan, parameters.depth_step())?,
            centres: (0..scan.lines())
                .map(|line| scan.aperture_centre(line))
                .collect(),
            aperture: *scan.aperture(),
            start: scan.start() - 2.0 * lens.behind() / c,
            samples: scan.samples(),
            parameters: own,
            stage,
            transmits,
            data,
            elements,
            lens,
            beams,
            set: InstructionSet::detect(),
            upsampled,
            factors,
            spare: Mutex::default(),
        })
    }

    /// The same stage with a given instruction set; the result does not depend on it.
    pub fn with_instruction_set(self, set: InstructionSet) -> Self {
        DelayStage { set, ..self }
    }

    /// Lateral positions of [`DelayStage::all_rays`], m, at their beginning.
    pub fn beam_x(&self) -> &[f64] {
        &self.beam_x
    }

    /// The aligned beams.
    pub fn rays(&self) -> &[Ray] {
        &self.beams.rays
    }

    /// The output lines.
    ///
    /// They are the beams, or their sub-lines in order, or lines that are each the largest of some sub-lines.
    pub fn all_rays(&self) -> &[Ray] {
        &self.sub_lines.rays
    }

    /// Number of sub-lines of a beam.
    pub fn sub_lines(&self) -> usize {
        self.sub_lines.count
    }

    /// Number of sub-lines pooled into each output line; `None` if each is output.
    pub fn pooled(&self) -> Option<usize> {
        self.sub_lines.pooled()
    }

    /// Approximate largest loss of a point between two lines or sub-lines, dB.
    ///
    /// `None` for DAS. It counts the transmits that are compounded, whose delays are those of the line.
    pub fn loss_between(&self) -> Option<f64> {
        self.sub_lines.loss
    }

    /// The output lines, from all sub-lines of all beams.
    ///
    /// # Errors
    /// A sample that is not finite.
    pub(super) fn pool(
        &self,
        all: ArrayView2<'_, Complex<f32>>,
        z: ArrayViewMut2<'_, Complex<f32>>,
    ) -> Result<()> {
        self.sub_lines.pool(all, &self.interpolation, z)
    }

    /// The scan of the beams.
    ///
    /// # Errors
    /// None: it is that of [`DelayStage::new`].
    pub(super) fn scan(&self) -> Result<Scan<'_>> {
        scan(self.data, self.array(), &self.beams, self.parameters)
    }

    /// Whether lines are output as beamformed: neither pooled nor interpolated.
    pub(super) fn puts_out_beamformed(&self) -> bool {
        self.pooled().is_none() && self.interpolation.depth_step() == 1
    }

    /// Number of output samples of a beam that are beamformed; others are interpolated.
    pub fn line_samples(&self) -> usize {
        self.interpolation.line_samples()
    }

    /// Output samples per beam.
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
        Axis::new(
            self.parameters.sound_speed * self.start / 2.0,
            self.parameters.sound_speed / self.parameters.output_rate / 2.0,
            self.samples,
        )
    }

    /// The speed of sound in use, m/s.
    pub fn sound_speed(&self) -> f64 {
        self.parameters.sound_speed
    }

    /// Active elements of a beam at an output sample; none for an unknown beam.
    pub fn active(&self, beam: usize, sample: usize) -> Active {
        let time = self.start + sample as f64 / self.parameters.output_rate;
        let centre = self.centres.get(beam).copied().unwrap_or(f64::NAN);
        let depth = self.parameters.sound_speed * time / 2.0 + self.lens.behind();
        self.aperture.active(centre, depth)
    }

    /// Origins and directions of the beams, if not straight down from z = 0.
    pub fn beam_rays(&self) -> Option<BeamRays> {
        let down = |ray: &Ray| ray.z() == 0.0 && ray.angle() == 0.0;
        let rays = self.all_rays();
        (!rays.iter().all(down)).then(|| BeamRays {
            z: rays.iter().map(Ray::z).collect(),
            angle: rays.iter().map(Ray::angle).collect(),
        })
    }

    /// Beamformed lines `z` with their positions and times.
    pub fn lines<Z>(&self, z: Z) -> BeamformedLines<Z> {
        BeamformedLines {
            z,
            fs: self.parameters.output_rate,
            t0: self.start,
            beam_x: self.beam_x.clone(),
            rays: self.beam_rays(),
            sub_lines: self.sub_lines.put_out(),
            c: self.parameters.sound_speed,
        }
    }

    /// Aligned analytic samples of some beams of the first frame.
    ///
    /// The axes are [beam, sample, element].
    ///
    /// # Errors
    /// An error of the core: samples beyond its range.
    pub fn delay(&self, beams: Range<usize>) -> Result<Array3<Complex<f32>>> {
        let first = self.data.samples.frame(0);
        let first = first.ok_or_else(|| Error::Data("the recording has no frame".into()))?;
        let mut x = Array3::zeros((beams.len(), self.samples, self.elements()));
        let own = x.as_slice_mut().expect("a standard layout");
        self.delay_into(first, beams, own)?;
        Ok(x)
    }

    /// As [`DelayStage::delay`], for any frame of this shape, into the caller's memory.
    ///
    /// # Errors
    /// An error of the core: samples beyond its range, or of another shape.
    pub fn delay_into(
        &self,
        frame: FrameSamples<'_>,
        beams: Range<usize>,
        x: &mut [Complex<f32>],
    ) -> Result<()> {
        let own = beams.clone();
        self.source(frame, beams, Parameters::DEFAULT, &mut |source| {
            source.align_lines(self.set, own.clone(), x)
        })
    }

    /// Ranges of lines that are beamformed together, one source each.
    pub(super) fn passes(&self) -> impl Iterator<Item = Range<usize>> + use<> {
        let lines = self.rays().len();
        let at_a_time = match self.data.samples {
            _ if self.upsampled => LINES_UPSAMPLED,
            Samples::Counts(_) if self.beams.own => lines.div_ceil(COUNTED_PASSES),
            Samples::Stored(_) if self.beams.own => lines.div_ceil(StoredFrame::WINDOWS),
            _ => lines,
        };
        let firsts = (0..lines).step_by(at_a_time.max(1));
        firsts.map(move |first| first..lines.min(first + at_a_time))
    }

    /// Passes the source of some lines of a frame to `work`.
    ///
    /// # Errors
    /// Errors of the core and of `work`.
    pub(super) fn source(
        &self,
        frame: FrameSamples<'_>,
        lines: Range<usize>,
        beamformer: Parameters,
        work: &mut dyn FnMut(&LineSource<'_>) -> Result<()>,
    ) -> Result<()> {
        let own = self.beams.transmits_of(&lines);
        let own = own.unwrap_or(0..self.transmits.len());
        let order = self.beams.order.as_ref().map(|order| &order[own.clone()]);
        let by = (own.clone(), lines, beamformer);
        let FrameSamples::Stored(stored) = frame else {
            return self.source_of_some(frame, (order, own), by, work);
        };
        let spare = || self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        let chosen = order.map_or_else(|| own.collect(), <[_]>::to_vec);
        let read = stored.read(&chosen, &mut spare())?;
        let frame = read.frame(0).expect("one frame is read");
        let done = self.source_of_some(frame, (None, 0..chosen.len()), by, work);
        read.leave(&mut spare());
        done
    }

    /// [`DelayStage::source`] with the transmits of a range, or those of an order, of a frame in memory.
    fn source_of_some(
        &self,
        frame: FrameSamples<'_>,
        (order, own): (Option<&[usize]>, Range<usize>),
        by: (Range<usize>, Range<usize>, Parameters),
        work: &mut dyn FnMut(&LineSource<'_>) -> Result<()>,
    ) -> Result<()> {
        match frame {
            FrameSamples::Rf(rf) => {
                let rf = picked(rf, order, own);
                self.source_of(FrameSamples::Rf(rf.view()), by, work)
            }
            FrameSamples::Counts(counts) => {
                let counts = picked(counts, order, own);
                let spare = || self.spare.lock().unwrap_or_else(PoisonError::into_inner);
                let mut floats = std::mem::take(&mut spare().real);
                let rf = in_float(counts.view(), &mut floats);
                let done = self.source_of(FrameSamples::Rf(rf), by, work);
                spare().real = floats;
                done
            }
            FrameSamples::Iq { iq, f_demod } => {
                let iq = picked(iq, order, own);
                let iq = iq.view();
                self.source_of(FrameSamples::Iq { iq, f_demod }, by, work)
            }
            FrameSamples::Stored(_) => Err(other_kind()),
        }
    }

    /// [`DelayStage::source`] with the samples of the lines' transmits alone.
    fn source_of(
        &self,
        samples: FrameSamples<'_>,
        (transmits, lines, beamformer): (Range<usize>, Range<usize>, Parameters),
        work: &mut dyn FnMut(&LineSource<'_>) -> Result<()>,
    ) -> Result<()> {
        let scan = self.scan()?;
        let first = transmits.start;
        let transmits = &self.transmits[transmits];
        let of_line = |line: usize| match self.beams.of_lines.get(line) {
            Some(of) => of.start - first..of.end - first,
            None => 0..transmits.len(),
        };
        // What is not in row-major order is put into it, and each transmit is checked, once.
        match (&self.stage, samples) {
            (Stage::Rf(delay), FrameSamples::Rf(rf)) => {
                let rf = self.weighted(&rf);
                let records = records(rf.view(), Record::new)?;
                if self.upsampled {
                    let rf = rf.as_slice().expect("a standard layout is contiguous");
                    let by = (&**delay, scan);
                    let largest = records.iter().map(Record::largest_aligned);
                    let rf = (rf, largest.fold(0.0, f32::max));
                    let compounded = Compounded::new(self.set, by, transmits, rf, lines)?;
                    return work(&LineSource::Upsampled(Box::new(compounded)));
                }
                work(&LineSource::Rf(Recorded {
                    pipeline: LinePipeline::by(delay, scan, beamformer)?,
                    transmits,
                    records: &records,
                    of_line: &of_line,
                }))
            }
            (Stage::Iq(input), FrameSamples::Iq { iq, f_demod }) => {
                // Demodulated from the moment of t0, which a lens puts off.
                let late = late(self.data, self.lens, self.sound_speed());
                let phase = (late * f_demod).rem_euclid(1.0) * std::f64::consts::TAU;
                let iq = self.weighted(&iq);
                let records = records(iq.view(), |iq, elements| {
                    Record::iq(IqSamples::Float(iq), IqLayout::Planar, elements)?.with_phase(phase)
                })?;
                let pipeline = LinePipeline::of_iq(scan, *input, beamformer)?;
                work(&LineSource::Iq(Recorded {
                    pipeline: pipeline.by_reference(),
                    transmits,
                    records: &records,
                    of_line: &of_line,
                }))
            }
            _ => Err(other_kind()),
        }
    }

    /// Samples in row-major order, each transmit's times its factor.
    fn weighted<'s, T>(&self, samples: &'s ArrayView3<'_, T>) -> CowArray<'s, T, Ix3>
    where
        T: Copy + std::ops::Mul<f32, Output = T>,
    {
        let Some(factors) = &self.factors else {
            return samples.as_standard_layout();
        };
        let mut weighted = samples.as_standard_layout().into_owned();
        for (mut record, &factor) in weighted.outer_iter_mut().zip(factors) {
            record.mapv_inplace(|sample| sample * factor);
        }
        weighted.into()
    }

    fn array(&self) -> Array<'_> {
        beams::array_of(self.data, &self.elements)
    }
}

pub(crate) fn other_kind() -> Error {
    Error::Data("the frame is of another kind of data than the recording".into())
}

/// The scan of a recording's lines.
fn scan<'s>(
    data: &ChannelData,
    array: Array<'s>,
    beams: &'s Beams,
    parameters: ScanParameters<'static>,
) -> Result<Scan<'s>> {
    let parameters = ScanParameters {
        array,
        lines: Lines::Rays(&beams.rays),
        ..parameters
    };
    Ok(match data.samples.f_demod() {
        None => Scan::new(parameters)?,
        Some(_) => Scan::of_iq(parameters)?,
    })
}

/// By how much a lens delays what is heard, there and back, beside the way from where the elements seem to lie, s.
fn late(data: &ChannelData, lens: Lens, c: f64) -> f64 {
    2.0 * (data.lens_delay - lens.behind() / c)
}

/// The delay law of one transmit; `elements` are given if the array is not straight.
fn law<'d>(data: &'d ChannelData, elements: &[Element], transmit: usize) -> TransmitLaw<'d> {
    match &data.transmits {
        Transmits::Focused { .. } => TransmitLaw::Focused,
        Transmits::Plane { angle } => TransmitLaw::Plane {
            angle: angle[transmit],
        },
        Transmits::Element { index } => {
            let at = index[transmit];
            let [x, z] = elements
                .get(at)
                .map_or_else(|| data.element(at), |e| [e.x, e.z]);
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
