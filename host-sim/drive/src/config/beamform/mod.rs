//! Parameters of delay and beamformer: the section, and the core's parameters.
//!
//! The core's parameters come from its table: see [`core`](super::core). A key of the host is a field of [`Beamform`],
//! with its range in [`Beamform::validate`] and its flag in the command's `flags`.

mod section;
mod validate;

use std::ops::Range;

use bonebeam::beamform::{Apodization, Parameters};
use bonebeam::covariance::Covariance;
use bonebeam::delay::{IqInterpolation, MAX_DECIMATION};
use bonebeam::geometry::Axis;
use bonebeam::pipeline::DepthGate;
use serde::{Deserialize, Serialize};

use super::core::{APODIZATION, POSTFILTER};
use crate::methods::{MethodName, Options, default_beta};
use crate::names::keys;
use crate::{Error, Result};
use bonebeam_files::terminal::short;
use bonebeam_files::{ChannelData, Samples};

/// Default number of samples of a line per period of the centre frequency.
///
/// It gives the paper's 20 MHz at 5 MHz.
const PERIOD_SAMPLES: f64 = 4.0;
/// Upper band edge of a pulse of 60 % bandwidth, relative to its centre frequency.
const UPPER_EDGE: f64 = 1.3;
/// Band that the decimator keeps, relative to the output rate: 0.7 of its half.
const KEPT: f64 = 0.35;
/// Direction of the lines of compounded transmits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum LineKind {
    /// Straight down from the array
    Down,
    /// Along the normals of a curved array
    Normals,
    /// A fan from the array's middle
    Sector,
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

/// Interpolation of RF between its samples, for compounded transmits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum RfInterpolation {
    /// By the delay stage's filter, separately for each line
    Filtered,
    /// Upsampled 16 times by that filter, once for all lines, then linear
    ///
    /// Within 3e-3 of `filtered`, and several times as fast for many transmits.
    Upsampled,
}

/// Interpolation of I/Q between its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum Interpolation {
    /// Linear interpolation
    Linear,
    /// Cubic polynomials
    Cubic,
    /// Windowed sinc of 12 taps
    Sinc,
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

/// Values of a section for a purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// Live images: a depth step of 4 for das and mv, 2 for esmv and esmv-rank1
    Live,
}

impl Preset {
    /// The keys that the preset sets, and their values for a method.
    ///
    /// docs/reproduction.md has the errors of [`Preset::Live`]: below 3 grey levels of 255 in the bright half, with the
    /// bone within 0.02 mm.
    fn values(self, method: MethodName) -> [(&'static str, f64); 1] {
        match self {
            Preset::Live => {
                let depth_step = match method {
                    MethodName::Das | MethodName::Mv => 4.0,
                    MethodName::Esmv | MethodName::EsmvRank1 => 2.0,
                };
                [("depth_step", depth_step)]
            }
        }
    }

    /// The preset, unless a key that it sets is `given`.
    pub fn unless(self, given: impl Fn(&str) -> bool) -> Option<Self> {
        let keys = self.values(MethodName::Das).map(|(key, _)| key);
        (!keys.into_iter().any(given)).then_some(self)
    }

    /// Sets the preset's values for the section's method.
    pub fn apply(self, section: &mut Beamform) {
        for (key, value) in self.values(section.method) {
            section.core.set(key, value).expect("a row of the table");
        }
    }
}

/// Section `[beamform]`.
///
/// With `remote`, serde's functions for the host's keys are methods of this type; the module `core`
/// adds the keys of the core's table to them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(remote = "Self", deny_unknown_fields, default)]
pub struct Beamform {
    /// Preset of several values, which other keys override.
    ///
    /// [`Beamform::resolve`] sets them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preset: Option<Preset>,
    /// Beamformer.
    pub method: MethodName,
    /// ESMV: β of the cross-spectral rank rule (Eq. 8), above 0 and at most 1.
    ///
    /// Without a rank the default is 0.01.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beta: Option<f64>,
    /// ESMV: fixed rank of the signal subspace, in place of β.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rank: Option<usize>,
    /// Rank-1 ESMV: all eigenvectors but the first, in place of the first (Fig. 2c).
    pub exclude_first: bool,
    /// Rank-1 ESMV: steps of power iteration for the eigenvector, 1 to 64.
    ///
    /// By default the eigenvector has the accuracy of f32.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power_steps: Option<usize>,
    /// The parameters of the core's table, postfilter and apodization.
    ///
    /// [`Beamform::parameters`] adds the method.
    #[serde(skip)]
    pub core: Parameters,
    /// Covariance estimate: forward (Eq. 2) or forward-backward (Eq. 3).
    pub covariance: Covariance,
    /// The shallowest depth at which the beamformer is used, m; DAS above.
    ///
    /// By default the start of the lines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adaptive_depth_start: Option<f64>,
    /// The greatest depth at which the beamformer is used, m; DAS below.
    ///
    /// By default the end of the lines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adaptive_depth_end: Option<f64>,
    /// The receive f-number: depth over aperture.
    pub f_number: f64,
    /// The fewest active elements at any depth.
    pub min_elements: usize,
    /// The sampling rate of the beamformed lines, Hz; by default [`Beamform::rate`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub output_rate: Option<f64>,
    /// The direction of the lines of compounded transmits.
    ///
    /// By default straight down for linear arrays, and radial for curved and phased arrays.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lines: Option<LineKind>,
    /// The number of lines of compounded transmits.
    ///
    /// By default two per element, or with an adaptive method at most 0.1 mm, or a 400th of the depth, apart.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line_count: Option<usize>,
    /// The spacing of parallel lines, m; by default half the pitch of the elements.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line_spacing: Option<f64>,
    /// The lateral position of the first parallel line, m.
    ///
    /// By default that of the first element.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lateral_start: Option<f64>,
    /// The largest lateral position of a parallel line, m.
    ///
    /// By default that of the last element.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lateral_end: Option<f64>,
    /// Sub-lines of each line, each written: 1, 2, 4, 8, 16 or 32.
    ///
    /// Sub-lines are directions within the cell of a line, which share its covariance. By default their number keeps the
    /// level of a point between two lines, and only the largest is written; DAS has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sub_lines: Option<usize>,
    /// The angle of a sector from its first to its last line, rad.
    pub sector: f64,
    /// The weights of compounded transmits; by default equal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transmit_weights: Option<TransmitWeights>,
    /// The interpolation of RF of compounded transmits.
    ///
    /// By default the delay stage's filter.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rf_interpolation: Option<RfInterpolation>,
    /// The interpolation of I/Q.
    ///
    /// By default the cheapest with errors within 10⁻³ for a pulse of 60 % bandwidth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub iq_interpolation: Option<Interpolation>,
    /// The shallowest depth of the lines, m; by default the start of the recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_start: Option<f64>,
    /// The greatest depth of the lines, m; by default the end of the recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_end: Option<f64>,
    /// The speed of sound, m/s, in place of the file's.
    ///
    /// By default 1540 for aligned data, whose files do not have it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sound_speed: Option<f64>,
    /// Aligned data without beam positions: the distance between beams, m.
    pub beam_spacing: f64,
}

impl Default for Beamform {
    fn default() -> Self {
        Self {
            preset: None,
            method: MethodName::EsmvRank1,
            beta: None,
            rank: None,
            exclude_first: false,
            power_steps: None,
            core: Parameters::DEFAULT,
            covariance: Covariance::ForwardBackward,
            adaptive_depth_start: None,
            adaptive_depth_end: None,
            f_number: 1.5,
            min_elements: 8,
            output_rate: None,
            lines: None,
            line_count: None,
            line_spacing: None,
            lateral_start: None,
            lateral_end: None,
            sub_lines: None,
            sector: std::f64::consts::FRAC_PI_2,
            transmit_weights: None,
            rf_interpolation: None,
            iq_interpolation: None,
            depth_start: None,
            depth_end: None,
            sound_speed: None,
            beam_spacing: 0.308e-3,
        }
    }
}

impl Beamform {
    /// The keys of the section.
    pub fn keys() -> impl Iterator<Item = &'static str> {
        let core = Parameters::TABLE.map(|row| row.name);
        let host = keys::<Self>().iter().copied();
        host.chain([POSTFILTER, APODIZATION]).chain(core)
    }

    /// Sets the preset's values and a missing β.
    ///
    /// The written configuration then has them. β is set if the method needs it and has neither β nor a rank.
    pub fn resolve(&mut self) {
        if let Some(preset) = self.preset.take() {
            preset.apply(self);
        }
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
        match data.samples {
            Samples::Rf(_) | Samples::Counts(_) => self.rate(data.f0, data.fs),
            Samples::Iq { .. } => self.rate(data.f0, 2.0 * data.fs),
        }
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
        let (method, options) = MethodName::of(core.method);
        Beamform {
            method,
            beta: options.beta,
            rank: options.rank,
            exclude_first: options.exclude_first,
            power_steps: options.power_steps,
            sub_lines: (core.sub_lines > 1).then_some(core.sub_lines),
            covariance: core.covariance,
            core: Parameters {
                method: Parameters::DEFAULT.method,
                covariance: Parameters::DEFAULT.covariance,
                sub_lines: Parameters::DEFAULT.sub_lines,
                ..core
            },
            ..Beamform::default()
        }
    }

    /// Whether the recording decides the number of sub-lines.
    pub fn chooses_sub_lines(&self) -> bool {
        self.sub_lines.is_none() && self.method != MethodName::Das
    }

    /// The core's parameters, with one sub-line if the recording decides their number.
    pub fn parameters(&self) -> Parameters {
        Parameters {
            method: self.method.method(&Options {
                beta: self.beta,
                rank: self.rank,
                exclude_first: self.exclude_first,
                power_steps: self.power_steps,
            }),
            covariance: self.covariance,
            sub_lines: self.sub_lines.unwrap_or(1),
            ..self.core
        }
    }
}
