//! Recordings with a known truth, drawn from a seed: array, transmits, tissue, aberration, noise.

#![allow(dead_code, reason = "the study and the tests use a part each")]

use std::f64::consts::TAU;

use bonebeam_files::{ChannelData, Samples, Transmits};
use bonebeam_simulate::{
    Layers, Phantom, Scatterer, Settings, Summation, Tissue, channel_data, complex_gaussian,
    visible,
};
use ndarray::{Array3, Axis};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;

/// Taps of the fractional delays.
const TAPS: usize = 12;
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
pub enum Shape {
    Linear,
    Curved,
    Phased,
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
    pub elements: usize,
    pub shape: Shape,
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
    /// One-way delay of a lens, s.
    pub lens: f64,
    pub seed: u64,
}

impl Scene {
    pub fn draw(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let laws = [Law::Focused, Law::Plane, Law::Diverging, Law::Element];
        let media = [Medium::Speckle, Medium::Points, Medium::Bone];
        let shapes = [Shape::Linear, Shape::Linear, Shape::Curved, Shape::Phased];
        let mut scene = Scene {
            elements: 64,
            shape: Shape::Linear,
            law: laws[random.random_range(0..4)],
            medium: media[random.random_range(0..3)],
            f0: random.random_range(3e6..8e6),
            c: random.random_range(1400.0..1620.0),
            pitch: random.random_range(0.6..1.0),
            aberration: ABERRATIONS[random.random_range(0..3)],
            snr: random.random_range(0.0..30.0),
            lens: 0.0,
            seed,
        };
        scene.shape = shapes[random.random_range(0..4)];
        if scene.shape == Shape::Phased {
            scene.pitch *= 0.5;
        }
        if random.random_range(0..2) == 0 {
            scene.lens = random.random_range(0.0..0.6e-6);
        }
        scene
    }

    /// Tissue under clean conditions.
    pub fn small(law: Law) -> Self {
        Scene {
            elements: 64,
            shape: Shape::Linear,
            law,
            medium: Medium::Speckle,
            f0: 5e6,
            c: 1540.0,
            pitch: 0.9,
            aberration: 0.0,
            snr: 10.0,
            lens: 0.0,
            seed: 7,
        }
    }

    pub fn record(&self) -> ChannelData {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed.wrapping_add(1 << 32));
        let Scene {
            elements: count,
            shape,
            law,
            medium,
            f0,
            c,
            ..
        } = *self;
        let pitch = c / f0 * self.pitch;
        let settings = Settings {
            elements: count,
            pitch,
            kerf: 0.1 * pitch,
            f0,
            fs: 8.0 * f0,
            c,
            beams: count,
            f_number: 1e6,
            depth_start: 3e-3,
            depth_end: 30e-3,
            noise: None,
            seed: self.seed,
            ..Settings::default()
        };
        let half = 0.5 * count as f64 * pitch;
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
        let radius = match shape {
            Shape::Curved => random.random_range(20e-3..50e-3),
            _ => f64::INFINITY,
        };
        let all = if shape == Shape::Curved {
            curved(&settings, &phantom, radius)
        } else {
            channel_data(&settings, &phantom, Summation::Cells, &|_| {}).expect("a record")
        };
        let delays = screen(&mut random, count, self.aberration, pitch);
        let elements: Vec<[f64; 2]> = (0..count).map(|m| all.element(m)).collect();
        // Sources before or behind the array, and the half aperture of those before it.
        let from = |[sx, sz]: [f64; 2], reach: f64| -> Vec<f64> {
            let range = sx.hypot(sz) * sz.signum();
            let fires = |&[x, z]: &[f64; 2]| {
                let path = (x - sx).hypot(z - sz) * sz.signum();
                let tilt = (sx - x).atan2(sz - z) - (x / (radius + z)).atan();
                let inside = sz < 0.0 || path * tilt.sin().abs() <= reach;
                if inside { (range - path) / c } else { f64::NAN }
            };
            elements.iter().map(fires).collect()
        };
        let even = |count: usize, k: usize, most: f64| {
            most * (2.0 * (k as f64 + 0.5) / count as f64 - 1.0)
        };
        let sources = |sources: Vec<[f64; 2]>, reach: f64| {
            let fire = sources.iter().map(|&s| from(s, reach)).collect();
            let [x, z] = [0, 1].map(|k| sources.iter().map(|s| s[k]).collect());
            (Transmits::VirtualSource { x, z }, fire)
        };
        let (transmits, fire): (Transmits, Vec<Vec<f64>>) = match law {
            Law::Focused => {
                let focus = random.random_range(12e-3..22e-3);
                let reach = 0.5 * focus / 2.5;
                let at = (0..24).map(|k| even(24, k, 0.85 * half));
                match shape {
                    Shape::Linear => {
                        let at: Vec<f64> = at.collect();
                        let own = |&x: &f64| {
                            let late = from([x, focus], reach).into_iter();
                            late.map(|late| late + (focus - x.hypot(focus)) / c)
                                .collect()
                        };
                        let fire = at.iter().map(own).collect();
                        let transmits = Transmits::Focused {
                            focus: vec![focus; at.len()],
                            x: at,
                            f_number: Some(2.5),
                        };
                        (transmits, fire)
                    }
                    Shape::Curved => {
                        let along = |s: f64| {
                            let ((sin, cos), r) = ((s / radius).sin_cos(), radius + focus);
                            [r * sin, r * cos - radius]
                        };
                        sources(at.map(along).collect(), reach)
                    }
                    Shape::Phased => {
                        let along = |k| {
                            let (sin, cos) = even(24, k, 0.6).sin_cos();
                            [focus * sin, focus * cos]
                        };
                        sources((0..24).map(along).collect(), f64::INFINITY)
                    }
                }
            }
            Law::Plane => {
                let count = [7, 11, 15][random.random_range(0..3)];
                let most = random.random_range(0.12..0.26);
                let angle: Vec<f64> = (0..count)
                    .map(|k| most * (2.0 * k as f64 / (count - 1) as f64 - 1.0))
                    .collect();
                let late = |a: f64| {
                    let path = |[x, z]: &[f64; 2]| (x * a.sin() + z * a.cos()) / c;
                    elements.iter().map(path).collect()
                };
                let fire = angle.iter().map(|&a| late(a)).collect();
                (Transmits::Plane { angle }, fire)
            }
            Law::Diverging => {
                let z = -random.random_range(5e-3..15e-3);
                let at = (0..11).map(|k| [even(11, k, 0.88 * half), z]);
                sources(at.collect(), f64::INFINITY)
            }
            Law::Element => {
                let index: Vec<usize> = (0..16).map(|k| 2 + 4 * k).collect();
                let of = |m: usize, i: usize| if m == i { 0.0 } else { f64::NAN };
                let fire = index
                    .iter()
                    .map(|&i| (0..elements.len()).map(|m| of(m, i)).collect())
                    .collect();
                (Transmits::Element { index }, fire)
            }
        };
        let delays: Vec<f64> = delays.iter().map(|late| late + self.lens).collect();
        let mut rf = transmitted(&all, &fire, &delays);
        noise(&mut rf, self.snr, &mut random);
        ChannelData {
            samples: rf.into(),
            t0: vec![all.t0[0]; transmits.len()],
            transmits,
            lens_delay: self.lens,
            ..all
        }
    }
}

/// Records of single elements on an arc; shadows are those of its middle.
fn curved(settings: &Settings, phantom: &Phantom, radius: f64) -> ChannelData {
    const FINE: usize = 4;
    let &Settings {
        elements: count,
        f0,
        fs,
        c,
        ..
    } = settings;
    let middle = 0.5 * (count - 1) as f64;
    let angles: Vec<f64> = (0..count)
        .map(|m| (m as f64 - middle) * settings.pitch / radius)
        .collect();
    let elements: Vec<[f64; 2]> = angles
        .iter()
        .map(|a| [radius * a.sin(), radius * (a.cos() - 1.0)])
        .collect();
    let points: Vec<[f64; 2]> = phantom.scatterers.iter().map(|s| [s.x, s.z]).collect();
    let seen = match &phantom.bone {
        Some(bone) => visible(bone, &[0.0], &points).remove(0),
        None => vec![true; points.len()],
    };
    let start = 2.0 * settings.depth_start / c;
    let samples = ((2.4 * settings.depth_end / c - start) * fs) as usize;
    // Two-way time and amplitude from each element.
    let paths: Vec<Vec<[f64; 2]>> = elements
        .iter()
        .zip(&angles)
        .map(|(&[ex, ez], angle)| {
            let of = |&[x, z]: &[f64; 2]| {
                let r = (x - ex).hypot(z - ez);
                let cos = ((x - ex).atan2(z - ez) - angle).cos();
                [r / c, cos.max(0.0) / r]
            };
            points.iter().map(of).collect()
        })
        .collect();
    let reach = (4.0 * fs / f0) as isize;
    let pulse: Vec<f32> = (-reach * FINE as isize..reach * FINE as isize)
        .map(|n| {
            let t = n as f64 / (FINE as f64 * fs) * f0;
            ((TAU * t).cos() * (-t * t).exp()) as f32
        })
        .collect();
    let row = |(i, m): (usize, usize)| -> Vec<f32> {
        let mut fine = vec![0.0f32; samples * FINE];
        for (k, scatterer) in phantom
            .scatterers
            .iter()
            .enumerate()
            .filter(|(k, _)| seen[*k])
        {
            let ([there, a], [back, b]) = (paths[i][k], paths[m][k]);
            let at = (there + back - start) * fs * FINE as f64;
            if at >= 0.0 && at < (fine.len() - 1) as f64 {
                let (value, part) = (scatterer.amplitude * a * b, at.fract());
                fine[at as usize] += (value * (1.0 - part)) as f32;
                fine[at as usize + 1] += (value * part) as f32;
            }
        }
        let sample = |n: usize| {
            let first = (n * FINE) as isize - reach * FINE as isize;
            let (skipped, first) = ((-first).max(0) as usize, first.max(0) as usize);
            let part = fine[first..].iter().zip(&pulse[skipped..]);
            part.map(|(a, b)| a * b).sum()
        };
        (0..samples).map(sample).collect()
    };
    let rows: Vec<(usize, usize)> = (0..count * count).map(|k| (k / count, k % count)).collect();
    let rf: Vec<f32> = rows.into_par_iter().flat_map_iter(row).collect();
    let rf = Array3::from_shape_vec((count, count, samples), rf).expect("the shape");
    let [x, z] = [0, 1].map(|k| elements.iter().map(|at| at[k]).collect());
    let transmits = Transmits::Element {
        index: (0..count).collect(),
    };
    ChannelData {
        t0: vec![start; count],
        element_z: Some(z),
        ..ChannelData::linear(rf, x, transmits, ([fs, f0], c))
    }
}

/// Delays of tissue before `count` elements, of an RMS in s, smooth over 3 mm.
fn screen(random: &mut ChaCha8Rng, count: usize, rms: f64, pitch: f64) -> Vec<f64> {
    let waves: Vec<[f64; 3]> = (0..12)
        .map(|_| {
            [
                random.random_range(0.0..2.0 * TAU / 6e-3),
                random.random_range(0.0..TAU),
                1.0,
            ]
        })
        .collect();
    let raw: Vec<f64> = (0..count)
        .map(|m| {
            waves
                .iter()
                .map(|[k, phase, a]| a * (k * pitch * m as f64 + phase).cos())
                .sum()
        })
        .collect();
    let mean = raw.iter().sum::<f64>() / count as f64;
    let power = raw.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / count as f64;
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
