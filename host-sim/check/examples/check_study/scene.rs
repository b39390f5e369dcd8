//! Recordings with a known truth, drawn from a seed: array, transmits, tissue, aberration, noise.

#![allow(dead_code, reason = "the study and the tests use a part each")]

use std::f64::consts::TAU;

use bonebeam_files::{ChannelData, Samples, Transmits};
use bonebeam_simulate::{
    Layers, Phantom, Scatterer, Settings, Summation, Tissue, channel_data, complex_gaussian,
};
use ndarray::{Array3, Axis};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;

/// Taps of the fractional delays.
const TAPS: usize = 12;
const ELEMENTS: usize = 64;
/// RMS of the delays of tissue before the elements, s.
pub const ABERRATIONS: [f64; 3] = [0.0, 20e-9, 35e-9];

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    Focused,
    Plane,
    Diverging,
    Element,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Medium {
    Speckle,
    Points,
    Bone,
}

/// What is recorded, and how.
#[derive(Clone, Copy, Debug)]
pub struct Scene {
    pub law: Law,
    pub medium: Medium,
    pub f0: f64,
    pub c: f64,
    /// In wavelengths.
    pub pitch: f64,
    /// RMS of the delays of tissue before the elements, s.
    pub aberration: f64,
    /// dB.
    pub snr: f64,
    pub seed: u64,
}

impl Scene {
    pub fn draw(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let laws = [Law::Focused, Law::Plane, Law::Diverging, Law::Element];
        let media = [Medium::Speckle, Medium::Points, Medium::Bone];
        Scene {
            law: laws[random.random_range(0..4)],
            medium: media[random.random_range(0..3)],
            f0: random.random_range(3e6..8e6),
            c: random.random_range(1400.0..1620.0),
            pitch: random.random_range(0.6..1.0),
            aberration: ABERRATIONS[random.random_range(0..3)],
            snr: random.random_range(0.0..30.0),
            seed,
        }
    }

    /// Tissue under clean conditions.
    pub fn small(law: Law) -> Self {
        Scene {
            law,
            medium: Medium::Speckle,
            f0: 5e6,
            c: 1540.0,
            pitch: 0.9,
            aberration: 0.0,
            snr: 10.0,
            seed: 7,
        }
    }

    pub fn record(&self) -> ChannelData {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed.wrapping_add(1 << 32));
        let Scene {
            law, medium, f0, c, ..
        } = *self;
        let pitch = c / f0 * self.pitch;
        let settings = Settings {
            elements: ELEMENTS,
            pitch,
            kerf: 0.1 * pitch,
            f0,
            fs: 8.0 * f0,
            c,
            beams: ELEMENTS,
            f_number: 1e6,
            depth_start: 3e-3,
            depth_end: 30e-3,
            noise: None,
            seed: self.seed,
            ..Settings::default()
        };
        let half = 0.5 * ELEMENTS as f64 * pitch;
        let tissue = Tissue {
            density: 25e6,
            amplitude: 1.0,
            layers: Layers::Uniform,
            x: [-half - 3e-3, half + 3e-3],
            z: [3e-3, 32e-3],
            seed: self.seed,
        };
        let phantom = match medium {
            Medium::Speckle => Phantom::default().with_tissue(&tissue),
            Medium::Points => {
                let scatterers = (0..25)
                    .map(|_| Scatterer {
                        x: random.random_range(-half..half),
                        y: 0.0,
                        z: random.random_range(5e-3..28e-3),
                        amplitude: random.random_range(0.5..1.5),
                    })
                    .collect();
                Phantom {
                    scatterers,
                    ..Phantom::default()
                }
            }
            Medium::Bone => Phantom::vertebra(
                random.random_range(-4e-3..4e-3),
                random.random_range(15e-3..22e-3),
            )
            .expect("a bone")
            .with_tissue(&Tissue {
                layers: Layers::Anatomy,
                amplitude: 0.1,
                ..tissue
            }),
        };
        let all = channel_data(&settings, &phantom, Summation::Cells, &|_| {}).expect("a record");
        let delays = screen(&mut random, self.aberration, pitch);
        let x = all.element_x.clone();
        let (transmits, fire): (Transmits, Vec<Vec<f64>>) = match law {
            Law::Focused => {
                let focus = random.random_range(12e-3..22e-3);
                let at: Vec<f64> = (0..24)
                    .map(|k| half * (1.7 * (k as f64 + 0.5) / 24.0 - 0.85))
                    .collect();
                let fire = at
                    .iter()
                    .map(|&at| {
                        let of = |&x: &f64| {
                            let inside = (x - at).abs() <= 0.5 * focus / 2.5;
                            let late = (focus - focus.hypot(x - at)) / c;
                            if inside { late } else { f64::NAN }
                        };
                        x.iter().map(of).collect()
                    })
                    .collect();
                let transmits = Transmits::Focused {
                    x: at.clone(),
                    focus: vec![focus; at.len()],
                    f_number: Some(2.5),
                };
                (transmits, fire)
            }
            Law::Plane => {
                let count = [7, 11, 15][random.random_range(0..3)];
                let most = random.random_range(0.12..0.26);
                let angle: Vec<f64> = (0..count)
                    .map(|k| most * (2.0 * k as f64 / (count - 1) as f64 - 1.0))
                    .collect();
                let fire = angle
                    .iter()
                    .map(|a| x.iter().map(|x| x * a.sin() / c).collect())
                    .collect();
                (Transmits::Plane { angle }, fire)
            }
            Law::Diverging => {
                let count = 11;
                let z = -random.random_range(5e-3..15e-3);
                let at: Vec<f64> = (0..count)
                    .map(|k| half * (1.6 * k as f64 / (count - 1) as f64 - 0.8))
                    .collect();
                let fire = at
                    .iter()
                    .map(|&at| {
                        x.iter()
                            .map(|&x| ((x - at).hypot(z) - at.hypot(z)) / c)
                            .collect()
                    })
                    .collect();
                let z = vec![z; count];
                (Transmits::VirtualSource { x: at, z }, fire)
            }
            Law::Element => {
                let index: Vec<usize> = (0..16).map(|k| 2 + 4 * k).collect();
                let fire = index
                    .iter()
                    .map(|&i| {
                        (0..ELEMENTS)
                            .map(|m| if m == i { 0.0 } else { f64::NAN })
                            .collect()
                    })
                    .collect();
                (Transmits::Element { index }, fire)
            }
        };
        let mut rf = transmitted(&all, &fire, &delays);
        noise(&mut rf, self.snr, &mut random);
        ChannelData {
            samples: rf.into(),
            t0: vec![all.t0[0]; transmits.len()],
            transmits,
            ..all
        }
    }
}

/// Delays of tissue before the elements, of an RMS in s, smooth over 3 mm.
fn screen(random: &mut ChaCha8Rng, rms: f64, pitch: f64) -> Vec<f64> {
    let waves: Vec<[f64; 3]> = (0..12)
        .map(|_| {
            [
                random.random_range(0.0..2.0 * TAU / 6e-3),
                random.random_range(0.0..TAU),
                1.0,
            ]
        })
        .collect();
    let raw: Vec<f64> = (0..ELEMENTS)
        .map(|m| {
            waves
                .iter()
                .map(|[k, phase, a]| a * (k * pitch * m as f64 + phase).cos())
                .sum()
        })
        .collect();
    let mean = raw.iter().sum::<f64>() / ELEMENTS as f64;
    let power = raw.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / ELEMENTS as f64;
    raw.iter()
        .map(|v| rms * (v - mean) / power.sqrt())
        .collect()
}

/// Records of transmits whose elements fire at `fire`, from those of single elements.
fn transmitted(all: &ChannelData, fire: &[Vec<f64>], screen: &[f64]) -> Array3<f32> {
    let single = all.samples.rf(0).expect("RF");
    let (_, elements, samples) = single.dim();
    let rows: Vec<(usize, usize)> = (0..fire.len())
        .flat_map(|t| (0..elements).map(move |m| (t, m)))
        .collect();
    let rf: Vec<f32> = rows
        .into_par_iter()
        .flat_map_iter(|(t, m)| {
            let mut sum = vec![0.0f32; samples];
            for (i, &at) in fire[t].iter().enumerate().filter(|(_, at)| at.is_finite()) {
                let row = single.index_axis(Axis(0), i);
                let row = row.index_axis(Axis(0), m);
                let row = row.to_slice().expect("a row");
                add_late(&mut sum, row, (at + screen[i] + screen[m]) * all.fs);
            }
            sum
        })
        .collect();
    Array3::from_shape_vec((fire.len(), elements, samples), rf).expect("the shape")
}

/// Adds a record later by a number of samples.
fn add_late(sum: &mut [f32], row: &[f32], late: f64) {
    let whole = late.floor();
    let part = late - whole;
    let half = TAPS as isize / 2;
    let taps: Vec<f32> = (-half + 1..=half)
        .map(|k| {
            let u = k as f64 - part;
            let sinc = if u == 0.0 {
                1.0
            } else {
                (0.5 * TAU * u).sin() / (0.5 * TAU * u)
            };
            let window = (0.25 * TAU * u / (half as f64 + 0.5)).cos().powi(2);
            (sinc * window) as f32
        })
        .collect();
    // sum[n] += Σ_k taps[k]·row[n − whole − k]
    for (k, tap) in (-half + 1..=half).zip(&taps) {
        let offset = whole as isize + k;
        let (to, from) = (offset.max(0) as usize, (-offset).max(0) as usize);
        if to >= sum.len() || from >= row.len() {
            continue;
        }
        for (s, v) in sum[to..].iter_mut().zip(&row[from..]) {
            *s += tap * v;
        }
    }
}

fn noise(rf: &mut Array3<f32>, snr: f64, random: &mut ChaCha8Rng) {
    let power = rf.iter().map(|v| f64::from(v * v)).sum::<f64>() / rf.len() as f64;
    let rms = power.sqrt() * 10f64.powf(-snr / 20.0);
    rf.iter_mut()
        .for_each(|v| *v += (rms * complex_gaussian(random).re) as f32);
}

/// The RF of a scene.
pub fn rf(data: &mut ChannelData) -> &mut ndarray::Array4<f32> {
    match &mut data.samples {
        Samples::Rf(rf) => rf,
        _ => panic!("RF"),
    }
}
