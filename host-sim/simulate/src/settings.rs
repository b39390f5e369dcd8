//! Settings of the simulated scanner: array, pulse, beams, record, noise.

use crate::{Error, Result};
use bonebeam_files::memory::{self, product};
use bonebeam_files::section::{Section, row};
use bonebeam_files::terminal::short;
use bonebeam_files::{choice, section};

use super::array::Array;
use super::pulse::{DIRECT_FLOOR, FLOOR, Pulse};
use super::time_axis::{TimeAxis, Window, row_rate};

choice! {
    /// Surroundings of the elements.
    Baffle = Rigid {
        /// Hard: only the element's width changes its sensitivity with angle
        Rigid = "rigid",
        /// Pressure-release: the sensitivity falls with the cosine of the angle
        Soft = "soft",
    }
}

choice! {
    /// Spectrum of the noise.
    NoiseSpectrum = Transducer {
        /// The transducer's one-way response
        Transducer = "transducer",
        /// An amplifier: flat from a tenth of to three times the centre frequency
        Amplifier = "amplifier",
    }
}

section! {
    /// The scanner's settings, in SI units.
    ///
    /// The default is the paper's (Section "Simulation setup"). Kerf, depths, height, baffle and attenuation, which the
    /// paper does not give, are assumed. A value outside its range is probably in another unit.
    Settings "scanner" {
        "Scanner" {
            /// Number of elements
            elements: usize = 128, row("N").within([2.0, 1024.0], "");
            /// Distance between neighbouring elements, m
            pitch: f64 = 0.308e-3, row("M").within([1e-6, 10e-3], " m");
            /// Gap between neighbouring elements, m
            kerf: f64 = 0.028e-3, row("M").flag("");
            /// Centre frequency of the pulse, Hz [default: 5e6]
            #[alias = "centre_frequency"]
            f0: f64 = 5e6, row("HZ").flag("centre-frequency").within([50e3, 200e6], " Hz");
            /// Fractional bandwidth of the transducer at −6 dB, one way
            bandwidth: f64 = 0.6, row("").within([0.1, 1.0], "");
            /// Sampling rate, Hz; at least 4 times the centre frequency [default: 100e6]
            #[alias = "sampling_rate"]
            fs: f64 = 100e6, row("HZ").flag("sampling-rate").within([200e3, 10e9], " Hz");
            /// Sound speed, m/s
            #[alias = "sound_speed"]
            c: f64 = 1540.0, row("M/S").flag("sound-speed").within([200.0, 20e3], " m/s");
            /// Depth of the transmit focus, m
            focus: f64 = 15e-3, row("M").within([0.1e-3, 10.0], " m");
            /// Transmit f-number
            f_number: f64 = 2.8, row("").within([0.1, 1e6], "");
            /// Number of beams
            beams: usize = 128, row("N");
            /// Position of the first beam, in pitches from the first element
            first_beam: f64 = 0.0, row("PITCHES");
            /// Distance between the beams, in pitches
            beam_step: f64 = 1.0, row("PITCHES").within([1e-4, 1024.0], " pitches");
            /// Shallowest depth that the record covers, m [default: point 0.012, vertebra 0.005]
            depth_start: f64 = 5e-3, row("M");
            /// Greatest depth that the record covers, m [default: point 0.018, vertebra 0.04]
            depth_end: f64 = 40e-3, row("M");
            /// Smallest receive f-number for which the record is long enough at `depth_end`
            receive_f_number: f64 = 1.5, row("").flag("").within([0.1, 1e6], "");
            /// Electronic noise, dB relative to the record's largest sample [default: point none, vertebra -40, volumes -60]
            noise: Option<f64> = None, row("DB").within([-400.0, 40.0], " dB");
            /// Spectrum of the noise
            noise_spectrum: NoiseSpectrum = NoiseSpectrum::default(), row("");
            /// Increase of the noise with depth, dB per m
            ///
            /// It models a time-gain curve. --noise is the level at depth 0.
            noise_rise: f64 = 0.0, row("DB").within([0.0, 2000.0], " dB per m");
            /// Bits of the converter; full scale is the largest sample [default: no rounding]
            adc_bits: Option<u32> = None, row("N").within([2.0, 24.0], "");
            /// Height of an element, m; 0 for no elevation [default: 0, for volumes 0.004]
            element_height: f64 = 0.0, row("M").within([0.0, 100e-3], " m");
            /// Focus of the lens in elevation, m [default for volumes: 0.019]
            elevation_focus: Option<f64> = None, row("M").within([1e-3, 10.0], " m");
            /// Baffle around the elements
            baffle: Baffle = Baffle::default(), row("");
            /// Attenuation, dB/(cm·MHz) one way
            attenuation: f64 = 0.0, row("DB").within([0.0, 10.0], " dB/(cm MHz)");
            /// Seed of noise and tissue
            seed: u64 = 1, row("N");
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
        if let Some((key, value, range)) = self.first_outside() {
            return usage(format!("{} is {value}; expected {range}", key.name));
        }
        if !(self.kerf >= 0.0 && self.kerf < self.pitch) {
            return usage(format!(
                "kerf is {1} m; expected at least 0 and below the pitch of {0} m",
                self.pitch,
                short(self.kerf)
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
        self.check_bytes()
    }

    /// Memory of the record, bytes.
    pub(super) fn record_bytes(&self) -> usize {
        let samples = self.time_axis().samples;
        product(&[self.beams, self.elements, samples, size_of::<f32>()])
    }

    /// The window of the transforms, and the bytes of the record and of its echoes.
    fn bytes(&self) -> (Window, usize) {
        let pulse = self.pulse();
        let band = pulse.band(FLOOR);
        // About twice what an echo is long.
        let margin = 4.0 * pulse.half_length(FLOOR);
        let window = self.window(band, row_rate(self.fs, band), margin);
        let pairs = product(&[self.elements, self.elements.div_ceil(2) + 1, window.row, 8]);
        (window, self.record_bytes().saturating_add(pairs))
    }

    /// Checks that the memory of the record, of its echoes and of `more` bytes is available.
    ///
    /// # Errors
    /// [`Error::Data`] with the size.
    pub(super) fn check_memory(&self, more: usize) -> Result<()> {
        memory::check(self.bytes().1.saturating_add(more), "the record")
    }

    /// Checks the memory of the record and of its echoes.
    ///
    /// # Errors
    /// More memory than the limit.
    fn check_bytes(&self) -> Result<()> {
        let (window, bytes) = self.bytes();
        let samples = self.time_axis().samples;
        if window.samples > MAX_WINDOW {
            return usage(format!(
                "the record of {samples} samples needs transforms of {}, more than {MAX_WINDOW}; give less \
                 depth, a nearer focus, larger f-numbers or a lower fs",
                window.samples
            ));
        }
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
