//! Settings of the simulated scanner: array, pulse, beams, record, noise.

use serde::{Deserialize, Serialize};

use crate::{Error, Result};
use bonebeam_files::memory::product;
use bonebeam_files::terminal::short;

use super::array::Array;
use super::pulse::{DIRECT_FLOOR, FLOOR, Pulse};
use super::time_axis::{TimeAxis, Window, row_rate};

/// Surroundings of the elements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum Baffle {
    /// Hard: only the element's width changes its sensitivity with angle
    #[default]
    Rigid,
    /// Pressure-release: the sensitivity falls with the cosine of the angle
    Soft,
}

/// Spectrum of the noise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum NoiseSpectrum {
    /// The transducer's one-way response
    #[default]
    Transducer,
    /// An amplifier: flat from a tenth of to three times the centre frequency
    Amplifier,
}

/// The scanner's settings, in SI units.
///
/// The default is the paper's (Section "Simulation setup"); values that the paper does not give are marked as
/// assumed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Number of elements.
    pub elements: usize,
    /// Distance between neighbouring elements, m.
    pub pitch: f64,
    /// Gap between neighbouring elements, m (assumed).
    pub kerf: f64,
    /// Centre frequency, Hz.
    pub f0: f64,
    /// −6 dB fractional bandwidth of the transducer, one way.
    pub bandwidth: f64,
    /// Sampling frequency of the record, Hz; at least 4·f0.
    pub fs: f64,
    /// Sound speed, m/s.
    pub c: f64,
    /// Depth of the fixed transmit focus, m.
    pub focus: f64,
    /// Transmit f-number.
    pub f_number: f64,
    /// Number of transmit beams.
    pub beams: usize,
    /// Position of the first beam's axis, in pitches from element 0.
    pub first_beam: f64,
    /// Distance between neighbouring beams, in pitches: 1 is one beam per element.
    pub beam_step: f64,
    /// Shallowest depth that the record covers, m (assumed).
    pub depth_start: f64,
    /// Greatest depth that the record covers, m (assumed).
    pub depth_end: f64,
    /// Smallest receive f-number for which the record is long enough at `depth_end`.
    pub receive_f_number: f64,
    /// RMS of the electronic noise, dB; `None` for a noise-free record.
    ///
    /// It is relative to the largest absolute sample of the noise-free record of all beams and elements.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<f64>,
    /// Spectrum of the noise.
    #[serde(default)]
    pub noise_spectrum: NoiseSpectrum,
    /// Increase of the noise with depth, dB per m.
    ///
    /// It models a time-gain curve; `noise` is then the level at depth 0.
    #[serde(default)]
    pub noise_rise: f64,
    /// Bits of the analogue-to-digital converter; `None` for no rounding.
    ///
    /// Its full scale is the largest sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adc_bits: Option<u32>,
    /// Height of an element, m (assumed); 0 for echoes that do not depend on elevation.
    pub element_height: f64,
    /// Focus of the lens in elevation, m; `None` for a flat one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub elevation_focus: Option<f64>,
    /// Surroundings of the elements (assumed).
    pub baffle: Baffle,
    /// Attenuation, dB/(cm·MHz) one way (assumed).
    pub attenuation: f64,
    /// Seed of the noise.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            elements: 128,
            pitch: 0.308e-3,
            kerf: 0.028e-3,
            f0: 5e6,
            bandwidth: 0.6,
            fs: 100e6,
            c: 1540.0,
            focus: 15e-3,
            f_number: 2.8,
            beams: 128,
            first_beam: 0.0,
            beam_step: 1.0,
            depth_start: 5e-3,
            depth_end: 40e-3,
            receive_f_number: 1.5,
            noise: None,
            noise_spectrum: NoiseSpectrum::Transducer,
            noise_rise: 0.0,
            adc_bits: None,
            element_height: 0.0,
            elevation_focus: None,
            baffle: Baffle::Rigid,
            attenuation: 0.0,
            seed: 1,
        }
    }
}

impl Settings {
    /// The paper's point scatterer (its Fig. 2), noise-free.
    ///
    /// The record covers 3 mm of depth on either side of the focus.
    pub fn point() -> Self {
        Settings {
            depth_start: 12e-3,
            depth_end: 18e-3,
            ..Settings::default()
        }
    }

    /// The vertebra in a water bath: 5 to 40 mm, noise at −40 dB.
    ///
    /// Without noise the shadow of a bone that absorbs all sound would be empty.
    pub fn vertebra() -> Self {
        Settings {
            noise: Some(-40.0),
            ..Settings::default()
        }
    }

    /// The paper's array with its height and its lens, over a volume.
    ///
    /// Elevation focus 19 mm, noise at −60 dB.
    pub fn volume() -> Self {
        Settings {
            element_height: 4e-3,
            elevation_focus: Some(19e-3),
            noise: Some(-60.0),
            ..Settings::default()
        }
    }

    /// The array.
    pub fn array(&self) -> Array {
        Array {
            elements: self.elements,
            pitch: self.pitch,
            kerf: self.kerf,
        }
    }

    /// The two-way pulse.
    pub fn pulse(&self) -> Pulse {
        Pulse::new(self.f0, self.bandwidth)
    }

    /// Times of the record.
    ///
    /// It covers depths `depth_start` to `depth_end` for the receive aperture of `receive_f_number`.
    pub fn time_axis(&self) -> TimeAxis {
        let s = self;
        let half = s.pulse().half_length(DIRECT_FLOOR);
        let edge = 0.5 * s.depth_end / s.receive_f_number;
        let last = (s.depth_end + root_of_squares(s.depth_end, edge)) / s.c + half;
        // A whole number of samples, so that sample times are round numbers.
        let first = ((2.0 * s.depth_start / s.c - half) * s.fs).floor();
        TimeAxis {
            fs: s.fs,
            t0: first / s.fs,
            samples: (last * s.fs - first).ceil() as usize,
        }
    }

    /// Window of the record for a pulse of the band `band`, as in [`Window::new`].
    pub(super) fn window(&self, band: [f64; 2], rate: f64, margin: f64) -> Window {
        Window::new(
            self.time_axis(),
            self.greatest_advance(),
            band,
            rate,
            margin,
        )
    }

    /// How much earlier an element `dx` beside a beam's axis fires, s.
    pub(super) fn advance(&self, dx: f64) -> f64 {
        (root_of_squares(dx, self.focus) - self.focus) / self.c
    }

    /// Largest advance of any element in any beam, s.
    fn greatest_advance(&self) -> f64 {
        self.advance(0.5 * self.focus / self.f_number + self.pitch)
    }

    /// Position of a beam's axis, m.
    pub fn beam_x(&self, beam: usize) -> f64 {
        self.array()
            .x(self.first_beam + beam as f64 * self.beam_step)
    }

    /// Checks every value; the error names the first impossible one.
    pub fn validate(&self) -> Result<()> {
        for (name, value, [least, most], unit) in self.ranges() {
            if !(least..=most).contains(&value) {
                return usage(format!(
                    "{name} is {}; expected {least} to {most}{unit}",
                    short(value)
                ));
            }
        }
        if !(2..=1024).contains(&self.elements) {
            return usage(format!("elements is {}; expected 2 to 1024", self.elements));
        }
        if !(self.kerf >= 0.0 && self.kerf < self.pitch) {
            return usage(format!(
                "kerf is {1} m; expected at least 0 and below the pitch of {0} m",
                self.pitch,
                short(self.kerf)
            ));
        }
        if !(self.bandwidth >= 0.1 && self.bandwidth <= 1.0) {
            return usage(format!(
                "bandwidth is {}; expected 0.1 to 1",
                short(self.bandwidth)
            ));
        }
        if self.fs < 4.0 * self.f0 {
            return usage(format!(
                "fs is {1} Hz; expected at least 4·f0 = {0} Hz",
                4.0 * self.f0,
                short(self.fs)
            ));
        }
        let last = self.first_beam + (self.beams.max(1) - 1) as f64 * self.beam_step;
        if self.beams == 0 || !(self.first_beam >= 0.0 && last <= (self.elements - 1) as f64) {
            return usage(format!(
                "{1} beams from {2} to {last}; expected at least 1, between element 0 and {0}",
                self.elements - 1,
                self.beams,
                self.first_beam
            ));
        }
        if !(self.depth_start > 0.0 && self.depth_end > self.depth_start && self.depth_end <= 0.2) {
            return usage(format!(
                "depth_start and depth_end are {} and {} m; expected 0 < depth_start < depth_end ≤ 0.2 m",
                short(self.depth_start),
                short(self.depth_end)
            ));
        }
        if let Some(noise) = self.noise
            && !(-400.0..=40.0).contains(&noise)
        {
            return usage(format!("noise is {}; expected -400 to 40 dB", short(noise)));
        }
        if !(0.0..=2000.0).contains(&self.noise_rise) {
            return usage(format!(
                "noise_rise is {}; expected 0 to 2000 dB per m",
                short(self.noise_rise)
            ));
        }
        if let Some(bits) = self.adc_bits
            && !(2..=24).contains(&bits)
        {
            return usage(format!("adc_bits is {bits}; expected 2 to 24"));
        }
        if !(0.0..=100e-3).contains(&self.element_height) {
            return usage(format!(
                "element_height is {}; expected 0 to 0.1 m",
                short(self.element_height)
            ));
        }
        if let Some(focus) = self.elevation_focus
            && !(1e-3..=10.0).contains(&focus)
        {
            return usage(format!(
                "elevation_focus is {}; expected 0.001 to 10 m",
                short(focus)
            ));
        }
        if !(0.0..=10.0).contains(&self.attenuation) {
            return usage(format!(
                "attenuation is {}; expected 0 to 10 dB/(cm MHz)",
                short(self.attenuation)
            ));
        }
        self.check_bytes()
    }

    /// Ranges of an array, its pulse and a medium.
    ///
    /// A value outside is probably in another unit.
    fn ranges(&self) -> [(&'static str, f64, [f64; 2], &'static str); 8] {
        [
            ("pitch", self.pitch, [1e-6, 10e-3], " m"),
            ("f0", self.f0, [50e3, 200e6], " Hz"),
            ("fs", self.fs, [200e3, 10e9], " Hz"),
            ("c", self.c, [200.0, 20e3], " m/s"),
            ("focus", self.focus, [0.1e-3, 10.0], " m"),
            ("f_number", self.f_number, [0.1, 1e6], ""),
            ("receive_f_number", self.receive_f_number, [0.1, 1e6], ""),
            ("beam_step", self.beam_step, [1e-4, 1024.0], " pitches"),
        ]
    }

    /// Memory of the record, bytes.
    pub(super) fn record_bytes(&self) -> usize {
        let samples = self.time_axis().samples;
        product(&[self.beams, self.elements, samples, size_of::<f32>()])
    }

    /// Checks the memory of the record and of its echoes.
    ///
    /// # Errors
    /// More memory than the limit.
    fn check_bytes(&self) -> Result<()> {
        let pulse = self.pulse();
        let band = pulse.band(FLOOR);
        // About twice what an echo is long.
        let margin = 4.0 * pulse.half_length(FLOOR);
        let window = self.window(band, row_rate(self.fs, band), margin);
        let samples = self.time_axis().samples;
        if window.samples > MAX_WINDOW {
            return usage(format!(
                "the record of {samples} samples needs transforms of {}, more than {MAX_WINDOW}; give less \
                 depth, a nearer focus, larger f-numbers or a lower fs",
                window.samples
            ));
        }
        let pairs = product(&[self.elements, self.elements.div_ceil(2) + 1, window.row, 8]);
        let bytes = self.record_bytes().saturating_add(pairs);
        if bytes <= MAX_BYTES {
            return Ok(());
        }
        usage(format!(
            "{} beams of {} elements with {samples} samples each, and the spectra they are made of, would \
             need {:.1} GiB, more than {} GiB; give fewer beams, less depth or a lower fs",
            self.beams,
            self.elements,
            bytes as f64 / GIB as f64,
            MAX_BYTES / GIB
        ))
    }
}

/// √(a² + b²), of lengths.
fn root_of_squares(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}

const GIB: usize = 1 << 30;
/// Largest memory of a record and its spectra, bytes.
///
/// It is four times that of the paper's record with two beams per element.
const MAX_BYTES: usize = 4 * GIB;
/// Longest transform, samples.
const MAX_WINDOW: usize = 1 << 22;

fn usage<T>(message: String) -> Result<T> {
    Err(Error::Usage(format!("simulation settings: {message}")))
}
