//! All bit-for-bit checks, with hashes: every kernel on a small recording.

use std::hash::Hasher;

use bonebeam::beamform::{AlignedLine, Beamformer, Method, Parameters};
use bonebeam::covariance::Covariance;
use bonebeam::delay::{
    Compounding, Contribution, Delay, DelayParameters, IqDelay, IqInterpolation, IqLayout,
    IqParameters, IqSamples, Record, ScanLine, Stage, Upsampled, hilbert_taps,
};
use bonebeam::geometry::{Active, Array, Ray, Transmit, TransmitLaw};
use bonebeam::simd::InstructionSet;
use fnv::FnvHasher;
use ndarray::{Array2, Array3, Axis};
use num_complex::Complex;

use crate::Result;
use crate::reference;
use crate::verify::recording::recording;
use crate::verify::{self, Bits, Bound};
use bonebeam_drive::beamform::{Memory, Plan, beamform};
use bonebeam_drive::config;
use bonebeam_drive::delay::DelayStage;
use bonebeam_drive::image::{b_mode, grid_of_lines};
use bonebeam_drive::methods::COMPARED;
use bonebeam_drive::phase_symmetry::{self, phase_symmetry};
use bonebeam_drive::threads::pool;
use bonebeam_files::{BeamformedLines, ChannelData};

/// Methods that are not compared elsewhere.
///
/// They are a fixed rank other than 1, and rank 1 in constant time.
const OTHERS: [(&str, Method); 2] = [
    ("ESMV rank 3", Method::EsmvRank(3)),
    ("ESMV rank 1, 8 steps", Method::EsmvRank1Steps(8)),
];

/// One thing that was verified.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// Name of the result and of its reference.
    pub name: String,
    /// FNV-1a, 64 bits, of the core's result in little endian; `None` for a bound.
    pub hash: Option<u64>,
    /// Whether the check passed.
    pub holds: bool,
    /// Number of values compared, and their differences.
    pub detail: String,
}

impl Verdict {
    fn bits(name: String, core: &[f32], bits: &Bits) -> Self {
        let mut hasher = FnvHasher::default();
        for value in core {
            hasher.write(&value.to_bits().to_le_bytes());
        }
        Verdict {
            name,
            hash: Some(hasher.finish()),
            holds: bits.different == 0 && bits.compared > 0,
            detail: format!("{} of {} values differ", bits.different, bits.compared),
        }
    }

    fn bound(name: String, bound: &Bound) -> Self {
        Verdict {
            name,
            hash: None,
            holds: bound.holds(),
            detail: format!(
                "{} values within {:.1e}, {:.0e} allowed; {} ill-conditioned",
                bound.compared, bound.largest_error, bound.bound, bound.ill_conditioned
            ),
        }
    }
}

/// Runs every check; `progress` is called with the number of finished ones.
///
/// # Errors
/// A result that could not be computed. A wrong result is a failed [`Verdict`] instead.
pub fn verify(mut progress: impl FnMut(usize)) -> Result<Vec<Verdict>> {
    let data = recording();
    let mut verdicts = delay_laws(&data)?;
    verdicts.extend(iq_readings(&data)?);
    verdicts.push(upsampled(&data)?);
    progress(verdicts.len());
    let scene = AlignedRecording::new(&data)?;
    for covariance in [Covariance::Forward, Covariance::ForwardBackward] {
        for temporal_half_window in [0, 2, 10] {
            let compared = COMPARED.iter().map(|row| (row.name, row.method));
            for (name, method) in compared.chain(OTHERS) {
                let parameters = Parameters {
                    method,
                    covariance,
                    temporal_half_window,
                    ..Parameters::default()
                };
                verdicts.extend(scene.verify(name, parameters)?);
                progress(verdicts.len());
            }
        }
    }
    verdicts.extend(scene.image_and_phase_symmetry()?);
    progress(verdicts.len());
    Ok(verdicts)
}

/// Real and imaginary parts, one after the other.
fn parts<'a>(z: impl IntoIterator<Item = &'a Complex<f32>>) -> Vec<f32> {
    z.into_iter().flat_map(|z| [z.re, z.im]).collect()
}

/// Every delay law against the f32 reference.
///
/// The law only sets the positions at which the record is read, so one transmit's record serves all three.
fn delay_laws(data: &ChannelData) -> Result<Vec<Verdict>> {
    const RATE: f64 = 20e6;
    let (_, _, elements, record_samples) = data.samples.dim();
    let parameters = DelayParameters {
        sound_speed: data.c,
        sampling_rate: data.fs,
        centre_frequency: data.f0,
        output_rate: RATE,
        output_start: 2.0 * 5e-3 / data.c,
        output_samples: 240,
        elements,
        record_samples,
        hilbert_taps: hilbert_taps(RATE, data.f0),
    };
    let delay = Delay::new(parameters)?;
    let rf = data.samples.rf(0).expect("a recording of RF");
    let record: Vec<f32> = rf.index_axis(Axis(0), 5).iter().copied().collect();
    let laws = [
        ("focused", TransmitLaw::Focused),
        ("plane", TransmitLaw::Plane { angle: 0.2 }),
        (
            "element",
            TransmitLaw::Element {
                x: data.element_x[3],
                z: 0.0,
            },
        ),
    ];
    let verdicts = laws.map(|(name, law)| {
        let line = ScanLine {
            transmit: Transmit {
                law,
                t0: data.t0[5],
            },
            ray: Ray::down(data.element_x[22]),
            array: Array::LinearAt(&data.element_x),
            active: Active::new(0, elements),
            compounding: Compounding::Replace,
        };
        let mut core = vec![Complex::ZERO; parameters.output_samples * elements];
        let mut expected = core.clone();
        let mut scratch = vec![0.0; parameters.need(1).real];
        let checked = Record::new(&record, elements)?;
        delay.line(0.0f32, &line, &checked, &mut scratch, &mut core)?;
        reference::f32::delay::line(&parameters, &line, &record, &mut expected);
        let bits = Bits::complex(&core, &expected);
        Ok(Verdict::bits(
            format!("delay, {name}: f32"),
            &parts(&core),
            &bits,
        ))
    });
    verdicts.into_iter().collect()
}

/// Records upsampled and compounded, against the f32 reference.
///
/// The recording's numbers are taken at another rate, as two plane waves.
fn upsampled(data: &ChannelData) -> Result<Verdict> {
    const RATE: f64 = 20e6;
    let (_, _, elements, record_samples) = data.samples.dim();
    let parameters = DelayParameters {
        sound_speed: data.c,
        sampling_rate: RATE,
        centre_frequency: data.f0,
        output_rate: RATE,
        output_start: 2.0 * 5e-3 / data.c,
        output_samples: 240,
        elements,
        record_samples,
        hilbert_taps: hilbert_taps(RATE, data.f0),
    };
    let rf = data.samples.rf(0).expect("a recording of RF");
    let rf = rf.as_standard_layout();
    let record = |transmit: usize| {
        let own = rf.index_axis(Axis(0), transmit);
        own.to_slice().expect("made in row-major order").to_vec()
    };
    let waves = [(0.1, 4), (-0.2, 5)].map(|(angle, transmit)| {
        let line = ScanLine {
            transmit: Transmit {
                law: TransmitLaw::Plane { angle },
                t0: data.t0[transmit],
            },
            ray: Ray::new(1e-3, 0.0, 0.1),
            array: Array::LinearAt(&data.element_x),
            active: Active::new(1, elements - 2),
            compounding: Compounding::Replace,
        };
        (line, record(transmit))
    });
    let delay = Delay::new(parameters)?;
    let upsampled = Upsampled::new(&delay)?;
    let length = upsampled.line_len();
    let mut values = vec![0.0; (elements - 2) * length];
    let (mut centre, mut receive_delays) = (vec![0; length], vec![0; length]);
    let mut fine = vec![0.0; upsampled.record_len()];
    let mut padded = vec![0.0; upsampled.need().real];
    for (line, rf) in &waves {
        upsampled.centre(line, &mut centre)?;
        for (k, values) in values.chunks_exact_mut(length).enumerate() {
            let element = line.active.first + k;
            let samples = &rf[element * record_samples..][..record_samples];
            upsampled.record(0.0f32, samples, &mut padded, &mut fine)?;
            upsampled.receive_delays(0.0f32, line, element, &mut receive_delays)?;
            let contribution = Contribution {
                record: &fine,
                centre: &centre,
                receive_delays: &receive_delays,
            };
            upsampled.add(0.0f32, &contribution, values)?;
        }
    }
    let mut core = vec![Complex::ZERO; parameters.output_samples * elements];
    let mut expected = core.clone();
    let mut scratch = vec![0.0; parameters.need(1).real];
    upsampled.analytic(0.0f32, &waves[0].0, &values, &mut scratch, &mut core)?;
    let waves: Vec<(ScanLine<'_>, &[f32])> =
        waves.iter().map(|(line, rf)| (*line, &rf[..])).collect();
    reference::f32::delay::upsampled(&parameters, &waves, &mut expected);
    Ok(Verdict::bits(
        "delay, upsampled: f32".into(),
        &parts(&core),
        &Bits::complex(&core, &expected),
    ))
}

/// Every interpolation of I/Q against the f32 reference.
///
/// The line is a ray of a sector, and the wave diverging. Only the recording's numbers are used, not its scene.
fn iq_readings(data: &ChannelData) -> Result<Vec<Verdict>> {
    let (_, _, elements, record_samples) = data.samples.dim();
    let rf = data.samples.rf(0).expect("a recording of RF");
    let iq = rf
        .index_axis(Axis(0), 5)
        .mapv(|v| Complex::new(v, -0.5 * v));
    let iq = iq.as_slice().expect("made in row-major order");
    let record = Record::iq(IqSamples::Float(iq), IqLayout::Planar, elements)?;
    let line = ScanLine {
        transmit: Transmit {
            law: TransmitLaw::VirtualSource { x: 2e-3, z: -10e-3 },
            t0: data.t0[5],
        },
        ray: Ray::new(0.0, 0.0, 0.3),
        array: Array::LinearAt(&data.element_x),
        active: Active::new(0, elements),
        compounding: Compounding::Replace,
    };
    let interpolations = [
        ("linear", IqInterpolation::Linear),
        ("cubic", IqInterpolation::Cubic),
        ("sinc", IqInterpolation::Sinc),
    ];
    let verdicts = interpolations.map(|(name, interpolation)| {
        let parameters = IqParameters {
            sound_speed: data.c,
            sampling_rate: data.fs,
            demodulation_frequency: data.f0,
            output_rate: 12e6,
            output_start: 2.0 * 5e-3 / data.c,
            output_samples: 240,
            elements,
            record_samples,
            interpolation,
        };
        let delay = IqDelay::new(parameters)?;
        let mut core = vec![Complex::ZERO; parameters.output_samples * elements];
        let mut expected = core.clone();
        let mut scratch = vec![0.0; parameters.need(1).real];
        delay.line(0.0f32, &line, &record, &mut scratch, &mut core)?;
        reference::f32::iq::line(&parameters, &line, (iq, 1.0, 0.0), &mut expected);
        let bits = Bits::complex(&core, &expected);
        Ok(Verdict::bits(
            format!("delay, I/Q, {name}: f32"),
            &parts(&core),
            &bits,
        ))
    });
    verdicts.into_iter().collect()
}

/// The delayed recording, with a growing aperture that is cut at the array's ends.
struct AlignedRecording<'a> {
    stage: DelayStage<'a>,
    x: Array3<Complex<f32>>,
}

impl<'a> AlignedRecording<'a> {
    fn new(data: &'a ChannelData) -> Result<Self> {
        let settings = config::Beamform {
            f_number: 1.0,
            sub_lines: Some(1),
            ..config::Beamform::default()
        };
        let stage = DelayStage::new(data, &settings)?;
        let x = stage.delay(0..stage.beam_x().len())?;
        Ok(AlignedRecording { stage, x })
    }

    fn active(&self, beam: usize, sample: usize) -> Active {
        self.stage.active(beam, sample)
    }

    fn beamform(&self, parameters: Parameters) -> Result<Array2<Complex<f32>>> {
        let active = |beam: usize, sample: usize| self.active(beam, sample);
        beamform(self.x.view(), &active, parameters, &|_| {})
    }

    /// One beamformer against both references, with one lane and other thread counts.
    fn verify(&self, name: &str, parameters: Parameters) -> Result<Vec<Verdict>> {
        let side = match parameters.covariance {
            Covariance::Forward => "forward",
            Covariance::ForwardBackward => "forward-backward",
        };
        let name = format!("{name}, {side}, K={}", parameters.temporal_half_window);
        let z = self.beamform(parameters)?;
        let numbers = parts(&z);
        let frame = verify::beamform::AlignedFrame {
            x: &self.x,
            active: |beam, sample| self.active(beam, sample),
        };
        let bits = frame.bits(&z, parameters, 1);
        let mut verdicts = vec![Verdict::bits(format!("{name}: f32"), &numbers, &bits)];
        for error in frame.errors(&[(&z, parameters)], 6)? {
            verdicts.push(Verdict::bound(format!("{name}: f64"), &error));
        }
        let one_line = self.one_line(parameters)?;
        let bits = Bits::real(&parts(&one_line), &numbers);
        verdicts.push(Verdict::bits(
            format!("{name}: a line at a time"),
            &numbers,
            &bits,
        ));
        for set in InstructionSet::available() {
            let active = |beam, sample| self.active(beam, sample);
            let x = self.x.view();
            let plan = Plan::new(set, parameters, x.dim().2)?;
            let again = plan.run(x, &active, &|_| {})?;
            let bits = Bits::real(&parts(&again), &numbers);
            verdicts.push(Verdict::bits(
                format!("{name}: {}", set.name()),
                &numbers,
                &bits,
            ));
        }
        for count in [1, 2, 7] {
            let again = pool(count)?.install(|| self.beamform(parameters))?;
            let bits = Bits::real(&parts(&again), &numbers);
            verdicts.push(Verdict::bits(
                format!("{name}: threads {count}"),
                &numbers,
                &bits,
            ));
        }
        Ok(verdicts)
    }

    /// As a microcontroller would: one lane, one line at a time.
    fn one_line(&self, parameters: Parameters) -> Result<Array2<Complex<f32>>> {
        let (beams, samples, elements) = self.x.dim();
        let mut z = Array2::zeros((beams, samples));
        let beamformer = Beamformer::new(parameters)?;
        let mut memory = Memory::new(0.0, beamformer.sizes(elements))?;
        let mut line = vec![Complex::ZERO; samples];
        for beam in 0..beams {
            let x: Vec<_> = self.x.index_axis(Axis(0), beam).iter().copied().collect();
            let delayed = AlignedLine::new(&x, elements)?;
            let active = |sample| self.active(beam, sample);
            beamformer.line(&mut memory.view(), delayed, active, &mut line)?;
            z.row_mut(beam).assign(&ndarray::aview1(&line));
        }
        Ok(z)
    }

    /// The DAS image against both references, then its phase symmetry: the whole transform
    /// against both, and every strip height against the whole.
    fn image_and_phase_symmetry(&self) -> Result<Vec<Verdict>> {
        const RANGE: f32 = 60.0;
        let parameters = Parameters {
            method: Method::Das,
            ..Parameters::default()
        };
        let lines = BeamformedLines {
            z: self.beamform(parameters)?,
            fs: 20e6,
            t0: self.stage.start(),
            beam_x: self.stage.beam_x().to_vec(),
            rays: None,
            sub_lines: 1,
            c: self.stage.sound_speed(),
        };
        let grid = grid_of_lines(&lines, 128, 128)?;
        let image = b_mode(&lines, RANGE, &grid, true)?;
        let (bits, error) = verify::image::check(&image, &lines, f64::from(RANGE), &grid, true);
        let pixels: Vec<f32> = image.pixels.iter().copied().collect();
        let mut verdicts = vec![
            Verdict::bits("image: f32".into(), &pixels, &bits),
            Verdict::bound("image: f64".into(), &error),
        ];
        for scales in [&[7, 8, 9][..], &[5, 6, 7, 8, 9]] {
            let mut parameters = phase_symmetry::Parameters {
                scales: scales.iter().map(|&power| 0.5f64.powi(power)).collect(),
                threshold: 15.0,
                strip: grid.rows,
            };
            let name = format!("phase symmetry, {} filters", 6 * scales.len());
            let map = phase_symmetry(image.pixels.view(), &parameters, &mut |_, _| {})?;
            let numbers: Vec<f32> = map.iter().copied().collect();
            let (bits, error) = verify::phase_symmetry::check(&map, &image.pixels, &parameters);
            verdicts.push(Verdict::bits(format!("{name}: f32"), &numbers, &bits));
            verdicts.push(Verdict::bound(format!("{name}: f64"), &error));
            for strip in [1, 7, 16, 64] {
                parameters.strip = strip;
                let strips = phase_symmetry(image.pixels.view(), &parameters, &mut |_, _| {})?;
                let strips: Vec<f32> = strips.iter().copied().collect();
                let bits = Bits::real(&strips, &numbers);
                verdicts.push(Verdict::bits(
                    format!("{name}: strips of {strip}"),
                    &numbers,
                    &bits,
                ));
            }
        }
        Ok(verdicts)
    }
}
