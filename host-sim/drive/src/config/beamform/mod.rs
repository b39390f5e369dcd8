//! Parameters of delay and beamformer.

mod method;
mod validate;

use std::ops::Range;

use bonebeam::beamform::{Apodization, Parameters, Postfilter};
use bonebeam::covariance::Covariance;
use bonebeam::delay::{IqInterpolation, MAX_DECIMATION};
use bonebeam::geometry::Axis;
use bonebeam::pipeline::DepthGate;
use serde::{Deserialize, Serialize};

use super::core::plain;
use crate::methods::{MethodName, default_beta};
use crate::{Error, Result};
use bonebeam_files::section::{Value, row};
use bonebeam_files::settings::{COUNTS, LENGTHS};
use bonebeam_files::terminal::short;
use bonebeam_files::{ChannelData, choice, section};

/// Default number of samples of a line per period of the centre frequency.
///
/// It gives the paper's 20 MHz at 5 MHz.
const PERIOD_SAMPLES: f64 = 4.0;
/// Upper band edge of a pulse of 60 % bandwidth, relative to its centre frequency.
const UPPER_EDGE: f64 = 1.3;
/// Band that the decimator keeps, relative to the output rate: 0.7 of its half.
const KEPT: f64 = 0.35;

choice! {
    /// Direction of the lines of compounded transmits.
    LineKind {
        /// Straight down from the array
        Down = "down",
        /// Along the normals of a curved array
        Normals = "normals",
        /// A fan from the array's middle
        Sector = "sector",
    }
}

/// The weights of compounded transmits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum TransmitWeights {
    /// A window over the transmits in their order.
    Window(Apodization),
    /// One number per transmit.
    Each(Vec<f64>),
}

impl TransmitWeights {
    /// The factor of the record of each transmit.
    ///
    /// The mean of the records with these factors is their weighted sum, divided by the sum of the weights' magnitudes.
    ///
    /// # Errors
    /// [`Error::Usage`] for a wrong number of weights, or weights that are not finite or all zero.
    pub fn factors(&self, transmits: usize, tukey_taper: f32) -> Result<Vec<f32>> {
        let weights: Vec<f64> = match self {
            TransmitWeights::Window(window) => (0..transmits)
                .map(|transmit| f64::from(window.weight(tukey_taper, transmit, transmits)))
                .collect(),
            TransmitWeights::Each(weights) => weights.clone(),
        };
        let total: f64 = weights.iter().map(|weight| weight.abs()).sum();
        if weights.len() != transmits || !(total > 0.0 && total.is_finite()) {
            return Err(Error::Usage(format!(
                "--transmit-weights has {}; expected {transmits} finite numbers, not all 0, one for each \
                 transmit, or a window",
                weights
                    .iter()
                    .map(|&weight| short(weight))
                    .collect::<Vec<_>>()
                    .join(", ")
            )));
        }
        let scale = transmits as f64 / total;
        Ok(weights
            .iter()
            .map(|weight| (weight * scale) as f32)
            .collect())
    }
}

impl Value for TransmitWeights {
    fn python() -> String {
        format!("{} | Sequence[float]", Apodization::python())
    }

    fn read(text: &str) -> std::result::Result<Self, String> {
        if let Ok(window) = Value::read(text) {
            return Ok(TransmitWeights::Window(window));
        }
        let weights: std::result::Result<_, _> = text
            .split(',')
            .map(|weight| weight.trim().parse())
            .collect();
        weights.map(TransmitWeights::Each).map_err(|_| {
            let keys = Apodization::EXAMPLES.map(|window| window.key()).join(", ");
            format!("expected numbers separated by commas, or one of {keys}")
        })
    }
}

choice! {
    /// Interpolation of RF between its samples, for compounded transmits.
    RfInterpolation {
        /// By the delay stage's filter, separately for each line
        Filtered = "filtered",
        /// Upsampled 16 times by that filter, once for all lines, then linear
        ///
        /// Within 3e-3 of `filtered`, and several times as fast for many transmits.
        Upsampled = "upsampled",
    }
}

choice! {
    /// Interpolation of I/Q between its samples.
    Interpolation {
        /// Linear interpolation
        Linear = "linear",
        /// Cubic polynomials
        Cubic = "cubic",
        /// Windowed sinc of 12 taps
        Sinc = "sinc",
    }
}

impl From<Interpolation> for IqInterpolation {
    fn from(interpolation: Interpolation) -> Self {
        match interpolation {
            Interpolation::Linear => IqInterpolation::Linear,
            Interpolation::Cubic => IqInterpolation::Cubic,
            Interpolation::Sinc => IqInterpolation::Sinc,
        }
    }
}

choice! {
    /// Values of a section for a purpose.
    ///
    /// docs/reproduction.md has the errors of [`Preset::Live`]: below 3 grey levels of 255 in the bright half, with the
    /// bone within 0.02 mm.
    Preset {
        /// Live images: a depth step of 4 for das and mv, 2 for esmv and esmv-rank1
        Live = "live",
    }
}

section! {
    /// Section `[beamform]`.
    ///
    /// Help, default and range of the core's parameters come from the core's table: see
    /// [`of_core`](bonebeam_files::section::of_core).
    Beamform "beamform" {
        "Beamformer" {
            /// Preset of several values, which other flags override
            preset: Option<Preset> = None, row("").replaces_if_changed(&["depth_step"]);
            /// Beamformer [default: esmv-rank1; das for the command surface]
            method: MethodName = MethodName::EsmvRank1,
                row("").replaces_if_changed(&["beta", "rank", "exclude_first", "power_steps"]);
            /// Share of the power in the signal subspace of esmv (Eq. 8), above 0, at most 1 [default: 0.01]
            beta: Option<f64> = None, row("").replaces(&["rank"]);
            /// Fixed rank of the signal subspace of esmv, in place of --beta
            rank: Option<usize> = None, row("").replaces(&["beta"]);
            /// Use all eigenvectors but the first in esmv-rank1, as in Fig. 2c of the paper
            exclude_first: bool = false, row("").replaces(&["power_steps"]);
            /// Steps of power iteration for the eigenvector of esmv-rank1, 1 to 64 [default: Lanczos steps]
            ///
            /// Power iteration takes the same time for all data. Lanczos steps go on until they converge.
            power_steps: Option<usize> = None, row("N").replaces(&["exclude_first"]);
            /// K: the covariance is averaged over the samples n−K to n+K
            #[alias = "temporal"]
            temporal_half_window: usize = Parameters::DEFAULT.temporal_half_window, row("N");
            /// Δ: Δ/L·tr(R) is added to the diagonal of the covariance R
            #[alias = "loading"]
            diagonal_loading: f64 = plain(Parameters::DEFAULT.diagonal_loading), row("X");
            /// Length of the subapertures over the number of active elements
            #[alias = "subarray_ratio"]
            subaperture_ratio: f64 = Parameters::DEFAULT.subaperture_ratio, row("X");
            /// Highest coherent spatial frequency of the generalized coherence factor
            coherence_cutoff: usize = Parameters::DEFAULT.coherence_cutoff, row("N");
            /// Share of the active aperture in the falling ends of a Tukey window
            tukey_taper: f64 = plain(Parameters::DEFAULT.tukey_taper), row("X");
            /// Distance of beamformed samples of a line; by default that of the preset, or 1
            depth_step: Option<usize> = None, row("N");
            /// Postfilter: a factor on the beamformer's output [default: none]
            postfilter: Postfilter = Postfilter::None, row("");
            /// Receive weights of the elements of das, or of the subapertures of other methods [default: none]
            apodization: Apodization = Apodization::None, row("");
            /// Covariance estimate [default: forward-backward]
            covariance: Covariance = Covariance::ForwardBackward, row("");
            /// Depth above which delay and sum replaces the beamformer, m [default: none]
            adaptive_depth_start: Option<f64> = None, row("M").at_least(DEPTHS, " (m)");
            /// Depth below which delay and sum replaces the beamformer, m [default: none]
            adaptive_depth_end: Option<f64> = None, row("M");
        }
        "Delay (channel data only)" {
            /// Receive f-number: depth over aperture
            f_number: f64 = 1.5, row("").positive([1e-3, 1e6], "");
            /// Minimum number of active elements; fewer at the ends of the array
            min_elements: usize = 8, row("N").at_least(COUNTS, "");
            /// Sampling rate of the lines, Hz [default: 4 x centre frequency]
            ///
            /// The default does not exceed the sampling rate of the recording.
            output_rate: Option<f64> = None, row("HZ").positive([1e3, 10e9], " (Hz)");
            /// Direction of the lines of compounded transmits [default: by the array]
            ///
            /// The default is straight down for linear arrays, and radial for curved and phased arrays.
            lines: Option<LineKind> = None, row("");
            /// Number of lines of compounded transmits [default: two per element]
            ///
            /// By default, lines of adaptive methods, and of das with a depth step, are 0.1 mm, or a 400th of the depth, apart.
            line_count: Option<usize> = None, row("N").within([2.0, 65536.0], "");
            /// Spacing of parallel lines of compounded transmits, m [default: half the pitch]
            line_spacing: Option<f64> = None, row("M").positive(SPACINGS, " (m)");
            /// Lateral position of the first parallel line, m [default: that of the first element]
            lateral_start: Option<f64> = None, row("M").at_least([-LENGTHS[1], LENGTHS[1]], " (m)");
            /// Largest lateral position of a parallel line, m [default: that of the last element]
            lateral_end: Option<f64> = None, row("M").at_least([-LENGTHS[1], LENGTHS[1]], " (m)");
            /// Sub-lines of each line: 1, 2, 4, 8, 16 or 32 [default: by the recording; 1 for das of all depths]
            ///
            /// Sub-lines are directions within the cell of a line, which reaches half way to its neighbours. They share the
            /// covariance of the line. With this flag, each sub-line is written. By default their number keeps the loss of a
            /// point between two within 2 dB, and the line written is the largest of its sub-lines. The focus of compounded
            /// transmits stays at the line, which adds a loss: `host-sim info` states the sum.
            sub_lines: Option<usize> = None, row("N");
            /// Angle from the first to the last line of a sector, rad [default: 1.5708]
            sector: f64 = std::f64::consts::FRAC_PI_2, row("RAD");
            /// Weights of compounded transmits: a number each, or a window [default: equal]
            ///
            /// For example 0.5,1,0.5 or hann. Lines are the weighted sum, divided by the sum of the weights' magnitudes.
            transmit_weights: Option<TransmitWeights> = None, row("W,…");
            /// Interpolation of RF for compounded transmits [default: upsampled, if that can read the record]
            ///
            /// `upsampled` is within 3e-3 of `filtered`, and several times as fast for many transmits. It needs records below 2.5
            /// times the output rate, of at most 16,384 samples.
            rf_interpolation: Option<RfInterpolation> = None, row("");
            /// Interpolation of I/Q between its samples [default: by the sampling rate]
            ///
            /// The default is the cheapest one with errors within 1e-3 of a pulse's peak.
            iq_interpolation: Option<Interpolation> = None, row("");
            /// Shallowest depth of the lines, m [default: the start of the recording]
            depth_start: Option<f64> = None, row("M").at_least(DEPTHS, " (m)");
            /// Greatest depth of the lines, m [default: the end of the recording]
            depth_end: Option<f64> = None, row("M");
            /// Thickness of the lens before the elements, m [default: no refraction]
            ///
            /// Echoes are refracted at its face. The time straight through it stays that of the recording.
            lens_thickness: Option<f64> = None, row("M").positive(LENSES, " (m)");
            /// Speed of sound in the lens, m/s [default: 1000, of silicone]
            lens_speed: f64 = 1000.0, row("M/S").positive([100.0, 20e3], " (m/s)");
        }
        "" {
            /// Speed of sound, m/s [default: that of the file; 1540 for aligned data]
            sound_speed: Option<f64> = None, row("M/S").positive([100.0, 20e3], " (m/s)");
            /// Beam spacing of aligned data without `beam_x`, m [default: 0.308e-3]
            beam_spacing: f64 = 0.308e-3, row("M").positive(SPACINGS, " (m)");
        }
    }
}

/// Heading of the keys that only affect channel data.
pub const DELAY: &str = "Delay (channel data only)";
/// Range of depths, m.
const DEPTHS: [f64; 2] = [0.0, LENGTHS[1]];
/// Range of thicknesses, m.
const LENSES: [f64; 2] = [1e-6, 0.02];
/// Range of spacings, m.
const SPACINGS: [f64; 2] = [1e-6, 1.0];

impl Beamform {
    /// Sets the depth step and a missing β, which the written configuration then has.
    ///
    /// The depth step is the preset's, or 1. β is set if the method needs it and has neither β nor a rank.
    pub fn resolve(&mut self) {
        let step = match (self.preset.take(), self.method) {
            (None, _) => Parameters::DEFAULT.depth_step,
            (Some(Preset::Live), MethodName::Das | MethodName::Mv) => 4,
            (Some(Preset::Live), MethodName::Esmv | MethodName::EsmvRank1) => 2,
        };
        self.depth_step.get_or_insert(step);
        let by_beta = self.method.takes().contains(&"beta");
        if by_beta && self.rank.is_none() && self.beta.is_none() {
            self.beta = Some(default_beta());
        }
    }

    /// The samples of lines at these depths that the beamformer makes; others are DAS.
    ///
    /// # Errors
    /// [`Error::Usage`] if no sample lies between the depths.
    pub fn adaptive_samples(&self, depths: &Axis) -> Result<Range<usize>> {
        let (start, end) = (self.adaptive_depth_start, self.adaptive_depth_end);
        if start.is_none() && end.is_none() {
            return Ok(0..depths.count);
        }
        let from = start.unwrap_or(f64::MIN);
        let to = end.unwrap_or(f64::MAX);
        DepthGate { from, to }.samples(depths).map_err(|_| {
            let edge = |name: &str, edge: Option<f64>| {
                edge.map(|depth| format!("--adaptive-depth-{name} {}", short(depth)))
            };
            let reported: Vec<String> = edge("start", start)
                .into_iter()
                .chain(edge("end", end))
                .collect();
            Error::Usage(format!(
                "no sample lies within {}; the lines reach from {:.6} m to {:.6} m",
                reported.join(" and "),
                depths.first,
                depths.last()
            ))
        })
    }

    /// The sampling rate of the lines of a recording, Hz.
    ///
    /// `f0` is the centre frequency and `fs` the sampling rate of the recording. The result is `output_rate`, or else
    /// 4·f0, which holds a pulse of 80 % bandwidth, limited to `fs` and to the lowest rate of the decimator.
    pub fn rate(&self, f0: f64, fs: f64) -> f64 {
        let slowest = fs / MAX_DECIMATION as f64;
        self.output_rate
            .unwrap_or_else(|| (PERIOD_SAMPLES * f0).min(fs).max(slowest))
    }

    /// [`Beamform::rate`] of a recording.
    ///
    /// I/Q has the information of RF at twice its rate, and gives the same lines.
    pub fn rate_of(&self, data: &ChannelData) -> f64 {
        let rates = data.samples.f_demod().map_or(1.0, |_| 2.0);
        self.rate(data.f0, rates * data.fs)
    }

    /// A warning for the terminal if the sampling rates lose part of a pulse's band.
    ///
    /// It concerns the rate of the recording and `output_rate`.
    pub fn warnings(&self, f0: f64, fs: f64) -> Option<String> {
        let mhz = |hertz: f64| format!("{:.4} MHz", hertz / 1e6);
        let rate = self.rate(f0, fs);
        let reaches = UPPER_EDGE * f0;
        if fs < 2.0 * reaches {
            return Some(format!(
                "`fs` of {} is {:.2} times `f0`: a pulse around {} usually reaches {}, and frequencies \
                 above {} are aliased; if the recording is bandpass-sampled, convert it to I/Q (`iq`, `f_demod`)",
                mhz(fs),
                fs / f0,
                mhz(f0),
                mhz(reaches),
                mhz(fs / 2.0)
            ));
        }
        if KEPT * rate < reaches && rate < fs && rate > 2.0 * f0 {
            return Some(format!(
                "--output-rate is {}: the lines keep frequencies below {}, but a pulse around {} \
                 usually reaches {}; rates of {} and above keep it",
                mhz(rate),
                mhz(KEPT * rate),
                mhz(f0),
                mhz(reaches),
                mhz((PERIOD_SAMPLES * f0).min(fs))
            ));
        }
        None
    }

    /// The section of a beamformer.
    ///
    /// With one sub-line, the recording decides their number.
    pub fn of(core: Parameters) -> Self {
        Beamform {
            sub_lines: (core.sub_lines > 1).then_some(core.sub_lines),
            covariance: core.covariance,
            temporal_half_window: core.temporal_half_window,
            diagonal_loading: plain(core.diagonal_loading),
            subaperture_ratio: core.subaperture_ratio,
            coherence_cutoff: core.coherence_cutoff,
            tukey_taper: plain(core.tukey_taper),
            depth_step: (core.depth_step > 1).then_some(core.depth_step),
            postfilter: core.postfilter,
            apodization: core.apodization,
            ..Beamform::of_method(core.method)
        }
    }

    /// Distance of the beamformed samples of a line, samples.
    pub fn depth_step(&self) -> usize {
        self.depth_step.unwrap_or(Parameters::DEFAULT.depth_step)
    }

    /// Whether the recording decides the number of sub-lines.
    pub fn chooses_sub_lines(&self) -> bool {
        self.sub_lines.is_none() && (self.method != MethodName::Das || self.depth_step() > 1)
    }

    /// The core's parameters, with one sub-line if the recording decides their number.
    pub fn parameters(&self) -> Parameters {
        Parameters {
            method: self.core_method(),
            covariance: self.covariance,
            sub_lines: self.sub_lines.unwrap_or(1),
            temporal_half_window: self.temporal_half_window,
            diagonal_loading: self.diagonal_loading as f32,
            subaperture_ratio: self.subaperture_ratio,
            coherence_cutoff: self.coherence_cutoff,
            tukey_taper: self.tukey_taper as f32,
            depth_step: self.depth_step(),
            postfilter: self.postfilter,
            apodization: self.apodization,
        }
    }
}
