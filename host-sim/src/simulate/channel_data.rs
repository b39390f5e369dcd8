//! Channel data of focused transmits by the full-matrix method.
//!
//! 1. The echo spectrum of every element pair (see `pair_spectra`).
//! 2. Beam l, receiver j: S(f) = Σ_i H_ij(f)·e^{+j2πfτ_i} over the transmit aperture, with the
//!    focusing advance τ_i = (√(x_i² + F²) − F)/c for x_i from the beam's axis and the focus F.
//! 3. An inverse transform per row at the record's sampling frequency; electronic noise.
//!
//! Time 0 is the moment at which the transmit wave passes z = 0 on the beam's axis. The result's
//! bits do not depend on the number of threads.

use std::f64::consts::TAU;
use std::sync::atomic::{AtomicUsize, Ordering};

use ndarray::Array3;
use num_complex::Complex;
use rayon::prelude::*;
use realfft::RealFftPlanner;

use crate::files::{ChannelData, Transmits};
use crate::memory::{self, product};
use crate::{Error, Result};

use super::element;
use super::noise;
use super::pair_spectra::{PairSpectra, Paths};
use super::phantom::{Phantom, Scatterer};
use super::record::Record;
use super::settings::Settings;
use super::visibility::visible;

/// How echoes are summed over the scatterers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Summation {
    /// Every scatterer at every frequency in f64: exact, for up to some tens of scatterers.
    Direct,
    /// Spikes on a grid: for many scatterers, each echo within −80 dB.
    Gridded,
}

/// Simulates the record of every beam and element. `progress` is called with the fraction done,
/// 0 to 1, from any thread. Errors: impossible settings, a phantom that reaches the array.
pub fn channel_data(
    settings: &Settings,
    phantom: &Phantom,
    summation: Summation,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<ChannelData> {
    settings.validate()?;
    let in_front = |z: f64| z.is_finite() && z > 0.0;
    if !phantom
        .scatterers
        .iter()
        .all(|s| in_front(s.z) && s.x.is_finite() && s.amplitude.is_finite())
        || !phantom
            .bone
            .iter()
            .flat_map(|bone| bone.loops())
            .flatten()
            .all(|p| in_front(p[1]))
    {
        return Err(Error::Data(
            "the phantom must be finite and lie at depths above 0".into(),
        ));
    }
    let record = settings.record();
    memory::check(bytes(settings, &record, phantom, summation)?, "the record")?;
    let beams: Vec<Beam> = (0..settings.beams)
        .map(|l| Beam::new(settings, l))
        .collect();
    let steps = settings.elements + settings.beams;
    let done = AtomicUsize::new(0);
    let tick = || progress((done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / steps as f64);

    let pairs = pair_spectra(settings, &record, phantom, summation, &beams, tick);
    let mut rf = vec![0.0f32; beams.len() * settings.elements * record.samples];
    let transform = RealFftPlanner::<f64>::new().plan_fft_inverse(record.window);
    rf.par_chunks_mut(settings.elements * record.samples)
        .zip(&beams)
        .for_each(|(rows, beam)| {
            let phases: Vec<Vec<Complex<f64>>> = beam
                .advance
                .iter()
                .map(|&advance| beam_phase(&record, advance))
                .collect();
            let mut spectrum = transform.make_input_vec();
            let mut window = transform.make_output_vec();
            for (j, row) in rows.chunks_exact_mut(record.samples).enumerate() {
                spectrum.fill(Complex::default());
                for (i, phase) in beam.elements.clone().zip(&phases) {
                    for ((s, h), e) in spectrum.iter_mut().zip(pairs.get(i, j)).zip(phase) {
                        *s += h * e;
                    }
                }
                spectrum[0].im = 0.0;
                transform
                    .process(&mut spectrum, &mut window)
                    .expect("buffers made by the plan");
                for (sample, value) in row.iter_mut().zip(&window[record.lead..]) {
                    *sample = *value as f32;
                }
            }
            tick();
        });
    if let Some(level) = settings.noise {
        add_noise(&mut rf, settings, &record, level);
    }
    let shape = (beams.len(), settings.elements, record.samples);
    Ok(ChannelData {
        samples: Array3::from_shape_vec(shape, rf)
            .expect("the record's shape")
            .into(),
        fs: settings.fs,
        t0: vec![record.t0; beams.len()],
        element_x: settings.array().element_x(),
        element_z: None,
        element_angle: None,
        c: settings.c,
        f0: settings.f0,
        transmits: Transmits::Focused {
            x: beams.iter().map(|beam| beam.x).collect(),
            focus: vec![settings.focus; beams.len()],
            f_number: Some(settings.f_number),
        },
        lens_delay: 0.0,
    })
}

/// The memory that a record takes while it is made: itself and its spectra, the paths from every
/// element to every scatterer, and what each thread works with.
fn bytes(
    settings: &Settings,
    record: &Record,
    phantom: &Phantom,
    summation: Summation,
) -> Result<usize> {
    // Time, gain and visibility as they are made, and time and gain as they are summed.
    const PATH: usize = 32;
    let spectrum = product(&[record.bins, size_of::<Complex<f64>>()]);
    let path = match summation {
        Summation::Direct => PATH.saturating_add(spectrum),
        Summation::Gridded => PATH,
    };
    let paths = product(&[settings.elements, phantom.scatterers.len(), path]);
    // The phases of a beam, and a spectrum and a window of each transform.
    let phases = product(&[settings.elements, spectrum]);
    let transforms = product(&[
        record.window.max(record.coarse),
        4 * size_of::<Complex<f64>>(),
    ]);
    let threads = product(&[
        rayon::current_num_threads(),
        phases.saturating_add(transforms),
    ]);
    let parts = [settings.bytes()?, paths, threads];
    Ok(parts.into_iter().fold(0, usize::saturating_add))
}

/// A transmit beam: its axis, its elements and by how much each fires ahead.
struct Beam {
    x: f64,
    elements: std::ops::Range<usize>,
    advance: Vec<f64>,
}

impl Beam {
    fn new(settings: &Settings, index: usize) -> Self {
        let array = settings.array();
        let x = settings.beam_x(index);
        let position = settings.first_beam + index as f64 * settings.beam_step;
        let elements = array.transmit_elements(position, settings.focus, settings.f_number);
        let advance = elements
            .clone()
            .map(|i| {
                let dx = array.x(i as f64) - x;
                (dx.hypot(settings.focus) - settings.focus) / settings.c
            })
            .collect();
        Beam {
            x,
            elements,
            advance,
        }
    }
}

fn beam_phase(record: &Record, advance: f64) -> Vec<Complex<f64>> {
    (0..record.bins)
        .map(|k| Complex::from_polar(1.0, TAU * k as f64 * record.df * advance))
        .collect()
}

fn pair_spectra(
    settings: &Settings,
    record: &Record,
    phantom: &Phantom,
    summation: Summation,
    beams: &[Beam],
    tick: impl Fn() + Sync,
) -> PairSpectra {
    let element_x = settings.array().element_x();
    let (scatterers, seen) = seen_scatterers(phantom, &element_x);
    let paths: Vec<Paths> = element_x
        .par_iter()
        .zip(&seen)
        .map(|(&x, seen)| element_paths(settings, x, &scatterers, seen))
        .collect();
    let amplitude: Vec<f64> = scatterers.iter().map(|s| s.amplitude).collect();
    // Both signs of the frequency make the real pulse, which the real transform takes care of.
    let pulse = settings.pulse();
    let weight: Vec<f64> = (0..record.bins)
        .map(|k| pulse.spectrum(k as f64 * record.df) * record.df)
        .collect();
    let mut transmits = vec![false; settings.elements];
    for i in beams.iter().flat_map(|beam| beam.elements.clone()) {
        transmits[i] = true;
    }
    let wanted = |i: usize, j: usize| transmits[i] || transmits[j];
    match summation {
        Summation::Direct => PairSpectra::direct(record, &paths, &amplitude, &weight, wanted, tick),
        Summation::Gridded => {
            PairSpectra::gridded(record, &paths, &amplitude, &weight, wanted, tick)
        }
    }
}

/// The scatterers that some element sees, and the visibility `[element][scatterer]`.
fn seen_scatterers(phantom: &Phantom, element_x: &[f64]) -> (Vec<Scatterer>, Vec<Vec<bool>>) {
    let all = &phantom.scatterers;
    let Some(bone) = &phantom.bone else {
        return (all.clone(), vec![vec![true; all.len()]; element_x.len()]);
    };
    let points: Vec<[f64; 2]> = all.iter().map(|s| [s.x, s.z]).collect();
    let seen = visible(bone, element_x, &points);
    let kept: Vec<usize> = (0..all.len())
        .filter(|&s| seen.iter().any(|element| element[s]))
        .collect();
    let visibility = seen
        .iter()
        .map(|element| kept.iter().map(|&s| element[s]).collect());
    (kept.iter().map(|&s| all[s]).collect(), visibility.collect())
}

fn element_paths(settings: &Settings, x: f64, scatterers: &[Scatterer], seen: &[bool]) -> Paths {
    let width = settings.array().element_width();
    let wavelength = settings.c / settings.f0;
    let gain = |s: &Scatterer| element::response(width, wavelength, s.x - x, s.z);
    Paths {
        time: scatterers
            .iter()
            .map(|s| (s.x - x).hypot(s.z) / settings.c)
            .collect(),
        gain: scatterers
            .iter()
            .zip(seen)
            .map(|(s, &v)| if v { gain(s) } else { 0.0 })
            .collect(),
    }
}

fn add_noise(rf: &mut [f32], settings: &Settings, record: &Record, level: f64) {
    let peak = rf.par_iter().map(|v| v.abs()).reduce(|| 0.0, f32::max);
    let pulse = settings.pulse();
    let mut shape: Vec<f64> = (0..record.bins)
        .map(|k| pulse.transducer(k as f64 * record.df))
        .collect();
    shape[0] = 0.0;
    // A bin X gives 2·Re(X·e^{jφ}) in every sample, and Re X has the variance shape².
    let power: f64 = shape.iter().map(|s| 4.0 * s * s).sum();
    let scale = f64::from(peak) * 10f64.powf(level / 20.0) / power.sqrt();
    shape.iter_mut().for_each(|s| *s *= scale);
    let transform = RealFftPlanner::<f64>::new().plan_fft_inverse(record.window);
    rf.par_chunks_exact_mut(record.samples)
        .enumerate()
        .for_each_init(
            || (transform.make_input_vec(), transform.make_output_vec()),
            |(spectrum, window), (index, row)| {
                noise::fill_spectrum(spectrum, &shape, settings.seed, index as u64);
                transform
                    .process(spectrum, window)
                    .expect("buffers made by the plan");
                for (sample, value) in row.iter_mut().zip(&window[record.lead..]) {
                    *sample += *value as f32;
                }
            },
        );
}
