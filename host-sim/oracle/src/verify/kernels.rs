//! All bit-for-bit checks, with hashes: every kernel on a small recording.

use std::hash::Hasher;

use bonebeam::beamform::Parameters;
use bonebeam::delay::hilbert_taps;
use bonebeam::prelude::stages::*;
use fnv::FnvHasher;
use ndarray::{Array2, Array3, Axis};
use num_complex::Complex;

use crate::Result;
use crate::reference::plain::Plain;
use crate::verify::recording::recording;
use crate::verify::{self, Bits, Bound};
use bonebeam_drive::beamform::{Memory, Plan, beamform};
use bonebeam_drive::config;
use bonebeam_drive::delay::DelayStage;
use bonebeam_drive::image::{b_mode, grid_of_lines};
use bonebeam_drive::methods::COMPARED;
use bonebeam_drive::phase_symmetry::{self, phase_symmetry};
use bonebeam_drive::threads::pool;
use bonebeam_files::ChannelData;
use bonebeam_tests::kernel::over_one_lane;
use bonebeam_tests::kernels::delay::{self, Input, Iq, Law, Place};
use bonebeam_tests::kernels::upsampled::Waves;

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

    /// Another way to the core's result.
    fn again(name: String, core: &[f32], again: &[f32]) -> Self {
        Verdict::bits(name, core, &Bits::real(again, core))
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
    verdicts.extend(iq_interpolations(&data)?);
    verdicts.push(upsampled(&data)?);
    progress(verdicts.len());
    let scene = AlignedRecording::new(&data)?;
    for covariance in [Covariance::Forward, Covariance::ForwardBackward] {
        for temporal_half_window in [0, 2, 10] {
            let compared = COMPARED.iter().map(|row| (row.name, row.method));
            for (name, method) in compared.chain(OTHERS) {
                let parameters = Parameters {
                    covariance,
                    temporal_half_window,
                    ..Parameters::of(method)
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

/// A kernel of the catalogue against the f32 reference.
fn delayed(name: &str, kernel: &impl Plain<Number = Complex<f32>>) -> Result<Verdict> {
    let core = over_one_lane(kernel)?;
    let bits = Bits::complex(&core, &kernel.plain().unwrap_or_default());
    let name = format!("delay, {name}: f32");
    Ok(Verdict::bits(name, &parts(&core), &bits))
}

/// The numbers of a transmit, `[element][sample]`.
fn record(data: &ChannelData, transmit: usize) -> Vec<f32> {
    let rf = data.samples.rf(0).expect("a recording of RF");
    rf.index_axis(Axis(0), transmit).iter().copied().collect()
}

fn stage(data: &ChannelData, sampling_rate: f64) -> Result<Delay> {
    const RATE: f64 = 20e6;
    let (_, _, elements, record_samples) = data.samples.dim();
    Ok(Delay::new(DelayParameters {
        sound_speed: data.c,
        sampling_rate,
        centre_frequency: data.f0,
        output_rate: RATE,
        output_start: 2.0 * 5e-3 / data.c,
        output_samples: 240,
        elements,
        record_samples,
        hilbert_taps: hilbert_taps(RATE, data.f0),
    })?)
}

/// Lines of the sixth transmit's numbers.
fn lines(data: &ChannelData, law: TransmitLaw<'static>, ray: Ray, input: Input) -> delay::Lines {
    delay::Lines {
        place: Place::Level(data.element_x.clone()),
        waves: vec![(Law::Of(law), data.t0[5], ray)],
        active: Active::new(0, data.element_x.len()),
        block: 1,
        input,
    }
}

/// Every delay law.
///
/// The law only sets the positions at which the record is read, so one transmit's record serves all three.
fn delay_laws(data: &ChannelData) -> Result<Vec<Verdict>> {
    let (x, stage) = (data.element_x[3], stage(data, data.fs)?);
    let laws = [
        ("focused", TransmitLaw::Focused),
        ("plane", TransmitLaw::Plane { angle: 0.2 }),
        ("element", TransmitLaw::Element { x, z: 0.0 }),
    ];
    let verdicts = laws.into_iter().map(|(name, law)| {
        let input = Input::Rf(Box::new(stage.clone()), record(data, 5), false);
        let ray = Ray::down(data.element_x[22]);
        delayed(name, &lines(data, law, ray, input))
    });
    verdicts.collect()
}

/// Records upsampled and compounded.
///
/// The recording's numbers are taken at another rate, as two plane waves.
fn upsampled(data: &ChannelData) -> Result<Verdict> {
    let wave = |(angle, transmit): (f64, usize)| {
        let law = Law::Of(TransmitLaw::Plane { angle });
        (law, data.t0[transmit], record(data, transmit))
    };
    let waves = Waves {
        delay: stage(data, 20e6)?,
        place: Place::Level(data.element_x.clone()),
        waves: [(0.1, 4), (-0.2, 5)].map(wave).into(),
        ray: Ray::new(1e-3, 0.0, 0.1),
        active: Active::new(1, data.element_x.len() - 2),
        block: 1,
    };
    delayed("upsampled", &waves)
}

/// Every interpolation of I/Q.
///
/// The line is a ray of a sector, and the wave diverging. Only the recording's numbers are used, not its scene.
fn iq_interpolations(data: &ChannelData) -> Result<Vec<Verdict>> {
    let (_, _, elements, record_samples) = data.samples.dim();
    let planar = record(data, 5)
        .into_iter()
        .map(|v| Complex::new(v, -0.5 * v));
    let iq = Iq {
        planar: planar.collect(),
        counts: None,
        interleaved: false,
        phase: 0.0,
    };
    let interpolations = [
        ("linear", IqInterpolation::Linear),
        ("cubic", IqInterpolation::Cubic),
        ("sinc", IqInterpolation::Sinc),
    ];
    let verdicts = interpolations.into_iter().map(|(name, interpolation)| {
        let stage = IqDelay::new(IqParameters {
            sound_speed: data.c,
            sampling_rate: data.fs,
            demodulation_frequency: data.f0,
            output_rate: 12e6,
            output_start: 2.0 * 5e-3 / data.c,
            output_samples: 240,
            elements,
            record_samples,
            interpolation,
        })?;
        let law = TransmitLaw::VirtualSource { x: 2e-3, z: -10e-3 };
        let input = Input::Iq(stage, iq.clone());
        let kernel = lines(data, law, Ray::new(0.0, 0.0, 0.3), input);
        delayed(&format!("I/Q, {name}"), &kernel)
    });
    verdicts.collect()
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
        let mut same = |way: &str, z: &Array2<_>| {
            verdicts.push(Verdict::again(
                format!("{name}: {way}"),
                &numbers,
                &parts(z),
            ));
        };
        same("a line at a time", &self.one_line(parameters)?);
        for set in InstructionSet::available() {
            let active = |beam, sample| self.active(beam, sample);
            let x = self.x.view();
            let plan = Plan::new(set, parameters, x.dim().2)?;
            same(set.name(), &plan.run(x, &active, &|_| {})?);
        }
        for count in [1, 2, 7] {
            let again = pool(count)?.install(|| self.beamform(parameters))?;
            same(&format!("threads {count}"), &again);
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
        let parameters = Parameters::of(Method::Das);
        let lines = self.stage.lines(self.beamform(parameters)?);
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
                let name = format!("{name}: strips of {strip}");
                verdicts.push(Verdict::again(name, &numbers, &strips));
            }
        }
        Ok(verdicts)
    }
}
