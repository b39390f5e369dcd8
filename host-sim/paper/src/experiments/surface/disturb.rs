//! Disturbances of a recording: aberration, clutter, noise, a wrong speed of sound.

use std::f64::consts::PI;

use ndarray::ArrayView1;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::experiments::common::recording::rf;
use crate::{Error, Result};
use bonebeam_files::{ChannelData, Transmits};
use bonebeam_simulate::{NoiseSpectrum, Settings, complex_gaussian, noise};

/// What a scene is disturbed by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Condition {
    Clean,
    Aberration,
    Clutter,
    Noise,
    SoundSpeed,
    Together,
}

impl Condition {
    pub const ALL: [Condition; 6] = [
        Condition::Clean,
        Condition::Aberration,
        Condition::Clutter,
        Condition::Noise,
        Condition::SoundSpeed,
        Condition::Together,
    ];

    /// For people.
    pub fn name(self) -> &'static str {
        match self {
            Condition::Clean => "clean",
            Condition::Aberration => "aberration",
            Condition::Clutter => "clutter on every channel",
            Condition::Noise => "amplifier noise that rises with depth",
            Condition::SoundSpeed => "wrong speed of sound",
            Condition::Together => "aberration, clutter and noise together",
        }
    }
}

/// Section `[surface.disturbances]`: how strong they are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Disturbances {
    /// RMS of the delays of the elements on receive, s.
    pub aberration: f64,
    /// Full width at half maximum of their correlation along the array, m.
    pub aberration_length: f64,
    /// Clutter of every channel, dB of the tissue's RMS.
    pub clutter: f64,
    /// Neighbouring elements that hear the same clutter.
    pub coherent: usize,
    /// Noise at depth 0, dB of the tissue's RMS.
    pub noise: f64,
    /// By how much it rises, dB per m of depth.
    pub noise_rise: f64,
    /// The speed of sound that the beamformer takes, of the true one.
    pub sound_speed: f64,
}

impl Default for Disturbances {
    fn default() -> Self {
        Disturbances {
            aberration: 35e-9,
            aberration_length: 3e-3,
            clutter: -10.0,
            coherent: 3,
            noise: -20.0,
            noise_rise: 300.0,
            sound_speed: 1.02,
        }
    }
}

/// The depths whose echoes are the tissue's, m, and how far beside its beam an element hears them, m.
const TISSUE: [f64; 2] = [4e-3, 14e-3];
const BESIDE: f64 = 5e-3;
/// Half the length of the interpolator that delays a channel, samples.
const TAPS: i64 = 8;

/// A recording of one frame of RF with its disturbances, which several conditions share.
pub struct Disturbed<'a> {
    section: &'a Disturbances,
    recorded: &'a ChannelData,
    aberrated: ChannelData,
    /// `[transmit][element][sample]`, as [`Disturbed::noise`].
    clutter: Vec<f32>,
    noise: Vec<f32>,
}

impl Disturbed<'_> {
    /// The recording in a condition.
    ///
    /// # Errors
    /// I/Q.
    pub fn under(&self, condition: Condition) -> Result<ChannelData> {
        let both = |one| condition == one || condition == Condition::Together;
        let mut data = match both(Condition::Aberration) {
            true => self.aberrated.clone(),
            false => self.recorded.clone(),
        };
        if both(Condition::Clutter) {
            self.section.add_clutter(&self.clutter, &mut data)?;
        }
        if both(Condition::Noise) {
            let sum = rf(&mut data)?.iter_mut().zip(&self.noise);
            sum.for_each(|(value, noise)| *value += noise);
        }
        if condition == Condition::SoundSpeed {
            data.c *= self.section.sound_speed;
        }
        Ok(data)
    }
}

impl Disturbances {
    /// Those of a recording of one frame of RF by `settings`, whose seed is theirs.
    ///
    /// # Errors
    /// I/Q, or transmits without axes.
    pub fn of<'a>(
        &'a self,
        settings: &Settings,
        recorded: &'a ChannelData,
    ) -> Result<Disturbed<'a>> {
        let mut aberrated = recorded.clone();
        let level = tissue_rms(&mut aberrated)?;
        self.aberrate(settings, &mut aberrated)?;
        let by = |noise_spectrum, shift: u32, noise_rise| Settings {
            noise_spectrum,
            noise_rise,
            seed: settings.seed.wrapping_add(1 << shift),
            ..settings.clone()
        };
        let coherent = self.coherent.max(1) as f64;
        let clutter = level * 10f64.powf(self.clutter / 20.0) / coherent.sqrt();
        let white = level * 10f64.powf(self.noise / 20.0);
        Ok(Disturbed {
            section: self,
            recorded,
            aberrated,
            clutter: noise(&by(NoiseSpectrum::Transducer, 33, 0.0), clutter),
            noise: noise(&by(NoiseSpectrum::Amplifier, 34, self.noise_rise), white),
        })
    }

    /// Delays of the elements, s: a smooth random curve without mean and slope.
    fn delays(&self, element_x: &[f64], seed: u64) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let white: Vec<f64> = element_x
            .iter()
            .map(|_| complex_gaussian(&mut random).re)
            .collect();
        // White noise through a Gaussian of the standard deviation σ has a correlation of the full width 4·√(ln 2)·σ.
        let width = self.aberration_length / (4.0 * std::f64::consts::LN_2.sqrt());
        let smooth = |x: &f64| {
            let weight = |at: &f64| (-0.5 * ((x - at) / width).powi(2)).exp();
            let terms = element_x.iter().zip(&white);
            terms.map(|(at, value)| weight(at) * value).sum::<f64>()
        };
        let mut delays: Vec<f64> = element_x.iter().map(smooth).collect();
        let n = delays.len() as f64;
        let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / n;
        let centre = mean(&mut element_x.iter().copied());
        let level = mean(&mut delays.iter().copied());
        let spread = mean(&mut element_x.iter().map(|x| (x - centre).powi(2)));
        let tilt = mean(&mut delays.iter().zip(element_x).map(|(d, x)| d * (x - centre)));
        let slope = tilt / spread.max(f64::MIN_POSITIVE);
        for (delay, x) in delays.iter_mut().zip(element_x) {
            *delay -= level + slope * (x - centre);
        }
        let rms = mean(&mut delays.iter().map(|d| d * d)).sqrt();
        let scale = self.aberration / rms.max(f64::MIN_POSITIVE);
        delays.iter().map(|d| d * scale).collect()
    }

    fn aberrate(&self, settings: &Settings, data: &mut ChannelData) -> Result<()> {
        let delays = self.delays(&data.element_x, settings.seed);
        let fs = data.fs;
        let kernels: Vec<_> = delays.iter().map(|delay| Kernel::of(delay * fs)).collect();
        let mut rows: Vec<_> = rf(data)?.rows_mut().into_iter().collect();
        rows.par_iter_mut().enumerate().for_each(|(row, values)| {
            let delayed = kernels[row % kernels.len()].apply(values.view());
            values.iter_mut().zip(delayed).for_each(|(v, d)| *v = d);
        });
        Ok(())
    }

    /// Each element hears what is independent, and that of its neighbours.
    fn add_clutter(&self, independent: &[f32], data: &mut ChannelData) -> Result<()> {
        let coherent = self.coherent.max(1);
        let rf = rf(data)?;
        let (_, _, elements, samples) = rf.dim();
        let rows = rf.rows_mut().into_iter().enumerate();
        for (row, mut values) in rows {
            let (transmit, element) = (row / elements, row % elements);
            for neighbour in element..element + coherent {
                let from = (transmit * elements + neighbour % elements) * samples;
                let heard = independent.iter().skip(from);
                values.iter_mut().zip(heard).for_each(|(v, n)| *v += n);
            }
        }
        Ok(())
    }
}

/// The RMS of the channels near their beam, at times at which tissue in front of the bone echoes.
fn tissue_rms(data: &mut ChannelData) -> Result<f64> {
    let Transmits::Focused { x: beams, .. } = &data.transmits else {
        return Err(Error::Data("the transmits have no axes".into()));
    };
    let beams = beams.clone();
    let element_x = data.element_x.clone();
    let sample = |depth: f64| ((2.0 * depth / data.c - data.t0[0]) * data.fs).max(0.0) as usize;
    let [from, to] = TISSUE.map(sample);
    let rf = rf(data)?;
    let elements = element_x.len();
    let (mut power, mut count) = (0.0, 0usize);
    for (row, values) in rf.rows().into_iter().enumerate() {
        let (transmit, element) = (row / elements, row % elements);
        if (element_x[element] - beams[transmit]).abs() > BESIDE {
            continue;
        }
        for value in values.iter().take(to).skip(from) {
            power += f64::from(*value).powi(2);
            count += 1;
        }
    }
    Ok((power / count.max(1) as f64).sqrt())
}

/// A delay by a fraction of samples: a sinc within a Hann window.
struct Kernel {
    /// Whole samples.
    whole: i64,
    /// Of the samples from `whole + 1 − TAPS` before on.
    weights: Vec<f32>,
}

impl Kernel {
    fn of(delay: f64) -> Self {
        let whole = delay.floor() as i64;
        let fraction = delay - whole as f64;
        let weight = |k: i64| {
            let x = k as f64 - fraction;
            let sinc = if x == 0.0 {
                1.0
            } else {
                (PI * x).sin() / (PI * x)
            };
            (sinc * (0.5 + 0.5 * (PI * x / (TAPS as f64 + 1.0)).cos())) as f32
        };
        Kernel {
            whole,
            weights: (1 - TAPS..=TAPS).map(weight).collect(),
        }
    }

    /// Samples before the first and after the last are 0.
    fn apply(&self, row: ArrayView1<f32>) -> Vec<f32> {
        let at = |n: i64| usize::try_from(n).ok().and_then(|n| row.get(n)).copied();
        let delayed = |n: i64| {
            let taps = self.weights.iter().zip(1 - TAPS..);
            taps.map(|(w, k)| w * at(n - self.whole - k).unwrap_or(0.0))
                .sum()
        };
        (0..row.len() as i64).map(delayed).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array1;

    #[test]
    fn a_sine_is_delayed() {
        let sine = |n: f64| (2.0 * PI * 5.0 / 40.0 * n).sin();
        let row = Array1::from_shape_fn(200, |n| sine(n as f64) as f32);
        for delay in [-3.4, -0.5, 0.0, 1.25, 2.0] {
            let found = Kernel::of(delay).apply(row.view());
            for (n, found) in found.iter().enumerate().take(180).skip(20) {
                let error = f64::from(*found) - sine(n as f64 - delay);
                assert!(error.abs() < 3e-3, "{delay}: {error} at {n}");
            }
        }
    }

    #[test]
    fn delays_have_the_rms_that_is_asked_for_and_no_slope() {
        let x: Vec<f64> = (0..128).map(|k| 0.3e-3 * k as f64).collect();
        let delays = Disturbances::default().delays(&x, 3);
        let rms = (delays.iter().map(|d| d * d).sum::<f64>() / 128.0).sqrt();
        assert!((rms - 35e-9).abs() < 1e-12, "{rms}");
        assert!(delays.iter().sum::<f64>().abs() < 1e-15);
        let tilt: f64 = delays.iter().zip(&x).map(|(d, x)| d * x).sum();
        assert!(tilt.abs() < 1e-16, "{tilt}");
        // Neighbours are alike, those 10 mm away are not.
        let correlation = |lag: usize| {
            let pairs = delays.iter().zip(&delays[lag..]);
            pairs.map(|(a, b)| a * b).sum::<f64>() / (128 - lag) as f64 / (rms * rms)
        };
        assert!(correlation(1) > 0.9 && correlation(5) < 0.75 && correlation(33) < 0.5);
    }
}
