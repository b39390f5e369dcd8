//! Clutter that is coherent over only a part of the aperture.
//!
//! After delays, a point scatterer's echoes add in phase over the whole aperture. Sound on other paths
//! (reverberation, off-axis echoes, multiple scattering) does not: neighbouring channels agree only over a
//! coherence length (Pinton, Trahey and Dahl 2011). So the analytic signal of each channel is multiplied by a
//! complex Gaussian field of power 1. Its correlation between two elements, and between two beams, at the distance
//! d is exp(−4·ln 2·(d/ℓ)²): its full width at half maximum is the coherence length ℓ. Over time its values at
//! nodes 1 µs apart are independent. Between two nodes a and b it is a·cos φ + b·sin φ, so its power is 1 at all
//! times.

use std::f64::consts::{FRAC_PI_2, LN_2};

use num_complex::Complex;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;

use super::fourier::Fourier;
use super::noise::complex_gaussian;
use super::settings::Settings;

/// Distance of the field's nodes in time, s.
const NODE: f64 = 1e-6;
/// Length of a Gaussian to either side, standard deviations.
const REACH: f64 = 4.0;
/// Random stream of the first node.
///
/// It is far from those of the noise's rows, which have the same seed.
const STREAM: u64 = 1 << 40;

/// Multiplies each channel of a record by a field of coherence length `length`, m.
///
/// 0 makes channels independent; infinity does not change the record. `rf` is `[beam][element][sample]` of the
/// settings' record.
pub fn decorrelate(settings: &Settings, length: f64, rf: &mut [f32]) {
    if !length.is_finite() {
        return;
    }
    let samples = settings.time_axis().samples;
    let field = Field::new(settings, length, samples);
    let window = samples.next_power_of_two();
    let transform = Fourier::new(window);
    rf.par_chunks_exact_mut(samples).enumerate().for_each_init(
        || (Vec::new(), Vec::new()),
        |(x, scratch), (row, rf)| {
            analytic(&transform, rf, x, scratch);
            for (n, (value, analytic)) in rf.iter_mut().zip(x.iter()).enumerate() {
                *value = (analytic * field.at(row, n)).re as f32;
            }
        },
    );
}

/// Analytic signal of a row, with as many values as the transform.
fn analytic(
    transform: &Fourier,
    row: &[f32],
    x: &mut Vec<Complex<f64>>,
    scratch: &mut Vec<Complex<f64>>,
) {
    let window = row.len().next_power_of_two();
    x.clear();
    x.extend(row.iter().map(|v| Complex::from(f64::from(*v))));
    x.resize(window, Complex::default());
    transform.forward(x, scratch);
    let scale = 1.0 / window as f64;
    for (k, bin) in x.iter_mut().enumerate() {
        *bin *= match k {
            0 => scale,
            _ if 2 * k < window => 2.0 * scale,
            _ if 2 * k == window => scale,
            _ => 0.0,
        };
    }
    transform.inverse(x, scratch);
}

/// A complex Gaussian field of power 1 over beams, elements and time.
struct Field {
    /// `[node][beam·elements + element]`.
    nodes: Vec<Vec<Complex<f64>>>,
    /// Nodes per sample.
    step: f64,
}

impl Field {
    fn new(settings: &Settings, length: f64, samples: usize) -> Self {
        let step = 1.0 / (NODE * settings.fs);
        let count = (samples as f64 * step) as usize + 2;
        // White noise through a Gaussian of the standard deviation σ has a correlation of the full width 4·√(ln 2)·σ.
        let width = length / (4.0 * LN_2.sqrt());
        let elements = Weights::new(width / settings.pitch);
        let beams = Weights::new(width / (settings.pitch * settings.beam_step));
        let shape = [settings.beams, settings.elements];
        let node = |k: usize| {
            let mut random = ChaCha8Rng::seed_from_u64(settings.seed);
            random.set_stream(STREAM + k as u64);
            let [rows, columns] = [shape[0] + beams.more(), shape[1] + elements.more()];
            let white: Vec<_> = (0..rows * columns)
                .map(|_| complex_gaussian(&mut random) * 0.5f64.sqrt())
                .collect();
            let across: Vec<Vec<_>> = white
                .chunks_exact(columns)
                .map(|row| elements.of(row))
                .collect();
            let mut field = vec![Complex::default(); shape[0] * shape[1]];
            for element in 0..shape[1] {
                let column: Vec<_> = across.iter().map(|row| row[element]).collect();
                for (beam, value) in beams.of(&column).into_iter().enumerate() {
                    field[beam * shape[1] + element] = value;
                }
            }
            field
        };
        Field {
            nodes: (0..count).into_par_iter().map(node).collect(),
            step,
        }
    }

    /// The field of a channel at a sample.
    fn at(&self, channel: usize, sample: usize) -> Complex<f64> {
        let position = sample as f64 * self.step;
        let node = position as usize;
        let (sin, cos) = libm::sincos(FRAC_PI_2 * (position - node as f64));
        self.nodes[node][channel] * cos + self.nodes[node + 1][channel] * sin
    }
}

/// A Gaussian whose squares add up to 1.
struct Weights(Vec<f64>);

impl Weights {
    /// From a standard deviation in grid points.
    fn new(deviation: f64) -> Self {
        let reach = (REACH * deviation) as i64;
        let weight = |k: i64| match k {
            0 => 1.0,
            k => libm::exp(-0.5 * (k as f64 / deviation) * (k as f64 / deviation)),
        };
        let weights: Vec<f64> = (-reach..=reach).map(weight).collect();
        let norm = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
        Weights(weights.iter().map(|w| w / norm).collect())
    }

    /// Number of values by which the input is longer than the output.
    fn more(&self) -> usize {
        self.0.len() - 1
    }

    fn of(&self, values: &[Complex<f64>]) -> Vec<Complex<f64>> {
        let sum = |near: &[Complex<f64>]| near.iter().zip(&self.0).map(|(v, w)| v * w).sum();
        values.windows(self.0.len()).map(sum).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: fn() -> Settings = || Settings {
        elements: 64,
        beams: 48,
        fs: 20e6,
        ..Settings::default()
    };

    /// Mean of a·conj(b) over beams, elements and nodes, for channels `elements` and `beams` apart.
    fn correlation(field: &Field, settings: &Settings, beams: usize, elements: usize) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for node in &field.nodes {
            for beam in 0..settings.beams - beams {
                for element in 0..settings.elements - elements {
                    let a = node[beam * settings.elements + element];
                    let b = node[(beam + beams) * settings.elements + element + elements];
                    sum += (a * b.conj()).re;
                    count += 1;
                }
            }
        }
        sum / f64::from(count)
    }

    /// Tolerance: about 40 nodes of some hundred independent patches each leave 2 %.
    #[test]
    fn the_field_has_power_one_and_falls_to_a_half_at_half_its_length() {
        let settings = SETTINGS();
        let field = Field::new(
            &settings,
            4.0 * settings.pitch,
            settings.time_axis().samples,
        );
        let near = |found: f64, expected: f64| {
            assert!((found - expected).abs() < 0.06, "{found} beside {expected}");
        };
        near(correlation(&field, &settings, 0, 0), 1.0);
        near(correlation(&field, &settings, 0, 2), 0.5);
        near(correlation(&field, &settings, 2, 0), 0.5);
        near(correlation(&field, &settings, 0, 4), 1.0 / 16.0);
        near(correlation(&field, &settings, 0, 16), 0.0);
    }

    #[test]
    fn without_a_length_neighbours_have_nothing_in_common() {
        let settings = SETTINGS();
        let field = Field::new(&settings, 0.0, settings.time_axis().samples);
        assert!((correlation(&field, &settings, 0, 0) - 1.0).abs() < 0.02);
        assert!(correlation(&field, &settings, 0, 1).abs() < 0.02);
        assert!(correlation(&field, &settings, 1, 0).abs() < 0.02);
    }

    /// An echo on every channel keeps its power and its band, and has the field's coherence over the channels.
    #[test]
    fn channels_keep_their_power() {
        let settings = SETTINGS();
        let samples = settings.time_axis().samples;
        let cycles = settings.f0 / settings.fs;
        let sine = |n: usize| (std::f64::consts::TAU * cycles * n as f64).sin() as f32;
        let row: Vec<f32> = (0..samples).map(sine).collect();
        let rows = settings.beams * settings.elements;
        let original = row.repeat(rows);
        let power = |rf: &[f32]| rf.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>();
        let mut rf = original.clone();
        decorrelate(&settings, 2.0 * settings.pitch, &mut rf);
        let ratio = power(&rf) / power(&original);
        assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
        let mut same = original.clone();
        decorrelate(&settings, f64::INFINITY, &mut same);
        assert_eq!(same, original);
    }
}
