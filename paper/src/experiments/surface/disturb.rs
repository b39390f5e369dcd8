//! Disturbances of a recording: aberration, clutter, noise, a wrong speed of sound.

use crate::experiments::common::aberration::aberrate;
use crate::experiments::study::*;
use bonebeam_files::section::Value;
use bonebeam_files::{Transmits, choice};
use bonebeam_simulate::noise;

choice! {
    /// Disturbance of a scene.
    Condition {
        /// clean
        Clean = "clean",
        /// aberration
        Aberration = "aberration",
        /// clutter on every channel
        Clutter = "clutter",
        /// amplifier noise that rises with depth
        Noise = "noise",
        /// speed of sound too low
        SpeedLow = "speed_low",
        /// speed of sound too high
        SpeedHigh = "speed_high",
        /// aberration, clutter and noise together
        Together = "together",
    }
}

impl Condition {
    /// Name in the tables.
    pub fn title(self) -> &'static str {
        Condition::choices()[self as usize][1]
    }
}

parameters! {
    /// Section `[surface.disturbances]`: the strength of disturbances.
    Disturbances "surface.disturbances" {
        /// RMS of the delays of the elements on receive, s.
        aberration: f64 = 35e-9, positive([1e-12, 1e-6], " (s)");
        /// Full width at half maximum of the delays' correlation along the array, m.
        aberration_length: f64 = 3e-3, positive(LENGTHS, " (m)");
        /// Clutter of every channel, dB relative to the tissue's RMS.
        clutter: f64 = -10.0, level();
        /// Number of neighbouring elements that receive the same clutter.
        coherent: usize = 3;
        /// Noise at depth 0, dB relative to the tissue's RMS.
        noise: f64 = -20.0, level();
        /// Increase of the noise with depth, dB per m.
        noise_rise: f64 = 300.0;
        /// Error of the assumed speed of sound, relative to the true one.
        speed_error: f64 = 0.02, positive([1e-6, 0.5], "");
    }
}

/// Depths of the tissue's echoes, m.
const TISSUE: [f64; 2] = [4e-3, 14e-3];
/// Largest distance of an element from its beam for the tissue's RMS, m.
const BESIDE: f64 = 5e-3;

/// A recording of one frame of RF with the disturbances of all conditions.
pub struct Disturbed<'a> {
    section: &'a Disturbances,
    recorded: &'a ChannelData,
    aberrated: ChannelData,
    /// `[transmit][element][sample]`, like [`Disturbed::noise`].
    clutter: Vec<f32>,
    noise: Vec<f32>,
}

impl Disturbed<'_> {
    /// The recording in a condition.
    ///
    /// # Errors
    /// A recording of I/Q.
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
        data.c *= match condition {
            Condition::SpeedLow => 1.0 - self.section.speed_error,
            Condition::SpeedHigh => 1.0 + self.section.speed_error,
            _ => 1.0,
        };
        Ok(data)
    }
}

impl Disturbances {
    /// Disturbs a recording of one frame of RF, with the seed of `settings`.
    ///
    /// # Errors
    /// A recording of I/Q, or transmits without beam axes.
    pub fn of<'a>(
        &'a self,
        settings: &Settings,
        recorded: &'a ChannelData,
    ) -> Result<Disturbed<'a>> {
        let mut aberrated = recorded.clone();
        let level = tissue_rms(&mut aberrated)?;
        aberrate(
            &mut aberrated,
            self.aberration,
            self.aberration_length,
            settings.seed,
        )?;
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

    /// Adds clutter: each element receives the sum of its neighbours' independent clutter.
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
