//! What the simulated scanner does: array, pulse, beams, record, noise.

use num_complex::Complex;
use serde::{Deserialize, Serialize};

use crate::memory::product;
use crate::{Error, Result};

use super::array::Array;
use super::pulse::Pulse;
use super::record::{Record, smooth_even};

/// The scanner's settings. The default is the paper's (Section "Simulation setup"); what the
/// paper leaves open is marked as assumed. SI units.
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
    /// Shallowest depth that the record serves, m (assumed).
    pub depth_start: f64,
    /// Greatest depth that the record serves, m (assumed).
    pub depth_end: f64,
    /// Smallest receive f-number that the record is long enough for at `depth_end`.
    pub receive_f_number: f64,
    /// RMS of the electronic noise in decibels relative to the largest absolute sample of the
    /// noise-free record of all beams and elements; none for a noise-free record.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub noise: Option<f64>,
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
            seed: 1,
        }
    }
}

impl Settings {
    /// The paper's point scatterer (its Fig. 2): 3 mm of depth either side of the focus,
    /// noise-free.
    pub fn point() -> Self {
        Settings {
            depth_start: 12e-3,
            depth_end: 18e-3,
            ..Settings::default()
        }
    }

    /// The vertebra in a water bath: 5 to 40 mm, noise at −40 dB, without which the shadow of a
    /// totally absorbing bone would be empty.
    pub fn vertebra() -> Self {
        Settings {
            noise: Some(-40.0),
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

    /// The record that serves depths `depth_start` to `depth_end` with the receive aperture of
    /// `receive_f_number`.
    pub fn record(&self) -> Record {
        let s = self;
        let pulse = s.pulse();
        let half = pulse.half_length();
        let edge = 0.5 * s.depth_end / s.receive_f_number;
        let last = (s.depth_end + s.depth_end.hypot(edge)) / s.c + half;
        // A whole number of samples, so that sample times are round numbers.
        let first = ((2.0 * s.depth_start / s.c - half) * s.fs).floor();
        let samples = (last * s.fs - first).ceil() as usize;
        // Echoes outside the record reach into it by half a pulse, and their transmit
        // advance by the focusing delay of the aperture's edge.
        let aperture = 0.5 * s.focus / s.f_number + s.pitch;
        let advance = (s.focus.hypot(aperture) - s.focus) / s.c;
        // Eight samples of the coarse grid, of at least 8·f0, hold the spreading kernel.
        let guard = half + advance + 1.0 / s.f0;
        let lead = (guard * s.fs).ceil() as usize;
        let window = smooth_even(samples + 2 * lead);
        let df = s.fs / window as f64;
        let highest = pulse.highest_frequency().min(0.5 * s.fs);
        Record {
            t0: first / s.fs,
            samples,
            lead,
            window,
            coarse: smooth_even((8.0 * s.f0 / df).ceil() as usize),
            start: (first - lead as f64) / s.fs,
            df,
            bins: (highest / df).floor() as usize,
        }
    }

    /// Position of a beam's axis, m.
    pub fn beam_x(&self, beam: usize) -> f64 {
        self.array()
            .x(self.first_beam + beam as f64 * self.beam_step)
    }

    /// Checks every value; the error names the first that is impossible.
    pub fn validate(&self) -> Result<()> {
        for (name, value, [least, most], unit) in self.ranges() {
            if !(least..=most).contains(&value) {
                return usage(format!(
                    "{name} must be positive, {least} to {most}{unit}, is {value}"
                ));
            }
        }
        if !(2..=1024).contains(&self.elements) {
            return usage(format!("elements must be 2 to 1024, is {}", self.elements));
        }
        if !(self.kerf >= 0.0 && self.kerf < self.pitch) {
            return usage(format!(
                "kerf must be at least 0 and below the pitch of {} m, is {}",
                self.pitch, self.kerf
            ));
        }
        if !(self.bandwidth >= 0.1 && self.bandwidth <= 1.0) {
            return usage(format!("bandwidth must be 0.1 to 1, is {}", self.bandwidth));
        }
        if self.fs < 4.0 * self.f0 {
            return usage(format!(
                "fs must be at least 4·f0 = {} Hz, is {}",
                4.0 * self.f0,
                self.fs
            ));
        }
        let last = self.first_beam + (self.beams.max(1) - 1) as f64 * self.beam_step;
        if self.beams == 0 || !(self.first_beam >= 0.0 && last <= (self.elements - 1) as f64) {
            return usage(format!(
                "beams must be at least 1 and lie between element 0 and {}: {} beams from {} to {last}",
                self.elements - 1,
                self.beams,
                self.first_beam
            ));
        }
        if !(self.depth_start > 0.0 && self.depth_end > self.depth_start && self.depth_end <= 0.2) {
            return usage(format!(
                "depths must satisfy 0 < depth_start < depth_end ≤ 0.2 m, are {} and {}",
                self.depth_start, self.depth_end
            ));
        }
        if let Some(noise) = self.noise
            && !(-400.0..=40.0).contains(&noise)
        {
            return usage(format!("noise must be -400 to 40 dB, is {noise}"));
        }
        self.bytes().map(drop)
    }

    /// What an ultrasound array, its pulse and a medium can be; beyond that a value is in another unit.
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

    /// What the record and the spectra it is made of take, bytes: known before they are made, and
    /// bounded.
    ///
    /// # Errors
    /// More than any machine is asked for.
    pub(super) fn bytes(&self) -> Result<usize> {
        let Record {
            samples,
            window,
            bins,
            ..
        } = self.record();
        if window > MAX_WINDOW {
            return usage(format!(
                "the record of {samples} samples needs transforms of {window}, more than {MAX_WINDOW}; ask \
                 for less depth, a nearer focus, larger f-numbers or a lower fs"
            ));
        }
        let record = product(&[self.beams, self.elements, samples, size_of::<f32>()]);
        let pairs = product(&[
            self.elements,
            self.elements.div_ceil(2) + 1,
            bins,
            size_of::<Complex<f64>>(),
        ]);
        let bytes = record.saturating_add(pairs);
        if bytes <= MAX_BYTES {
            return Ok(bytes);
        }
        usage(format!(
            "{} beams of {} elements with {samples} samples each, and the spectra they are made of, would \
             take {:.1} GiB, more than {} GiB; ask for fewer beams, less depth or a lower fs",
            self.beams,
            self.elements,
            bytes as f64 / GIB as f64,
            MAX_BYTES / GIB
        ))
    }
}

const GIB: usize = 1 << 30;
/// The most that a record and its spectra may take, bytes: four times the paper's with two beams an
/// element.
const MAX_BYTES: usize = 4 * GIB;
/// The longest transform, samples.
const MAX_WINDOW: usize = 1 << 22;

fn usage<T>(message: String) -> Result<T> {
    Err(Error::Usage(format!("simulation settings: {message}")))
}
