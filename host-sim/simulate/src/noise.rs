//! Electronic noise: Gaussian, with one stream of the generator per row.
//!
//! So the order of the rows does not matter.

use std::f64::consts::TAU;

use num_complex::Complex;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;

use super::fourier::Fourier;
use super::settings::{NoiseSpectrum, Settings};

/// The noise of a record.
pub struct Noise {
    shape: Vec<f64>,
    transform: Fourier,
    window: usize,
    /// Gain of each sample.
    gains: Vec<f64>,
    seed: u64,
}

impl Noise {
    /// Noise with an RMS of `rms` at depth 0, in rows of the settings' record.
    pub fn new(settings: &Settings, rms: f64) -> Self {
        let axis = settings.time_axis();
        let samples = axis.samples;
        let gain = |n: usize| {
            let depth = 0.5 * settings.c * (axis.t0 + n as f64 / axis.fs);
            libm::pow(10.0, settings.noise_rise * depth / 20.0)
        };
        let window = samples.next_power_of_two();
        let pulse = settings.pulse();
        let f0 = settings.f0;
        let level = |f: f64| match settings.noise_spectrum {
            NoiseSpectrum::Transducer => pulse.transducer(f),
            NoiseSpectrum::Amplifier => f64::from(u8::from((0.1 * f0..=3.0 * f0).contains(&f))),
        };
        let df = settings.fs / window as f64;
        // Without the mean, and without the frequency of half the rate.
        let mut shape: Vec<f64> = (0..window / 2).map(|k| level(k as f64 * df)).collect();
        shape[0] = 0.0;
        // A bin X gives 2·Re(X·e^{jφ}) in every sample, and Re X has the variance shape².
        let power: f64 = shape.iter().map(|s| 4.0 * s * s).sum();
        let scale = rms / power.sqrt();
        shape.iter_mut().for_each(|s| *s *= scale);
        Noise {
            shape,
            transform: Fourier::new(window),
            window,
            gains: (0..samples).map(gain).collect(),
            seed: settings.seed,
        }
    }

    /// Adds noise to every row.
    pub fn add_to(&self, rf: &mut [f32]) {
        rf.par_chunks_exact_mut(self.gains.len())
            .enumerate()
            .for_each_init(
                || (Vec::new(), Vec::new()),
                |(x, scratch), (index, row)| {
                    x.clear();
                    x.resize(self.window, Complex::default());
                    let mut random = ChaCha8Rng::seed_from_u64(self.seed);
                    random.set_stream(index as u64);
                    for (bin, &shape) in x.iter_mut().zip(&self.shape) {
                        if shape > 0.0 {
                            *bin = complex_gaussian(&mut random) * (2.0 * shape);
                        }
                    }
                    self.transform.inverse(x, scratch);
                    for ((sample, value), gain) in row.iter_mut().zip(x.iter()).zip(&self.gains) {
                        *sample += (value.re * gain) as f32;
                    }
                },
            );
    }
}

/// Two independent Gaussian numbers of variance 1 (Box–Muller).
pub fn complex_gaussian(random: &mut ChaCha8Rng) -> Complex<f64> {
    let radius = (-2.0 * libm::log(1.0 - random.random::<f64>())).sqrt();
    let (sin, cos) = libm::sincos(TAU * random.random::<f64>());
    Complex::new(radius * cos, radius * sin)
}
